"""A trace of one line: who sent which characters when, whatever it was recorded by.  Journals and line records become traces, and back.

Sides are A and B, as the line process calls them.  In a journal (protocols.base.dialogue) the station is B and its partner A, unless
the journal's `station` line has side=A.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from protocols.base.dialogue import Dialogue, Entry
from protocols.base.errors import DecodeError
from protocols.base.machine import Damage, Ns

GONE = ("lost", "gone", "overflow", "drop")  # marks of characters that never arrived
DAMAGES = {"parity": Damage.PARITY, "framing": Damage.FRAMING, "overrun": Damage.OVERRUN, "break": Damage.BREAK}


class RunLike(Protocol):
    """A run of the line process' record (drivers.ports.serial.line_format.Run)."""

    @property
    def stamp_ns(self) -> Ns: ...
    @property
    def side(self) -> str: ...
    @property
    def data(self) -> bytes: ...
    @property
    def mark(self) -> str: ...


@dataclass(frozen=True, slots=True)
class Item:
    """Characters one side sent in one go; `stamp_ns` is the end of the last one."""

    stamp_ns: Ns
    side: str
    data: bytes  # as sent; empty for a damage whose character is not known
    damage: Damage | None = None  # they arrived spoiled
    arrived: bool = True
    altered: bytes | None = None  # what arrived instead, without any mark
    remark: str = ""  # what the station reported at that moment


def of_runs(runs: Iterable[RunLike]) -> list[Item]:
    """A line record as a trace.  DecodeError: an unknown mark."""
    return [_item(run) for run in runs]


def _item(run: RunLike) -> Item:
    if not run.mark:
        return Item(run.stamp_ns, run.side, run.data)
    if run.mark in GONE:
        return Item(run.stamp_ns, run.side, run.data, arrived=False)
    if run.mark in DAMAGES:
        return Item(run.stamp_ns, run.side, run.data, damage=DAMAGES[run.mark])
    kind, _, other = run.mark.partition("=")
    if kind != "flip":
        raise DecodeError(f"line record: mark {run.mark!r}; known: {', '.join((*GONE, *DAMAGES))}, flip=<hex>")
    return Item(run.stamp_ns, run.side, run.data, altered=bytes.fromhex(other))


def of_dialogue(dialogue: Dialogue, start_ns: Ns = 0) -> list[Item]:
    """A journal as a trace; reports of the station become remarks at the last characters before them.

    Its `station` line may say when it began (start_ns=..), else `start_ns` does.
    """
    station = dialogue.station.get("side", "B")
    partner = "A" if station == "B" else "B"
    start = int(dialogue.station.get("start_ns", start_ns))
    items: list[Item] = []
    for entry in dialogue.entries:
        stamp = start + entry.time
        match entry.verb:
            case "hears":
                items.append(Item(stamp, partner, entry.data))
            case "says":
                items.append(Item(stamp, station, entry.data))
            case "damaged":
                items.append(Item(stamp, partner, b"", damage=Damage[entry.what]))
            case "reports" if items:
                last = items[-1]
                remark = f"{last.remark}; {entry.what}" if last.remark else entry.what
                items[-1] = Item(last.stamp_ns, last.side, last.data, last.damage, last.arrived, last.altered, remark)
    return items


def to_dialogue(items: Iterable[Item], name: str, side: str = "B", settings: dict[str, str] | None = None) -> Dialogue:
    """What the station at `side` received and sent; times from the first item on, whose moment is kept as start_ns."""
    known = list(items)
    start = known[0].stamp_ns if known else 0
    dialogue = Dialogue(name, {**(settings or {}), "side": side, "start_ns": str(start)})
    for item in known:
        time = item.stamp_ns - start
        if item.side == side:
            dialogue.entries.append(Entry(time, "says", _hex(item.data)))
        elif item.damage is not None:
            dialogue.entries += [Entry(time, "damaged", item.damage.name)] * max(1, len(item.data))
        elif item.arrived:
            dialogue.entries.append(Entry(time, "hears", _hex(item.data if item.altered is None else item.altered)))
    return dialogue


def _hex(data: bytes) -> str:
    return data.hex(" ").upper()
