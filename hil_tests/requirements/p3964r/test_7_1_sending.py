"""rho 3 Releases part 1, section 7.1: what the block transmitter must do; where it is silent, AX-003, AX-004, AX-052."""

import pytest

from hil_tests.lab.virtual.bench import Bench
from protocols.base.errors import EncodeError
from protocols.base.machine import Damage, ms
from protocols.p3964r.events import BlockSent, Failure, SendFailed, SendRepeated, Stage, StrayCharacters
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority

STX, DLE, NAK = b"\x02", b"\x10", b"\x15"
BLOCK_A = b"A\x10\x03\x52"


def idle() -> Bench[Link]:
    return Bench(Link(RHO3, Priority.HIGH))


def wishing(block: bytes = b"A") -> Bench[Link]:
    """STX has been sent at 0."""
    return idle().does(lambda link, now: link.send(block, now)).says(STX)


def sending(block: bytes = b"A") -> Bench[Link]:
    """The block is given out but has not yet left the line."""
    line = Bench(Link(RHO3, Priority.HIGH), leaves_at_once=False)
    return line.does(lambda link, now: link.send(block, now)).says(STX).left().hears(DLE)


@pytest.mark.requirement("RHO-SER-01", by="protocols.p3964r.sender:Sender._connect")
@pytest.mark.requirement("RHO-SER-04", by="protocols.p3964r.characters:wire_block")
def test_stx_then_dle_then_the_block_with_its_check_then_dle() -> None:
    line = wishing(b"12").at(ms(549)).hears(DLE).says(b"12\x10\x03\x10").reports()
    line.at(ms(600)).hears(DLE).says(b"").reports(BlockSent(1))


@pytest.mark.requirement("RHO-SER-01", by="protocols.p3964r.sender:Sender._finish")
def test_every_block_needs_its_own_connection() -> None:
    line = wishing().does(lambda link, now: link.send(b"B", now)).says(b"")
    line.hears(DLE).says(BLOCK_A).hears(DLE).says(STX).reports(BlockSent(1))
    line.at(ms(1)).hears(DLE).says(b"B\x10\x03\x51").hears(DLE).says(b"").reports(BlockSent(2))


@pytest.mark.requirement("RHO-SER-02", by="protocols.p3964r.sender:Sender.expire")
def test_a_silent_partner_gets_six_stx_550_ms_apart_then_the_job_fails() -> None:
    line = wishing()
    for repeat in range(1, 6):
        line.at(ms(550 * repeat) - 1).says(b"").reports()
        line.at(ms(550 * repeat)).says(STX).reports(SendRepeated(1, Failure.SILENT, Stage.CONNECT))
    line.at(ms(3300) - 1).says(b"").reports()
    line.at(ms(3300)).says(NAK).reports(SendFailed(1, Failure.SILENT, Stage.CONNECT))
    line.at(ms(60_000)).says(b"").reports()


@pytest.mark.requirement("RHO-SER-02", by="protocols.p3964r.sender:Sender._connect_failed")
@pytest.mark.parametrize("answer, why", [(NAK, Failure.NAK), (b"A", Failure.WRONG)])
def test_any_answer_but_dle_to_stx_repeats_it_at_once_six_in_all(answer: bytes, why: Failure) -> None:
    line = wishing()
    for repeat in range(1, 6):
        line.at(ms(repeat)).hears(answer).says(STX).reports(SendRepeated(1, why, Stage.CONNECT))
    line.at(ms(6)).hears(answer).says(NAK).reports(SendFailed(1, why, Stage.CONNECT))


def test_a_damaged_answer_to_stx_repeats_it() -> None:
    line = wishing().damaged(Damage.PARITY).says(STX).reports(SendRepeated(1, Failure.DAMAGED, Stage.CONNECT))
    line.at(1000).hears(DLE).says(BLOCK_A)


def test_what_came_in_one_burst_with_a_refused_stx_is_no_answer_to_the_next_one() -> None:
    """Else two of our STX and the block would leave in one breath (AX-228)."""
    line = wishing().hears(NAK + DLE + NAK).says(STX).reports(SendRepeated(1, Failure.NAK, Stage.CONNECT))
    line.at(1000).hears(DLE).says(BLOCK_A)


def test_a_late_report_of_what_left_before_starts_no_wait() -> None:
    link = Link(RHO3, Priority.HIGH)
    link.send(b"A", 0)
    assert link.sent(ms(1)) == [] and link.deadline() is None and link.take_output() == STX


def test_the_wait_runs_from_when_stx_has_left() -> None:
    line = Bench(Link(RHO3, Priority.HIGH), leaves_at_once=False)
    line.does(lambda link, now: link.send(b"A", now)).says(STX)
    line.at(ms(500)).left().at(ms(1050) - 1).says(b"")
    line.at(ms(1050)).says(STX).reports(SendRepeated(1, Failure.SILENT, Stage.CONNECT))


@pytest.mark.requirement("RHO-SER-03", by="protocols.p3964r.characters:wire_block")
def test_a_dle_in_the_data_is_sent_twice() -> None:
    wishing(b"\x10A").hears(DLE).says(b"\x10\x10A\x10\x03\x52")


@pytest.mark.requirement("RHO-SER-05", by="protocols.p3964r.link:Link.send")
def test_138_bytes_are_sent_139_are_rejected_without_transmission() -> None:
    wishing(b"A" * 138).hears(DLE).says(b"A" * 138 + b"\x10\x03\x13")
    for wrong in (b"A" * 139, b""):
        link = Link(RHO3, Priority.HIGH)
        with pytest.raises(EncodeError, match=f"block of {len(wrong)} bytes, limit 138"):
            link.send(wrong, 0)
        assert link.take_output() == b"" and link.deadline() is None and link.pending == 0


@pytest.mark.requirement("RHO-SER-07", by="protocols.p3964r.sender:Sender._block_failed")
@pytest.mark.parametrize("answer, why", [(NAK, Failure.NAK), (b"A", Failure.WRONG), (STX, Failure.WRONG)])
def test_any_answer_but_dle_to_the_check_repeats_the_block_from_stx_six_in_all(answer: bytes, why: Failure) -> None:
    line = wishing()
    for repeat in range(1, 6):
        line.at(ms(10 * repeat)).hears(DLE).says(BLOCK_A)
        line.at(ms(10 * repeat + 5)).hears(answer).says(STX).reports(SendRepeated(1, why, Stage.BLOCK))
    line.at(ms(100)).hears(DLE).says(BLOCK_A).hears(answer).says(NAK).reports(SendFailed(1, why, Stage.BLOCK))


@pytest.mark.requirement("RHO-SER-07", by="protocols.p3964r.sender:Sender._succeed")
def test_dle_ends_the_repeats_at_once() -> None:
    line = wishing().hears(DLE).says(BLOCK_A).hears(NAK).says(STX).reports(SendRepeated(1, Failure.NAK, Stage.BLOCK))
    line.at(ms(1)).hears(DLE).says(BLOCK_A).at(ms(2)).hears(DLE).says(b"").reports(BlockSent(1))
    line.at(ms(60_000)).says(b"").reports()


@pytest.mark.requirement("RHO-SER-08", by="protocols.p3964r.sender:Sender.sent")
def test_no_answer_within_550_ms_after_the_check_repeats_the_block() -> None:
    line = sending().says(BLOCK_A)
    line.at(ms(165)).left()
    line.at(ms(715) - 1).says(b"").reports()
    line.at(ms(715)).says(STX).reports(SendRepeated(1, Failure.SILENT, Stage.BLOCK))
    line.left().at(ms(720)).hears(DLE).says(BLOCK_A).left().at(ms(725)).hears(DLE).reports(BlockSent(1))


def test_a_damaged_answer_to_the_check_repeats_the_block() -> None:
    line = wishing().hears(DLE).says(BLOCK_A).damaged(Damage.FRAMING).says(STX)
    line.reports(SendRepeated(1, Failure.DAMAGED, Stage.BLOCK))


def test_connection_and_block_attempts_are_counted_apart_and_neither_resets_the_other() -> None:
    line = wishing()
    for repeat in range(1, 6):
        line.at(ms(repeat)).hears(NAK).says(STX).reports(SendRepeated(1, Failure.NAK, Stage.CONNECT))
    line.at(ms(10)).hears(DLE).says(BLOCK_A).hears(NAK).says(STX).reports(SendRepeated(1, Failure.NAK, Stage.BLOCK))
    line.at(ms(11)).hears(NAK).says(NAK).reports(SendFailed(1, Failure.NAK, Stage.CONNECT))


def test_a_new_job_starts_with_fresh_counters() -> None:
    line = wishing().does(lambda link, now: link.send(b"B", now))
    line.at(ms(3300) - 1).says(STX * 5).reports(*[SendRepeated(1, Failure.SILENT, Stage.CONNECT)] * 5)
    line.at(ms(3300)).says(NAK + STX).reports(SendFailed(1, Failure.SILENT, Stage.CONNECT))
    line.at(ms(6600) - 1).says(STX * 5).reports(*[SendRepeated(2, Failure.SILENT, Stage.CONNECT)] * 5)


# ---- while the block is on its way
def test_nak_during_the_block_breaks_off_and_counts_as_a_failed_block() -> None:
    link = Link(RHO3, Priority.HIGH)
    link.send(b"A", 0)
    assert link.take_output() == STX
    assert link.receive(DLE, 0) + link.receive(NAK, 0) == [SendRepeated(1, Failure.NAK, Stage.BLOCK)]
    assert link.take_output() == STX  # the block, not yet taken, stays here


def test_nak_after_the_block_was_given_out_repeats_after_its_rest() -> None:
    line = sending().says(BLOCK_A).at(ms(2)).hears(NAK).says(STX).reports(SendRepeated(1, Failure.NAK, Stage.BLOCK))
    line.at(ms(5)).left().at(ms(555) - 1).says(b"").at(ms(555)).says(STX).reports(SendRepeated(1, Failure.SILENT, Stage.CONNECT))


def test_other_characters_during_the_block_change_nothing() -> None:
    line = sending().says(BLOCK_A).hears(b"AB").damaged(Damage.PARITY).says(b"").reports()
    line.at(ms(10)).left().hears(DLE).reports(BlockSent(1))


def test_a_second_dle_to_stx_is_not_taken_for_the_acknowledgement() -> None:
    line = sending(b"A" * 60).says(b"A" * 60 + b"\x10\x03\x13").at(ms(1)).hears(DLE).says(b"").reports()
    line.at(ms(70)).left().reports().at(ms(620)).says(STX).reports(SendRepeated(1, Failure.SILENT, Stage.BLOCK))


def test_an_acknowledgement_that_overtakes_the_ports_report_counts() -> None:
    line = sending().says(BLOCK_A).at(ms(10)).hears(DLE).reports()
    line.at(ms(12)).left().reports(BlockSent(1))


def test_dle_after_giving_up_is_a_stray_character() -> None:
    line = wishing().at(ms(3300)).hears(DLE).at(ms(3600))
    line.says(STX * 5 + NAK)
    line.reports(*[SendRepeated(1, Failure.SILENT, Stage.CONNECT)] * 5, SendFailed(1, Failure.SILENT, Stage.CONNECT), StrayCharacters(1))


# ---- break, loss, crowd
def test_break_ends_the_job_without_a_repeat() -> None:
    wishing().damaged(Damage.BREAK).says(b"").reports(SendFailed(1, Failure.BREAK, Stage.CONNECT)).at(ms(9000)).says(b"").reports()
    line = sending().says(BLOCK_A).damaged(Damage.BREAK).says(b"").reports(SendFailed(1, Failure.BREAK, Stage.BLOCK))
    line.at(ms(9000)).says(b"").reports()


def test_a_lost_port_reports_every_open_job_and_the_next_one_starts_anew() -> None:
    line = wishing().does(lambda link, now: link.send(b"B", now)).loses_the_port()
    line.says(b"").reports(SendFailed(1, Failure.LOST, Stage.CONNECT), SendFailed(2, Failure.LOST, Stage.WAITING))
    line.at(ms(9000)).says(b"").reports().does(lambda link, now: link.send(b"C", now)).says(STX)


def test_jobs_do_not_grow_without_end_while_the_partner_is_away() -> None:
    line = wishing()
    for _ in range(63):
        line.does(lambda link, now: link.send(b"B", now))
    line.says(b"").reports()
    line.does(lambda link, now: link.send(b"C", now)).reports(SendFailed(2, Failure.CROWDED, Stage.WAITING))
    assert line.machine.pending == 64


def test_a_block_is_replaced_until_its_first_character_is_on_the_line() -> None:
    """AX-650: STX says nothing of the block that follows."""
    line = idle().does(lambda link, now: link.send(b"A", now)).does(lambda link, now: link.send(b"C", now)).says(STX)
    line.does(lambda link, now: link.replace(1, b"B")).does(lambda link, now: link.replace(2, b"D", follow_on=True))
    line.hears(DLE).says(b"B\x10\x03\x51").does(lambda link, now: link.replace(1, b"A")).hears(DLE).says(STX).reports(BlockSent(1))
    line.at(ms(1)).hears(DLE).says(b"D\x10\x03\x57").hears(DLE).says(b"").reports(BlockSent(2))
    assert not line.machine.replace(2, b"E")


@pytest.mark.parametrize(("after", "told"), [(1100, BlockSent(1)), (900, None)])
def test_an_acknowledgement_shortly_before_a_late_report_counts_by_the_length_of_the_block(after: int, told: BlockSent | None) -> None:
    """AX-652: a clock that differs from the port's count is late by a share of the block's time; here 1170 ms, of which 1/16 counts."""
    line = sending(b"A" * 100).at(ms(after)).hears(DLE).at(ms(1170)).left()
    line.reports(*([told] if told else [])).says(b"A" * 100 + b"\x10\x03\x13")
    if told is None:
        line.at(ms(1200)).hears(DLE).says(b"").reports(BlockSent(1))
