"""[[telegram]]: lines, places, types, lengths, names, and ambiguous matches."""

from collections.abc import Iterable, Iterator

from gateway.assembly.telegrams import factor_of, incoming, is_incoming, outcomes, outgoing, signals, watched, written
from gateway.checks.context import Context, near
from gateway.checks.lines import profile_of
from gateway.pure.cell.cell import Cell, Line, Notice, Telegram, TelegramMatch, TelegramPart
from gateway.pure.image.names import lookup, spelled
from gateway.registry import LINE_LAYERS
from protocols.telegrams.builder import Edge, parse_when
from protocols.telegrams.fields import TEXTS, Field, Kind
from protocols.telegrams.judge import Finding, incoming_faults, outgoing_faults, same_block
from protocols.telegrams.layout import Incoming

RESERVED = ("cell", "axis", "line", "move", "robot", "telegram")  # first words of axisgate's own names


def _key(telegram: Telegram, key: str = "", index: int | None = None) -> str:
    return f"telegram.{telegram.name}{'.' if key else ''}{key}{'' if index is None else f'[{index}]'}"


def heads(check: Context) -> None:
    """Every telegram has its own name, a line of its layer, and one direction."""
    lines = {line.name: line for line in check.cell.line}
    seen: set[str] = set()
    for telegram in check.cell.telegram:
        if telegram.name in seen:
            check.fault(_key(telegram, "name"), telegram.name, "the name is used twice among the [[telegram]] tables")
        seen.add(telegram.name)
        if not check.unknown(_key(telegram, "line"), telegram.line, "line") and telegram.line in lines:
            layer = lines[telegram.line].layer
            if not LINE_LAYERS[layer].telegrams:
                check.fault(_key(telegram, "line"), telegram.line, f'layer "{layer}" carries no telegrams; write layer = "telegrams" there')
        _direction(check, telegram)


def _direction(check: Context, telegram: Telegram) -> None:
    sends = bool(telegram.when or telegram.build)
    if is_incoming(telegram) and sends:
        check.fault(_key(telegram), "", "one direction: match, fields, then (the partner sends it) or when, build (axisgate sends it)")
    elif not is_incoming(telegram) and not sends:
        check.fault(_key(telegram), "", "neither match nor build: which bytes is it made of?")
    elif sends and not telegram.build:
        check.fault(_key(telegram, "build"), "", 'missing: what is sent? build = [ { hex = "00 00" }, { type = "INTEGER", from = ".." } ]')
    elif sends and not telegram.when:
        check.fault(_key(telegram, "when"), "", 'missing: what sends it? when = "rising order.done"')
    if sends and telegram.length is not None:
        check.fault(_key(telegram, "length"), telegram.length, "the length of a built telegram is that of its parts")


def entries(check: Context) -> None:
    """Each entry is one thing; then reader and builder rules judge every place, length and range."""
    lines = {line.name: line for line in check.cell.line}
    for telegram in check.cell.telegram:
        line = lines.get(telegram.line)
        if line is None or profile_of(line) is None or not _sound(check, telegram):
            continue
        for finding in _findings(telegram, line):
            check.fault(_key(telegram, finding.key, finding.index), "", finding.words)


def _findings(telegram: Telegram, line: Line) -> Iterator[Finding]:
    if is_incoming(telegram):
        yield from incoming_faults(incoming(telegram, line))
    elif telegram.build:
        yield from outgoing_faults(outgoing(telegram, line))


def _sound(check: Context, telegram: Telegram) -> bool:
    before = len(check.faults)
    for index, match in enumerate(telegram.match):
        _one_of(check, _key(telegram, "match", index), match, "hex, text")
    for index, part in enumerate(telegram.build):
        one = _one_of(check, _key(telegram, "build", index), part, "hex, text, type with from")
        if one and bool(part.type) is not bool(part.from_):
            check.fault(_key(telegram, "build", index), part.from_ or part.type, "a value has type and from")
    for index, field in enumerate(telegram.fields):
        _one_scale(check, _key(telegram, "fields", index), field.unit, field.scale)
    for index, part in enumerate(telegram.build):
        _one_scale(check, _key(telegram, "build", index), part.unit, part.scale)
    return len(check.faults) == before


def _one_scale(check: Context, key: str, unit: str, scale: float) -> None:
    factor = factor_of(unit)
    if factor is not None and scale != 1.0:
        check.fault(key, unit, f"scale = {scale:g} sets the same: keep one of them")
    if factor == 0.0:
        check.fault(key, unit, "one count must be greater than 0")


def _one_of(check: Context, key: str, part: TelegramMatch | TelegramPart, words: str) -> bool:
    given = [part.hex, part.text, *([part.type] if isinstance(part, TelegramPart) else [])]
    if sum(map(bool, given)) == 1:
        return True
    check.fault(key, " ".join(filter(None, given)), f"exactly one of {words}")
    return False


def matches(check: Context) -> None:
    """No block may match two telegrams of a line."""
    for line in check.cell.line:
        tables = [(each, table) for each, table in _incoming(check.cell.telegram, line)]
        for number, (telegram, table) in enumerate(tables):
            for other, earlier in tables[:number]:
                shared = same_block(earlier, table)
                if shared is not None:
                    shown = f"begins {shared.hex(' ').upper()}" if shared else "can be anything"
                    hint = f"{other.name} matches the same bytes: a block that {shown} would match both; match more bytes or set length"
                    check.fault(_key(telegram, "match"), "", hint)


def _incoming(telegrams: Iterable[Telegram], line: Line) -> Iterator[tuple[Telegram, Incoming]]:
    for telegram in telegrams:
        if (
            telegram.line == line.name
            and profile_of(line) is not None
            and is_incoming(telegram)
            and all(bool(match.hex) is not bool(match.text) for match in telegram.match)
        ):
            yield telegram, incoming(telegram, line)


def names(check: Context) -> None:
    """`to` and `then` are the cell's own names, each written by one line; `from` and `when` are names that exist."""
    counting = signals(check.cell.telegram) | outcomes(check.cell.telegram)
    own = written(check.cell.telegram) | counting | set(watched(check.cell.telegram))
    writers: dict[str, str] = {}
    for telegram in check.cell.telegram:
        targets = [(_key(telegram, "fields", index), field.to) for index, field in enumerate(telegram.fields)]
        targets += [(_key(telegram, "then"), signal) for signal in signals([telegram])]
        for key, name in targets:
            if lookup(name) is not None or check.signals.named(name) is not None or name.split(".")[0] in RESERVED:
                check.fault(key, name, "this name is reserved for axisgate; a telegram writes names of the cell's own, as order.number")
            elif writers.setdefault(name, telegram.line) != telegram.line:
                check.fault(key, name, f"line {writers[name]} writes it already")
        for signal in signals([telegram]) & written(check.cell.telegram):
            check.fault(_key(telegram, "then"), signal, "a field writes this name: a signal needs a name of its own")
        when = parse_when(telegram.when)
        if when is not None:
            _readable(check, _key(telegram, "when"), when.name, own)
            if when.edge is Edge.FALLING and when.name in counting:
                check.fault(_key(telegram, "when"), telegram.when, "a signal can only be received: rising")
        for index, part in enumerate(telegram.build):
            if part.from_:
                _readable(check, _key(telegram, "build", index), part.from_, own)
                _kinds(check, telegram, index)


def _readable(check: Context, key: str, name: str, own: set[str]) -> None:
    if name in own or check.signals.named(name) is not None:
        return
    found = lookup(name)
    if found is None and check.known["telegram"] - {telegram.name for telegram in check.cell.telegram}:
        return  # a telegram with a fault of its own may write it
    if found is None or not found.name.from_ or name.startswith("move."):
        hint = near(name, {*own, *spelled(sorted(check.known["axis"]), [])}) or f"known are {', '.join(sorted(own)) or 'no own names'}"
        check.fault(key, name, f"no such value to read; {hint}")
    elif found.which not in ("", "*"):
        check.unknown(key, found.which, found.kind)


def _kinds(check: Context, telegram: Telegram, index: int) -> None:
    """A text cannot be sent as a number, nor three values as one."""
    part = telegram.build[index]
    for other in check.cell.telegram:
        for field in other.fields:
            if field.to != part.from_ or not part.type:
                continue
            kinds = Kind(field.type), Kind(part.type)
            if (kinds[0] in TEXTS) is not (kinds[1] in TEXTS):
                check.fault(_key(telegram, "build", index), part.type, f"{other.name} writes {part.from_} as {field.type}")
            elif kinds[0] not in TEXTS and _items(field.type, field.count) != _items(part.type, part.count):
                check.fault(_key(telegram, "build", index), part.count, f"{other.name} writes {field.count} values into {part.from_}")


def _items(kind: str, count: int) -> tuple[bool, int]:
    return Field(Kind(kind), "", 0, count).single, count


def silence(check: Context) -> None:
    """max_silence_ms = 0 switches supervision off, allowed only for a partner that sends irregularly."""
    for line in check.cell.line:
        value = line.supervision.max_silence_ms
        if value < 50 and not (value == 0 and LINE_LAYERS[line.layer].telegrams):
            hint = "" if LINE_LAYERS[line.layer].telegrams else '0 (no supervision) only with layer = "telegrams"'
            check.fault(f"line.{line.name}.supervision.max_silence_ms", value, hint, "50..60000", "ms")


def unwritten(cell: Cell) -> Iterator[Notice]:
    """Report values that send a telegram and that nothing in the file writes, and lines that accept no telegram."""
    given = written(cell.telegram) | signals(cell.telegram) | outcomes(cell.telegram)
    for telegram in cell.telegram:
        for name in watched([telegram]):
            if name not in given:
                text = f"nothing in this file writes {name}: a program must write it, or `axisgate var {name} --set 1` in a simulated run"
                yield Notice("note", f"telegram {telegram.name}", text)
    for line in cell.line:
        if LINE_LAYERS[line.layer].telegrams and not any(telegram.line == line.name for telegram in cell.telegram):
            yield Notice("warning", f"line {line.name}", 'layer = "telegrams" and no [[telegram]]: every block is counted and dropped')


CHECKS = (heads, entries, matches, names, silence)
NOTES = (unwritten,)
