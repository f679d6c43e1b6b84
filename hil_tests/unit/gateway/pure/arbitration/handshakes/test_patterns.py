"""AX-403: every handshake pattern starts once, says what became of it, and never starts twice on a repeated telegram."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.arbitration.handshakes import Asked, Handshaking, Pattern, State
from gateway.pure.image.reasons import CommandState

REST, ASKS = Asked(), Asked(start=True)
GOOD = {  # the request of each pattern, and how it is let go
    Pattern.START_BUSY_DONE: (ASKS, REST),
    Pattern.LEVEL_ACK: (ASKS, REST),
    Pattern.TOGGLE: (ASKS, ASKS),
    Pattern.STROBE_PARITY: (Asked(True, 7, True), Asked(False, 7, True)),
    Pattern.NUMBER_SELECT: (Asked(number=7), REST),
}


def made(pattern: Pattern) -> Handshaking:
    shake = Handshaking(pattern, (3, 7))
    assert not shake.see(REST)
    return shake


def bits(shake: Handshaking) -> str:
    return "".join(key[0] for key in ("busy", "done", "refused") if shake.bit(key))


@pytest.mark.parametrize("pattern", Pattern)
def test_a_request_starts_once_however_often_its_telegram_is_repeated(pattern: Pattern) -> None:
    asks, lets_go = GOOD[pattern]
    shake = made(pattern)
    assert [shake.see(asks) for _ in range(20)] == [True] + [False] * 19
    shake.hear(CommandState.ACCEPTED)
    assert not any(shake.see(asks) for _ in range(5))
    shake.hear(CommandState.DONE)
    assert not any(shake.see(asks) for _ in range(5)), "also after it is done"
    assert not shake.see(lets_go)
    again = Asked() if pattern is Pattern.TOGGLE else asks
    assert shake.see(again), "a fresh request starts again"


@pytest.mark.parametrize("pattern", Pattern)
def test_what_is_set_at_the_start_or_after_a_lost_link_starts_nothing(pattern: Pattern) -> None:
    asks, _ = GOOD[pattern]
    shake = Handshaking(pattern, (3, 7))
    assert not shake.see(asks) and not shake.see(asks)
    shake.restart()
    assert not shake.see(asks)
    shake = made(pattern)
    assert shake.see(asks)
    shake.restart()
    assert not shake.see(asks) and not shake.bit("busy")


@pytest.mark.parametrize(
    ("pattern", "shown"),
    [
        (Pattern.START_BUSY_DONE, ["b", "b", "d", ""]),
        (Pattern.LEVEL_ACK, ["b", "d", "d", ""]),
        (Pattern.TOGGLE, ["b", "b", "d", "d"]),
        (Pattern.STROBE_PARITY, ["b", "d", "d", ""]),
        (Pattern.NUMBER_SELECT, ["b", "b", "d", ""]),
    ],
)
def test_what_the_answering_bits_show_of_a_move_that_ends_well(pattern: Pattern, shown: list[str]) -> None:
    asks, lets_go = GOOD[pattern]
    shake = made(pattern)
    steps: list[Callable[[], object]] = [
        lambda: shake.see(asks), lambda: shake.hear(CommandState.ACCEPTED),
        lambda: shake.hear(CommandState.DONE), lambda: shake.see(lets_go),
    ]  # fmt: skip
    told = []
    for step in steps:
        step()
        told.append(bits(shake))
    assert told == shown


@pytest.mark.parametrize("pattern", Pattern)
@pytest.mark.parametrize("end", [CommandState.REFUSED, CommandState.ABORTED])
def test_a_refused_move_is_shown_until_the_request_is_let_go(pattern: Pattern, end: CommandState) -> None:
    asks, lets_go = GOOD[pattern]
    shake = made(pattern)
    shake.see(asks)
    shake.hear(end)
    assert bits(shake) == ("dr" if pattern is Pattern.TOGGLE else "r"), "the toggle is answered all the same"
    shake.see(lets_go)
    assert pattern is Pattern.TOGGLE or bits(shake) == ""


def test_a_toggle_that_flips_during_a_move_is_no_second_request_and_the_answer_waits_for_the_move() -> None:
    shake = made(Pattern.TOGGLE)
    assert shake.see(ASKS) and not shake.see(REST) and not shake.see(ASKS)
    assert bits(shake) == "b"
    shake.hear(CommandState.DONE)
    assert bits(shake) == "d" and shake.see(REST)


def test_a_strobe_with_a_wrong_parity_is_refused_and_starts_nothing() -> None:
    for odd in (False, True):
        shake = Handshaking(Pattern.STROBE_PARITY, (3, 7), odd=odd)
        shake.see(REST)
        assert not shake.see(Asked(True, 7, odd)) and bits(shake) == "r"
        assert not shake.see(Asked(True, 7, not odd)), "parity set right under the standing strobe: too late"
        assert not shake.see(Asked(False, 7, not odd)) and bits(shake) == ""
        assert shake.see(Asked(True, 7, not odd))


def test_without_positions_a_strobe_takes_any_code() -> None:
    shake = Handshaking(Pattern.STROBE_PARITY)
    shake.see(REST)
    assert shake.see(Asked(True, 5, False))


def test_numbers_are_selected_one_by_one_with_zero_between_them() -> None:
    shake = made(Pattern.NUMBER_SELECT)
    assert not shake.see(Asked(number=99)) and bits(shake) == "r", "no such position"
    assert not shake.see(Asked(number=7)) and bits(shake) == "r", "zero first"
    shake.see(REST)
    assert shake.see(Asked(number=7)) and not shake.see(Asked(number=3))
    shake.hear(CommandState.DONE)
    assert bits(shake) == "d" and not shake.see(Asked(number=7)) and bits(shake) == "r"
    shake.see(REST)
    assert shake.see(Asked(number=3))


@given(st.sampled_from(Pattern), st.lists(st.tuples(st.booleans(), st.sampled_from((0, 3, 7, 9)), st.booleans()), max_size=30))
def test_doubling_every_telegram_changes_nothing(pattern: Pattern, telegrams: list[tuple[bool, int, bool]]) -> None:
    once, twice = Handshaking(pattern, (3, 7)), Handshaking(pattern, (3, 7))
    for n, telegram in enumerate(telegrams):
        asked = Asked(*telegram)
        first = once.see(asked)
        assert [twice.see(asked), twice.see(asked)] == [first, False]
        if n % 3 == 2:
            for shake in (once, twice):
                shake.hear(CommandState.DONE)
        assert once.state is twice.state and (once.state is not State.IDLE or not once.bit("busy"))
