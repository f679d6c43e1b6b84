"""Run-time errors of the motion instructions, by their numbers.  Source: VAL 3 reference, L3656-3698 and appendix L6607-6710."""

from motion.errors import MotionError

TEXTS = {
    60: "instruction exceeded its maximum time",
    70: "invalid parameter value",
    100: "mdesc speed invalid",
    101: "mdesc acceleration invalid",
    102: "mdesc deceleration invalid",
    103: "mdesc tvel invalid",
    104: "mdesc rvel invalid",
    105: "mdesc reach invalid",
    106: "mdesc leave invalid",
    150: "a move requested earlier could not be completed",
    153: "motion command not supported",
    154: "invalid motion instruction",
    160: "tool flange coordinates invalid",
    161: "frame world coordinates invalid",
    162: "point without reference frame",
    163: "frame without reference frame",
    164: "tool without reference tool",
    165: "invalid reference",
    250: "no run-time licence",
    520: "joint position outside the software limits",
    530: "no joint solution: point probably out of reach",
    531: "position outside the joint limits",
    532: "position outside the workspace",
    533: "unreachable in the given configuration",
    534: "orientation unreachable with this arm",
    540: "singularity cannot be crossed here",
    542: "configuration break: the joint position reached does not fit the next move",
    543: "robot not at the start of its trajectory",
    544: "the path drives a joint out of its range",
    550: "arc: angle from start to intermediate point is above 180 degrees",
    551: "arc: angle from intermediate point to end is above 180 degrees",
    552: "arc: points too close",
    553: "arc: orientation changes by exactly 180 degrees",
    554: "Cartesian blend: rotation too large",
    570: "invalid data for this arm",
}


class RuntimeFault(MotionError):
    """A run-time error of a task; code: its number."""

    def __init__(self, code: int, detail: str = "") -> None:
        self.code, self.detail = code, detail
        words = TEXTS.get(code, "motion generator")
        super().__init__(f"VAL 3 error {code}: {words}{f' ({detail})' if detail else ''}")


class AmbiguousExpression(MotionError):
    """Compile error: a structured literal where both a joint and a point would do (L5742-5752)."""

    def __init__(self, literal: str) -> None:
        self.literal = literal
        super().__init__(f'"{literal}": Ambiguous expression')
