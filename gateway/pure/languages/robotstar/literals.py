"""Values in a step that no variable of the destination's name accepts, whatever program calls this one.  The texts are those with which
the step stops.
"""

from collections.abc import Callable, Sequence

from gateway.pure.languages.robotstar.faults import WRONG_TYPES, StepFault
from gateway.pure.languages.robotstar.operands import Number, Operand, Ref, Text
from gateway.pure.languages.robotstar.path import RANGES, outside
from gateway.pure.languages.robotstar.program import Step
from gateway.pure.languages.robotstar.system import ALIASES, DEFAULTS
from gateway.pure.languages.robotstar.values import Array, Cell, Scalar, Variable, converted

MATH = ("ADD", "SUB", "MUL", "DIV", "MODULO")
LOGIC = ("AND", "OR", "EXCL_OR")


def wrong_literal(step: Step, found: Callable[[Ref], Sequence[Variable]]) -> str:
    """Return the fault of COPY: too long a text, a number outside the range of a system variable."""
    value, destination = step.slots.get("source"), step.slots.get("destination")
    if step.word != "COPY" or not isinstance(value, Number | Text) or not isinstance(destination, Ref) or destination.element:
        return ""
    texts = [_refusal(value.value, destination.name, variable) for variable in found(destination)]
    return texts[0] if texts and all(texts) else ""


def _refusal(value: Scalar, name: str, variable: Variable) -> str:
    cell = variable.items[0] if isinstance(variable, Array) and variable.items else variable
    if not isinstance(cell, Cell):
        return ""
    try:
        value = converted(value, cell.kind, cell.length)
    except StepFault as fault:
        return fault.text
    name = ALIASES.get(name, name)
    parameter = DEFAULTS.get(name, name)
    if parameter in RANGES and not isinstance(value, str):
        low, high = RANGES[parameter]
        if not low <= value <= high:
            return outside(parameter, value, low, high)
    return ""


def wrong_kind(step: Step, kind_of: Callable[[str], str]) -> str:
    """Of mathematics, logic and tests: an operand that is not a number, or no integer."""
    if step.word in ("TEST", "TEST_BIT"):
        return _wrong_test(step, kind_of)
    allowed = "IR" if step.word in MATH else "I" if step.word in LOGIC else ""
    if not allowed:
        return ""
    kinds = (_kind(step.slots[place], kind_of) for place in ("source", "destination"))
    return "" if all(kind in allowed for kind in kinds) else WRONG_TYPES


def _wrong_test(step: Step, kind_of: Callable[[str], str]) -> str:
    """Return the fault of #VARIABLE: a bit of a non-integer, a structure, a text compared with a number."""
    if getattr(step.slots["area"], "name", "") != "VARIABLE":
        return ""
    if step.word == "TEST_BIT":
        return "" if _kind(step.slots["byte"], kind_of) in ("", "I") else WRONG_TYPES
    first, second = (_kind(step.slots[place], kind_of) for place in ("first", "second"))
    mixed = bool(first and second) and (first == "S") != (second == "S")
    return WRONG_TYPES if mixed or {first, second} & set("VPT") else ""


def _kind(operand: Operand, kind_of: Callable[[str], str]) -> str:
    """I, R, S, V, P or T; "" where it is not known."""
    if isinstance(operand, Text):
        return "S"
    if isinstance(operand, Number):
        return "I" if isinstance(operand.value, int) else "R"
    if not isinstance(operand, Ref) or operand.element or operand.name.startswith("_"):
        return ""
    return kind_of(operand.name)
