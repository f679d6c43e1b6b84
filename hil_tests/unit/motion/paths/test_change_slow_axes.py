"""Changes of speed where the axes are slow to accelerate: as short as the limits allow on a line, and each of them ends."""

import itertools
import math
import random

import numpy as np
import pytest

from hil_tests.bench.online_figures import loaded, random_pieces
from hil_tests.lab.cells.motion_paths import MS, portal_limits, worst_shares
from hil_tests.soak import motion as soak
from motion.execution.stepper import Sample, State, Stepper
from motion.execution.timed import TimedPiece, most_nodes

SPEED, ACCEL, JERK = 0.1, 3.0, 30.0  # of the line: m and s
SHORTEST = 2 * math.sqrt(SPEED / JERK)  # s from that speed to rest: ACCEL is never reached
HEAVY = portal_limits(2.0, ACCEL, JERK)[:2]


RISE = 0.25  # s from rest to the speed of a path, and back


def pieces_of(speed: float, length: float, radius: float = math.inf) -> list[TimedPiece]:
    """A line along x, or an arc that begins along x, as one would plan it: 5 ms from node to node."""
    total = length / speed + RISE
    times = np.linspace(0.0, total, math.ceil(total / 0.005) + 1)
    nodes = [node(t, speed, total, radius) for t in times]
    most = most_nodes(2) - 1
    found: list[TimedPiece] = []
    for first in range(0, len(times) - 1, most):
        last = min(first + most, len(times) - 1)
        part = times[first : last + 1] - times[first]
        ends = last == len(times) - 1
        accel, jerk = (ACCEL, ACCEL, math.inf), (JERK, JERK, math.inf)
        found.append(TimedPiece(len(found) + 1, 0b11, 1, tuple(part), tuple(nodes[first : last + 1]), accel, jerk, ends))
    return found


def node(t: float, speed: float, total: float, radius: float) -> tuple[float, ...]:
    """Position, speed and acceleration of x, y and the way."""
    mirrored = t > 0.5 * total
    x = min((total - t if mirrored else t) / RISE, 1.0)
    way = speed * RISE * (x**3 - 0.5 * x**4) + speed * max((total - t if mirrored else t) - RISE, 0.0)
    v, a = speed * (3 * x * x - 2 * x**3), speed / RISE * 6 * (x - x * x)
    if mirrored:
        way, a = speed * (total - RISE) - way, -a
    if radius == math.inf:
        return (way, v, a, 0.0, 0.0, 0.0, way, v, a)
    sine, cosine, turn = math.sin(way / radius), math.cos(way / radius), v * v / radius
    return (radius * sine, v * cosine, a * cosine - turn * sine, radius * (1 - cosine), v * sine, a * sine + turn * cosine, way, v, a)


def stopped(stepper: Stepper, samples: list[Sample]) -> int:
    """Periods from the order to STOPPED; some more are driven."""
    stepper.stop()
    count = 0
    while stepper.state is State.STOPPING and count < 1000:
        samples.append(stepper.step())
        count += 1
    samples += [stepper.step() for _ in range(5)]
    return count


def shares(pieces: list[TimedPiece], samples: list[Sample]) -> tuple[float, float]:
    """Worst acceleration and jerk."""
    _, accel, jerk = worst_shares(np.array([pieces[0].start(), *(s.q for s in samples)]), HEAVY)
    return accel, jerk


@pytest.mark.parametrize("override", [1.0, 0.3])
def test_a_stop_on_a_line_takes_the_time_and_the_way_that_the_limits_ask_for(override: float) -> None:
    pieces = pieces_of(SPEED, 0.1)
    stepper = loaded(pieces, 2)
    stepper.set_override(override)
    samples = [stepper.step() for _ in range(500)]
    at = samples[-1].q[0]
    count = stopped(stepper, samples)
    shortest = SHORTEST * math.sqrt(override)
    assert count * MS <= 1.04 * shortest
    assert samples[-1].q[0] - at <= 1.04 * 0.5 * SPEED * override * shortest
    assert samples[-1].q[1] == 0.0 and samples[-1].q == samples[-2].q
    accel, jerk = shares(pieces, samples)
    assert accel <= 1.02 and jerk <= 1.10


@pytest.mark.parametrize("wait", [5, 40, 90])
def test_a_stop_or_a_resume_in_the_middle_of_a_change_is_as_short(wait: int) -> None:
    pieces = pieces_of(SPEED, 0.1)
    stepper = loaded(pieces, 2)
    samples = [stepper.step() for _ in range(500)]
    stepper.set_override(0.3)
    samples += [stepper.step() for _ in range(wait)]
    assert stopped(stepper, samples) * MS <= 1.04 * SHORTEST
    stepper.resume()
    stepper.set_override(1.0)
    samples += [stepper.step() for _ in range(wait)]
    assert stopped(stepper, samples) * MS <= 1.6 * SHORTEST  # the speed that still rises has to be caught first
    stepper.resume()
    samples += [stepper.step() for _ in range(wait)]
    stepper.stop()
    samples += [stepper.step() for _ in range(wait // 2)]
    stepper.resume()
    while stepper.state is not State.IDLE and len(samples) < 5000:
        samples.append(stepper.step())
    accel, jerk = shares(pieces, samples)
    assert accel <= 1.02 and jerk <= 1.10
    assert samples[-1].q == pytest.approx((0.1, 0.0), abs=1e-12)
    assert all(b.q[0] >= a.q[0] - 1e-12 for a, b in itertools.pairwise(samples))


@pytest.mark.parametrize(("speed", "radius"), [(0.2, 0.03), (0.25, 0.04), (0.15, 0.015)])
@pytest.mark.parametrize("at", [250, 430])
def test_each_stop_on_an_arc_ends_and_keeps_the_limits(speed: float, radius: float, at: int) -> None:
    pieces = pieces_of(speed, 0.2, radius)
    stepper = loaded(pieces, 2)
    samples = [stepper.step() for _ in range(at)]
    assert stopped(stepper, samples) < 500 and stepper.state is State.STOPPED
    accel, jerk = shares(pieces, samples)
    assert accel <= 1.02 and jerk <= 1.10
    assert max(abs(math.hypot(s.q[0], s.q[1] - radius) - radius) for s in samples) <= 1e-6


SLOW = [(20.0, 200.0, 4), (20.0, 200.0, 9), (20.0, 200.0, 16), (5.0, 50.0, 2), (5.0, 50.0, 12), (5.0, 50.0, 14)]
STIFF = (20.0, 200.0, 30, 330)  # 1.1516 of the jerk limit: shortly before full speed u had the wrong sign, and was foreseen to overshoot
TURNING = [(3.0, 30.0, 54, 154), (20.0, 200.0, 25, 425), (20.0, 200.0, 20, 320), (20.0, 200.0, 58, 458)]
SLOWEST = [(3.0, 30.0, 3), (3.0, 30.0, 9), (3.0, 30.0, 7), (3.0, 30.0, 36), (3.0, 30.0, 52)]


def ordered_shares(accel: float, jerk: float, seed: int, orders: int) -> tuple[float, float, float]:
    """Worst speed, acceleration and jerk of a random chain under random orders."""
    limits = portal_limits(2.0 if accel != 5.0 else 1.0, accel, jerk)
    pieces = random_pieces(random.Random(seed), limits, 3)
    driven = soak.ordered(loaded(pieces, 3), random.Random(orders))[1:]
    return worst_shares(np.array([pieces[0].start(), *driven]), limits)


@pytest.mark.parametrize(
    ("accel", "jerk", "seed", "orders"), [*((*one, one[-1] + 100) for one in SLOW + SLOWEST), (20.0, 200.0, 29, 229), STIFF]
)
def test_random_orders_on_random_chains_keep_the_limits_and_end(accel: float, jerk: float, seed: int, orders: int) -> None:
    """They came back to full speed with more change than the last period may take, up to 13 times the jerk limit; the third one had
    driven what it foresaw beyond all bounds and ended in a number that is none.  Then 1.1 to 5.7 of the jerk limit: places 5 ms apart had
    told c of the period they begin with, and the way went along the very edge of what could be met, with nothing to spare."""
    speed, acceleration, third = ordered_shares(accel, jerk, seed, orders)
    assert speed <= 1.0 and acceleration <= 1.02 and third <= 1.10


@pytest.mark.parametrize(("accel", "jerk", "seed", "orders"), TURNING)
def test_an_axis_that_turns_back_between_two_places_is_warned_of_before(accel: float, jerk: float, seed: int, orders: int) -> None:
    """Without the track's turns they come to 1.1006, 1.1026, 1.1357 and 1.1599 of the jerk limit: from 7 to 1 ms before it turned no
    place told of it, and the last look has no c for it."""
    speed, acceleration, third = ordered_shares(accel, jerk, seed, orders)
    assert speed <= 1.0 and acceleration <= 1.02 and third <= 1.0905
