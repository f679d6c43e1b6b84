"""Errors at the interface: what acknowledges what.  Source: rho3 3.3, 9.1 (L1072-1076, L3033, L3059-3065, L4046-4068), AX-501.

Error acknowledgement (bit 62) clears errors and leaves processes alone; Control reset (bit 19) or PHG 11.1 clears more and ends
processes; EMERGENCY STOP and P2 errors need Control reset; system errors need a restart.
"""

from dataclasses import dataclass
from enum import Enum, auto

from gateway.pure.interface.image import Edge, PicImage
from gateway.pure.interface.numbers import AS_SHIPPED, Numbers

CONTROL_RESET, ACKNOWLEDGE = 19, 62  # RC inputs
EMERGENCY_STOP = 528
SYSTEM_BASE = 3583  # coded error = base + system error number
MOST_SYSTEM = 4095 - SYSTEM_BASE


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


def system_code(number: int) -> int:
    """Code at the interface of system error `number`: 133 is 3716.  ValueError outside 1..512."""
    if not 1 <= number <= MOST_SYSTEM:
        raise ValueError(f"system error {number}: 1..{MOST_SYSTEM} have a code")
    return SYSTEM_BASE + number


def system_number(code: int) -> int:
    """The reverse of system_code; ValueError for a code that is none of a system error."""
    if kind_of(code) is not Kind.SYSTEM:
        raise ValueError(f"code {code}: system errors are {SYSTEM_BASE + 1}..4095")
    return code - SYSTEM_BASE


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a look at the image led to."""

    cleared: tuple[int, ...] = ()
    processes_end: bool = False  # Control reset: active processes are deselected, user outputs cleared


class Faults:
    """The errors that are shown, each with whether its cause still stands, and the latch of EMERGENCY STOP."""

    def __init__(self, numbers: Numbers = AS_SHIPPED) -> None:
        self._numbers = numbers
        self._causes: dict[int, bool] = {}
        self._reset, self._acknowledge = Edge(CONTROL_RESET), Edge(ACKNOWLEDGE)
        self._panel = True

    @property
    def shown(self) -> tuple[int, ...]:
        """Codes in the order they came."""
        return tuple(self._causes)

    def came(self, code: int, stands: bool = False) -> None:
        """An error; `stands`: its cause lasts until `gone`."""
        self._causes[code] = stands

    def gone(self, code: int) -> None:
        """The cause has been removed; the error stays until it is acknowledged."""
        if code in self._causes:
            self._causes[code] = False

    def update(self, image: PicImage, panel_reset: bool = False) -> Outcome:
        """Looks at chain, acknowledgement and reset; `panel_reset`: mode 11.1 is being chosen on the PHG."""
        self._watch_chain(image.input(self._numbers.chain))
        acknowledged = self._acknowledge.rises(image)
        by_panel, self._panel = panel_reset and not self._panel, panel_reset
        reset = self._reset.rises(image) or by_panel
        cleared = self._clear({Kind.RUNTIME, Kind.P2} if reset else {Kind.RUNTIME} if acknowledged else set())
        image.put(self._numbers.emergency, EMERGENCY_STOP in self._causes)
        return Outcome(cleared, reset)

    def _watch_chain(self, closed: bool) -> None:
        if not closed:
            self.came(EMERGENCY_STOP, stands=True)
        else:
            self.gone(EMERGENCY_STOP)

    def _clear(self, kinds: set[Kind]) -> tuple[int, ...]:
        cleared = tuple(code for code, stands in self._causes.items() if not stands and kind_of(code) in kinds)
        for code in cleared:
            del self._causes[code]
        return cleared
