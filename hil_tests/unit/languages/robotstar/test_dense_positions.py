"""Positions that lie close together: a program that comes position by position is as fast as one the planner reads whole."""

import pytest

from gateway.pure.languages.robotstar import ahead
from hil_tests.bench.robotstar_bench import dense


@pytest.mark.parametrize("most, slower", [(200, 1.02), (30, 1.15)])
def test_dense_positions_are_as_fast_as_the_same_program_read_whole(monkeypatch: pytest.MonkeyPatch, most: int, slower: float) -> None:
    """most: positions that may be prepared; when that many are, the program waits, but the axes do not stop at each of them."""
    monkeypatch.setattr(ahead, "MOST", most)
    streamed, whole = dense(80, 200)
    assert streamed <= slower * whole
