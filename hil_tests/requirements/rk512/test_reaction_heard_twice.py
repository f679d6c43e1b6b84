"""The acknowledgement of a reaction is lost: the partner repeats it after our next command has left (AX-225, AX-242)."""

import pytest

from gateway.pure.lines.rk512_link import Rk512Link
from hil_tests.lab.virtual.rk512_blocks import Blocks
from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import wire_block
from protocols.p3964r.profiles import RHO3, Priority
from protocols.rk512.active import Done, Unasked

STX, DLE = b"\x02", b"\x10"
FIRST, SECOND = bytes.fromhex("00000000 1111"), bytes.fromhex("00000000 2222")


class Partner:
    """The other station by hand: what it says is written out, what we say and report is noted."""

    def __init__(self, priority: Priority) -> None:
        self.ours, self.now, self.events = Rk512Link(RHO3, priority, Blocks({})), 0, list[object]()

    def asks(self, word: int) -> None:
        self.ours.active.fetch(word, 1, 7)
        self.ours.start(self.now)

    def says(self, data: bytes, answer: bytes) -> None:
        """One burst, a millisecond later."""
        self.wait(ms(1))
        self.events += self.ours.receive(data, self.now)
        self.hears(answer)

    def hears(self, answer: bytes) -> None:
        assert self.ours.take_output() == answer
        if answer:
            self.events += self.ours.sent(self.now)

    def wait(self, time: Ns) -> None:
        self.now += time
        self.events += self.ours.wake(self.now)

    def first_job(self) -> None:
        self.asks(0)
        self.hears(STX)
        self.says(DLE, wire_block(bytes.fromhex("00004544070000 01FFFF")))
        self.says(DLE + STX, DLE)
        self.says(wire_block(FIRST), DLE)  # this DLE is lost
        assert self.events == [Done(1, b"\x11\x11")]
        self.events.clear()


@pytest.mark.parametrize("priority", list(Priority))
def test_the_repeat_of_a_reaction_is_not_the_next_one(priority: Priority) -> None:
    partner = Partner(priority)
    partner.first_job()
    partner.asks(1)
    partner.hears(STX)
    command = wire_block(bytes.fromhex("00004544070100 01FFFF"))
    if priority is Priority.HIGH:
        partner.says(STX, b"")  # waits for the acknowledgement: a STX is none, so it begins again
        partner.wait(ms(550))
        partner.hears(STX)
        partner.says(DLE, command)  # it gives way and keeps its job
        partner.says(DLE + STX, DLE)
        partner.says(wire_block(FIRST), DLE)
    else:
        partner.says(STX, DLE)
        partner.says(wire_block(FIRST), DLE + STX)
        partner.says(DLE, command)
        partner.says(DLE, b"")
    assert [event for event in partner.events if isinstance(event, Done | Unasked)] == [Unasked(FIRST)]
    partner.says(STX, DLE)
    partner.says(wire_block(SECOND), DLE)
    assert partner.events[-1] == Done(2, b"\x22\x22")
