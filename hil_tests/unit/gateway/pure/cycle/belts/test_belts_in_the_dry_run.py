"""Synchronous parts looked at and run on paper: what `axisgate motion check` and `plot` say of a program with belts."""

import numpy as np
import pytest

from gateway.tools.motion.dry_run import DryRun, sections_of
from hil_tests.lab.running.belt_run import INCREMENT
from hil_tests.lab.virtual.belt_bench import FACTS, HEAD, MACHINE
from motion.planner.trace import Trace
from motion.program.errors import BlockError
from motion.program.text.reader import read

SPEED = 0.1  # m/s of every belt
CARRIED = """linear pose 100 120 50 0 0 0
synchron B1 at=60mm
linear pose 150 150 50 0 0 0 belt=60mm
linear pose 150 150 90 0 0 0 belt=60mm path=60
synchron_end
linear pose 100 100 50 0 0 0
"""
FOLLOWED = """synchron B2 at=50mm
linear pose 200 150 50 0 0 0 belt=150mm
synchron_end
synchron B3 at=50mm
linear pose 100 100 50 0 0 0 belt=200mm camin=30mm camout=70mm
synchron_end
linear pose 100 120 50 0 0 0
"""


def run(text: str, speed: float = SPEED) -> Trace:
    sections, faults = sections_of(read(HEAD + text), MACHINE, FACTS)
    assert not faults
    return DryRun(MACHINE, FACTS, (speed,) * 3, 4).run(sections)


def test_a_carried_robot_goes_with_its_belt_and_the_program_goes_on_beside_it() -> None:
    made = run(CARRIED)
    way = made.belts[0]
    assert (way.name, way.unit) == ("B1", "mm")
    first = int(np.argmin(np.abs(made.t - way.t[0])))
    on = made.tool[first : first + len(way.t)]
    lifted = (on[:, 2] > 0.055) & (on[:, 2] < 0.085)
    assert np.count_nonzero(lifted) > 300
    ahead = 2 * SPEED * made.period + 0.5 * INCREMENT  # for the SYNC that activates it; in the middle of a count (AX-144)
    assert np.max(np.abs(on[lifted, 0] - way.value[lifted] - 0.09 - ahead)) < 2e-5, "x 150 mm is meant for the belt at 60 mm"
    assert np.max(np.abs(on[lifted, 1] - 0.15)) < 1e-6
    assert made.q[-1][:3] == pytest.approx((0.1, 0.1, 0.05), abs=1e-6)
    assert [block for block, _ in made.ends] == [1, 3, 4] and set(made.block) == {1, 2, 3, 4}
    assert np.max(np.linalg.norm(np.diff(made.q, axis=0), axis=1)) < 1.0 * made.period, "it never jumps from one part to the next"


ROUND = CARRIED.replace(" path=60", "").replace("belt=60mm", "belt=60mm radius=30", 1).replace("150 150 90", "220 80 70")


@pytest.mark.parametrize(("text", "speed"), [(CARRIED, 0.1), (ROUND, 0.02), (ROUND, 0.15)])
def test_catching_up_and_path_together_stay_within_the_limits_of_every_axis(text: str, speed: float) -> None:
    made = run(text, speed)
    way, h = made.belts[0], made.period
    first = int(np.argmin(np.abs(made.t - way.t[0])))
    on = made.q[first : first + len(way.t)]
    for order, most, limits in (
        (1, 1.0, [axis.speed for axis in MACHINE.limits]),
        (2, 1.02, [axis.accel for axis in MACHINE.limits]),
        (3, 1.10, [axis.jerk for axis in MACHINE.limits]),
    ):
        loads = np.abs(np.diff(on, order, axis=0)) / h**order / np.array(limits)
        assert loads.max() <= most, (order, loads.max(axis=0))
    begins = on[np.argmax(np.abs(on[:, 1] - 0.12) > 1e-6), 0] - 0.1
    assert begins < 0.01, "the path does not wait until the robot is on its belt"


def test_a_long_way_on_a_belt_is_run_whole() -> None:
    """Some seconds of way between two SYNC, more than a running cell is ever given ahead (AX-606)."""
    heights = (90, 50, 90, 50, 90)
    way = "\n".join(f"linear pose 150 150 {z} 0 0 0 belt=60mm path=20 blend=off" for z in (50, *heights))
    made = run(f"synchron B1 at=60mm\n{way}\nsynchron_end\nlinear pose 100 100 50 0 0 0\n", 0.02)
    assert made.belts[0].t[-1] - made.belts[0].t[0] > 2.0 * len(heights)
    assert np.count_nonzero(np.abs(np.diff(np.sign(made.tool[:, 2] - 0.07))) > 0) == len(heights) + 1


def test_type_2_arrives_with_its_belt_and_the_cam_is_a_parabola_a_line_and_a_parabola() -> None:
    made = run(FOLLOWED)
    paced, cam = made.belts
    x = made.tool[:, 0]
    there = np.searchsorted(made.t, paced.t[int(np.argmax(paced.value >= 0.15 - 1e-9))])
    assert x[there] == pytest.approx(0.2, abs=5e-4)
    first = int(np.argmin(np.abs(made.t - cam.t[0])))
    for counter, share in ((0.080, 0.15), (0.105, 0.40), (0.130, 0.65)):  # A 30, D 70 of 150 mm: 15 of 100 mm in section 1
        row = first + int(np.argmin(np.abs(cam.value - counter)))
        assert x[row] == pytest.approx(0.2 - 0.1 * share, abs=2e-4)
    assert made.q[-1][:2] == pytest.approx((0.1, 0.12), abs=1e-6)


def test_what_the_belts_forbid_is_reported_of_every_block_before_anything_runs() -> None:
    text = """synchron B2 at=50mm
ptp pose 200 150 50 0 0 0 belt=150mm
linear pose 200 150 50 0 0 0 belt=50mm
synchron_end
synchron B9 at=50mm
linear pose 100 100 50 0 0 0 belt=200mm
synchron_end
linear pose 100 9120 50 0 0 0
"""
    _, faults = sections_of(read(HEAD + text), MACHINE, FACTS)
    assert [(fault.block, fault.code, fault.axis) for fault in faults] == [(1, 23, ""), (2, 89, ""), (3, 93, ""), (4, 531, "Y")]


def test_a_belt_too_fast_for_an_axis_and_one_that_runs_the_wrong_way_end_the_page_with_block_and_number() -> None:
    with pytest.raises(BlockError) as fast:
        run(CARRIED, 1.5)
    assert fast.value.code in (65001, 65003) and fast.value.axis == "X" and fast.value.block == 2
    with pytest.raises(BlockError) as back:
        run(FOLLOWED, -SPEED)
    assert (back.value.code, back.value.block) == (928, 1)
