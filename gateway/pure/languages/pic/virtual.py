"""A PIC program in virtual time: scanned each period, bits of others set at their times, each bit that changes is an event.  Pure."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from gateway.pure.languages.base.trace import Trace
from gateway.pure.languages.pic.reader import PicProgram
from gateway.pure.languages.pic.run import Scan, Timers
from gateway.pure.languages.pic.symbols import BYTES, Area, Bit, Symbols, address
from gateway.pure.languages.plc.state import TimeError

SECOND = 1_000_000_000
STOPPED = 1275  # error code of a PIC whose scan does not end (AX-981)
KEYS, INPUT_KEYS = ("p5_ms", "until_s", "p3", "timers", "counters", "input"), ("name", "value", "at")
WORDS = {Area.OUTPUT: "out", Area.FLAG: "flag"}


class PicFeedFault(Exception):
    """The feed is faulty: one sentence."""


@dataclass(frozen=True, slots=True)
class Change:
    """A bit that others set."""

    at: int
    place: Bit
    value: bool


@dataclass(frozen=True, slots=True)
class PicFeed:
    """Times in ns; p3, timers, counters: parameters P3, P13 and P14."""

    period: int = 10_000_000
    until: int = 20 * SECOND
    p3: int = 8
    timers: tuple[int, ...] = ()
    counters: tuple[int, ...] = ()
    changes: tuple[Change, ...] = ()


def pic_feed_of(raw: Mapping[str, object], symbols: Symbols, program: PicProgram) -> PicFeed:
    """From the tables of a TOML file.  PicFeedFault."""
    _known(raw, KEYS, "a feed of a PIC program")
    inputs = raw.get("input", [])
    if not isinstance(inputs, list):
        raise PicFeedFault("input is not a list of tables")
    changes = sorted((_change(each, symbols, program) for each in inputs), key=lambda change: change.at)
    p3 = round(_number(raw.get("p3", 8), "p3", 8, 32))
    if p3 % 8:
        raise PicFeedFault(f"p3 = {p3}: 8, 16, 24 or 32 timers and counters")
    return PicFeed(
        round(_number(raw.get("p5_ms", 10), "p5_ms", 1, 1_000) * 1e6),
        round(_number(raw.get("until_s", 20), "until_s", 0.001, 86_400) * SECOND),
        p3,
        _values(raw, "timers", p3),
        _values(raw, "counters", p3),
        tuple(changes),
    )


def _known(table: Mapping[str, object], keys: tuple[str, ...], what: str) -> None:
    for key in table:
        if key not in keys:
            raise PicFeedFault(f"{key} is not a key of {what}; the keys are {', '.join(keys)}")


def _number(value: object, where: str, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise PicFeedFault(f"{where} = {value!r}: a number from {low:g} to {high:g} is expected")
    return float(value)


def _values(raw: Mapping[str, object], key: str, most: int) -> tuple[int, ...]:
    found = raw.get(key, [])
    if not isinstance(found, list) or len(found) > most:
        raise PicFeedFault(f"{key}: a list of at most {most} numbers is expected")
    return tuple(round(_number(each, key, 0, 1e9)) for each in found)


def _change(row: object, symbols: Symbols, program: PicProgram) -> Change:
    if not isinstance(row, Mapping) or not isinstance(row.get("name"), str):
        raise PicFeedFault("an input needs the name of a bit: an address, a symbol or a signal")
    _known(row, INPUT_KEYS, "an input")
    name = str(row["name"])
    place = address(name) or symbols.find(name)
    if not isinstance(place, Bit):
        raise PicFeedFault(place or f"input {name}: no address, no symbol and no signal")
    if place.area is Area.OUTPUT and place.byte in program.outputs:
        raise PicFeedFault(f"input {name}: byte O{place.byte} is written by the program")
    value = row.get("value", 1)
    level = bool(value) if isinstance(value, bool) else bool(_number(value, f"input {name} value", 0, 1))
    return Change(round(_number(row.get("at", 0), f"input {name} at", 0, 86_400) * SECOND), place, level)


class VirtualPic:
    """One run of a program; outputs of bytes that it does not write are those of others."""

    def __init__(self, name: str, program: PicProgram, timers: Timers, feed: PicFeed, named: Callable[[Bit], str]) -> None:
        """`named`: the name of a bit, "" where it has none."""
        self._name, self._feed, self._named = name, feed, named
        self._owned = frozenset(program.outputs)
        self._scan = Scan(timers)
        self._scan.load(program)
        self._inputs, self._others = bytearray(BYTES), bytearray(BYTES)
        self.trace = Trace()

    def run(self) -> bool:
        """False: its scan does not end, the PIC stops with all outputs 0."""
        feed, waiting = self._feed, list(self._feed.changes)
        before = self._seen()
        for now in range(0, feed.until, feed.period):
            while waiting and waiting[0].at <= now:
                self._set(now, waiting.pop(0))
            before = {**before, Area.FLAG: self._scan.flags}  # flags set by the feed are not changes by the program
            try:
                self._scan.scan(feed.period if now else 0, bytes(self._inputs), bytes(self._others), self._owned)
            except TimeError as error:
                self.trace.add(now, self._name, error.line, "error", code=STOPPED, text="the scan does not end; the PIC stops")
                self._report(now, before, {Area.OUTPUT: bytes(BYTES), Area.FLAG: before[Area.FLAG]})
                return False
            seen = self._seen()
            self._report(now, before, seen)
            before = seen
        return True

    def _seen(self) -> dict[Area, bytes]:
        outputs = bytes(value if byte in self._owned else 0 for byte, value in enumerate(self._scan.outputs))
        return {Area.OUTPUT: outputs, Area.FLAG: self._scan.flags}

    def _set(self, now: int, change: Change) -> None:
        place, mask = change.place, 1 << change.place.bit
        if place.area is Area.FLAG:
            byte = self._scan.flags[place.byte]
            self._scan.set_flags(place.byte, bytes((byte | mask if change.value else byte & ~mask,)))
        else:
            image = self._inputs if place.area is Area.INPUT else self._others
            image[place.byte] = image[place.byte] & ~mask | (mask if change.value else 0)
        self._event(now, "in", place, change.value)

    def _report(self, now: int, before: Mapping[Area, bytes], seen: Mapping[Area, bytes]) -> None:
        for area, word in WORDS.items():
            for byte, (old, new) in enumerate(zip(before[area], seen[area], strict=True)):
                for bit in _bits(old ^ new):
                    self._event(now, word, Bit(area, byte, bit), bool(new >> bit & 1))

    def _event(self, now: int, word: str, place: Bit, value: bool) -> None:
        name = self._named(place)
        self.trace.add(now, self._name, 0, word, channel=str(place), value=int(value), **({"name": name} if name else {}))


def _bits(value: int) -> Sequence[int]:
    return [bit for bit in range(8) if value >> bit & 1]
