"""Our link against hostile partners over a line in virtual time, both wanting to send: what comes out is named for each."""

from collections import Counter
from dataclasses import replace

import pytest

from gateway.conformance.serial.partners import make
from hil_tests.lab.virtual.virtual_line import VirtualLine
from protocols.base.machine import Ns, ms
from protocols.p3964r.events import BlockReceived, BlockSent, SendFailed, SendRepeated
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority

ROUNDS = 20


def meet(partner: str, rounds: int = ROUNDS, pause: Ns = 0, ours_is: Priority = Priority.HIGH) -> tuple[Counter[str], list[object]]:
    """Both get a block at the same moment, so many times; what happened on our side, and what the partner took."""
    theirs_is = Priority.LOW if ours_is is Priority.HIGH else Priority.HIGH
    ours, theirs = Link(replace(RHO3, retry_pause=pause), ours_is), make(partner, RHO3, theirs_is)
    theirs.passive = None
    counts: Counter[str] = Counter()
    received: list[object] = []

    def event(side: int, what: object, now: Ns) -> None:
        if side == 0:
            name = type(what).__name__
            reason = f" {what.why.name}" if isinstance(what, SendFailed | SendRepeated) else ""
            counts[name + reason] += 1
            if isinstance(what, BlockReceived):
                received.append(what.data)

    line: VirtualLine[object] = VirtualLine(ours, theirs, event)
    for number in range(rounds):
        ours.send(b"ours" + number.to_bytes(2, "big"), line.now)
        theirs.stimulate(line.now, b"theirs" + number.to_bytes(2, "big"))
        line.kick(0)
        line.kick(1)
        line.run(line.now + ms(8000))
    return counts, received


@pytest.mark.parametrize(
    "partner, sent, received, noted",
    [
        ("good", ROUNDS, ROUNDS, {}),
        ("silent", 0, 0, {"SendFailed SILENT": ROUNDS, "SendRepeated SILENT": 5 * ROUNDS}),
        ("no-nak", ROUNDS, ROUNDS, {}),
        ("drops-its-job", ROUNDS, 0, {}),  # the partner's own loss; ours lose nothing
        ("slow-21ms", ROUNDS, ROUNDS, {}),
        ("two-attempts", ROUNDS, ROUNDS, {}),
        ("naks-conflicts", ROUNDS, ROUNDS, {"SendRepeated NAK": ROUNDS, "SendFailed NAK": 0}),  # let through, then ours goes (AX-243)
    ],
)
def test_each_hostile_partner_has_its_named_outcome(partner: str, sent: int, received: int, noted: dict[str, int]) -> None:
    _outcome(Priority.HIGH, partner, sent, received, noted)


@pytest.mark.parametrize(
    "partner, sent, received, noted",
    [
        ("silent", 0, 0, {"SendFailed SILENT": ROUNDS, "SendRepeated SILENT": 5 * ROUNDS}),
        ("no-nak", ROUNDS, ROUNDS, {}),
        ("drops-its-job", ROUNDS, 0, {"SamePriority": ROUNDS, "ReceptionFailed": ROUNDS}),  # gives way although it has priority
        ("slow-21ms", ROUNDS, ROUNDS, {}),
        ("two-attempts", ROUNDS, ROUNDS, {}),
        ("naks-conflicts", ROUNDS, ROUNDS, {"BlockRefused": ROUNDS}),  # its NAK is the first character after our DLE
    ],
)
def test_each_hostile_partner_with_priority_has_its_named_outcome(partner: str, sent: int, received: int, noted: dict[str, int]) -> None:
    _outcome(Priority.LOW, partner, sent, received, noted)


def _outcome(ours_is: Priority, partner: str, sent: int, received: int, noted: dict[str, int]) -> None:
    counts, blocks = meet(partner, ours_is=ours_is)
    assert counts["BlockSent"] == sent, counts
    assert len(blocks) == received, counts
    assert len(set(map(str, blocks))) == received  # each once
    for name, count in noted.items():
        assert counts[name] == count, counts


def test_a_pause_before_repeats_gets_past_a_partner_that_naks_conflicts() -> None:
    counts, blocks = meet("naks-conflicts", pause=ms(50))
    assert counts["BlockSent"] == ROUNDS, counts
    assert len(blocks) == ROUNDS


def test_a_thousand_rounds_lose_no_job_on_either_side() -> None:
    counts, blocks = meet("good", 1000)
    assert counts["BlockSent"] == 1000
    assert len(blocks) == 1000


def test_two_attempts_of_the_partner_are_too_few_when_we_are_busy_twice() -> None:
    """We refuse its STX twice: it gives up, as its two attempts allow, and we hear nothing of that block."""
    theirs = make("two-attempts", RHO3, Priority.LOW)
    theirs.passive = None
    theirs.stimulate(0, b"late")
    said = b""
    for now in (ms(10), ms(20)):
        said += theirs.take_output()
        theirs.sent(now - ms(5))
        theirs.receive(b"\x15", now)
    assert said + theirs.take_output() == b"\x02\x02\x15"
    assert theirs.link.pending == 0


def test_blocks_are_delivered_whole_to_a_slow_partner() -> None:
    ours, theirs = Link(RHO3, Priority.HIGH), make("slow-21ms", RHO3, Priority.LOW)
    theirs.passive = None
    sent: list[object] = []
    line: VirtualLine[object] = VirtualLine(
        ours, theirs, lambda side, what, now: sent.append(what) if isinstance(what, BlockSent) else None
    )
    ours.send(b"\x10" * 138, 0)
    line.kick(0)
    line.run(ms(5000))
    assert theirs.received == [b"\x10" * 138]
    assert len(sent) == 1
