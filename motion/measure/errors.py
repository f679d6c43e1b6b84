"""Runtime errors of rho 3 programs in this part of the core: the text as the control prints it, its number where it has one."""

from motion.errors import MotionError

POINT_NOT_DEFINED = "point not defined"  # L1132
INADMISSABLE_INPUT = "inadmissable input"  # L1257-1259, so spelt
POINT_INVALID = "Point is invalid"  # 90, L5319
BAD_MEASURING_SYSTEM = "Inadmiss. meas. sys."  # 91, L5255


class ProgramFault(MotionError):
    """Ends the program.  text: as the control shows it; code: its number, 0 where the manual prints none."""

    def __init__(self, text: str, detail: str = "", code: int = 0) -> None:
        self.text, self.code, self.detail = text, code, detail
        number = f" (rho 3 {code})" if code else ""
        super().__init__(f"{text}{number}{f': {detail}' if detail else ''}")
