"""Translates READ, WRITE and the orders for files."""

from dataclasses import replace

from gateway.pure.languages.baps2.output import Writer
from gateway.pure.languages.baps2.scope import Symbol
from gateway.pure.languages.baps2.standard import DEVICES
from gateway.pure.languages.baps2.tree import Expression, FileOrder, Name, Read, Write
from gateway.pure.languages.baps2.typed import Typed
from gateway.pure.languages.baps2.types import NONE, POINTS, SCALARS, TEXT, Type, fits

BINARY_FORMS = ("INTEGER", "BINARY", "REAL", "POINT", "JC_POINT")  # of BNR files (L6942-6944)
MOST_LETTERS = 80  # of an array that is written (L779-783)


def _unit(bodies: Writer, name: str, statement: Read | Write | FileOrder) -> tuple[str, Symbol | None]:
    """Python text of the name of a unit and its symbol; the PHG where none is named."""
    symbol = bodies.names.find(name) if name else None
    if symbol is not None and symbol.kind == "file":
        return (symbol.python if symbol.reference else repr(name)), symbol
    if symbol is not None and symbol.misread:
        return repr(name), None
    if symbol is not None or (name and name not in DEVICES):
        bodies.names.once("file-unknown", name, statement.at, f"{name} is neither a file nor a device")
    return repr(name or "PHG"), None


def _fits_file(bodies: Writer, symbol: Symbol | None, kind: Type, tree: Expression) -> None:
    """Reports a value that a binary file cannot hold.  An INTEGER that is written becomes REAL in a file of REAL; one that is read does not
    become INTEGER."""
    if symbol is None or kind is NONE or (symbol.type.base == "FILE" and symbol.type.element in ("", "CHAR")):
        return
    element = symbol.type.element
    if kind.base not in BINARY_FORMS:
        bodies.names.faults.error("file-type", tree.at, f"{kind} cannot be in a binary file")
    elif element and element != kind.base:
        bodies.names.faults.error("file-type", tree.at, f"{kind} cannot be in a file of {element}")


def _form(bodies: Writer, kind: Type) -> tuple[int, int]:
    """Components of a point, elements of an array."""
    size = len(bodies.names.components(kind)) if kind.base in POINTS else 0
    return size, kind.high - kind.low + 1 if kind.low is not None and kind.high is not None else 0


def read(bodies: Writer, statement: Read) -> None:
    """READ; each variable is one request."""
    if (file := _file_of(bodies, statement.targets, statement.device)) is not None:
        statement = Read(statement.at, file, statement.targets[1:])
    unit, symbol = _unit(bodies, statement.device, statement)
    for tree in statement.targets:
        target = bodies.target(tree)
        if target.type is NONE:
            continue
        if target.type.base not in SCALARS or target.type.base == "WC_FRAME":
            bodies.names.faults.error("type", tree.at, f"{target.type} cannot be read")
            continue
        _fits_file(bodies, symbol, target.type, tree)
        size, count = _form(bodies, target.type)
        name = bodies.new("d")
        bodies.out.add(f"{name} = yield ReadDevice({unit}, {target.type.base!r}, {size}, {count})")
        bodies.out.add(f"if {name} is not None:")
        bodies.out.indent += 1
        bodies.out.add("pass")
        bodies.store(tree, target.type, Typed(target.type, name))
        bodies.out.indent -= 1


def _file_of(bodies: Writer, values: tuple[Expression, ...], device: str) -> str | None:
    """A file that only the names show, because it is declared elsewhere."""
    first = values[0] if values and not device else None
    symbol = bodies.names.find(first.name) if isinstance(first, Name) else None
    return first.name if isinstance(first, Name) and symbol is not None and symbol.kind == "file" else None


def write(bodies: Writer, statement: Write) -> None:
    """WRITE; all values go in one request."""
    if (file := _file_of(bodies, statement.values, statement.device)) is not None:
        statement = Write(statement.at, file, statement.values[1:], statement.open)
    unit, symbol = _unit(bodies, statement.device, statement)
    items = []
    for tree in statement.values:
        value = bodies.typing.of(tree)
        kind = value.type
        if kind is NONE:
            continue
        if kind.base not in SCALARS or kind.base == "WC_FRAME":
            bodies.names.faults.error("type", tree.at, f"{kind} cannot be written")
        _, count = _form(bodies, kind)
        if kind.base == "CHAR" and count > MOST_LETTERS:
            bodies.names.faults.error("array-size", tree.at, f"{count} characters; a WRITE accepts {MOST_LETTERS}")
        base = "REAL" if kind.base == "INTEGER" and symbol is not None and symbol.type.element == "REAL" else kind.base
        _fits_file(bodies, symbol, replace(kind, base=base), tree)
        items.append(f"({base!r}, {_written(value)}),")
    bodies.out.add(f"yield WriteDevice({unit}, ({' '.join(items)}), {statement.open})")


def _written(value: Typed) -> str:
    return f"point({value.code})" if value.type.base in POINTS and not value.type.is_array else value.value


def file_order(bodies: Writer, statement: FileOrder) -> None:
    """READ_BEGIN, WRITE_BEGIN, WRITE_END, CLOSE, ASSIGN."""
    unit, symbol = _unit(bodies, statement.file, statement)
    if symbol is None and statement.word in ("WRITE_END", "CLOSE") and statement.file in DEVICES:
        bodies.names.faults.error("file-unknown", statement.at, f"{statement.word} takes a file, {statement.file} is a device")
    value = "None"
    if statement.word == "ASSIGN" and statement.value is not None:
        text = bodies.typing.of(statement.value)
        if not fits(TEXT, text.type):
            bodies.names.faults.error("type", statement.at, f"ASSIGN takes a TEXT, not {text.type}")
        value = f"text({text.code})"
    elif statement.value is not None:
        value = bodies.typing.whole(statement.value, "the offset").code
    bodies.out.add(f"yield FileAction({statement.word!r}, {unit}, {value})")
