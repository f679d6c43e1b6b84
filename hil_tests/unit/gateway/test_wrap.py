"""A multi-turn encoder that counted round between two starts is told from an axis that was moved."""

import pytest

from gateway.pure.wrap import wrapped

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
