"""Chains of timed pieces: override, stop, resume, retrace, new tails (motion.md goals 3, 4, 9, 10; design 6)."""

import functools
import itertools
import random
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from hil_tests.lab.cells.motion_paths import point, portal_limits, portal_path, u_portal, worst_shares
from hil_tests.unit.motion.paths.test_joint_paths import passing
from motion.errors import MotionError, PieceError
from motion.execution.follower import Follower, joined
from motion.execution.pieces import RECORD_SIZE
from motion.execution.ptp import plan_ptp
from motion.execution.stepper import Sample, State, Stepper
from motion.execution.timed import TimedPiece, decode_any, encode_timed, most_nodes
from motion.paths.joints import joined as joined_paths
from motion.paths.line import line
from motion.planner.commit import timed_pieces
from motion.timing.choice import assembled
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits

LIMITS = portal_limits()
MS = 1e-3


@functools.cache
def u_pieces() -> tuple[TimedPiece, ...]:
    """The U of the portal, R 12.5 mm: one path over two corners, blocks 1, 2, 3."""
    path, limits = assembled(*u_portal(0.0124999)), law_limits(LIMITS)
    return tuple(timed_pieces(path, limits, jerk_limited(path, limits), blocks=[(0.025, 1), (0.325, 2), (path.length, 3)]))


def loaded(pieces: tuple[TimedPiece, ...] = (), period_s: float = MS) -> Stepper:
    pieces = pieces or u_pieces()
    stepper = Stepper(3, period_s, pieces[0].start())
    for piece in pieces:
        stepper.load(decode_any(encode_timed(piece)))
    return stepper


def steps(stepper: Stepper, count: int) -> list[Sample]:
    return [stepper.step() for _ in range(count)]


def run_out(stepper: Stepper, most: int = 4000) -> list[Sample]:
    samples = [stepper.step()]
    while samples[-1].state is not State.IDLE:
        assert len(samples) < most, samples[-1]
        samples.append(stepper.step())
    return samples


@functools.cache
def curve() -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """The path, densely."""
    return np.array([s.q for s in run_out(loaded(period_s=2e-5), 100_000)])


def off_path(samples: list[Sample]) -> float:
    worst = 0.0
    for sample in samples:
        q = np.array(sample.q)
        k = int(np.argmin(np.sum((curve() - q) ** 2, axis=1)))
        best = 1.0
        for a, b in itertools.pairwise(curve()[max(k - 1, 0) : k + 2]):
            length = float((b - a) @ (b - a))
            u = min(max(float((q - a) @ (b - a)) / length, 0.0), 1.0) if length > 0 else 0.0
            best = min(best, float(np.linalg.norm(q - a - u * (b - a))))
        worst = max(worst, best)
    return worst


def assert_kept(samples: list[Sample], jerk_top: float = 1.10) -> None:
    speed, accel, jerk = worst_shares(np.array([u_pieces()[0].start(), *(s.q for s in samples)]), LIMITS)
    assert speed <= 1.0
    assert accel <= 1.02
    assert jerk <= jerk_top


def test_several_pieces_are_one_path_driven_without_a_stop_inside_all_limits() -> None:
    samples = run_out(loaded())
    assert len(u_pieces()) > 5
    assert_kept(samples, 1.05)
    assert samples[-1].q == pytest.approx((0.3, 0.0, 0.0), abs=1e-9)
    speeds = [max(abs(v) for v in s.qd) for s in samples[5:-6]]
    assert min(speeds) > 0.01
    assert samples[-1].done_id == u_pieces()[-1].id
    assert [s.piece_id for s in samples] == sorted(s.piece_id for s in samples)


def test_speeds_are_the_slopes_of_the_positions() -> None:
    samples = run_out(loaded())
    for before, now, after in zip(samples, samples[1:], samples[2:], strict=False):
        for n in range(3):
            assert now.qd[n] == pytest.approx((after.q[n] - before.q[n]) / (2 * MS), abs=2e-3)


@pytest.mark.parametrize("at", range(7, 380, 34))
def test_override_100_30_100_keeps_path_and_limits(at: int) -> None:
    stepper = loaded()
    samples = steps(stepper, at)
    stepper.set_override(0.3)
    samples += steps(stepper, 300)
    stepper.set_override(1.0)
    samples += run_out(stepper)
    assert_kept(samples)
    assert off_path(samples[::7]) <= 1e-6
    assert samples[-1].q == pytest.approx((0.3, 0.0, 0.0), abs=1e-9)


def test_30_percent_are_reached_and_held() -> None:
    full, slow = run_out(loaded()), loaded()
    steps(slow, 20)
    slow.set_override(0.3)
    steps(slow, 150)
    held = steps(slow, 100)
    ways = np.array([s.s for s in full])
    speeds = np.gradient(ways)
    for before, after in itertools.pairwise(held):
        nominal = float(np.interp(0.5 * (before.s + after.s), ways, speeds))
        assert (after.s - before.s) == pytest.approx(0.3 * nominal, rel=0.02)


@pytest.mark.parametrize("at", [1, 30, 61, 110, 205, 290, 340, 380])
def test_stop_on_the_path_and_resume_lose_nothing(at: int) -> None:
    stepper = loaded()
    samples = steps(stepper, at)
    stepper.stop()
    samples += steps(stepper, 320)
    assert stepper.state in (State.STOPPED, State.IDLE)
    assert samples[-1].q == samples[-2].q
    stepper.resume()
    samples += run_out(stepper)
    assert_kept(samples, 1.15)
    assert off_path(samples[::7]) <= 1e-6
    assert samples[-1].q == pytest.approx((0.3, 0.0, 0.0), abs=1e-9)


def test_override_0_holds_and_goes_on() -> None:
    stepper = loaded()
    steps(stepper, 100)
    stepper.set_override(0.0)
    held = steps(stepper, 300)
    assert held[-1].state is State.RUNNING and held[-1].q == held[-2].q and held[-1].qd == (0.0, 0.0, 0.0)
    stepper.set_override(1.0)
    assert run_out(stepper)[-1].q == pytest.approx((0.3, 0.0, 0.0), abs=1e-9)


def test_retrace_goes_back_on_the_same_path_to_the_start_and_resume_forward_again() -> None:
    stepper = loaded()
    samples = steps(stepper, 200)
    stepper.stop()
    samples += steps(stepper, 300)
    stepper.retrace()
    back = steps(stepper, 20)
    assert back[-1].s < samples[-1].s
    while stepper.state is State.RUNNING:
        back.append(stepper.step())
    assert back[-1].q == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert [s.s for s in back] == sorted((s.s for s in back), reverse=True)
    samples += back
    stepper.resume()
    samples += run_out(stepper)
    assert_kept(samples, 1.15)
    assert off_path(samples[::9]) <= 1e-6
    assert samples[-1].q == pytest.approx((0.3, 0.0, 0.0), abs=1e-9)


def blocks(count: int) -> list[TimedPiece]:
    """A chain of short lines there and back, each to rest."""
    limits = law_limits(LIMITS)
    there, back = (portal_path(line(a, b)) for a, b in ((point(0, 0, 0), point(0.004, 0.002, 0)), (point(0.004, 0.002, 0), point(0, 0, 0))))
    laws = [jerk_limited(path, limits) for path in (there, back)]
    pieces: list[TimedPiece] = []
    for number in range(count):
        path, law = ((there, laws[0]), (back, laws[1]))[number % 2]
        pieces += timed_pieces(path, limits, law, first_id=len(pieces) + 1, blocks=[(1.0, number + 1)])
    return pieces


def test_220_blocks_can_be_retraced() -> None:
    pieces = blocks(220)
    follower = Follower(3, 0.01)
    for piece in pieces:
        follower.load(piece)
    seen = []
    while not (progress := follower.step(1.0)).at_end:
        seen.append(progress.block)
    assert list(dict.fromkeys(seen)) == list(range(1, 221))
    back = []
    while not (progress := follower.step(-1.0)).at_start:
        back.append(progress.block)
        x, y = progress.q[0][0], progress.q[1][0]
        assert y == pytest.approx(0.5 * x, abs=1e-9)
    assert list(dict.fromkeys(back)) == list(range(220, 0, -1))
    assert progress.q[0][0] == pytest.approx(0.0, abs=1e-9)


def test_a_tail_counts_only_when_it_is_whole_and_ends_at_rest_before_that() -> None:
    pieces = list(u_pieces())
    stepper = Stepper(3, MS, pieces[0].start())
    for piece in pieces[:-1]:
        stepper.load(piece)
    assert {s.q for s in steps(stepper, 20)} == {(0.0, 0.0, 0.0)}, "moves into a tail without an end"
    stepper.load(pieces[-1])
    assert run_out(stepper)[-1].q == pytest.approx((0.3, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("written", range(0, 40, 5))
def test_whatever_part_of_a_new_tail_was_written_the_axes_end_at_rest_on_a_committed_path(written: int) -> None:
    """A planner that dies between two writes of the ring (design 6)."""
    first = blocks(1)
    legs = blocks(9)
    stepper = Stepper(3, MS, first[0].start())
    for piece in first:
        stepper.load(piece)
    samples = steps(stepper, 5)
    tail = [replace(legs[len(first)], new_tail=True), *legs[len(first) + 1 :]]
    for piece in tail[:written]:
        stepper.load(piece)
    samples += run_out(stepper)
    ends = {(0.0, 0.0, 0.0), (0.004, 0.002, 0.0)}
    assert any(samples[-1].q == pytest.approx(end, abs=1e-9) for end in ends)
    assert worst_shares(np.array([(0.0, 0.0, 0.0), *(s.q for s in samples)]), LIMITS)[1] <= 1.02


def test_a_new_tail_replaces_a_path_at_whose_beginning_the_axes_are_held() -> None:
    limits, ways = law_limits(LIMITS), []
    for end in (point(0.1, 0.0, 0.0), point(0.0, 0.1, 0.0)):
        path = portal_path(line(point(0.0, 0.0, 0.0), end))
        ways.append(timed_pieces(path, limits, jerk_limited(path, limits)))
    stepper = loaded(tuple(ways[0]), period_s=1e-4)
    stepper.set_override(0.0)
    assert steps(stepper, 3)[-1].q == (0.0, 0.0, 0.0)
    for n, piece in enumerate(ways[1]):
        stepper.load(replace(piece, new_tail=n == 0))
    stepper.set_override(1.0)
    samples = run_out(stepper, 20_000)
    assert max(abs(s.q[0]) for s in samples) < 1e-12, "not one period goes along the path that was replaced"
    assert samples[-1].q[1] == pytest.approx(0.1)


def test_a_new_tail_replaces_what_has_not_begun_and_comes_too_late_for_what_has() -> None:
    pieces = blocks(3)
    second = next(k for k, piece in enumerate(pieces) if piece.block == 2)
    other = [replace(piece, block=77) for piece in pieces[second:]]
    other[0] = replace(other[0], new_tail=True)
    follower = Follower(3, MS)
    for piece in pieces:
        follower.load(piece)
    for _ in range(5):
        follower.step(1.0)
    for piece in other:
        follower.load(piece)
    numbers = set()
    while not (progress := follower.step(1.0)).at_end:
        numbers.add(progress.block)
    assert numbers == {1, 77}
    whole = next(k for k, piece in enumerate(other) if piece.ends_at_rest)
    for piece in other[:whole]:
        follower.load(piece)
    with pytest.raises(PieceError, match="too late"):
        follower.load(other[whole])


def test_pieces_that_do_not_go_on_are_refused() -> None:
    pieces = u_pieces()
    assert joined(pieces)
    assert not joined([pieces[0], pieces[2]])
    follower = Follower(3, MS)
    follower.load(pieces[0])
    with pytest.raises(PieceError, match="continues at"):
        follower.load(pieces[2])
    with pytest.raises(PieceError, match="ids must rise"):
        follower.load(pieces[0])
    stepper = Stepper(3, MS, (1.0, 0.0, 0.0))
    with pytest.raises(PieceError, match="will be at"):
        stepper.load(pieces[0])
    with pytest.raises(PieceError, match="does not exist"):
        Stepper(2, MS).load(pieces[0])
    with pytest.raises(MotionError, match="no path to retrace"):
        Stepper(3, MS).retrace()


def test_both_kinds_of_pieces_follow_one_another_at_rest() -> None:
    stepper = loaded()
    steps(stepper, 3)
    back = plan_ptp([0.3, 0.0, 0.0], [0.0, 0.0, 0.0], LIMITS, piece_id=900)
    with pytest.raises(PieceError, match="at rest"):
        stepper.load(back)
    run_out(stepper)
    stepper.load(back)
    with pytest.raises(PieceError, match="at rest"):
        stepper.load(u_pieces()[0])
    assert run_out(stepper)[-1].q == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    for piece in u_pieces():
        stepper.load(piece)
    assert run_out(stepper)[-1].q == pytest.approx((0.3, 0.0, 0.0), abs=1e-9)


def test_abandon_stops_on_the_path_and_drops_the_rest() -> None:
    stepper = loaded()
    samples = steps(stepper, 150)
    stepper.abandon()
    samples += run_out(stepper)
    assert samples[-1].state is State.IDLE and stepper.queued == 0
    assert 0.0 < samples[-1].q[0] < 0.3
    assert off_path(samples[-1:]) <= 1e-6
    with pytest.raises(MotionError):
        stepper.retrace()


def test_random_orders_never_leave_the_path() -> None:
    dice = random.Random(3)
    for _ in range(6):
        stepper, samples = loaded(), []
        for _ in range(12):
            match dice.randint(1, 4):
                case 1:
                    stepper.stop()
                case 2:
                    stepper.resume()
                case 3 if stepper.state is State.STOPPED:
                    stepper.retrace()
                case _:
                    stepper.set_override(dice.choice((0.0, 0.05, 0.3, dice.random(), 1.0)))
            samples += steps(stepper, dice.randint(1, 60))
        assert off_path(samples[::9]) <= 1e-6
        speed, accel, _ = worst_shares(np.array([(0.0, 0.0, 0.0), *(s.q for s in samples)])[:-1], LIMITS)
        assert speed <= 1.0
        stepper.set_override(1.0)
        stepper.resume()
        if stepper.state is not State.IDLE:
            samples += run_out(stepper)
        accel = worst_shares(np.array([(0.0, 0.0, 0.0), *(s.q for s in samples)]), LIMITS)[1]
        assert accel <= 1.05


def test_passed_ptp_points_are_driven_through_the_same_way() -> None:
    path, limits = joined_paths(passing(1.0)), law_limits(LIMITS)
    pieces = tuple(timed_pieces(path, limits, jerk_limited(path, limits)))
    samples = run_out(loaded(pieces))
    assert samples[-1].q == pytest.approx((0.5, -0.3, 0.2), abs=1e-9)
    assert min(max(abs(v) for v in s.qd) for s in samples[5:-6]) > 0.01


def test_a_record_round_trips_and_damage_is_refused() -> None:
    for piece in (*u_pieces(), replace(u_pieces()[0], new_tail=True)):
        record = encode_timed(piece)
        assert len(record) == RECORD_SIZE
        assert decode_any(record) == piece
    whole = encode_timed(u_pieces()[0])
    for place in (0, 5, 9, 13, 15, 40, 400, RECORD_SIZE - 1):
        spoiled = bytearray(whole)
        spoiled[place] ^= 0x41
        with pytest.raises(PieceError):
            decode_any(bytes(spoiled))
    with pytest.raises(PieceError):
        decode_any(whole[:-1])
    assert [most_nodes(axes) for axes in (1, 3, 6, 12, 13, 32)] == [46, 24, 14, 7, 7, 7]


def test_pieces_that_contradict_themselves_are_refused() -> None:
    good = u_pieces()[0]
    inf = float("inf")
    bad: tuple[Callable[[], TimedPiece], ...] = (
        lambda: replace(good, id=0),
        lambda: replace(good, mask=0),
        lambda: replace(good, times=good.times[:-1]),
        lambda: replace(good, times=(0.0, *good.times[2:], good.times[1])),
        lambda: replace(good, nodes=((inf, *good.nodes[0][1:]), *good.nodes[1:])),
        lambda: replace(good, accel=(0.0, *good.accel[1:])),
        lambda: replace(good, jerk=good.jerk[:-1]),
        lambda: replace(good, ends_at_rest=True),
    )
    for change in bad:
        with pytest.raises(PieceError):
            change()
    path, limits = joined_paths(passing(1.0)), law_limits(LIMITS)
    law = jerk_limited(path, limits)
    with pytest.raises(MotionError, match="does not name"):
        timed_pieces(path, limits, law, mask=0b11)
