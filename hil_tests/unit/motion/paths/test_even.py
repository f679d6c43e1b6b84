"""Paths whose axes swing: the same places by a parameter that goes on while they do."""

import math
from itertools import pairwise

import numpy as np
import pytest

from hil_tests.lab.cells.arms import robot
from motion.paths.corner import hermite
from motion.paths.even import evened
from motion.paths.joints import JointPath, joined, joint_line, joint_part, joint_path
from motion.planner.law_cache import KnownLaws
from motion.planner.quick_law import swift, width_s
from motion.planner.route import Route
from motion.planner.runs import make_run, progress
from motion.planner.stretch import Stretch
from motion.program.errors import BlockError
from motion.program.factors import FULL
from motion.program.text.reader import read
from motion.timing.jerk import estimate, shares
from motion.timing.slices import whole

HEAD = """robot tx60-like
angles val3
axes deg deg deg deg deg deg
start 0 20 80 10 0 0
"""
ARM = robot("tx60-like")


def beside(miss: float, pace: str = "path=200") -> Stretch:
    """A line of 150 mm, so far (mm) beside the wrist pole."""
    q = [math.radians(v) for v in (0, 20, 80, 10, 0, 0)]
    pole = ARM.forward(q)
    x, y, z = (float(v) for v in np.array(pole.position) + np.array([-0.04, miss * 1e-3, 0.06]))
    start = " ".join(f"{math.degrees(v):.9f}" for v in ARM.inverse(pole._replace(position=(x, y, z)), q))
    program = read(f"{HEAD.replace('0 20 80 10 0 0', start)}linear rel pose 83.205 0 -124.808 0 0 0 {pace}\n")
    route = Route(ARM, program.start)
    route.add(program.blocks[0])
    route.finish()
    (stretch,) = route.take()
    return stretch


@pytest.mark.parametrize("miss", [3.0, 0.1, 1e-3])
def test_the_tool_stays_on_its_line_and_both_laws_see_the_swing(miss: float) -> None:
    stretch = beside(miss)
    path = stretch.path
    assert stretch.even
    places = np.array([ARM.forward(row).position for row in path.at(np.linspace(0.0, path.length, 500))[:, :6]])
    line = places[-1] - places[0]
    assert np.linalg.norm(np.cross(places - places[0], line / np.linalg.norm(line)), axis=1).max() < 5e-8
    run = make_run([stretch], ARM)
    quick = swift(run.path, run.limits, width_s(run.limits)).law
    assert max(shares(run.path, run.limits, quick)) <= 1.045
    law = whole(KnownLaws().law(run, FULL))
    assert max(shares(run.path, run.limits, law)) <= 1.045
    assert law.duration < 1.3 * estimate(run.path, run.limits) and law.duration < quick.duration, "slowed as a whole it was 50 times that"


def test_shares_of_the_block_are_those_of_its_way() -> None:
    stretch = beside(1e-3)
    for u in np.linspace(0.0, stretch.path.length, 20):
        way = float(stretch.path.at(np.array([u]))[0, -2])
        block, share = progress(stretch, float(u))
        assert block == 1 and share == pytest.approx(way / 0.15, abs=1e-5)


def test_what_goes_by_its_way_in_time_keeps_it() -> None:
    stretch = beside(3.0, "time=20")
    assert not stretch.even and stretch.path.length == pytest.approx(0.15, abs=1e-6)


def swing(width: float) -> JointPath:
    """One axis that turns by almost half a turn around s = 0.1, as an arc tangent does."""
    knots = sorted({0.0, 0.2, 0.1, *(0.1 + k * width * 1.3**n for n in range(80) for k in (-1, 1) if width * 1.3**n < 0.1)})
    states = []
    for s in knots:
        x, d = (s - 0.1) / width, 1.0 + ((s - 0.1) / width) ** 2
        states.append((math.atan(x), 1.0 / width / d, -2.0 * x / width**2 / d**2))
    rows = []
    for n, (a, b) in enumerate(pairwise(knots)):
        rows.append([hermite(b - a, states[n], states[n + 1]), (0.0, 1.0), (0.0,)])
    return joint_path(knots, rows)


def test_two_parts_of_a_swing_still_fit_each_other() -> None:
    path = swing(1e-4)
    for at in (0.03, 0.0995, 0.1, 0.1002):
        parts = [evened(part) or part for part in (joint_part(path, 0.0, at), joint_part(path, at, path.length))]
        both = joined(parts)  # looks at value and slope
        ends = [part.at(np.array([s]), 2)[0] for part, s in zip(parts, (parts[0].length, 0.0), strict=True)]
        assert np.abs(ends[0] - ends[1])[0] < 1e-4 * (1.0 + np.abs(ends[0][0])), "and bend"
        assert both.at(np.array([both.length]))[0, 0] == pytest.approx(math.atan(1000.0), abs=1e-9)


def test_where_nothing_swings_the_path_is_left_alone() -> None:
    assert evened(joint_line((0.0,) * 6, (1.0, 0.5, 0.2, -1.0, 0.3, 2.0))) is None


@pytest.mark.parametrize("pace", ["time=20", "time=100"])
def test_a_time_no_axis_can_keep_in_a_swing_is_refused_however_short_the_swing_is(pace: str) -> None:
    """At even places a swing of micrometres was not seen."""
    with pytest.raises(BlockError, match=r"axis J[46]: \d+ s are too short"):
        beside(1e-3, pace)


def test_a_sine_square_ramp_is_as_slow_as_the_swing_asks() -> None:
    run = make_run([beside(1e-3, "path=20 shape=sin2")], ARM)
    law = whole(KnownLaws().law(run, FULL))
    assert max(shares(run.path, run.limits, law)) <= 1.05 and law.duration < 60.0, "by its way it took 6,867 s"
