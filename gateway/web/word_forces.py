"""Force requests of a page: the value of a data word in its own type and unit, or a bit, as words with masks (AX-498)."""

from gateway.observer.names import Entry
from protocols.base.errors import ProtocolError
from protocols.base.step5 import Step5Type, encode

FLOATS = (Step5Type.KG, Step5Type.REAL)
Words = tuple[int, list[list[int]]]  # block key, [word, mask, value]


def forced_words(entry: Entry, value: str | None) -> Words:
    """`value`: as shown on the page (1200.5, -3), or 0x.. for the bare word; None: return only the masks.  ValueError."""
    kind, _, rest = entry.id.partition(":")
    if kind != "db":
        raise ValueError(f"{entry.name}: not a data word; RC inputs are forced by their number")
    block, where = rest.split(":")
    word, dot, bit = where.partition(".")
    if dot:
        if value not in (None, "0", "1"):
            raise ValueError(f"{entry.name}: a bit is 0 or 1")
        return int(block), [[int(word), 1 << int(bit), (1 << int(bit)) * int(value or "0")]]
    place, half = int("".join(c for c in word if c.isdigit())), word[-2:]
    if half in ("DL", "DR"):
        number = _count(entry, value, 0, 255)
        return int(block), [[place, 0xFF00 if half == "DL" else 0x00FF, number << 8 if half == "DL" else number]]
    data = _encoded(entry, value)
    return int(block), [[place + n // 2, 0xFFFF, int.from_bytes(data[n : n + 2], "big")] for n in range(0, len(data), 2)]


def _encoded(entry: Entry, value: str | None) -> bytes:
    kind = Step5Type(entry.type)
    if value is None:
        return bytes(kind.size)
    if value.lower().startswith("0x") or kind in (Step5Type.KY, Step5Type.KC, Step5Type.KT):
        return _count(entry, value, 0, (1 << 8 * kind.size) - 1).to_bytes(kind.size, "big")
    try:
        count = float(value) / factor(entry.unit)
        return encode(kind, count if kind in FLOATS else round(count))
    except (ValueError, OverflowError, ProtocolError) as error:
        raise ValueError(f"{entry.name} = {value}: {error}") from error


def _count(entry: Entry, value: str | None, low: int, high: int) -> int:
    """An integer, also as 0x..; units of halves of a word count like those of words."""
    if value is None:
        return 0
    bare = value.lower().startswith("0x")
    try:
        number = int(value, 16) if bare else round(float(value) / factor(entry.unit))
    except (ValueError, OverflowError) as error:
        raise ValueError(f"{entry.name} = {value}: {error}") from error
    if not low <= number <= high:
        raise ValueError(f"{entry.name} = {value}: {low}..{high} counts")
    return number


def factor(unit: str) -> float:
    """One count of "0.1 mm" is 0.1; of "" it is 1."""
    return float(unit.split(maxsplit=1)[0]) if unit and unit[0].isdigit() else 1.0
