"""A virtual line that damages telegrams and records for a judge what was sent, what was received, and which belongs to which.

Each unit a station sends (a control character, a block) is damaged by at most one fault.  The record holds the characters as the
listener got them; nothing in it comes from a receiver of ours.
"""

from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random

from hil_tests.lab.virtual.virtual_line import VirtualLine
from protocols.base.machine import Damage, Machine, Ns, ms

KINDS = ("flip", "drop", "insert", "duplicate", "delay", "cut", "parity", "break")
Item = tuple[Ns, int | Damage]  # when it was heard, what
Origin = tuple[int, int]  # number in Record.said, place in its data
SPOILED = -1  # as place: the fault made it, nobody said it


@dataclass(slots=True)
class Said:
    """One unit that a station sent, and what the other one received of it."""

    data: bytes
    fault: str = ""
    heard_at: int = 0  # characters the speaker itself had heard before
    left: Ns = 0  # its last character is on the line

    @property
    def is_block(self) -> bool:
        return len(self.data) > 3 and not set(self.data) <= {0x02, 0x10, 0x15}  # VIPA answers every stray character with NAK


@dataclass(slots=True)
class Record:
    """Of one direction."""

    heard: list[Item] = field(default_factory=list)
    origins: list[Origin] = field(default_factory=list)  # of heard
    said: list[Said] = field(default_factory=list)
    coming: deque[Origin] = field(default_factory=deque)  # of what is under way

    def clear(self) -> None:
        """A new round on a quiet line."""
        assert not self.coming
        self.heard.clear()
        self.origins.clear()
        self.said.clear()


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
        said = Said(data, heard_at=len(self.records[1 - side].heard), left=way.free_at)
        items: list[int | Damage] = list(data)
        places = list(range(len(items)))
        delay, at = 0, len(data)
        if self._chance.random() < (self._share if len(data) > 3 else self._share / 10):
            said.fault = self._chance.choice(KINDS)
            self.faults[said.fault] += 1
            at, delay = self._spoil_one(said.fault, items, places)
        record.coming += [(len(record.said), place) for place in places]
        record.said.append(said)
        moment = max(start, way.last_arrival)
        self._arrive(way.under_way, items[:at], moment)
        self._arrive(way.under_way, items[at:], moment + at * self._char_time + delay)
        if way.under_way:
            way.last_arrival = max(way.last_arrival, way.under_way[-1][0])

    def _arrive(self, under_way: deque[tuple[Ns, bytes | Damage]], items: list[int | Damage], moment: Ns) -> None:
        """Good characters in runs as a UART with a FIFO hands them over; a damaged one arrives alone."""
        run = bytearray()
        last = under_way[-1] if items and under_way else (moment, Damage.BREAK)
        if isinstance(last[1], bytes) and last[0] >= moment and len(last[1]) < self._burst:
            run += last[1]  # what comes without a gap is handed over together, whoever said it in how many pieces
            under_way.pop()
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

    def _spoil_one(self, kind: str, items: list[int | Damage], places: list[int]) -> tuple[int, Ns]:
        """Spoils both lists alike; returns where a delay begins, and how long it is."""
        chance = self._chance
        at = chance.randrange(len(items))
        match kind:
            case "flip":
                byte = items[at]
                assert isinstance(byte, int)
                items[at], places[at] = byte ^ chance.randrange(1, 256), SPOILED
            case "drop":
                del items[at], places[at]
            case "insert":
                items.insert(at, chance.choice((0x00, 0xFF, 0x10, 0x02, 0x03, 0x15, chance.randrange(256))))
                places.insert(at, SPOILED)
            case "duplicate":
                items.insert(at, items[at])
                places.insert(at, SPOILED)
            case "delay":
                return at, chance.choice((ms(5), ms(100), ms(190), ms(300), ms(700), ms(2500)))
            case "cut":
                del items[at:], places[at:]
            case "parity":
                items[at], places[at] = chance.choice((Damage.PARITY, Damage.FRAMING, Damage.OVERRUN)), SPOILED
            case _:
                items[at], places[at] = Damage.BREAK, SPOILED
        return len(items), 0

    def _serve(self, side: int) -> None:
        partners, record = self._ways[1 - side], self.records[1 - side]
        for moment, item in partners.under_way:
            if moment > self.now:
                break
            heard = [item] if isinstance(item, Damage) else list(item)
            record.heard += [(moment, each) for each in heard]
            record.origins += [record.coming.popleft() for _ in heard]
        super()._serve(side)
