"""Hours of program: what a follower holds stays as large as it is, and the way back is there as far as it is kept."""

import functools
import itertools
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from hil_tests.lab.cells.motion_paths import worst_shares
from hil_tests.unit.motion.paths.test_follower import LIMITS, blocks
from motion.execution import follower as followers
from motion.execution.follower import Follower, Progress

PERIOD = 0.004
KEPT = 40  # pieces of history
PAIR = functools.cache(lambda: blocks(2))


@pytest.fixture
def short_history(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(followers, "HISTORY", KEPT)
    monkeypatch.setattr(followers, "BRAKING_S", 0.2)


def driven(follower: Follower, rounds: int, first: int = 0) -> Progress:
    """So many times there and back, loaded as they are driven; blocks are numbered on."""
    pair = PAIR()
    for number in range(first, first + rounds):
        for piece in pair:
            follower.load(replace(piece, id=piece.id + number * len(pair), block=piece.block + 2 * number))
        while not (progress := follower.step(1.0)).at_end:
            pass
    return progress


def held() -> int:
    return tracemalloc.get_traced_memory()[0]


def test_a_program_that_goes_on_for_hours_needs_no_more_memory(short_history: None) -> None:
    follower = Follower(3, PERIOD)
    driven(follower, 1)
    tracemalloc.start()
    try:
        driven(follower, 19, 1)
        early = held()
        driven(follower, 10, 20)
        assert held() - early < 0.06 * early, "rows or pieces of what was driven are kept for ever"
    finally:
        tracemalloc.stop()


def test_going_back_ends_at_rest_where_the_history_ends_and_forward_again(short_history: None) -> None:
    follower = Follower(3, PERIOD)
    last = driven(follower, 30)
    samples, seen = [last], [last.block]
    while not samples[-1].at_start:
        samples.append(follower.step(-1.0))
        seen.append(samples[-1].block)
        assert len(samples) < 5000, "goes back without an end"
    turned = samples[-1]
    assert turned.still and turned.q[0][1] == 0.0
    assert follower.step(-1.0).q == turned.q, "stays where the history ends"
    assert 60 - KEPT // 2 <= turned.block < 58 and seen == sorted(seen, reverse=True)
    while not samples[-1].at_end:
        samples.append(follower.step(1.0))
    q = np.array([[p.q[n][0] for n in range(3)] for p in samples])
    assert np.max(np.abs(q[:, 1] - 0.5 * q[:, 0])) <= 1e-9, "off the path"
    assert q[-1] == pytest.approx(q[0], abs=1e-9)
    assert worst_shares(q, LIMITS, PERIOD)[1] <= 1.02


def test_pieces_shorter_than_a_period_leave_the_rows_behind_them_in_place() -> None:
    """A change of speed over several pieces inside one period keeps the limits: rows of the track are found where they belong."""
    whole = blocks(1)[0]
    cut = [*range(0, 12, 1), len(whole.times) - 1]
    parts = [
        replace(
            whole,
            id=k + 1,
            times=tuple(t - whole.times[a] for t in whole.times[a : b + 1]),
            nodes=whole.nodes[a : b + 1],
            ends_at_rest=whole.ends_at_rest and b == cut[-1],
        )
        for k, (a, b) in enumerate(itertools.pairwise(cut))
    ]
    tail = [replace(piece, id=piece.id + 100) for piece in blocks(1)[1:]]
    one, other = Follower(3, PERIOD), Follower(3, PERIOD)
    for piece in (whole, *tail):
        one.load(piece)
    for piece in (*parts, *tail):
        other.load(piece)
    for n in range(60):
        wanted = 0.2 if n > 3 else 1.0
        a, b = one.step(wanted), other.step(wanted)
        assert a.q[0][0] == pytest.approx(b.q[0][0], abs=1e-7)


@pytest.mark.parametrize("period_s", [0.001, 0.004])
def test_what_comes_when_the_axes_rest_begins_like_the_first_of_all(period_s: float) -> None:
    """A program after another one in the same cell: it had climbed from omega 0, 50 to 60 ms more."""
    follower, runs = Follower(3, period_s), []
    for number in range(3):
        for piece in PAIR():
            follower.load(replace(piece, id=piece.id + number * len(PAIR())))
        run = [follower.step(1.0)]
        while not run[-1].at_end:
            run.append(follower.step(1.0))
        runs.append([[place for place, _ in progress.q.values()] for progress in run])
    assert len(runs[0]) == len(runs[1]) == len(runs[2])
    assert np.max(np.abs(np.array(runs) - runs[0])) <= 1e-12
