"""Names of faults of belt-synchronous and alter sections: the words of the rho 3 for its numbers, axisgate's for its own (AX-545,
AX-547).  Pure.
"""

from motion.sync.errors import DIRECTION, KINEMATICS, TEXTS, TOLERANCE

OURS = {
    65001: "the axis would leave its travel on the belt",
    65002: "no telegram from the belt's encoder",
    65003: "the axis cannot keep up with the belt",
    65004: "the correction is silent",
    65005: "the altered position cannot be reached (VAL 3 alter -3)",
    65006: "the altered path is too fast for its alterBegin (VAL 3 alter -3)",
}


def belt_words(code: int, block: int, axis: str) -> str:
    """One line: block, axis, words, number; empty for code 0."""
    if not code:
        return ""
    where = ", ".join(part for part in (f"block {block}" if block else "", f"axis {axis}" if axis else "", _kinematic(code)) if part)
    words = OURS.get(code) or f"{TEXTS.get(_base(code), 'belt error')} (rho 3 {code})"
    return f"{where}: {words}" if where else words


def _base(code: int) -> int:
    """Without the kinematic it depends on."""
    return next((base for base in (DIRECTION, TOLERANCE) if base <= code < base + KINEMATICS), code)


def _kinematic(code: int) -> str:
    return f"kinematic {code - _base(code) + 1}" if _base(code) in (DIRECTION, TOLERANCE) else ""
