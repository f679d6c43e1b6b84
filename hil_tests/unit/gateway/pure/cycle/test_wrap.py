"""A multi-turn encoder that counted round between two starts is told from an axis that was moved."""

import pytest

from gateway.pure.cycle.encoder_wrap import wrapped, wrapped_endless

TURN = 16384


@pytest.mark.parametrize(
    ("last", "now", "jump"),
    [
        (1000, 1000, 0),
        (1000, 1000 + 300 * TURN, 0),  # moved by hand
        (100, 100 + 4096 * TURN + 50, 4096 * TURN),
        (4096 * TURN - 10, 20, -4096 * TURN),
        (0, 2 * 65536 * TURN, 2 * 65536 * TURN),
        (0, 4096 * TURN + TURN, 0),  # a turn beside the range is no wrap
        (-(2**31) + 5, 2**31 - 40, 2**32),
    ],
)
def test_only_a_whole_range_is_a_wrap(last: int, now: int, jump: int) -> None:
    assert wrapped(last, now, TURN) == jump


@pytest.mark.parametrize(
    ("rounds", "moved", "jump"),
    [
        (100.0, 0.4, 0),  # where it was
        (100.0, 30.0, 0),  # turned by hand
        (100.0, 4096.0, 4096),
        (100.0, 4096.0 - 500.0 + 0.3, 4096),  # but for whole rounds
        (100.0, -4096.0, -4096),
        (128.0, 4096.0, 0),  # a range is whole rounds of the axis: it shows the same place
        (1.5, 4096.0, 4096),
        (1.5, 0.25, 0),  # half a turn would be any place here
    ],
)
def test_of_an_endless_axis_a_range_is_reported_but_for_whole_rounds(rounds: float, moved: float, jump: int) -> None:
    """rounds, moved: motor turns of a round of the axis, and since the last stop."""
    assert wrapped_endless(500, 500 + round(moved * TURN), TURN, rounds * TURN) == jump * TURN
