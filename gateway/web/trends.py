"""The trend of any value over hours: samples once a second, with or without viewers, and returns the points of one value (AX-805)."""

import math
import time
from collections import defaultdict
from collections.abc import Iterator

from gateway.observer.names import Entry, Names
from gateway.observer.regions import Row
from gateway.observer.tool_link import ServicesLink
from gateway.observer.values import Watched
from gateway.pure.image.records.cell import RC_BYTES, Quality
from gateway.web.history import HOURS, History, Points
from gateway.web.word_forces import factor
from protocols.base.errors import ProtocolError
from protocols.base.step5 import Step5Type, decode

LEAST_S, MOST_S = 60.0, HOURS * 3600.0
BYTE = 8
UNKNOWN = math.nan


class Trends:
    """Every value of a cell over the last hours."""

    def __init__(self, names: Names, watched: Watched) -> None:
        self._names, self._watched = names, watched
        self.history = History()
        self._blocks: dict[str, list[Entry]] = defaultdict(list)
        self._others: list[Entry] = []
        for entry in names.all:
            area, _, rest = entry.id.partition(":")
            if area == "db":
                self._blocks[rest.partition(":")[0]].append(entry)
            elif area not in ("in", "out"):
                self._others.append(entry)
        self._before: dict[str, object] = {}

    async def look(self, services_link: ServicesLink) -> None:
        """Everything that changed since the last look; the regions were looked at before."""
        await self._watched.look(services_link)
        self.take(time.monotonic())

    def take(self, at: float) -> None:
        """Take in the present values."""
        self.history.take(at, dict(self._changed()))

    def _changed(self) -> Iterator[tuple[str, float]]:
        """Ids and values; parts whose bytes and quality are those of the last look are left out."""
        watched = self._watched
        for block, entries in self._blocks.items():
            found = watched.looked["blocks"].get(block)
            if self._other(f"db:{block}", (found, watched.fresh)):
                yield from ((entry.id, number_of(entry, watched.value(entry.id, {}))) for entry in entries)
        regions = watched.regions
        stale = regions.ages()[0] > 250.0
        for octet in range(RC_BYTES):
            state = (regions.inputs.values[octet], regions.inputs.quality[octet])
            if self._other(f"in:{octet}", state):
                yield from _bits("in", octet, state[0], known=state[1] != Quality.BAD)
            if self._other(f"out:{octet}", (regions.outputs[octet], stale)):
                yield from _bits("out", octet, regions.outputs[octet], known=not stale)
        rows = {row["name"]: row for row in regions.drives()}
        yield from ((entry.id, number_of(entry, watched.value(entry.id, rows))) for entry in self._others)

    def _other(self, part: str, state: object) -> bool:
        if part in self._before and self._before[part] == state:
            return False
        self._before[part] = state
        return True

    def points(self, id_: str, seconds: float, now: float) -> Row:
        """Points of one value up to `now` (s, monotonic), their times as ms before it; null where it was not known.  KeyError."""
        entry = self._names.entry(id_)
        begin = now - min(max(seconds, LEAST_S), MOST_S)
        times, values = self._wide(entry, begin, now) if entry.id.startswith(("inw:", "outw:")) else self.history.since(id_, begin, now)
        began = self.history.began
        return {
            "id": id_, "name": entry.name, "unit": shown_unit(entry), "bit": entry.kind == "bit",
            "since_s": None if math.isnan(began) else round(now - began, 1),
            "ms": [round((moment - now) * 1e3) for moment in times],
            "values": [None if math.isnan(value) else value for value in values],
        }  # fmt: skip

    def _wide(self, entry: Entry, begin: float, end: float) -> Points:
        """Bytes of the image out of the changes of their bits."""
        area, byte, size = entry.id.split(":")
        count = BYTE * int(size)
        series = [self.history.since(f"{area[:-1]}:{BYTE * int(byte) + n}", begin, end) for n in range(count)]
        changes = sorted((at, n, value) for n, (times, values) in enumerate(series) for at, value in zip(times, values, strict=True))
        bits = [UNKNOWN] * count
        found: tuple[list[float], list[float]] = [], []
        for place, (at, n, value) in enumerate(changes):
            bits[n] = value
            if place + 1 == len(changes) or changes[place + 1][0] > at:
                found[0].append(at)
                found[1].append(_joined(bits, signed=count > BYTE))
        return found


def _joined(bits: list[float], *, signed: bool) -> float:
    """Bits of bytes that follow each other, the first byte the highest."""
    if any(math.isnan(bit) for bit in bits):
        return UNKNOWN
    octets = bytes(sum(int(bits[first + n]) << n for n in range(BYTE)) for first in range(0, len(bits), BYTE))
    return float(int.from_bytes(octets, "big", signed=signed))


def _bits(area: str, octet: int, value: int, *, known: bool) -> Iterator[tuple[str, float]]:
    return ((f"{area}:{BYTE * octet + n}", float(value >> n & 1) if known else UNKNOWN) for n in range(BYTE))


def number_of(entry: Entry, value: list[object] | None) -> float:
    """As the page shows it, in the entry's unit; NaN: not known, or no number."""
    if value is None or value[1] == Quality.BAD:
        return UNKNOWN
    shown = value[0]
    if entry.kind == "word" and isinstance(shown, str):
        return _word(entry, shown)
    try:
        return float(str(int(shown) if isinstance(shown, bool) else shown))
    except ValueError:
        return UNKNOWN


def _word(entry: Entry, shown: str) -> float:
    try:
        data = bytes.fromhex(shown)
        if entry.id.endswith(("DL", "DR")):
            return float(data[entry.id.endswith("DR")])
        kind = Step5Type(entry.type)
        found = decode(kind, data[: kind.size])
    except (ValueError, IndexError, ProtocolError):
        return UNKNOWN
    if isinstance(found, (int, float)):
        return float(found) * (factor(entry.unit) if kind is Step5Type.KF else 1.0)
    return float(int.from_bytes(data[: kind.size], "big"))


def shown_unit(entry: Entry) -> str:
    """`mm` of "0.1 mm": the trend uses the unit itself."""
    return entry.unit.partition(" ")[2] if entry.unit[:1].isdigit() and entry.type == "KF" else entry.unit
