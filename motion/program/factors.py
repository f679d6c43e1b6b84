"""A, D and V factors of the rho 3: global and per kinematic, their product, and what resets them.

Source: rho 3 Releases part 1, sections 14 (L2671-2745) and P25 (L5087-5117); doubt D-60: a set bit inverts what its operation
does by default.  Manual speeds and the jog keys are in motion/program/jog.py.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

from motion.errors import MotionError


@dataclass(frozen=True, slots=True)
class Factors:
    """Velocity, acceleration, deceleration; 1.0 is 100 %."""

    velocity: float = 1.0
    acceleration: float = 1.0
    deceleration: float = 1.0

    def __post_init__(self) -> None:
        for name, value in (("V", self.velocity), ("A", self.acceleration), ("D", self.deceleration)):
            if not 0.0 <= value <= 1.0:  # a NaN fails here too
                raise MotionError(f"{name} factor {value:.6g} is outside 0 .. 1")

    def times(self, other: "Factors") -> "Factors":
        """Global times kinematic: what acts on a block."""
        return Factors(self.velocity * other.velocity, self.acceleration * other.acceleration, self.deceleration * other.deceleration)


FULL = Factors()


class Operation(Enum):
    """What may reset factors.  Value: (bit for kinematic factors, bit for global factors) of the option byte; P25 has the same order."""

    CONTROL_RESET = (0, 4)
    AUTO_TO_MANUAL = (1, 5)
    MANUAL_TO_AUTO = (2, 6)
    PROCESS_START = (3, 7)


# Option byte 0: which of (kinematic, global) becomes 1.0 (L2707-2719); a set bit inverts its entry (D-60).
DEFAULT_RESETS = {
    Operation.CONTROL_RESET: (False, True),
    Operation.AUTO_TO_MANUAL: (False, False),
    Operation.MANUAL_TO_AUTO: (False, False),
    Operation.PROCESS_START: (True, False),
}


def option_byte(p25: Sequence[int]) -> int:
    """P25 (eight entries of 0 or 1, bit 0 first) as the option byte (L5087-5117)."""
    if len(p25) != 8 or any(entry not in (0, 1) for entry in p25):
        raise MotionError(f"P25 {list(p25)}: eight entries, each 0 or 1, are needed")
    return sum(entry << bit for bit, entry in enumerate(p25))


def resets(operation: Operation, option: int) -> tuple[bool, bool]:
    """(kinematic factors become 1.0, global factors become 1.0); raises MotionError for an option byte outside 0 .. 255."""
    if not 0 <= option <= 255:
        raise MotionError(f"option byte {option} is outside 0 .. 255")
    kinematic, world = DEFAULT_RESETS[operation]
    for_kinematic, for_world = operation.value
    return kinematic != bool(option >> for_kinematic & 1), world != bool(option >> for_world & 1)


class FactorTable:
    """The factors of one control: one global set, one for each kinematic (by its number, 1..); all 1.0 at start-up (L2713)."""

    def __init__(self, kinematics: int, option: int = 0) -> None:
        resets(Operation.CONTROL_RESET, option)
        self._option = option
        self._global = FULL
        self._kinematic = [FULL] * kinematics

    def set_global(self, **shares: float) -> None:
        """From the PHG (mode 11.4 .. 11.6) or the interface; never from a program.  velocity=, acceleration=, deceleration=."""
        self._global = replace(self._global, **shares)

    def set_kinematic(self, kinematic: int, **shares: float) -> None:
        """kin.VFACTOR, AFACTOR, DFACTOR of a program."""
        self._kinematic[self._place(kinematic)] = replace(self._kinematic[self._place(kinematic)], **shares)

    def global_factors(self) -> Factors:
        """As set last, or 1.0."""
        return self._global

    def kinematic_factors(self, kinematic: int) -> Factors:
        """Those of kinematic 1.. alone."""
        return self._kinematic[self._place(kinematic)]

    def acting(self, kinematic: int) -> Factors:
        """What a block of this kinematic runs with."""
        return self._global.times(self._kinematic[self._place(kinematic)])

    def happened(self, operation: Operation, kinematic: int | None = None) -> None:
        """Reset what the option byte selects; kinematic: the one whose process starts or whose mode changes, None: all of them.

        The global factors are one set: resetting them acts on every kinematic, also on one that moves (note to bit 7).
        """
        for_kinematic, for_world = resets(operation, self._option)
        if for_world:
            self._global = FULL
        if for_kinematic:
            for place in range(len(self._kinematic)) if kinematic is None else [self._place(kinematic)]:
                self._kinematic[place] = FULL

    def _place(self, kinematic: int) -> int:
        if not 1 <= kinematic <= len(self._kinematic):
            raise MotionError(f"kinematic {kinematic} is outside 1 .. {len(self._kinematic)}")
        return kinematic - 1
