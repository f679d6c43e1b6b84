"""Errors of belt synchronisation by the numbers of the rho 3.  Source: rho 3 Releases part 1, TO04 sections 14-16, L5998-6480.

Codes that depend on the kinematic are those of kinematic 1; kinematics 2 .. 10 follow (928 .. 937, 944 .. 953), and 11 .. 16, which the
manual does not list, after them (AX-552).
"""

from motion.errors import MotionError

NOT_POSSIBLE, NO_PTP, NO_DISTANCE, WRONG_KIND, NO_BELT = 20, 23, 89, 92, 93
EMERGENCY_STOP = 528
DIRECTION, TOLERANCE = 928, 944  # of kinematic 1
KINEMATICS = 16
OTHER_ERRORS = "other errors"  # text of the process display for 528, 928 .. 937 and 944 .. 953

TEXTS = {
    NOT_POSSIBLE: "Belt-sync. n.possible",
    NO_PTP: "PTP not allowed for belt synchronous or sensor movement",
    NO_DISTANCE: "beltdistance is zero",
    WRONG_KIND: "wrong belt-kind/-tol",
    NO_BELT: "Inadmiss. Belt-No",
    EMERGENCY_STOP: "EMERGENCY STOP - Input",
    DIRECTION: "wrong belt direction",
    TOLERANCE: "BS-tolerance too big",
}


class BeltError(MotionError):
    """Aborts the program.  code: of the kinematic; text: as printed; kinematic: from 1, 0 where none is concerned.

    codes: everything that is shown: a fault inside a synchronous part of type 2 or 3 shows 528 as well (L6112, L6324).
    opens_ready: the READY contact opens, so that the belt can be stopped.
    """

    def __init__(self, code: int, detail: str = "", *, kinematic: int = 0, synchronous: bool = False) -> None:
        self.text, self.kinematic, self.detail = TEXTS[code], kinematic, detail
        self.code = code + kinematic - 1 if code in (DIRECTION, TOLERANCE) else code
        self.opens_ready = synchronous
        self.codes = (self.code, EMERGENCY_STOP) if synchronous else (self.code,)
        self.display = OTHER_ERRORS if code in (DIRECTION, TOLERANCE) else self.text
        where = f"kinematic {kinematic}: " if kinematic else ""
        super().__init__(f"{where}{self.text} ({self.code}{f', {detail}' if detail else ''})")
