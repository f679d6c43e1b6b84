"""What a sender may take for the answer to its STX (AX-241), a job taken back, and a block overtaken by one of ours (AX-242).

Bursts matter here: every `hears` is one, as a port hands it over.
"""

from dataclasses import replace

import pytest

from hil_tests.requirements.p3964r.test_rest_of_a_block import Line
from protocols.base.machine import Damage, ms
from protocols.p3964r.events import BlockReceived, BlockSent, Failure, SamePriority, SendFailed, SendRepeated, Stage
from protocols.p3964r.profiles import RHO3, Priority

STX, DLE, NAK = b"\x02", b"\x10", b"\x15"
BLOCK_A, BLOCK_B = b"A\x10\x03\x52", b"B\x10\x03\x51"
REPEATED = SendRepeated(1, Failure.WRONG, Stage.CONNECT)


def wishing(priority: Priority = Priority.HIGH, leaves: bool = True, pause: int = 0) -> Line:
    line = Line(replace(RHO3, retry_pause=pause), priority)
    assert line.link.send(b"A", 0) == 1
    return line.says(STX, leaves)


@pytest.mark.parametrize("behind", [b"\x10", b"\x10\x10\x10\x03\x13", b"x"])
def test_a_dle_with_more_behind_it_is_no_answer_to_stx(behind: bytes) -> None:
    """The rest of a torn block full of 10h: who says DLE waits for our block."""
    line = wishing().at(ms(1)).hears(DLE + behind).says(STX).reports(REPEATED)
    line.at(ms(2)).hears(DLE).says(BLOCK_A).hears(DLE).reports(BlockSent(1))


def test_a_dle_and_the_partners_own_wish_in_one_burst() -> None:
    """Without priority: neither our block nor our STX leaves, the partner is served."""
    line = wishing(Priority.LOW).at(ms(1)).hears(DLE + STX).says(DLE).reports(REPEATED)
    line.at(ms(2)).hears(BLOCK_B).says(DLE + STX).reports(BlockReceived(b"B"))


def test_a_nak_behind_the_dle_breaks_the_block_off_before_it_leaves() -> None:
    wishing().at(ms(1)).hears(DLE + NAK).says(STX).reports(SendRepeated(1, Failure.NAK, Stage.BLOCK))


def test_what_comes_before_our_stx_has_left_is_no_answer_but_a_dle_may_be_ahead_of_the_report() -> None:
    line = wishing(leaves=False).at(1).hears(NAK + b"x")
    line.told += line.link.damaged(Damage.PARITY, 2)
    line.says(b"").reports().at(3).hears(DLE).says(BLOCK_A)


@pytest.mark.parametrize("more, answer", [(STX, DLE), (STX + STX, DLE), (NAK, b""), (NAK + STX, DLE), (STX + NAK, b"")])
def test_in_one_burst_with_a_stx_more_of_them_are_the_same_wish_and_nak_takes_it_back(more: bytes, answer: bytes) -> None:
    """Else an even number of surplus STX would cancel in the check and stand before the data."""
    line = Line().hears(STX + more).says(answer).reports()
    if answer:
        line.at(ms(1)).hears(BLOCK_B).says(DLE).reports(BlockReceived(b"B"))


def test_a_partner_who_answers_nak_to_a_conflict_is_let_through() -> None:
    """AX-243: otherwise both repeat in step until both give up."""
    line = wishing().at(ms(1)).hears(STX).says(b"").at(ms(2)).hears(NAK).says(b"").reports(SendRepeated(1, Failure.NAK, Stage.CONNECT))
    line.at(ms(3)).hears(STX).says(DLE).at(ms(5)).hears(BLOCK_B).says(DLE + STX).reports(BlockReceived(b"B"))
    line.at(ms(6)).hears(DLE).says(BLOCK_A).hears(DLE).reports(BlockSent(1))


def test_after_a_conflict_refused_in_silence_our_stx_comes_again_after_one_character_delay() -> None:
    line = wishing().at(ms(1)).hears(STX).at(ms(2)).hears(NAK).says(b"").at(ms(222) - 1).says(b"").at(ms(222)).says(STX)
    line.reports(SendRepeated(1, Failure.NAK, Stage.CONNECT))


# ---- a job taken back
def test_a_job_taken_back_before_the_answer_is_not_sent() -> None:
    line = wishing()
    line.link.revoke()
    line.at(ms(1)).hears(DLE).says(NAK).reports(SendFailed(1, Failure.REVOKED, Stage.CONNECT))


def test_a_block_on_the_line_is_ended_and_not_repeated() -> None:
    for answer, end in ((DLE, BlockSent(1)), (NAK, SendFailed(1, Failure.NAK, Stage.BLOCK))):
        line = wishing().at(ms(1)).hears(DLE).says(BLOCK_A)
        line.link.revoke()
        line.at(ms(9)).hears(answer).says(b"" if answer == DLE else NAK).reports(end)
        assert line.link.pending == 0


def test_a_job_taken_back_while_the_partner_sends_never_begins() -> None:
    line = wishing(Priority.LOW).at(ms(1)).hears(STX).says(DLE)
    line.link.revoke()
    line.at(ms(2)).hears(BLOCK_B).says(DLE).reports(BlockReceived(b"B"), SendFailed(1, Failure.REVOKED, Stage.WAITING))
    line.link.send(b"A", ms(3))
    assert line.link.untaken
    line.says(STX)
    assert not line.link.untaken


def test_the_partner_has_the_line_from_its_stx_to_the_end_of_its_block() -> None:
    line = Line()
    assert not line.link.receiving
    line.at(ms(1)).hears(STX).says(DLE)
    assert line.link.receiving
    line.at(ms(2)).hears(BLOCK_B).says(DLE).reports(BlockReceived(b"B"))
    assert not line.link.receiving


def test_nothing_to_take_back() -> None:
    line = Line()
    line.link.revoke()
    line.link.send(b"A", 0)
    line.says(STX).at(ms(1)).hears(DLE).says(BLOCK_A).hears(DLE).reports(BlockSent(1))


# ---- a block overtaken by ours
def test_a_wish_passed_over_with_priority_is_older_than_the_job_that_overtook_it() -> None:
    line = wishing().at(ms(1)).hears(STX + STX).at(ms(2)).hears(DLE).says(BLOCK_A).at(ms(9)).hears(DLE + STX).says(DLE)
    line.at(ms(20)).hears(BLOCK_B).says(DLE).reports(BlockSent(1), BlockReceived(b"B"))
    assert line.link.overtaken_by == 1
    line.at(ms(30)).hears(STX).says(DLE).at(ms(40)).hears(BLOCK_B).says(DLE)
    assert line.link.overtaken_by == 0


def test_a_wish_heard_after_the_partner_may_have_our_block_is_not_older() -> None:
    """Our acknowledgement got lost; the partner's answer to that very block comes now."""
    line = wishing().at(ms(1)).hears(DLE).says(BLOCK_A).at(ms(560)).says(STX)
    line.at(ms(561)).hears(STX).at(ms(562)).hears(DLE).says(BLOCK_A).at(ms(580)).hears(DLE + STX).says(DLE)
    line.at(ms(590)).hears(BLOCK_B).says(DLE)
    assert line.link.overtaken_by == 0 and line.told[-1] == BlockReceived(b"B")


def test_a_wish_that_nobody_answers_names_the_same_priority() -> None:
    line = wishing().at(ms(1)).hears(STX).at(ms(550)).says(STX)
    line.reports(SamePriority(Priority.HIGH), SendRepeated(1, Failure.SILENT, Stage.CONNECT))
