"""rho 3 Releases part 1, section 7.1: both stations want to send at once; priority."""

import pytest

from hil_tests.lab.virtual.bench import Bench
from protocols.base.machine import ms
from protocols.p3964r.events import (
    BlockReceived,
    BlockRefused,
    BlockSent,
    Failure,
    ReceptionFailed,
    Refusal,
    SamePriority,
    SendFailed,
    SendRepeated,
    Stage,
)
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority, priority_from_output_timeout

STX, DLE, NAK = b"\x02", b"\x10", b"\x15"
BLOCK_A, BLOCK_B = b"A\x10\x03\x52", b"B\x10\x03\x51"


def wishing(priority: Priority) -> Bench[Link]:
    return Bench(Link(RHO3, priority)).does(lambda link, now: link.send(b"A", now)).says(STX)


@pytest.mark.requirement("RHO-SER-10", by="protocols.p3964r.sender:Sender._meet")
def test_with_priority_the_partners_stx_is_ignored_and_the_wait_for_dle_goes_on() -> None:
    line = wishing(Priority.HIGH).at(ms(100)).hears(STX).says(b"").reports()
    line.at(ms(549)).hears(DLE).says(BLOCK_A).hears(DLE).reports(BlockSent(1))


def test_with_priority_the_partners_stx_does_not_prolong_the_wait() -> None:
    line = wishing(Priority.HIGH).at(ms(100)).hears(STX).at(ms(550) - 1).says(b"").at(ms(550)).says(STX)
    line.reports(SamePriority(Priority.HIGH), SendRepeated(1, Failure.SILENT, Stage.CONNECT))


@pytest.mark.requirement("RHO-SER-10", by="protocols.p3964r.link:Link._start")
def test_without_priority_the_partner_goes_first_and_our_job_follows() -> None:
    line = wishing(Priority.LOW).at(ms(1)).hears(STX).says(DLE).reports()
    line.at(ms(10)).hears(BLOCK_B).says(DLE + STX).reports(BlockReceived(b"B"))
    line.at(ms(20)).hears(DLE).says(BLOCK_A).hears(DLE).reports(BlockSent(1))


def test_a_job_given_while_a_block_comes_in_waits_for_its_end() -> None:
    line = Bench(Link(RHO3, Priority.HIGH)).hears(STX).says(DLE).does(lambda link, now: link.send(b"A", now)).says(b"")
    line.hears(BLOCK_B).says(DLE + STX).reports(BlockReceived(b"B"))


def test_a_job_that_gave_way_again_and_again_has_all_its_attempts_once_blocks_came_in() -> None:
    line = wishing(Priority.LOW)
    for turn in range(20):
        line.at(ms(turn)).hears(STX + BLOCK_B).says(DLE + DLE + STX).reports(BlockReceived(b"B"))
    line.at(ms(50)).hears(NAK).says(STX).at(ms(51)).hears(DLE).says(BLOCK_A).reports(SendRepeated(1, Failure.NAK, Stage.CONNECT))


def test_a_job_that_gave_way_to_bad_blocks_loses_no_attempt() -> None:
    line = wishing(Priority.LOW)
    for turn in range(5):
        line.at(ms(turn)).hears(STX).says(DLE).hears(b"B\x10\x03\x00").says(NAK + STX).reports(BlockRefused(Refusal.CHECK, 1))
    line.at(ms(10)).hears(STX).says(DLE).hears(b"B\x10\x03\x00").says(NAK + STX)
    line.reports(BlockRefused(Refusal.CHECK, 1), ReceptionFailed(Refusal.CHECK, 6))
    line.at(ms(50)).hears(NAK).says(STX).at(ms(51)).hears(DLE).says(BLOCK_A).reports(SendRepeated(1, Failure.NAK, Stage.CONNECT))


def test_giving_way_in_a_repeat_keeps_the_job() -> None:
    line = wishing(Priority.LOW).hears(NAK).says(STX).reports(SendRepeated(1, Failure.NAK, Stage.CONNECT))
    line.at(ms(1)).hears(STX + BLOCK_B).says(DLE + DLE + STX).reports(BlockReceived(b"B"))
    line.hears(DLE).says(BLOCK_A).hears(DLE).reports(BlockSent(1))


def test_a_refused_block_after_giving_way_leaves_our_job_its_turn() -> None:
    wishing(Priority.LOW).hears(STX).says(DLE).hears(b"B\x10\x03\x00").says(NAK + STX).reports(BlockRefused(Refusal.CHECK, 1))


def test_both_without_priority_is_named_and_ends_after_six_attempts() -> None:
    line = wishing(Priority.LOW)
    for turn in range(6):
        line.at(ms(221 * turn)).hears(STX).says(DLE).hears(DLE).says(b"").reports()
        line.at(ms(221 * turn + 220)).says(NAK + (NAK if turn == 5 else STX))
        given_up = (ReceptionFailed(Refusal.GAP, 6), SendFailed(1, Failure.CONFLICT, Stage.CONNECT)) if turn == 5 else ()
        line.reports(SamePriority(Priority.LOW), BlockRefused(Refusal.GAP, 0), *given_up)


def test_both_with_priority_is_named_and_ends_after_six_attempts() -> None:
    line = wishing(Priority.HIGH)
    for turn in range(6):
        line.at(ms(550 * turn + 1)).hears(STX).says(b"").reports()
        line.at(ms(550 * (turn + 1))).says(NAK if turn == 5 else STX)
        ending = SendFailed if turn == 5 else SendRepeated
        line.reports(SamePriority(Priority.HIGH), ending(1, Failure.SILENT, Stage.CONNECT))


def test_a_partner_without_a_buffer_for_us_while_we_want_to_send() -> None:
    line = Bench(Link(RHO3, Priority.LOW)).does(lambda link, now: link.set_buffer_free(False, now))
    line.does(lambda link, now: link.send(b"A", now)).says(STX).hears(STX).says(b"")
    line.at(ms(400)).says(NAK + STX).reports(BlockRefused(Refusal.NO_BUFFER, 0))


@pytest.mark.requirement("RHO-SER-11", by="protocols.p3964r.profiles:priority_from_output_timeout")
def test_output_timeout_minus_one_is_without_priority_all_else_is_with() -> None:
    found = [priority_from_output_timeout(value) for value in (-1, 0, 1, 5000, -2)]
    assert found == [Priority.LOW] + [Priority.HIGH] * 4


@pytest.mark.requirement("RHO-SER-11", by="protocols.p3964r.sender:Sender.sent")
@pytest.mark.parametrize("value", [-1, 0, 5000])
def test_the_times_are_the_same_with_and_without_priority(value: int) -> None:
    line = wishing(priority_from_output_timeout(value)).at(ms(550) - 1).says(b"").at(ms(550)).says(STX)
    line.reports(SendRepeated(1, Failure.SILENT, Stage.CONNECT))
