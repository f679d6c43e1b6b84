"""Automatic and manual: globally, or kinematic by kinematic.  Source: rho3 3.3 (L2496-2602); status signals L2534-2560, AX-500."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from gateway.pure.controllers.pic_image import PicImage

TEST_MN, AUTO_MN, FIRST_KINEMATIC, KIN_A_MN = 22, 23, 38, 54  # RC inputs
POWERRED, PHG_ACTV, AUTO_OUT, TEST_OUT = 68, 72, 96, 97  # RC outputs
MOST = 10  # K01..K10


class Refusal(Enum):
    """Runtime errors of this chapter; the value is the manual's text."""

    MANUAL = "Inadmis. in manual op."
    SWITCHED = "AUTO/MANUAL switching"
    NOT_MANUAL = "kinematic is not in manual mode"  # referencing, teach in, test: the manual names no text


@dataclass(frozen=True, slots=True)
class RuntimeFault:
    """A runtime error of a program, caused by a kinematic (1..10)."""

    program: str
    kinematic: int
    why: Refusal


class OperatingModes:
    """Judges the mode of each kinematic once per look at the image and keeps the status signals right."""

    def __init__(self, kinematics: int) -> None:
        """`kinematics` 1..10; ValueError otherwise."""
        if not 1 <= kinematics <= MOST:
            raise ValueError(f"{kinematics} kinematics: 1..{MOST} have a signal")
        self._automatic = [False] * kinematics
        self._moving: dict[int, str] = {}  # kinematic -> program whose block runs on it
        self._barred: dict[int, set[str]] = {}  # kinematic -> programs that were switched over in motion
        self.per_kinematic = False

    def automatic(self, kinematic: int) -> bool:
        """The mode of kinematic 1.., as mode 7.3.3 shows it."""
        return self._automatic[kinematic - 1]

    def update(self, image: PicImage, phg_active: bool = False, emergency_without_rc: bool = False) -> list[RuntimeFault]:
        """Reads the mode signals, writes the status signals; faults: programs whose kinematic left automatic under a block."""
        self.per_kinematic = image.input(KIN_A_MN)
        faults: list[RuntimeFault] = []
        for number, before in enumerate(self._automatic, 1):
            now = image.input(FIRST_KINEMATIC + number - 1) if self.per_kinematic else image.input(AUTO_MN)
            self._automatic[number - 1] = now
            if before and not now and number in self._moving:
                faults.append(self._switched(number))
        self._status(image, phg_active, emergency_without_rc)
        return faults

    def prepare(self, program: str, kinematics: Iterable[int]) -> RuntimeFault | None:
        """A block of `program` is to be prepared for these kinematics: None, or the runtime error it ends with."""
        for number in kinematics:
            if self._barred.get(number):
                return RuntimeFault(program, number, Refusal.SWITCHED)
            if not self.automatic(number):
                return RuntimeFault(program, number, Refusal.MANUAL)
        return None

    def set_up(self, program: str, kinematic: int) -> RuntimeFault | None:
        """Referencing, teach in or a test step of this kinematic: with KIN_A_MN only in manual."""
        return RuntimeFault(program, kinematic, Refusal.NOT_MANUAL) if self.automatic(kinematic) else None

    def begins(self, program: str, kinematics: Iterable[int]) -> None:
        """A block of `program` moves these kinematics from now on."""
        self._moving |= dict.fromkeys(kinematics, program)

    def ends(self, program: str, kinematic: int = 0) -> None:
        """The block of `program` has ended; kinematic: the one it moved, 0: all it moves."""
        self._moving = {n: owner for n, owner in self._moving.items() if owner != program or (kinematic and n != kinematic)}

    def deselected(self, program: str) -> None:
        """Unlock the functions that `program` had barred: it was deselected or reset."""
        self.ends(program)
        for programs in self._barred.values():
            programs.discard(program)

    def _switched(self, number: int) -> RuntimeFault:
        program = self._moving.pop(number)
        self._barred.setdefault(number, set()).add(program)
        return RuntimeFault(program, number, Refusal.SWITCHED)

    def _status(self, image: PicImage, phg_active: bool, emergency: bool) -> None:
        every, some_manual = all(self._automatic), not all(self._automatic)
        image.put(AUTO_OUT, every)
        image.put(POWERRED, some_manual or emergency)
        test = image.input(TEST_MN)
        if self.per_kinematic:
            image.put(PHG_ACTV, some_manual)
            image.put(TEST_OUT, test and some_manual)
        else:
            image.put(PHG_ACTV, some_manual and phg_active)
            image.put(TEST_OUT, test)
