"""The rule by which a compiler distinguishes the two forms of movej.  Source: VAL 3 reference L5736-5752, doubt none.

The first parameter is a joint or a point; an explicit structured literal could be either, so it is refused at compile time and
must be put into a variable first.
"""

from enum import Enum

from motion.val3.errors import AmbiguousExpression, RuntimeFault


class Operand(Enum):
    """What the compiler knows about the first argument."""

    JOINT = "joint"  # variable, element or call of type joint
    POINT = "point"
    LITERAL = "literal"  # {a, b, ...}: a structure without a type of its own
    OTHER = "other"


class Form(Enum):
    """Which of the two instructions is meant."""

    MOVEJ_JOINT = "movej(joint, tool, mdesc)"
    MOVEJ_POINT = "movej(point, tool, mdesc)"


def movej_form(operand: Operand, text: str = "") -> Form:
    """The form of movej; text: the argument as written.  AmbiguousExpression for a literal, RuntimeFault 70 for another type."""
    if operand is Operand.LITERAL:
        raise AmbiguousExpression(text)
    if operand is Operand.OTHER:
        raise RuntimeFault(70, f"{text}: a joint or a point is expected")
    return Form.MOVEJ_JOINT if operand is Operand.JOINT else Form.MOVEJ_POINT
