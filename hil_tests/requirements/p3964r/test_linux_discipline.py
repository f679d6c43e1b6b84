"""Profile linux against a foreign station that does as the line discipline did, in virtual time."""

from random import Random

import pytest

from hil_tests.lab.partners.linux_discipline import LinuxDiscipline
from hil_tests.lab.virtual.virtual_line import NO_FAULTS, Faults, VirtualLine
from protocols.base.machine import Ns, ms
from protocols.p3964r.events import BlockReceived, BlockSent, Event, SendFailed
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import LINUX, Priority

BLOCKS = 12
SPICY = bytes((0x02, 0x03, 0x10, 0x15, 0x04, 0xFF, 0x41))  # no 00h: a lost one is no fault to the block check
PRIORITIES = pytest.mark.parametrize("priority", [Priority.HIGH, Priority.LOW])


class Pair:
    """Our link, and the discipline with the other priority."""

    def __init__(self, priority: Priority, faults: Faults = NO_FAULTS, seed: int = 0, *, both: bool = False) -> None:
        self.link, self.station = Link(LINUX, priority), LinuxDiscipline(priority=both or priority is Priority.LOW)
        self.heard: list[bytes] = []
        self.sent = self.failed = 0
        self.line: VirtualLine[Event] = VirtualLine(self.link, self.station, self._event, seed, faults)

    def _event(self, side: int, event: Event, now: Ns) -> None:
        if isinstance(event, BlockReceived):
            self.heard.append(event.data)
        self.sent += isinstance(event, BlockSent)
        self.failed += isinstance(event, SendFailed)

    def send(self, block: bytes) -> None:
        self.link.send(block, self.line.now)
        self.line.kick(0)

    def give(self, block: bytes) -> None:
        self.station.give(block, self.line.now)
        self.line.kick(1)

    def run(self, seconds: float) -> None:
        self.line.run(self.line.now + ms(1000 * seconds))


def blocks(seed: int, largest: int = 256) -> list[bytes]:
    chance = Random(seed)
    return [bytes((k + 0x60,)) + bytes(chance.choices(SPICY, k=chance.choice((1, 7, largest - 1)))) for k in range(BLOCKS)]


@PRIORITIES
def test_every_block_arrives_once_in_order_when_both_always_have_one_to_send(priority: Priority) -> None:
    pair, ours, theirs = Pair(priority), blocks(1), blocks(2)
    for one, other in zip(ours, theirs, strict=True):  # both ask at the same time: a conflict each
        pair.send(one)
        pair.give(other)
        pair.run(3.0)
    pair.run(20.0)
    assert pair.station.heard == ours and pair.heard == theirs
    assert (pair.sent, pair.failed, pair.station.failed, pair.station.breaches) == (BLOCKS, 0, [], [])


@PRIORITIES
@pytest.mark.parametrize("seed", range(6))
def test_on_a_faulty_line_nothing_is_torn_and_both_are_back_afterwards(priority: Priority, seed: int) -> None:
    pair, ours, theirs = Pair(priority, Faults(drop=0.003, damage=0.003), seed), blocks(seed + 10, 60), blocks(seed + 20, 60)
    for one, other in zip(ours, theirs, strict=True):
        pair.send(one)
        pair.give(other)
        pair.run(8.0)
    pair.run(60.0)
    assert set(pair.station.heard) <= set(ours) and set(pair.heard) <= set(theirs), "no block is torn or invented"
    assert pair.sent + pair.failed == BLOCKS and pair.sent >= BLOCKS - 2
    assert len(pair.station.given) + len(pair.station.failed) == BLOCKS and len(pair.station.given) >= BLOCKS - 2


@PRIORITIES
def test_blocks_of_4000_characters_are_taken(priority: Priority) -> None:
    pair, longest = Pair(priority), bytes(Random(3).choices(SPICY, k=4000))
    pair.give(longest)
    pair.run(12.0)
    assert pair.heard == [longest] and pair.station.given == [longest] and not pair.station.breaches


def test_with_priority_it_yields_in_a_repeat_and_both_blocks_arrive() -> None:
    """A station that has priority, too: the first conflict leads nowhere, a repeat of ours must give way."""
    pair = Pair(Priority.HIGH, both=True)
    pair.link.send(b"ours", 0)
    assert pair.link.take_output() == b"\x02"
    pair.link.sent(0)
    pair.link.receive(b"\x15", 0)  # the first try is refused: the line has not heard of it
    pair.line.kick(0)
    pair.give(b"theirs")
    pair.run(0.2)
    assert pair.heard == [b"theirs"], "it gives way at once, not after its time"
    pair.run(10.0)
    assert pair.heard == [b"theirs"] and pair.station.heard == [b"ours"] and not pair.station.breaches
