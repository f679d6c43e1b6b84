"""Operators and their operand types.  Source: VAL 3 reference, tables of operators L1511-5722 (spec 2.5)."""

from gateway.pure.languages.val3.model import Type, UserType

EQUAL = frozenset("bool num string joint trsf frame tool point config mdesc shoulder elbow wrist blend".split())
STRUCTURES = frozenset("joint trsf frame tool point config mdesc".split())
ORDER = (">=", ">", "<=", "<")
ARITHMETIC: dict[str, dict[str, str]] = {  # operator -> type -> Python
    "+": {"num": "({0} + {1})", "string": "join({0}, {1})", "joint": "joint_sum({0}, {1})"},
    "-": {"num": "({0} - {1})", "joint": "joint_difference({0}, {1})"},
    "*": {"num": "({0} * {1})", "trsf": "trsf_product({0}, {1})"},
    "/": {"num": "({0} / {1})"},
    "%": {"num": "modulo({0}, {1})"},
}


def compare(operator: str, kind: Type, left: str, right: str) -> str | None:
    """Python of a comparison; None: the type has no such operator."""
    if isinstance(kind, UserType):
        return None
    if operator in ("==", "!="):
        if kind not in EQUAL:
            return None
        if kind in STRUCTURES:
            return f"{left}.same({right})" if operator == "==" else f"(not {left}.same({right}))"
        return f"({left} {operator} {right})"
    if kind == "num":
        return f"({left} {operator} {right})"
    if kind == "joint" and operator in (">", "<"):
        return f"joint_above({left}, {right})" if operator == ">" else f"joint_below({left}, {right})"
    return None


def fits(given: Type, wanted: Type) -> bool:
    """Whether a value of one type does where another is wanted, as it is or by reading an input."""
    return given is wanted or given == wanted or (wanted == "bool" and given == "dio")
