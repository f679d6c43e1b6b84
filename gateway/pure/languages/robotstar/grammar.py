"""The parameters of each command: their places, what may be there, their descriptors.  Source: robotstar 2.4, 2.5."""

from collections.abc import Mapping
from dataclasses import dataclass

from gateway.pure.languages.robotstar.operands import RELATIONS, Blank, Equate, Number, Operand, Ref, Text

LEAST = 1e-6  # means "above 0"
MODES = ("PTP", "LINEAR", "SPLINE", "ZIRK_MIN_ORI", "ZIRK_BAHN_ORI")


@dataclass(frozen=True, slots=True)
class Place:
    """One parameter.  `kind`: number, name, text, value (any of them), equate; `types`: first letters of a variable there."""

    name: str
    kind: str
    descriptors: tuple[str, ...] = ()
    equates: tuple[str, ...] = ()
    optional: bool = False
    types: str = ""
    low: float | None = None
    high: float | None = None


def number(name: str, *descriptors: str, low: float | None = None, high: float | None = None, optional: bool = False) -> Place:
    """A number, or a variable of type I or R."""
    return Place(name, "number", (*descriptors, "VALUE"), types="IR", low=low, high=high, optional=optional)


def variable(name: str, types: str, *descriptors: str) -> Place:
    """A variable of one of the types."""
    return Place(name, "name", (*descriptors, "VARIABLE", "NAME"), types=types)


def equate(name: str, *equates: str) -> Place:
    """A system equate."""
    return Place(name, "equate", equates=equates)


def label(optional: bool = False) -> Place:
    """The name of a label, with or without quotes."""
    return Place("label", "text", ("LABEL", "NAME"), optional=optional)


def program(name: str = "program", *descriptors: str) -> Place:
    """A program's name: a text, a string variable, or a bare name."""
    return Place(name, "text", (*descriptors, "NAME"))


_BYTE = Place("byte", "value", ("BYTE", "VARIABLE"))
_BIT = number("bit", "BIT", low=0, high=31)
_SOURCE = Place("source", "value", ("SOURCE", "OP_1"))
_DESTINATION = Place("destination", "name", ("DESTINATION", "VARIABLE", "OP_2", "NAME"))
_MATH = (_SOURCE, _DESTINATION)
_LOGIC = (Place("source", "value", ("SOURCE", "OP_1")), variable("destination", "I", "DESTINATION", "OP_2"))
_VECTORS = (variable("source", "V", "SOURCE", "OP_1", "VECTOR"), variable("destination", "V", "DESTINATION", "OP_2"))
_DEFINITION = (Place("name", "name", ("NAME", "VARIABLE")), Place("value", "value", ("VALUE",), optional=True))

GRAMMAR: Mapping[str, tuple[Place, ...]] = {
    "END": (),
    "STOP": (),
    "TOOL": (variable("tool", "T"),),
    "VAR_POS": (variable("position", "P"),),
    "ACT_POS": (variable("position", "P", "DESTINATION"),),
    "MOVE_MODE": (equate("mode", *MODES),),
    "PTP_SPEED": (number("value", low=LEAST, high=100),),
    "PTP_ACCEL": (number("value", low=LEAST, high=100),),
    "PATH_SPEED": (number("value", low=LEAST, high=1e6),),
    "PATH_ACCEL": (number("value", low=LEAST, high=100),),
    "PATH_TIME": (number("value", low=0, high=1e6),),
    "FLYBY": (equate("value", "ON", "OFF"),),
    "PATH_RADIUS": (number("value", low=0, high=1e6),),
    "PATH_DISTANCE": (number("value", low=0, high=1e6),),
    "RELATIVE": (variable("vector", "V_", "VECTOR"),),
    "CALC_REL": (variable("vector", "V", "VECTOR"),),
    "WRITE_BIT": (equate("area", "OUTPUT", "MARKER"), number("level", "LEVEL", low=0, high=1), _BYTE, _BIT),
    "WAIT_BIT": (
        equate("area", "INPUT", "OUTPUT", "MARKER", "VARIABLE"),
        number("level", "LEVEL", low=0, high=1),
        _BYTE,
        _BIT,
        number("time", "TIME", low=0, high=1e9, optional=True),
        label(optional=True),
    ),
    "TEST_BIT": (equate("area", "INPUT", "OUTPUT", "MARKER", "VARIABLE"), equate("condition", "=0", "=1"), _BYTE, _BIT, label()),
    "TEST": (
        equate("area", "INPUT", "OUTPUT", "MARKER", "VARIABLE"),
        Place("first", "value", ("OP_1",)),
        equate("relation", *RELATIONS),
        Place("second", "value", ("OP_2", "BYTE", "VARIABLE")),
        label(),
    ),
    "ANA_OUTP": (number("voltage", "VOLTAGE", low=-10, high=10), number("channel", "COUNT", low=1, high=24)),
    "ANA_INP": (number("channel", "COUNT", low=1, high=24), variable("destination", "R", "DESTINATION")),
    "PROGRAM": (program(),),
    "CALL": (program(),),
    "WAIT": (number("time", "TIME", low=0, high=1e9),),
    "LABEL": (label(),),
    "BRANCH": (label(),),
    "VAR": _DEFINITION,
    "LOC_VAR": _DEFINITION,
    "CONST": _DEFINITION,
    "LOC_CONST": _DEFINITION,
    "COPY": (_SOURCE, _DESTINATION),
    "COPY_OFFSETS": (
        number("from", "SOURCE_INDEX", low=1, high=36),
        _SOURCE,
        number("to", "DESTINATION_INDEX", low=1, high=36),
        _DESTINATION,
        number("count", "COUNT", low=1, high=36),
    ),
    **dict.fromkeys(("ADD", "SUB", "MUL", "DIV", "MODULO"), _MATH),
    "NEG": (Place("destination", "name", ("DESTINATION", "VARIABLE", "OP_1", "NAME"), types="IR_"),),
    "VEC_ADD": _VECTORS,
    "VEC_SUB": _VECTORS,
    "VEC_VALUE": (variable("source", "V_", "SOURCE", "OP_1", "VECTOR"), variable("destination", "R", "DESTINATION", "OP_2")),
    **dict.fromkeys(("AND", "OR", "EXCL_OR"), _LOGIC),
    "INVERT": (variable("destination", "I_", "DESTINATION", "OP_1"),),
    **dict.fromkeys(
        ("SHIFT_L", "SHIFT_R"),
        (number("count", "COUNT", "OP_1", low=0, high=2**31 - 1), variable("destination", "I_", "DESTINATION", "OP_2")),
    ),
    "PALLET": (program(), equate("order", "INIT", "ON", "OFF")),
    "TRAFO_6D": (
        program("ref_source", "REF_SOURCE"),
        program("ref_destination", "REF_DESTINATION"),
        program("source", "SOURCE"),
        program("destination", "DESTINATION"),
        variable("control", "I", "CONTROL"),
    ),
    "MOUSE_CALIBRATION": (variable("data", "V"),),
}
PRINTED = {"INPUT": "EINGANG", "OUTPUT": "AUSGANG", "MARKER": "MERKER"}  # equates as the manual prints them in both languages
PRINTED_SWITCH = {"ON": "EIN", "OFF": "AUS"}  # of UEBERSCHL (L1756); those of PALLET are #ON and #OFF
NOT_BUILT = {
    word: f"{spelling} is named by the manual only; its parameters are not known"
    for word, spelling in (("SEARCH_BIT", "SUCH_BIT"), ("OSCILLATION", "OSCILLATION"), ("WELDING", "WELDING"))
}


def fits(place: Place, operand: Operand) -> str:
    """ "" where the operand may be in the place, else what belongs there."""
    if place.kind == "equate":
        good = isinstance(operand, Equate) and operand.name in place.equates
        printed = PRINTED | (PRINTED_SWITCH if "INIT" not in place.equates else {})
        return "" if good else "one of " + ", ".join(f"#{printed.get(name, name)}" for name in place.equates)
    if isinstance(operand, Blank):
        return f"a value for <{operand.text}>"
    if isinstance(operand, Equate):
        return "no system equate"
    if place.kind == "text":
        plain = isinstance(operand, Ref) and not operand.element
        return "" if isinstance(operand, Text) or plain else "a name"
    if place.kind == "name":
        return "" if isinstance(operand, Ref) else "the name of a variable"
    if place.kind == "number":
        return "" if isinstance(operand, Number | Ref) else "a number or a variable"
    return ""


def typed(place: Place, operand: Operand) -> str:
    """ "" where type and range suit the place, else a sentence."""
    if isinstance(operand, Ref) and operand.name[0].isdigit() and place.kind != "text" and place.name != "name":
        shown = f"{operand.name}.{operand.element}" if operand.element else operand.name
        return f"{shown} is neither a number nor the name of a variable"
    if isinstance(operand, Ref) and place.types and not operand.element:
        if not operand.name.startswith("_") and operand.name[0] not in place.types:
            return f"{operand.name} is of type {operand.name[0]}; {' or '.join(place.types.strip('_'))} is needed"
    if isinstance(operand, Number) and place.low is not None and place.high is not None and not place.low <= operand.value <= place.high:
        if place.low == LEAST and not 0 < operand.value < LEAST:
            return f"{place.name} {operand.value:.10g} must be above 0 and at most {place.high:.10g}"
        return f"{place.name} {operand.value:.10g} is outside {place.low:.10g} .. {place.high:.10g}"
    return ""
