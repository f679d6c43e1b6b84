"""Checks of telegrams before the first block: colliding positions, impossible lengths, ambiguous matches."""

from collections.abc import Iterator
from dataclasses import dataclass

from protocols.telegrams.fields import POINTS, TEXTS, Field, Kind
from protocols.telegrams.layout import Incoming, Outgoing


@dataclass(frozen=True, slots=True)
class Finding:
    """A fault at a key of the telegram: `fields`, `match`, `build`, `length`, with the number of the entry where it has one."""

    key: str
    index: int | None
    words: str


def incoming_faults(telegram: Incoming) -> Iterator[Finding]:
    """Everything wrong inside one telegram the partner sends."""
    limit = telegram.most if telegram.length is None else telegram.length
    if limit > telegram.most:
        yield Finding("length", None, f"{limit} bytes; a block of this line's profile has 1..{telegram.most}")
    covered: dict[int, str] = {}
    for number, match in enumerate(telegram.matches):
        if not match.data:
            yield Finding("match", number, 'no bytes to recognise: hex = "00 00" or text = "OR"')
        yield from _place("match", number, (match.byte, match.end, f"match[{number}]"), covered, limit)
    for number, field in enumerate(telegram.fields):
        yield from _place("fields", number, (field.byte, field.end, field.name), covered, limit)
        yield from field_faults("fields", number, field)
    names = [field.name for field in telegram.fields]
    for number, name in enumerate(names):
        if name in names[:number]:
            yield Finding("fields", number, f"{name} is written twice by this telegram")


def _place(key: str, number: int, place: tuple[int, int, str], covered: dict[int, str], limit: int) -> Iterator[Finding]:
    start, end, name = place
    if end > limit:
        yield Finding(key, number, f"{name} covers bytes {start}..{end - 1}, beyond the length: bytes 0..{limit - 1}")
    other = next((byte for byte in range(start, end) if byte in covered), None)
    if other is not None:
        yield Finding(key, number, f"{name} overlaps {covered[other]}: both cover byte {other}")
    for byte in range(start, end):
        covered.setdefault(byte, name)


def outgoing_faults(telegram: Outgoing) -> Iterator[Finding]:
    """Everything wrong inside one telegram we build."""
    if not 1 <= telegram.length <= telegram.most:
        yield Finding("build", None, f"{telegram.length} bytes; a block has 1..{telegram.most}")
    for number, part in enumerate(telegram.parts):
        if isinstance(part, Field):
            yield from field_faults("build", number, part)
        elif not part:
            yield Finding("build", number, "no bytes")


def field_faults(key: str, number: int, field: Field) -> Iterator[Finding]:
    """Faults of a single field."""
    if field.kind is Kind.TEXT and field.count != 1:
        yield Finding(key, number, "TEXT is one text of 80 bytes; several characters are CHARACTER with count")
    numeric = field.kind not in TEXTS and field.kind is not Kind.BINARY
    if not numeric and (field.scale != 1.0 or field.low is not None or field.high is not None):
        yield Finding(key, number, f"{field.kind.value} has no scale, min or max")
    if field.scale == 0.0:
        yield Finding(key, number, "scale 0 makes every value 0")
    if field.low is not None and field.high is not None and field.low >= field.high:
        yield Finding(key, number, f"min {field.low:g} must be below max {field.high:g}")
    if field.kind in POINTS and field.count > 12:
        yield Finding(key, number, f"{field.kind.value} has 1..12 coordinates")


def same_block(one: Incoming, other: Incoming) -> bytes | None:
    """The start of a block that both telegrams would accept (free bytes shown as 00); None if every block matches at most one."""
    if one.length is not None and other.length is not None and one.length != other.length:
        return None
    exact = one.length if one.length is not None else other.length
    if exact is not None and exact < max(one.needed, other.needed):
        return None
    example = bytearray(max(match.end for match in (*one.matches, *other.matches))) if one.matches or other.matches else bytearray()
    for match in one.matches:
        example[match.byte : match.end] = match.data
    for match in other.matches:
        for place, byte in zip(range(match.byte, match.end), match.data, strict=True):
            if any(mine.byte <= place < mine.end for mine in one.matches) and example[place] != byte:
                return None
            example[place] = byte
    return bytes(example)
