"""A virtual line that spoils whole telegrams and writes down, for a judge, what was said and what was heard.

Each thing a station says at once (a control character, a block) is spoiled by at most one fault.  The record holds the characters as the
listener got them; nothing in it comes from a receiver of ours.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random

from hil_tests.lab.virtual_line import VirtualLine
from protocols.base.machine import Damage, Machine, Ns, ms

KINDS = ("flip", "drop", "insert", "duplicate", "delay", "cut", "parity", "break")
Item = tuple[Ns, int | Damage]  # when it was heard, what


@dataclass(slots=True)
class Said:
    """One thing a station said and what the other one heard of it."""

    data: bytes
    fault: str = ""
    heard_at: int = 0  # characters the speaker itself had heard before


@dataclass(slots=True)
class Record:
    """Of one direction."""

    heard: list[Item] = field(default_factory=list)
    said: list[Said] = field(default_factory=list)


class FaultedLine(VirtualLine[object]):
    """`share` of the blocks and `share` / 10 of the control characters are spoiled, every kind of fault as often."""

    def __init__(
        self,
        left: Machine[object],
        right: Machine[object],
        on_event: Callable[[int, object, Ns], None],
        seed: int,
        share: float,
        char_time: Ns,
    ) -> None:
        super().__init__(left, right, on_event, seed, char_time=char_time)
        self.records = (Record(), Record())  # what side 0, side 1 says
        self.faults: Counter[str] = Counter()
        self._chance, self._share = Random(seed), share

    def _speak(self, side: int) -> None:
        data = self.machines[side].take_output()
        if not data:
            return
        way, record = self._ways[side], self.records[side]
        start = max(self.now, way.free_at)
        way.free_at = way.sent_at = start + len(data) * self._char_time
        said = Said(data, heard_at=len(self.records[1 - side].heard))
        record.said.append(said)
        items: list[int | Damage] = list(data)
        delay, at = 0, len(data)
        if self._chance.random() < (self._share if len(data) > 3 else self._share / 10):
            said.fault = self._chance.choice(KINDS)
            self.faults[said.fault] += 1
            items, at, delay = self._spoil_one(said.fault, items)
        moment = max(start, way.last_arrival - self._char_time)
        self._arrive(way.under_way, items[:at], moment)
        self._arrive(way.under_way, items[at:], moment + at * self._char_time + delay)
        if way.under_way:
            way.last_arrival = max(way.last_arrival, way.under_way[-1][0])

    def _arrive(self, under_way: "object", items: list[int | Damage], moment: Ns) -> None:
        """Good characters in runs as a UART with a FIFO hands them over; a damage stands alone."""
        assert hasattr(under_way, "append")
        run = bytearray()
        for item in items:
            moment += self._char_time
            if isinstance(item, int):
                run.append(item)
            if run and (len(run) == self._burst or not isinstance(item, int)):
                under_way.append((moment, bytes(run)))
                run.clear()
            if isinstance(item, Damage):
                under_way.append((moment, item))
        if run:
            under_way.append((moment, bytes(run)))

    def _spoil_one(self, kind: str, items: list[int | Damage]) -> tuple[list[int | Damage], int, Ns]:
        """The characters that arrive, where a delay begins, and how long it is."""
        chance = self._chance
        at = chance.randrange(len(items))
        match kind:
            case "flip":
                byte = items[at]
                assert isinstance(byte, int)
                items[at] = byte ^ chance.randrange(1, 256)
            case "drop":
                del items[at]
            case "insert":
                items.insert(at, chance.choice((0x00, 0xFF, 0x10, 0x02, 0x03, 0x15, chance.randrange(256))))
            case "duplicate":
                items.insert(at, items[at])
            case "delay":
                return items, at, chance.choice((ms(5), ms(100), ms(190), ms(300), ms(700), ms(2500)))
            case "cut":
                del items[at:]
            case "parity":
                items[at] = chance.choice((Damage.PARITY, Damage.FRAMING, Damage.OVERRUN))
            case _:
                items[at] = Damage.BREAK
        return items, len(items), 0

    def _serve(self, side: int) -> None:
        partners, record = self._ways[1 - side], self.records[1 - side]
        for moment, item in partners.under_way:
            if moment > self.now:
                break
            if isinstance(item, Damage):
                record.heard.append((moment, item))
            else:
                record.heard += [(moment, byte) for byte in item]
        super()._serve(side)
