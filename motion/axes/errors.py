"""Runtime errors and warnings of single axes, in the words of the rho 3 (which prints no numbers for the first two)."""

from motion.errors import MotionError

DRIVE_ON_NOT_AVAILABLE = "DRIVE ON not avail."
DRIVE_ON_NOT_ALLOWED = "DRIVE ON not allowed"
SERVO_ERROR = "servo error"


class AxisError(MotionError):
    """Aborts the program.  axis: number from 1; text: as the rho 3 prints it; code: its number or 0."""

    def __init__(self, text: str, axis: int, detail: str = "", code: int = 0) -> None:
        self.text, self.axis, self.code = text, axis, code
        super().__init__(f"axis {axis}: {text}{f' ({detail})' if detail else ''}")
