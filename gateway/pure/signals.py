"""The numbered signals between PLC and controller: name, bit, direction, texts, and who gave the number.

The list is data (configs/signals/rho3.toml); this module turns its tables into signals and looks them up.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from gateway.pure.addresses import Direction, RcBit


@dataclass(frozen=True, slots=True)
class Signal:
    """One signal; `source` is "rho3" (the manual's number) or "axisgate" (ours, AX-002: movable, marked wherever shown)."""

    name: str
    at: RcBit
    source: str
    de: str
    en: str
    lines: str = ""  # lines of the manual the number stands in
    until: str = ""  # last software version that used this number
    named: str = "rho3"  # "axisgate": the manual gives the number but no symbol

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
                self._names[signal.name] = signal
                self._bits[signal.at] = signal

    def named(self, name: str) -> Signal | None:
        """The signal of that name, in any case of letters."""
        return self._names.get(name.upper())

    def at(self, place: RcBit) -> Signal | None:
        """The signal with that number."""
        return self._bits.get(place)

    def symbols(self) -> Mapping[str, RcBit]:
        """Name -> place, as the address parser takes it."""
        return {name: signal.at for name, signal in self._names.items()}


def from_tables(tables: Iterable[Mapping[str, str | int]]) -> SignalList:
    """Signals out of the [[signal]] tables; `count` repeats a table with {n} counting from `first`."""
    signals: list[Signal] = []
    for table in tables:
        first = int(table.get("first", 1))
        for step in range(int(table.get("count", 1))):
            signals.append(_signal(table, int(table["bit"]) + step, str(first + step)))
    return SignalList(signals)


def _signal(table: Mapping[str, str | int], bit: int, number: str) -> Signal:
    def text(key: str) -> str:
        return str(table.get(key, "")).replace("{n}", number)

    direction = Direction.INPUT if table["direction"] == "input" else Direction.OUTPUT
    return Signal(
        text("name"), RcBit(direction, bit), text("source"), text("de"), text("en"), text("lines"), text("until"), text("named") or "rho3"
    )
