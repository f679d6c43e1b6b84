"""rho 3 Releases part 1, section 7.1: what the block receiver must do; where it is silent, AX-005..009, AX-050."""

import pytest

from hil_tests.lab.virtual.bench import Bench
from protocols.base.machine import Damage, ms
from protocols.p3964r.events import BlockReceived, BlockRefused, LineBreak, ReceptionFailed, Refusal, StrayCharacters
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority

STX, DLE, NAK = b"\x02", b"\x10", b"\x15"
GOOD_AB = b"AB\x10\x03\x10"  # 41h ^ 42h ^ 10h ^ 03h = 10h


def listening() -> Bench[Link]:
    return Bench(Link(RHO3, Priority.LOW))


def connected() -> Bench[Link]:
    return listening().at(0).hears(STX).says(DLE).reports()


def test_a_good_block_is_acknowledged_and_reported_once() -> None:
    connected().at(ms(5)).hears(GOOD_AB).says(DLE).reports(BlockReceived(b"AB"))


def test_stx_and_block_in_one_piece() -> None:
    listening().hears(STX + GOOD_AB).says(DLE + DLE).reports(BlockReceived(b"AB"))


@pytest.mark.requirement("RHO-SER-03", by="protocols.p3964r.receiver:Receiver._store")
def test_a_doubled_dle_is_one_character_of_data() -> None:
    connected().hears(b"\x10\x10A\x10\x03\x52").says(DLE).reports(BlockReceived(b"\x10A"))


@pytest.mark.requirement("RHO-SER-04", by="protocols.p3964r.characters:check_of")
def test_block_check_of_31h_32h_is_10h_and_is_alone() -> None:
    connected().hears(b"\x31\x32\x10\x03\x10").says(DLE).reports(BlockReceived(b"12"))
    connected().hears(b"\x31\x32\x33\x10\x03\x23").says(DLE).reports(BlockReceived(b"123"))
    connected().hears(b"\x01\x02\x10\x03\x10").says(DLE).reports(BlockReceived(b"\x01\x02"))


def test_block_check_that_equals_a_control_character_is_taken_as_it_is() -> None:
    for check in (0x10, 0x15, 0x02, 0x03):
        data = bytes((0x41, 0x41 ^ 0x13 ^ check))
        connected().hears(data + b"\x10\x03" + bytes((check,))).says(DLE).reports(BlockReceived(data))


@pytest.mark.requirement("RHO-SER-05", by="protocols.p3964r.receiver:Receiver._store")
def test_138_characters_are_taken_139_are_heard_to_the_end_and_refused_once() -> None:
    connected().hears(b"A" * 138 + b"\x10\x03\x13").says(DLE).reports(BlockReceived(b"A" * 138))
    connected().hears(b"\x10" * 276 + b"\x10\x03\x13").says(DLE).reports(BlockReceived(b"\x10" * 138))
    line = connected().hears(b"A" * 139 + b"\x02A").says(b"").reports()
    line.hears(b"\x10\x03\x52").says(NAK).reports(BlockRefused(Refusal.LENGTH, 141))


@pytest.mark.requirement("RHO-SER-06", by="protocols.p3964r.receiver:Receiver.expire")
def test_a_gap_of_220_ms_inside_a_block_is_answered_with_nak() -> None:
    line = connected().at(ms(5)).hears(b"A").says(b"")
    line.at(ms(225) - 1).says(b"").reports()
    line.at(ms(225)).says(NAK).reports(BlockRefused(Refusal.GAP, 1))
    line.at(ms(230)).hears(STX).says(DLE).reports()


@pytest.mark.requirement("RHO-SER-06", by="protocols.p3964r.receiver:Receiver._step")
def test_a_gap_of_200_ms_is_accepted_everywhere() -> None:
    line = connected()
    for number, byte in enumerate(b"A\x10\x10B\x10\x03"):
        line.at(ms(200 * (number + 1))).hears(bytes((byte,))).says(b"").reports()
    line.at(ms(1400)).hears(b"\x10").says(DLE).reports(BlockReceived(b"A\x10B"))


@pytest.mark.parametrize("heard, count", [(b"", 0), (b"A", 1), (b"A\x10", 1), (b"A\x10\x03", 1)])
def test_silence_at_any_place_of_a_block(heard: bytes, count: int) -> None:
    line = connected().hears(heard)
    line.at(ms(220) - 1).says(b"").reports()
    line.at(ms(220)).says(NAK).reports(BlockRefused(Refusal.GAP, count))


def test_the_gap_after_our_dle_runs_from_when_it_has_left() -> None:
    line = Bench(Link(RHO3, Priority.LOW), leaves_at_once=False)
    line.hears(STX).says(DLE)
    line.at(ms(100)).left()
    line.at(ms(320) - 1).says(b"").reports()
    line.at(ms(320)).says(NAK).reports(BlockRefused(Refusal.GAP, 0))


def test_a_late_report_of_our_dle_does_not_prolong_a_gap_inside_the_block() -> None:
    line = Bench(Link(RHO3, Priority.LOW), leaves_at_once=False)
    line.hears(STX).says(DLE)
    line.at(ms(1)).hears(b"A")
    line.at(ms(100)).left()
    line.at(ms(221)).says(NAK).reports(BlockRefused(Refusal.GAP, 1))


@pytest.mark.requirement("RHO-SER-09", by="protocols.p3964r.receiver:Receiver._judge")
def test_a_wrong_block_check_is_answered_with_nak_and_nothing_is_delivered() -> None:
    line = connected().hears(b"AB\x10\x03\x11").says(NAK).reports(BlockRefused(Refusal.CHECK, 2))
    line.hears(STX).says(DLE).hears(GOOD_AB).says(DLE).reports(BlockReceived(b"AB"))


def test_a_check_that_counts_a_doubled_dle_once_is_refused() -> None:
    connected().hears(b"A\x10\x10B\x10\x03\x00").says(NAK).reports(BlockRefused(Refusal.CHECK, 3))


def test_a_block_refused_inside_is_answered_once_and_its_tail_never_starts_a_new_one() -> None:
    line = connected().hears(b"A\x10BCD\x02EVIL\x10\x03\x13").says(NAK)
    line.reports(BlockRefused(Refusal.ORDER, 8))


def test_a_refused_block_without_an_end_is_answered_once_after_the_gap() -> None:
    line = connected().hears(b"A\x10BC\x02D").says(b"")
    line.at(ms(220)).says(NAK).reports(BlockRefused(Refusal.ORDER, 4))


@pytest.mark.parametrize("kind", [Damage.PARITY, Damage.FRAMING, Damage.OVERRUN])
def test_a_damaged_character_spoils_the_block_which_is_heard_to_its_end(kind: Damage) -> None:
    connected().hears(b"A").damaged(kind).says(b"").hears(b"\x10\x03\x13").says(NAK).reports(BlockRefused(Refusal.DAMAGED, 1))
    connected().hears(b"A\x10\x03").damaged(kind).says(NAK).reports(BlockRefused(Refusal.DAMAGED, 1))  # it was the check
    line = connected().hears(b"A\x10").damaged(kind).says(b"").hears(b"\x52").says(b"").reports()  # it was the ETX
    line.at(ms(220)).says(NAK).reports(BlockRefused(Refusal.DAMAGED, 2))


def test_a_damaged_character_counts_for_the_gap() -> None:
    line = connected().at(ms(200)).damaged(Damage.PARITY)
    line.at(ms(419)).says(b"").reports()
    line.at(ms(420)).says(NAK).reports(BlockRefused(Refusal.DAMAGED, 0))


def test_stx_inside_a_block_is_data() -> None:
    connected().hears(b"\x02\x15\x03\x10\x03\x07").says(DLE).reports(BlockReceived(b"\x02\x15\x03"))


def test_dle_etb_ends_a_block_as_well() -> None:
    connected().hears(b"A\x10\x17\x46").says(DLE).reports(BlockReceived(b"A"))


def test_an_empty_block_is_a_block() -> None:
    connected().hears(b"\x10\x03\x13").says(DLE).reports(BlockReceived(b""))


# ---- idle
def test_nak_in_idle_is_not_answered() -> None:
    listening().hears(NAK * 3).says(b"").reports().at(ms(9000)).says(b"").reports()


def test_stray_characters_in_idle_are_silent_and_counted() -> None:
    line = listening().hears(b"\x10\x03A").says(b"").reports()
    line.at(ms(10)).damaged(Damage.PARITY).says(b"").reports()
    line.at(ms(230)).says(b"").reports(StrayCharacters(4))
    line.at(ms(231)).hears(b"x").at(ms(240)).hears(STX).says(DLE).reports(StrayCharacters(1))


def test_break_in_idle_is_not_answered() -> None:
    listening().damaged(Damage.BREAK).says(b"").reports(LineBreak()).at(ms(9000)).says(b"").reports()


def test_break_inside_a_block_leads_to_idle_at_once_without_an_answer() -> None:
    line = connected().hears(b"A").damaged(Damage.BREAK).says(b"").reports(BlockRefused(Refusal.BREAK, 1))
    line.at(ms(1000)).says(b"").reports().hears(STX).says(DLE)


def test_nothing_is_said_at_start() -> None:
    listening().says(b"").at(ms(60_000)).says(b"").reports()


# ---- the repeat
def test_a_refused_block_that_is_not_repeated_within_4_s_is_reported() -> None:
    line = connected().at(ms(1)).hears(b"A\x10\x03\x00").says(NAK).reports(BlockRefused(Refusal.CHECK, 1))
    line.at(ms(4001) - 1).reports()
    line.at(ms(4001)).says(b"").reports(ReceptionFailed(Refusal.CHECK, 1))
    line.at(ms(60_000)).says(b"").reports()


def test_the_wait_for_a_repeat_ends_with_the_next_stx() -> None:
    line = connected().hears(b"A\x10\x03\x00").says(NAK).reports(BlockRefused(Refusal.CHECK, 1))
    line.at(ms(3999)).hears(STX + b"A\x10\x03\x52").says(DLE + DLE).reports(BlockReceived(b"A")).at(ms(60_000)).reports()


def test_six_refusals_in_a_row_are_a_failure_with_the_first_fault_and_a_good_block_still_comes_in() -> None:
    line = listening().hears(STX).says(DLE).hears(b"A\x10A\x10\x03\x00").says(NAK).reports(BlockRefused(Refusal.ORDER, 1))
    for attempt in range(2, 8):
        line.at(ms(attempt)).hears(STX).says(DLE).hears(b"A\x10\x03\x00").says(NAK)
        failed = (ReceptionFailed(Refusal.ORDER, 6),) if attempt == 6 else ()
        line.reports(BlockRefused(Refusal.CHECK, 1), *failed)
    line.at(ms(100)).hears(STX).says(DLE).hears(GOOD_AB).says(DLE).reports(BlockReceived(b"AB"))


# ---- the buffer
def driver() -> Bench[Link]:
    """The driver task of 7.1 with no READ active, one block acknowledged and stored."""
    line = Bench(Link(RHO3, Priority.LOW, keep_one=True))
    return line.hears(STX + GOOD_AB).says(DLE + DLE).reports(BlockReceived(b"AB"))


@pytest.mark.requirement("RHO-SER-12", by="protocols.p3964r.receiver:Receiver._open")
def test_a_second_block_is_not_acknowledged_until_the_first_is_read() -> None:
    line = driver().at(ms(10)).hears(STX).says(b"").reports()
    line.at(ms(410) - 1).says(b"").reports()
    line.at(ms(410)).says(NAK).reports(BlockRefused(Refusal.NO_BUFFER, 0))
    line.at(ms(411)).hears(STX).says(b"")


@pytest.mark.requirement("RHO-SER-12", by="protocols.p3964r.link:Link.take_block")
def test_the_stored_block_is_read_once_and_the_waiting_partner_is_answered() -> None:
    line = driver().at(ms(10)).hears(STX).says(b"")
    line.at(ms(300)).does(lambda link, now: check(link.take_block(now), b"AB")).says(DLE)
    line.does(lambda link, now: check(link.take_block(now), None)).hears(b"C\x10\x03\x50").says(DLE).reports(BlockReceived(b"C"))


def check(block: bytes | None, expected: bytes | None) -> None:
    assert block == expected


def test_other_characters_while_waiting_for_a_buffer_change_nothing() -> None:
    line = driver().at(ms(10)).hears(STX).at(ms(300)).hears(STX + b"A").damaged(Damage.PARITY).says(b"").reports()
    line.at(ms(410)).says(NAK).reports(BlockRefused(Refusal.NO_BUFFER, 0))


def test_an_owner_without_room_refuses_and_takes_again() -> None:
    line = listening().does(lambda link, now: link.set_buffer_free(False, now)).hears(STX).says(b"")
    line.at(ms(400)).says(NAK).reports(BlockRefused(Refusal.NO_BUFFER, 0))
    line.does(lambda link, now: link.set_buffer_free(True, now)).says(b"").hears(STX).says(DLE)


def test_the_port_lost_inside_a_block_keeps_the_stored_one() -> None:
    line = driver().does(lambda link, now: link.set_buffer_free(True, now)).hears(STX + b"A").says(DLE)
    line.loses_the_port().says(b"").reports(BlockRefused(Refusal.LOST, 1))
    line.at(ms(9000)).says(b"").reports().does(lambda link, now: check(link.take_block(now), b"AB"))


def test_a_break_inside_a_block_is_reported_at_once_and_the_tail_never_starts_a_new_one() -> None:
    """AX-228: until the line was quiet for one ZVZ."""
    line = connected().hears(b"A").damaged(Damage.BREAK).says(b"").reports(BlockRefused(Refusal.BREAK, 1))
    line.hears(b"\x02EVIL\x10\x03\x00").damaged(Damage.BREAK).damaged(Damage.PARITY).says(b"").reports()
    line.at(ms(220) - 1).hears(b"x").says(b"").at(ms(440)).reports(StrayCharacters(10))
    line.hears(STX).says(DLE).hears(GOOD_AB).says(DLE).reports(BlockReceived(b"AB"))


def test_a_gap_that_ended_before_the_next_bytes_is_reported_first() -> None:
    link = Link(RHO3, Priority.LOW)
    link.receive(STX + b"A", 0)
    link.take_output()
    assert BlockReceived(b"AB") not in link.receive(b"B", ms(5000))
    link.send(b"AB", ms(9000))
    link.take_output()
    link.sent(ms(9001))
    link.receive(DLE, ms(9002))
    link.take_output()
    link.sent(ms(9003))
    assert link.sent(ms(9004)) == [], "a second report of what has left changes nothing"
