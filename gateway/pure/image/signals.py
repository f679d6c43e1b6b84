"""The numbered signals between PLC and controller: name, bit, direction, texts, and who gave the number.

The list is data (configs/signals/rho3.toml); this module turns its tables into signals and looks them up.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from gateway.pure.image.addresses import LAST_BIT, Direction, RcBit

ENDINGS = (("_RCI", "_RCE"), ("_RCO", "_RCA"))


class SignalFault(ValueError):
    """A signal cannot be where it was put."""


@dataclass(frozen=True, slots=True)
class Signal:
    """One signal; `source` is "rho3" (the manual's number) or "axisgate" (AX-002: movable, marked wherever shown)."""

    name: str
    at: RcBit
    source: str
    de: str
    en: str
    lines: str = ""  # lines of the manual the number is in
    until: str = ""  # last software version that used this number
    named: str = "rho3"  # "axisgate": the manual prints the number but no symbol
    also: tuple[str, ...] = ()  # other names: former and misprinted ones, the German ending
    row: str = ""  # the table it was repeated from: a row moves as a unit
    printed: int | None = None  # another number the manual prints for it: the only one it may be moved to

    def text(self, language: str) -> str:
        """What it means, in German or English."""
        return self.de if language == "de" else self.en


class SignalList:
    """All signals of one controller family; lookups by name and by bit."""

    def __init__(self, signals: Iterable[Signal]) -> None:
        self.all = tuple(signals)
        self._names: dict[str, Signal] = {}
        self._bits: dict[RcBit, Signal] = {}
        for signal in self.all:
            if not signal.until:  # a number given up by the manual stays listed but is not found by name or bit
                self._bits[signal.at] = signal
                for name in (*signal.also, signal.name):
                    self._names[name.upper()] = signal

    def named(self, name: str) -> Signal | None:
        """The signal of that name, in any case of letters."""
        return self._names.get(name.upper())

    def at(self, place: RcBit) -> Signal | None:
        """The signal with that number."""
        return self._bits.get(place)

    def symbols(self) -> Mapping[str, RcBit]:
        """Name -> place, as the address parser accepts it."""
        return {name: signal.at for name, signal in self._names.items()}

    def moved(self, places: Mapping[str, int]) -> "SignalList":
        """The list with rows at other bits; own signals anywhere free, the manual's only at a number it prints (AX-509).  SignalFault."""
        if not places:
            return self
        for name, bit in places.items():
            signal = self.named(name)
            if signal is None:
                raise SignalFault(f"{name}: no such signal")
            if signal.source != "axisgate" and bit not in (signal.at.number, signal.printed):
                raise SignalFault(f"{name}: the manual's number stays{f' or is {signal.printed}' if signal.printed else ''}")
        ways = {signal.row: bit - signal.at.number for name, bit in places.items() if (signal := self.named(name)) is not None}
        changed = SignalList(
            replace(each, at=RcBit(each.at.direction, each.at.number + ways.get(each.row, 0))) if each.row else each for each in self.all
        )
        for signal in changed.all:
            there = changed.at(signal.at)
            if not 0 <= signal.at.number <= LAST_BIT:
                raise SignalFault(f"{signal.name} at {signal.at.number}: bit numbers are 0..{LAST_BIT}")
            if there is not None and not signal.until and there.name != signal.name:
                raise SignalFault(f"{signal.name} and {there.name} at {signal.at.direction.value} {signal.at.number}")
        return changed


def from_tables(tables: Iterable[Mapping[str, str | int]], sizes: Mapping[str, int] | None = None) -> SignalList:
    """Signals out of the [[signal]] tables; `count` repeats a table with {n} counting from `first`.

    `sizes`: how many axes, kinematics and belts there are (keys axis, kinematic, belt); default: the maximum of the control.
    """
    signals: list[Signal] = []
    for table in tables:
        first, count = int(table.get("first", 1)), int(table.get("count", 1))
        last = (sizes or {}).get(str(table.get("per", "")), first + count - 1)
        for step in range(min(count, last - first + 1)):
            signals.append(_signal(table, int(table["bit"]) + step, str(first + step)))
    return SignalList(signals)


def _signal(table: Mapping[str, str | int], bit: int, number: str) -> Signal:
    def text(key: str) -> str:
        return str(table.get(key, "")).replace("{n}", number)

    direction = Direction.INPUT if table["direction"] == "input" else Direction.OUTPUT
    name = text("name")
    printed = table.get("printed")
    return Signal(
        name,
        RcBit(direction, bit),
        text("source"),
        text("de"),
        text("en"),
        text("lines"),
        text("until"),
        text("named") or "rho3",
        (*text("also").split(), *_german(name)),
        f"{table['name']}@{table['bit']}",
        None if printed is None else int(printed),
    )


def _german(name: str) -> tuple[str, ...]:
    """The name with the German ending: RCE for RC inputs (Eingang), RCA for RC outputs (Ausgang)."""
    return tuple(name.removesuffix(ending) + german for ending, german in ENDINGS if name.endswith(ending))
