"""The guard against remainders of blocks: its five questions, case by case (AX-228, AX-240, AX-654, AX-1730)."""

import pytest

from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import DLE, ETB, ETX, NAK, STX
from protocols.p3964r.events import Outbox
from protocols.p3964r.remainders import Remainders

GAP = ms(220)


def guard() -> tuple[Remainders, Outbox]:
    box = Outbox()
    return Remainders(box, GAP), box


def opened(made: Remainders, box: Outbox, now: Ns, *, behind_strays: bool = False) -> None:
    """STX came and was answered with DLE."""
    made.opening(now, behind_strays=behind_strays)
    box.say(DLE)
    made.answered()


@pytest.mark.parametrize(
    ("torn", "quiet", "taken", "left", "byte", "answer"),
    [
        (False, GAP, False, False, 0x41, False),  # nothing happened before: every opening is believed
        (True, GAP, False, False, 0x41, True),  # behind a torn block, in one burst with the STX
        (True, GAP, True, False, 0x41, True),  # given out, but not gone: it did not wait for our DLE
        (True, GAP, True, True, 0x41, False),  # our DLE had left: a partner that waited
        (True, GAP, False, False, STX, False),  # the same wish again is no remainder
    ],
)
def test_an_opening_is_withdrawn_when_its_first_character_did_not_wait(
    torn: bool, quiet: Ns, taken: bool, left: bool, byte: int, answer: bool
) -> None:
    made, box = guard()
    made.torn, made.heard_at = torn, 0
    opened(made, box, quiet)
    if taken:
        box.take_output()
    if left:
        made.left()
    assert made.not_opened(byte) is answer


@pytest.mark.parametrize(("quiet", "doubtful"), [(GAP - 1, True), (GAP, False)])
def test_a_character_without_a_place_makes_an_opening_doubtful_for_one_gap(quiet: Ns, doubtful: bool) -> None:
    made, box = guard()
    made.disquiet(0)
    opened(made, box, quiet)
    assert made.not_opened(0x41) is doubtful


def test_a_refused_block_makes_the_next_opening_doubtful() -> None:
    made, box = guard()
    made.refused()
    opened(made, box, GAP - 1)
    assert made.not_opened(0x41)
    opened(made, box, GAP - 1)
    assert not made.not_opened(0x41), "one opening only"


def test_an_stx_in_one_breath_with_the_end_of_a_block_is_a_part_of_it() -> None:
    made, box = guard()
    made.ended()
    assert made.behind_an_end
    box.say(DLE)
    box.take_output()
    assert not made.behind_an_end


def test_what_came_in_one_burst_with_the_stx_counts_only_while_our_dle_is_not_given_out() -> None:
    made, box = guard()
    opened(made, box, 0)
    made.heard(inside=True)
    assert made.same_burst and made.unsaid and not made.outrun
    box.take_output()
    assert made.outrun and not made.same_burst and not made.unsaid
    made.begins()
    assert not made.outrun


@pytest.mark.parametrize(
    ("characters", "refused", "waits"),
    [
        (bytes((STX,)), False, True),
        (bytes((0x41, STX)), False, True),
        (bytes((DLE, ETX, STX)), False, False),  # a block check of 02h
        (bytes((DLE, ETB, STX)), False, False),
        (bytes((STX, 0x41)), False, False),
        (bytes((STX, NAK)), False, False),
        (bytes((STX,)), True, False),  # this profile answers NAK at once: the partner knows
    ],
)
def test_a_partner_waits_when_the_last_stray_character_was_stx(characters: bytes, refused: bool, waits: bool) -> None:
    made, _ = guard()
    for byte in characters:
        made.pass_over(byte, refused=refused)
    assert made.waits is waits


def test_a_damaged_character_and_a_lost_port_end_a_wish() -> None:
    for end in (Remainders.damaged, Remainders.lost):
        made, _ = guard()
        made.pass_over(STX, refused=False)
        end(made)
        assert not made.waits


@pytest.mark.parametrize(("strays", "quiet", "answer"), [(True, GAP - 1, True), (False, GAP - 1, False), (True, GAP, False)])
def test_a_second_stx_while_our_dle_leaves_is_the_same_wish_only_behind_stray_characters(strays: bool, quiet: Ns, answer: bool) -> None:
    made, box = guard()
    made.disquiet(0)
    opened(made, box, quiet, behind_strays=strays)
    assert made.wish_again(STX) and made.wish_again(NAK), "in one burst with the STX"
    box.take_output()
    assert made.wish_again(STX) is answer and not made.wish_again(NAK)
    made.left()
    assert not made.wish_again(STX)
