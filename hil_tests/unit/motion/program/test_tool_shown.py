"""The planner says which tool the block under way has: the page draws that one."""

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from gateway.pure.image.records.planner import PLANNER_BYTES, PlannerState, pack_planner, unpack_planner
from gateway.pure.planning.planner import Programs
from gateway.web.skeleton import tool_pose
from hil_tests.unit.motion.program.test_workpiece_systems import HEAD, Portal
from motion.geometry.frames import NO_ROTATION, Pose

TOOLS = "tool short 0 0 60 0 0 0\ntool long 0 0 145 0 0 90\n"
SLOW = ("ptp joints 150 100 50 0 tool=short speed=5", "ptp joints 300 100 50 0 tool=long speed=5")


@pytest.fixture
def cell() -> Portal:
    return Portal()


def shown(cell: Portal) -> Pose:
    return tool_pose(unpack_planner(pack_planner(cell.programs.state)).tool)


def test_it_is_that_of_the_block_under_way_and_stays_at_rest(cell: Portal) -> None:
    assert shown(cell) == Pose((0.0, 0.0, 0.0), NO_ROTATION), "a program that named none"
    cell.order(HEAD + TOOLS + "\n".join(SLOW))
    cell.until(lambda state: state.axes[0].set > 0.12)
    assert shown(cell).position == pytest.approx((0.0, 0.0, 0.06))
    cell.until(lambda state: state.axes[0].set > 0.17)
    assert shown(cell).position == pytest.approx((0.0, 0.0, 0.145))
    assert shown(cell).rotation != pytest.approx(NO_ROTATION), "and it is turned"
    for code in (Code.STOP, Code.ABANDON):
        cell.done(code)
    cell.until(lambda state: state.motion is Motion.IDLE)
    assert shown(cell).position == pytest.approx((0.0, 0.0, 0.145)), "it is still mounted"
    another = Programs(cell.programs.cell)
    another.follows(cell.programs.state)
    assert cell.programs.state.tool == another._tool.shown, "a planner that takes over"
    assert cell.run("ptp joints 100 100 50 0") is CommandState.DONE
    assert shown(cell).position == (0.0, 0.0, 0.0)


def test_before_the_first_program_there_is_none() -> None:
    assert unpack_planner(pack_planner(PlannerState())).tool == ()
    widest = PlannerState(tool=(-1.2345678901234567e-10,) * 12, fault="x" * 4000, warning="y" * 4000)
    assert len(pack_planner(widest)) == PLANNER_BYTES
