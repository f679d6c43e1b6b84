"""Our link against a station written by hand from the text of the manual: no shared code, so no shared mistake."""

import pytest

from hil_tests.lab.partners.by_hand_partner import ByHandPartner, Gave, Got
from hil_tests.lab.virtual.virtual_line import NO_FAULTS, Faults, VirtualLine
from protocols.base.machine import Ns, ms
from protocols.p3964r.events import BlockReceived, BlockSent, Event, SendFailed
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority

Happening = Event | Got | Gave
BLOCKS = [bytes((number, 0x10, 0x02, 0x03)) + bytes(range(number, 128 + number // 8)) for number in range(40)]


class Meeting:
    """Our link on the left, the partner on the right."""

    def __init__(self, ours: Priority, seed: int = 0, faults: Faults = NO_FAULTS) -> None:
        self.link, self.partner = Link(RHO3, ours), ByHandPartner(ours is Priority.LOW)
        self.events: list[Happening] = []
        self.line = VirtualLine[Happening](self.link, self.partner, self._note, seed, faults)

    def _note(self, side: int, event: Happening, now: Ns) -> None:
        self.events.append(event)

    def both_send(self, ours: bytes | None, theirs: bytes | None) -> None:
        if ours is not None:
            self.link.send(ours, self.line.now)
            self.line.kick(0)
        if theirs is not None:
            self.partner.give(theirs, self.line.now)
            self.line.kick(1)

    def told(self, kind: type[Happening]) -> list[Happening]:
        return [event for event in self.events if isinstance(event, kind)]


@pytest.mark.parametrize("priority", list(Priority))
def test_blocks_both_ways_one_after_the_other(priority: Priority) -> None:
    meeting = Meeting(priority)
    for block in BLOCKS:
        meeting.both_send(block, None)
        meeting.line.run(meeting.line.now + ms(400))
        meeting.both_send(None, block)
        meeting.line.run(meeting.line.now + ms(400))
    assert meeting.told(Got) == [Got(block) for block in BLOCKS]
    assert meeting.told(BlockReceived) == [BlockReceived(block) for block in BLOCKS]
    assert len(meeting.told(BlockSent)) == len(meeting.told(Gave)) == len(BLOCKS)


@pytest.mark.requirement("RHO-SER-10", by="protocols.p3964r.sender:Sender._meet")
@pytest.mark.parametrize("priority", list(Priority))
def test_both_send_at_once_and_no_block_is_lost(priority: Priority) -> None:
    meeting = Meeting(priority)
    for block in BLOCKS:
        meeting.both_send(block, block[::-1])
        meeting.line.run(meeting.line.now + ms(1000))
    assert meeting.told(Got) == [Got(block) for block in BLOCKS]
    assert meeting.told(BlockReceived) == [BlockReceived(block[::-1]) for block in BLOCKS]
    assert meeting.told(Gave) == [Gave(block[::-1], True) for block in BLOCKS]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("priority", list(Priority))
def test_a_line_with_damaged_characters_costs_repeats_but_no_block(priority: Priority, seed: int) -> None:
    meeting = Meeting(priority, seed, Faults(damage=0.002))
    for block in BLOCKS:
        meeting.both_send(block, block[::-1])
        meeting.line.run(meeting.line.now + ms(20_000))
    assert without_repeats(meeting.told(Got)) == [Got(block) for block in BLOCKS]
    assert without_repeats(meeting.told(BlockReceived)) == [BlockReceived(block[::-1]) for block in BLOCKS]
    assert not meeting.told(SendFailed) and all(isinstance(gave, Gave) and gave.acknowledged for gave in meeting.told(Gave))
    assert meeting.line.counts(0).damaged > 0 < meeting.line.counts(1).damaged


def without_repeats(events: list[Happening]) -> list[Happening]:
    """A lost acknowledgement makes the sender repeat a block already delivered: by design of 3964R."""
    return [event for at, event in enumerate(events) if at == 0 or event != events[at - 1]]
