"""Errors at the interface: what acknowledges what.  Source: rho3 3.3, 9.1 (L1072-1076, L3033, L3059-3065, L4046-4068), AX-501.

They are kept in the one list of the control (gateway.pure.image.error_list), with the numbers of the rho 3.

Error acknowledgement (bit 62) clears errors and leaves processes alone; Control reset (bit 19) or PHG 11.1 clears more and ends
processes; EMERGENCY STOP and P2 errors need Control reset; system errors need a restart.
"""

from dataclasses import dataclass
from enum import Enum, auto

from gateway.pure.controllers.pic_image import Edge, PicImage
from gateway.pure.controllers.rho3.signals.numbers import AS_SHIPPED, Numbers
from gateway.pure.image.error_list import ErrorList, Reset
from protocols.base.machine import Ns

CONTROL_RESET, ACKNOWLEDGE = 19, 62  # RC inputs
EMERGENCY_STOP = 528
RHO3 = "rho3"  # who numbered them


class Kind(Enum):
    """How an error may be got rid of."""

    RUNTIME = auto()  # bit 62 or Control reset
    P2 = auto()  # Control reset: servo errors, measuring systems, travel limits, EMERGENCY STOP
    SYSTEM = auto()  # restart only


P2_GROUPS, SYSTEM_GROUPS = (2, 3, 13), (14, 15)  # group = code div 256


def kind_of(code: int) -> Kind:
    """The kind of a coded error 1..4095."""
    group = code >> 8
    return Kind.P2 if group in P2_GROUPS else Kind.SYSTEM if group in SYSTEM_GROUPS else Kind.RUNTIME


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a look at the image led to."""

    cleared: tuple[int, ...] = ()
    processes_end: bool = False  # Control reset: active processes are deselected, user outputs cleared


RESETS = {Kind.RUNTIME: Reset.ACKNOWLEDGE, Kind.P2: Reset.CONTROL_RESET, Kind.SYSTEM: Reset.RESTART}


class Faults:
    """The errors of the rho 3 in the list of the control, and the latch of EMERGENCY STOP."""

    def __init__(self, numbers: Numbers = AS_SHIPPED, errors: ErrorList | None = None) -> None:
        """`errors`: the list of the control; default: a separate one."""
        self.errors = ErrorList() if errors is None else errors
        self._numbers = numbers
        self._reset, self._acknowledge = Edge(CONTROL_RESET), Edge(ACKNOWLEDGE)
        self._panel = True
        self._open = False  # the chain, as seen last

    @property
    def shown(self) -> tuple[int, ...]:
        """Codes in the order they came."""
        return tuple(record.code for record in self.errors.records if record.source == RHO3)

    def came(self, code: int, active: bool = False, where: str = "", now: Ns = 0) -> None:
        """An error; `active`: its cause lasts until `gone`."""
        self.errors.report(code, where, now, source=RHO3, reset=RESETS[kind_of(code)])
        if not active:
            self.gone(code, where)

    def gone(self, code: int, where: str = "") -> None:
        """The cause has been removed; the error stays until it is acknowledged."""
        self.errors.gone(code, where, RHO3)

    def forget(self, code: int, where: str = "") -> None:
        """It is gone by another way than those of the interface."""
        self.errors.drop(code, where, RHO3)

    def update(self, image: PicImage, panel_reset: bool = False, now: Ns = 0) -> Outcome:
        """Looks at chain, acknowledgement and reset; `panel_reset`: mode 11.1 is being chosen on the PHG."""
        self._watch_chain(image.input(self._numbers.chain), now)
        acknowledged = self._acknowledge.rises(image)
        by_panel, self._panel = panel_reset and not self._panel, panel_reset
        reset = self._reset.rises(image) or by_panel
        cleared = self._clear(Reset.CONTROL_RESET if reset else Reset.ACKNOWLEDGE) if reset or acknowledged else ()
        image.put(self._numbers.emergency, EMERGENCY_STOP in self.shown)
        return Outcome(cleared, reset)

    def _watch_chain(self, closed: bool, now: Ns = 0) -> None:
        if not closed and not self._open:
            self.came(EMERGENCY_STOP, active=True, now=now)
        elif closed and self._open:
            self.gone(EMERGENCY_STOP)
        self._open = not closed

    def _clear(self, right: Reset) -> tuple[int, ...]:
        before = self.shown
        self.errors.acknowledge(right)
        left = self.shown
        return tuple(code for code in before if code not in left)
