"""Run-time errors of the language.  Source: VAL 3 reference, task status L3656-3698 and appendix L6607-6710."""

from motion.val3.errors import TEXTS as MOTION_TEXTS

TEXTS: dict[int, str] = {
    -1: "no task of that name",
    0: "suspended without error",
    1: "running",
    10: "invalid calculation: division by zero",
    11: "invalid calculation",
    20: "array index above the size",
    21: "array index negative",
    23: "collection used with an empty key",
    25: "collection used with a key that it does not have",
    29: "invalid task name",
    30: "the name is not that of a VAL 3 task",
    31: "task name already in use",
    32: "more than 2 different periods of synchronous tasks",
    33: "3000 lines reached in one synchronous cycle",
    34: "instruction cannot be run by 2 tasks at once",
    40: "not enough data memory",
    41: "run-time memory of the task too small",
    45: "wdgRefresh on a system without watchdog",
    60: "instruction exceeded its maximum time",
    61: "internal interpreter error",
    70: "invalid parameter value",
    71: "invalid operation on a local variable",
    80: "data or program of a library that is not in memory",
    81: "incompatible kinematics",
    82: "reference frame or tool out of scope",
    90: "the task cannot resume at that line",
    122: "write to a system input",
    123: "variable not linked to a system input or output",
    124: "access to a protected system input or output",
    125: "read or write error on an input or output",
    126: "invalid aio format",
    170: "mobile frame cannot be linked to another",
    171: "mobile frame expected",
    250: "no run-time licence for this instruction",
    270: "bad file path",
    271: "file cannot be read",
    290: "invalid path type",
    301: "external axis position required",
    513: "motion generator: internal error",
    514: "motion generator: bad parameter",
    515: "motion generator: bad state",
    525: "arm position in a forbidden zone",
    535: "the position found lies in a forbidden zone",
    536: "the positions found lie outside the joint limits or in forbidden zones",
    541: "Cartesian path interrupted",
    560: "reserved",
    561: "no blending with movejSync",
    562: "no joint blending while tracking: use Cartesian",
    563: "no blending with trajMove",
    564: "no blending with splines",
    565: "no Cartesian blending between kinematics with and without external axes",
    571: "invalid part of a kinematic chain",
    572: "carried part: use resetMotion",
    573: "carried tool: use resetMotion",
    574: "carried part not supported for this move",
    580: "trackOn required",
    581: "trackOff required",
    582: "motion frame changed: use trackOn",
    590: "alter: invalid state, command ignored",
    600: "motion generator locked to release a mobile frame",
    610: "reserved",
    611: "boxcar frequency too low",
    999: "see the log",
}
TEXTS.update({code: text for code, text in MOTION_TEXTS.items() if code not in TEXTS})


class Rte(Exception):
    """A run-time error: stops its task on the line."""

    def __init__(self, code: int, detail: str = "") -> None:
        words = TEXTS.get(code, "run-time error")
        super().__init__(f"{words} ({detail})" if detail else words)
        self.code, self.detail = code, detail


def help_text(code: float) -> str:
    """help(): the description of a code, "" where there is none."""
    return TEXTS.get(int(code), "") if code == int(code) else ""
