"""The parts of the interface that look at the image once per cycle, in their order."""

from dataclasses import dataclass

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.drives import DisabledAxes, drive_on
from gateway.pure.controllers.rho3.signals.errors import Faults, Outcome
from gateway.pure.controllers.rho3.signals.machine_type import show_machine
from gateway.pure.controllers.rho3.signals.modes import OperatingModes, RuntimeFault
from gateway.pure.controllers.rho3.signals.numbers import AS_SHIPPED, Numbers
from gateway.pure.controllers.rho3.signals.pic import PicLink
from gateway.pure.controllers.rho3.signals.timers import TimersAndCounters
from gateway.pure.controllers.rho3.signals.user import OUTPUTS, UserPorts
from gateway.pure.image.error_list import ErrorList
from protocols.base.machine import Ns


@dataclass(frozen=True, slots=True)
class Installation:
    """Machine parameters of the interface; the numbers are the manual's."""

    axes: int = 12
    kinematics: int = 1
    p2: int = 0  # machine configuration
    p3: int = 8  # timers and counters
    p13: tuple[int, ...] = ()  # timers, units
    p14: tuple[int, ...] = ()  # counters, pulses
    p24: int = OUTPUTS  # user outputs a Control reset clears
    p27: int = 0  # INTEGER inputs with strobe
    unit: Ns = 10_000_000  # of timers: gateway.pure.controllers.rho3.signals.timers.unit_of


@dataclass(frozen=True, slots=True)
class Seen:
    """What a cycle of the interface led to."""

    outcome: Outcome
    switched: tuple[RuntimeFault, ...]  # programs whose kinematic left automatic under a block
    drive_on: int  # mask of axes
    disabled: int  # mask of axes


class SignalInterface:
    """Call `step` once per cycle with the image filled by the command sources; the outputs of the interface are written into it."""

    def __init__(
        self,
        image: PicImage,
        installation: Installation,
        numbers: Numbers = AS_SHIPPED,
        errors: ErrorList | None = None,
        *,
        pic: bool = False,
    ) -> None:
        """`numbers`: of our own signals, where a cell has moved them; `errors`: the control's list; `pic`: a program is scanned.

        ValueError: a parameter out of its range.
        """
        self.image, self._installation = image, installation
        self.modes = OperatingModes(installation.kinematics)
        self.faults = Faults(numbers, errors)
        self.user = UserPorts(image, installation.p24, installation.p27, numbers)
        self.timers = TimersAndCounters(installation.p3, installation.p13, installation.p14, installation.unit)
        self.pic = PicLink(image, self.timers) if pic else None  # of the interpreter: it steps timers and counters
        self._disabled = DisabledAxes(installation.axes)
        show_machine(image, installation.p2)

    def step(
        self, elapsed: Ns, phg_active: bool = False, emergency_without_rc: bool = False, panel_reset: bool = False, now: Ns = 0
    ) -> Seen:
        """`elapsed`: since the last step; `now`: stamp of errors."""
        show_machine(self.image, self._installation.p2)
        for code in self._disabled.update(self.image):
            self.faults.came(code, now=now)
        switched = tuple(self.modes.update(self.image, phg_active, emergency_without_rc))
        self.user.look()
        outcome = self.faults.update(self.image, panel_reset, now)
        if outcome.processes_end:
            self.user.control_reset()
        if self.pic is None:
            self.timers.step(self.image.flags, elapsed)
        on = drive_on(self.image, self._installation.axes)
        return Seen(outcome, switched, on & ~self._disabled.mask, self._disabled.mask)
