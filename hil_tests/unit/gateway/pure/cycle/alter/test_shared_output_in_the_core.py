"""rho 3 Releases part 1, section 17 in a cell: two axes of a portal on one set-point output, in virtual time."""

import pathlib
import re

import pytest

from gateway.assembly.axes import core_axes
from gateway.assembly.limits import limits_of
from gateway.assembly.shared_outputs import shared_of_cell
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cell.faults import CellFaults
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.cycle.core_settings import CoreParts
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import CellState, Motion, get_bit, pack_cell_state, unpack_cell_state
from hil_tests.lab.virtual.alter_bench import HEAD, P5_MS, PORTAL, with_alter
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot

OUTPUT, SELECT, CORRECTION_S = 528, 544, 0.04
TABLE = f'[[shared_output]]\nname = "FU1"\naxes = ["X", "Y"]\noutput = {OUTPUT}\nselect = {SELECT}\ncorrection_ms = 40\n\n'


class Shared(Planned):
    """What the converter is told, cycle by cycle: set point -1..1, and which axis has it."""

    def __init__(self, table: str = TABLE) -> None:
        cell = load_cell(str(PORTAL), with_alter(PORTAL.read_text(), table))
        self.seen: list[tuple[CellState, float, tuple[bool, ...]]] = []

        class Robot(ServodynRobot):
            def cycle(self, count: int = 1) -> None:
                super().cycle(count)

            def _new_core(self) -> CycleLogic:
                shared = shared_of_cell(self.cell, self.p5_ms)
                return CycleLogic(core_axes(self.cell, self.p5_ms), self.period_ns / 1e9, self.generation, parts=CoreParts(shared=shared))

        super().__init__(Robot(P5_MS, cell=cell))
        self.home()

    def home(self) -> "Shared":
        """Drives on, the axes where programs begin, one after the other."""
        assert self.bench.settle(self.bench.give(Code.ENABLE, 0xF)).state is CommandState.DONE
        y, z = self.bench.set()[1:3]
        for there in (f"100 {y} {z} 0", f"100 100 {z} 0", "100 100 50 0"):
            if max(abs(a - float(b)) for a, b in zip(self.bench.set(), there.split(), strict=True)) > 1e-6:
                assert self.ordered(f"ptp joints {there}").state is CommandState.DONE
        return self

    def _turn(self) -> None:
        super()._turn()
        outputs = self.bench.core.outputs
        value = int.from_bytes(outputs[OUTPUT >> 3 : (OUTPUT >> 3) + 2], "big", signed=True) / 0x7FFF
        state = unpack_cell_state(pack_cell_state(self.state))
        self.seen.append((state, value, tuple(get_bit(outputs, SELECT + n) for n in range(2))))

    def ordered(self, *lines: str) -> Job:
        self.seen.clear()
        job = self.bench.settle(self.order(HEAD + "\n".join(lines)))
        self.until(lambda s: s.motion is Motion.IDLE)
        self.bench.run(0.1)
        return job


@pytest.fixture(scope="module")
def robot() -> Shared:
    return Shared()


@pytest.fixture
def shared(robot: Shared) -> Shared:
    return robot.home()


@pytest.mark.requirement("RHO-MOT-48", by="gateway.pure.cycle.shared_output:CoreShared.step")
def test_one_output_follows_one_axis_after_the_other(shared: Shared) -> None:
    tops = [limits_of(axis).speed for axis in shared.cell.axis[:2]]
    assert shared.ordered("ptp joints 200 100 50 0 speed=50", "ptp joints 200 200 50 0 speed=50").state is CommandState.DONE
    for axis, top in enumerate(tops):
        moving = [(s, value, has) for s, value, has in shared.seen if abs(s.axes[axis].speed) > 0.2 * top]
        assert len(moving) > 5
        for state, value, has in moving:
            assert has == tuple(n == axis for n in range(2)), "the axis that moves has the set point"
            assert value == pytest.approx(state.axes[axis].speed / top, abs=0.15), "its speed, and what it is behind"
    assert all(sum(has) <= 1 for _, _, has in shared.seen)
    assert shared.seen[-1][1:] == (0.0, (False, False)), "idle: 0 V"


def test_the_position_loop_stays_closed_for_the_correction_time(shared: Shared) -> None:
    shared.ordered("ptp joints 200 100 50 0 speed=20")
    window = shared.bench.core.plans[0].window
    there = [s.axes[0].speed == 0.0 and abs(s.axes[0].set - s.axes[0].actual) <= window for s, _, _ in shared.seen]
    arrived = max(n for n, inside in enumerate(there) if not inside) + 1
    released = max(n for n, (_, _, has) in enumerate(shared.seen) if has[0]) + 1
    assert (released - arrived) * P5_MS / 1e3 == pytest.approx(CORRECTION_S, abs=P5_MS / 1e3 + 1e-6)


@pytest.mark.requirement("RHO-MOT-48", by="gateway.pure.cycle.core:CycleLogic._share")
@pytest.mark.parametrize("program", [True, False])
def test_two_axes_at_a_time_are_a_servo_error_and_the_set_point_is_0(shared: Shared, program: bool) -> None:
    if program:
        job = shared.ordered("ptp joints 300 250 50 0 speed=20")
    else:
        shared.seen.clear()
        job = shared.bench.settle(shared.bench.give(Code.PTP_ABSOLUTE, 0b11, 0.2, (300.0, 250.0)))
        shared.bench.run(0.3)
    assert (job.state, job.reason, job.detail) == (CommandState.ABORTED, Reason.SERVO_ERROR, "Y")
    assert all(value == 0.0 for _, value, _ in shared.seen) and shared.seen[-1][2] == (False, False)
    assert not any(axis.drive.follows for axis in shared.bench.core._axes), "the drives are off"
    assert shared.bench.set()[0] < 110.0, "as soon as it is seen"


def test_other_axes_move_beside_the_output(shared: Shared) -> None:
    assert shared.ordered("ptp joints 300 100 80 20 speed=20").state is CommandState.DONE
    assert max(value for _, value, _ in shared.seen) > 0.1


def test_the_last_axis_keeps_its_output_outside_of_programs() -> None:
    shared = Shared(TABLE.replace("correction_ms = 40", "keep_last = true"))
    for axis, target in ((0b01, (150.0, 0.0)), (0b10, (0.0, 150.0))):
        assert shared.bench.settle(shared.bench.give(Code.PTP_ABSOLUTE, axis, 0.2, target)).state is CommandState.DONE
        shared.bench.run(0.5)
        assert shared.seen[-1][2] == (axis == 0b01, axis == 0b10)


FAULTS = {
    'axes = ["X", "W"]': "no such axis",
    'axes = ["X", "X"]': "is on set-point output FU1 already; an axis has only one",
    "output = 529": "the set point is a whole word of the image",
    "output = 64": "axisgate itself, or another table, writes one of these outputs",
    "select = 530": "writes one of these 2 outputs",
}


@pytest.mark.parametrize("line", FAULTS)
def test_who_may_not_share_is_reported(line: str) -> None:
    key = line.partition(" ")[0]
    table = re.sub(rf"^{key} = .*$", line, TABLE, flags=re.M)
    with pytest.raises(CellFaults, match=re.escape(FAULTS[line])):
        load_cell(str(PORTAL), with_alter(pathlib.Path(PORTAL).read_text(), table))
