"""[[telegram]] of a cell file -> tables of protocols.telegrams.  Used by `check` and by the running command source, so both mean the
same."""

from collections.abc import Iterable, Iterator

from gateway.pure.cell.cell import Cell, Line, Telegram, TelegramField, TelegramMatch, TelegramPart
from gateway.pure.image.named_values import Values
from gateway.pure.image.names import lookup
from gateway.pure.lines.line_profiles import link_profile
from protocols.telegrams.builder import parse_when
from protocols.telegrams.fields import Field, Kind, Order
from protocols.telegrams.layout import Incoming, Match, Outgoing


def is_incoming(telegram: Telegram) -> bool:
    """The partner sends it."""
    return bool(telegram.match or telegram.fields or telegram.then)


def incoming(telegram: Telegram, line: Line) -> Incoming:
    """Telegrams for the reader."""
    matches = tuple(Match(match.byte, raw_bytes(match)) for match in telegram.match)
    fields = tuple(_field(field, field.to, field.byte, line) for field in telegram.fields)
    return Incoming(telegram.name, matches, fields, telegram.length, signal_of(telegram), link_profile(line).most_received)


def outgoing(telegram: Telegram, line: Line) -> Outgoing:
    """Telegrams for the builder."""
    parts: list[bytes | Field] = []
    at = 0
    for part in telegram.build:
        made = _field(part, part.from_, at, line) if part.type else raw_bytes(part)
        at += made.size if isinstance(made, Field) else len(made)
        parts.append(made)
    return Outgoing(telegram.name, tuple(parts), link_profile(line).max_data)


def raw_bytes(part: TelegramMatch | TelegramPart) -> bytes:
    """hex = "00 00" or text = "OR"."""
    return bytes.fromhex(part.hex) if part.hex else part.text.encode("latin-1")


def signal_of(telegram: Telegram) -> str:
    """then = "signal order.new"."""
    return telegram.then.partition(" ")[2].strip()


def factor_of(unit: str) -> float | None:
    """ "0.1 mm" -> 0.1; "mm" -> None."""
    first, _, rest = unit.partition(" ")
    return float(first) if rest else None


def named_values(cell: Cell) -> Values:
    """The store with every name the cell's telegrams and Modbus clients use and axisgate does not already know."""
    asked = {value.name for modbus in cell.modbus for value in modbus.value}
    return Values(written(cell.telegram) | set(watched(cell.telegram)) | asked, signals(cell.telegram) | outcomes(cell.telegram))


def written(telegrams: Iterable[Telegram]) -> set[str]:
    """Names the partners write."""
    return {field.to for telegram in telegrams for field in telegram.fields}


def signals(telegrams: Iterable[Telegram]) -> set[str]:
    """Names of signals."""
    return {signal for telegram in telegrams if (signal := signal_of(telegram))}


def outcomes(telegrams: Iterable[Telegram]) -> set[str]:
    """Signals that exist for every telegram: telegram.ORDER.received, .refused; telegram.DONE.sent, .failed."""
    ends = {True: ("received", "refused"), False: ("sent", "failed")}
    return {f"telegram.{telegram.name}.{end}" for telegram in telegrams for end in ends[is_incoming(telegram)]}


def watched(telegrams: Iterable[Telegram]) -> Iterator[str]:
    """Names whose edge sends, as far as they are the cell's own."""
    for telegram in telegrams:
        when = parse_when(telegram.when)
        if when is not None and "." in when.name and lookup(when.name) is None:
            yield when.name


def _field(field: TelegramField | TelegramPart, name: str, byte: int, line: Line) -> Field:
    scale = factor_of(field.unit) or field.scale
    unit = field.unit.rpartition(" ")[2]
    return Field(
        Kind(field.type), name, byte, field.count, Order(field.byte_order or line.byte_order), scale, unit, field.min, field.max
    )  # fmt: skip
