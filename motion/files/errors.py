"""Runtime errors of MOVE_FILE by their numbers.  Source: rho 3 Releases part 2 (TO05), section 5.3 (L7195-7212), L7144."""

from motion.errors import MotionError

REAL_EXPRESSION, READ_BEGIN_EXPECTED = 38, 63
VERSION, AXES, READ_MARKER, TIME_BASE, BASE, FORMAT, MODULO_FLAG, NO_ENDLESS_AXIS = range(95, 103)

TEXTS = {
    REAL_EXPRESSION: "Inad. Real-Expression",
    READ_BEGIN_EXPECTED: "READ_BEGIN expected",
    VERSION: "MF: Version identification",
    AXES: "MF: No. of axes",
    READ_MARKER: "MF: Read marker err.",
    TIME_BASE: "MF: Time base",
    BASE: "MF: IP-PL base",
    FORMAT: "MF: Format error",
    MODULO_FLAG: "MF: MOD-Flag n. init.",
    NO_ENDLESS_AXIS: "MF: No endless axis",
}


class MoveFileError(MotionError):
    """Ends the process.  code: the manual's number; text: as the control shows it; axis: its name, where one is to blame."""

    def __init__(self, code: int, detail: str = "", axis: str = "") -> None:
        self.code, self.text, self.detail, self.axis = code, TEXTS[code], detail, axis
        super().__init__(f"{self.text} (rho 3 {code}){f': {detail}' if detail else ''}")
