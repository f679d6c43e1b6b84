"""Translates calls: subroutines, external subroutines, special functions, standard procedures."""

from gateway.pure.languages.baps2 import standard
from gateway.pure.languages.baps2.output import Writer
from gateway.pure.languages.baps2.scope import Symbol, python_name
from gateway.pure.languages.baps2.tree import CallStatement, Expression, Index, Member, Name
from gateway.pure.languages.baps2.types import INTEGER, NONE, Type, fits, same
from gateway.pure.languages.baps2.typing import with_article

UNITS = ("FILE", "BNR_FILE")


def call(bodies: Writer, statement: CallStatement) -> None:
    """A statement that is only a name."""
    symbol = bodies.names.find(statement.name)
    faults = bodies.names.faults
    if symbol is None:
        if statement.name in standard.PROCEDURES and statement.behind is None:
            _procedure(bodies, statement)
        else:
            text = f"{statement.name} is not a subroutine"
            bodies.names.unknown(statement.name, statement.at, text, "declare it, or write a colon after a label")
        return
    if statement.behind is not None:
        faults.error("syntax", statement.behind[0], f"a statement is expected, not {statement.behind[1]}")
        return
    if symbol.misread:
        return
    if symbol.kind not in ("subroutine", "special", "program"):
        faults.error("no-subroutine", statement.at, f"{statement.name} is {with_article(symbol.kind)}, not a subroutine")
        return
    values = _arguments(bodies, statement, symbol)
    if values is None:
        return
    if symbol.kind == "special":
        _special(bodies, statement, symbol, values)
    elif symbol.kind == "program":
        bodies.turn(1)
        bodies.out.add(f"yield from h.external(p, {symbol.name!r}, ({' '.join(f'{value},' for value in values)}))")
    else:
        bodies.turn(1)
        bodies.out.add(f"yield from s_{python_name(symbol.name, 0)}({', '.join(('p', *values))})")
    bodies.function.line = 0


def _arguments(bodies: Writer, statement: CallStatement, symbol: Symbol) -> list[str] | None:
    """Python texts of the values; None: they do not fit (reported)."""
    if symbol.constant == "any":
        return [bodies.typing.of(tree).code for tree in statement.arguments]
    if len(statement.arguments) != len(symbol.parameters):
        bodies.names.faults.error(
            "argument-count", statement.at, f"{statement.name} takes {len(symbol.parameters)} values, not {len(statement.arguments)}"
        )
        return None
    found = [_argument(bodies, tree, symbol, number) for number, tree in enumerate(statement.arguments)]
    return found if all(found) else None


def _argument(bodies: Writer, tree: Expression, symbol: Symbol, number: int) -> str:
    """Python text of a value; "": it does not fit (reported)."""
    kind, by_value = symbol.parameters[number]
    if kind is NONE:
        return "None"  # the declaration of the parameter is faulty and reported
    if kind.base in (*UNITS, "INPUT", "OUTPUT"):
        return _place(bodies, tree, kind)
    if not by_value:
        variable = _is_variable(bodies, tree)
        if variable or bodies.typing.of(tree).type is not NONE:
            bodies.names.passed(symbol.name, number, tree.at, variable=variable)
        if not variable:
            return ""
        given, text = bodies.typing.reference(tree)
        if text and not same(kind, given):
            bodies.names.faults.error("type", tree.at, f"{given} does not fit the parameter, which is {kind}")
            return ""
        return text
    value = (
        bodies.typing.point(tree, kind.kinematic) if kind.base in ("POINT", "JC_POINT") and not kind.is_array else bodies.typing.of(tree)
    )
    constant = value.constant
    if kind == INTEGER and isinstance(constant, float) and constant.is_integer():
        return str(int(constant))  # L6170 passes ROUND(..) * 1000.0
    if value.type is NONE:
        return ""
    if not fits(kind, value.type, constant):
        bodies.names.faults.error("type", tree.at, f"{value.type} does not fit the parameter, which is {kind}")
        return ""
    if kind.is_array:
        return f"{value.code}.copy()" if value.type.is_array else f"filled({kind.low}, {kind.high}, {value.code})"
    return f"float({value.code})" if kind.base == "REAL" and value.type == INTEGER else value.value


def _is_variable(bodies: Writer, tree: Expression) -> bool:
    """Whether the expression has the form of what a subroutine can set."""
    symbol = bodies.names.find(tree.name) if isinstance(tree, Name) else None
    return isinstance(tree, Name | Member | Index) and (symbol is None or symbol.kind != "constant")


def _place(bodies: Writer, tree: Expression, kind: Type) -> str:
    """Name of a file or channel of an input."""
    symbol = bodies.names.find(tree.name) if isinstance(tree, Name) else None
    if kind.base in UNITS:
        if text := bodies.typing.unit(tree):
            return text
    elif symbol is not None and symbol.kind == kind.base.lower():
        return symbol.python if symbol.reference else str(symbol.channel)
    if symbol is None and isinstance(tree, Name):
        bodies.names.unknown(tree.name, tree.at, f"{tree.name} is not declared")
    elif symbol is None or not symbol.misread:
        bodies.names.faults.error("type", tree.at, f"{kind.base} is expected here")
    return ""


def _special(bodies: Writer, statement: CallStatement, symbol: Symbol, values: list[str]) -> None:
    """Write a special function: arguments passed by reference are returned in lists."""
    bodies.out.add(f"yield Special({symbol.channel}, ({' '.join(f'{value},' for value in values)}))")


def _procedure(bodies: Writer, statement: CallStatement) -> None:
    """INT_ASC and ASC_INT."""
    arguments = statement.arguments
    if len(arguments) != 5:
        bodies.names.faults.error("argument-count", statement.at, f"{statement.name} takes 5 values, not {len(arguments)}")
        return
    first = statement.name == "INT_ASC"
    letters, number = (arguments[1], arguments[0]) if first else (arguments[0], arguments[1])
    text = bodies.typing.of(letters)
    if text.type is not NONE and not (text.type.base == "TEXT" or (text.type.is_array and text.type.base == "CHAR")):
        bodies.names.faults.error("type", letters.at, f"{statement.name} takes an array of CHAR or a TEXT, not {text.type}")
        return
    value = bodies.typing.whole(number, "the number").code
    index, length = (bodies.typing.whole(tree, "a place") for tree in arguments[2:4])
    result, error = bodies.new("d"), bodies.new("d")
    function = "int_asc" if first else "asc_int"
    order = f"{value}, {text.code}" if first else f"{text.code}, {value}"
    bodies.out.add(f"{result}, {error} = {function}({order}, {index.code}, {length.code})")
    target = letters if first else number
    if not (first and text.type.is_array) and (row := bodies.typing.assigned(target, result)):
        bodies.out.add(row)
    if bodies.typing.whole(arguments[4], "the error").type is not NONE and (row := bodies.typing.assigned(arguments[4], error)):
        bodies.out.add(row)
