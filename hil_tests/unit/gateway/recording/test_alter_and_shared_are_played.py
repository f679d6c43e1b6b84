"""A recorded cell with a correction and two axes on one set-point output: what they did comes out again (issue 7; AX-485)."""

from dataclasses import replace

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import get_bit, pack_inputs, unpack_inputs
from gateway.pure.recording.messages import Message, What
from gateway.recording.replay import Bench, replay
from hil_tests.lab.virtual.alter_bench import ALTER, INPUT, P5_MS, PORTAL, WAIT, AlterBench, with_alter
from hil_tests.lab.virtual.planned_bench import ServodynRobot
from hil_tests.lab.virtual.recorded_belts import TappedPlanner, found_in
from hil_tests.lab.virtual.recorded_bench import RecordedBench

OUTPUT, SELECT = 560, 592
TABLE = f'[[shared_output]]\nname = "FU1"\naxes = ["X", "Y"]\noutput = {OUTPUT}\nselect = {SELECT}\ncorrection_ms = 40\n\n'
CELL = load_cell(str(PORTAL), with_alter(PORTAL.read_text(), ALTER + TABLE))
HEAD = {"p5_ms": P5_MS, "simulated": True, "buses": ["drives"], "stamp_ns": 0, "zeros": {}}
PART = "alter frame - path=500 until=464", "linear pose 130 100 50 0 0 0 path=100", "alter_end"


class Robot(ServodynRobot, RecordedBench):
    """With all a cell may have, as the cycle makes it."""

    def _new_core(self) -> CycleLogic:
        core, _, _ = Bench(self.cell, HEAD, {}).core()
        core.state.generation = self.generation
        return core


class Recorded(AlterBench):
    """Its recording begins once the axes stand where programs begin."""

    def __init__(self) -> None:
        self.robot = Robot(P5_MS, cell=CELL)
        super().__init__(self.robot)
        self.planner = TappedPlanner(self.programs, len(CELL.axis), self.robot.tap)

    def home(self) -> "Recorded":
        """Axis by axis, since two of one output never move at a time."""
        assert self.bench.settle(self.bench.give(Code.ENABLE, 0xF)).state is CommandState.DONE
        _, y, z, _ = self.bench.set()
        for there in (f"100 {y} {z} 0", f"100 100 {z} 0", "100 100 50 0"):
            assert self.finished(self.begin(f"ptp joints {there}")).state is CommandState.DONE
        return self


@pytest.fixture(scope="module")
def recorded() -> Recorded:
    """Y alone, then an alterable part in which the correction carries X on and Z away; the converter takes one axis after the other."""
    bench = Recorded()
    bench.robot.record()
    bench.bench.run(0.1)
    assert bench.robot.tap.on
    assert bench.finished(bench.begin("ptp joints 100 120 50 0", "ptp joints 100 100 50 0")).state is CommandState.DONE
    drift = 0.0

    def correct() -> tuple[float, ...]:
        nonlocal drift
        drift = min(drift + 0.1, 5.0)
        return (drift, 0.0, 2.0 * drift, 0.0, 0.0, 0.0)

    bench.correct = correct
    job = bench.begin(*PART)
    bench.until(lambda s: s.axes[2].set > 0.0599)
    bench.bench.permit(WAIT)
    assert bench.finished(job).state is CommandState.DONE, job
    return bench


def test_a_correction_and_a_shared_output_come_out_as_they_were(recorded: Recorded) -> None:
    outputs = [payload[-128:] for what, payload in recorded.robot.messages if what is What.OUTPUTS]
    assert {(get_bit(each, SELECT), get_bit(each, SELECT + 1)) for each in outputs} >= {(True, False), (False, True)}
    assert len({each[OUTPUT >> 3 : (OUTPUT >> 3) + 2] for each in outputs}) > 20, "set points of both"
    verdict = replay(found_in(recorded.robot.messages, HEAD), CELL, CELL)
    assert (verdict.first, verdict.without_outputs) == (None, 0)
    assert verdict.cycles > 150 and max(s.axes[2].set for s in recorded.seen) > 0.0599, "it was altered meanwhile"


def test_another_correction_parts_in_its_cycle(recorded: Recorded) -> None:
    messages = list(recorded.robot.messages)
    asked = [n for n, message in enumerate(messages) if message.what is What.IMAGE and recorded_x(message) in range(250, 270)]
    for n in asked:  # two: one in two cycles is looked at
        image = unpack_inputs(messages[n].payload)
        image.values[INPUT >> 3 : (INPUT >> 3) + 2] = (300).to_bytes(2, "big")
        messages[n] = Message(What.IMAGE, pack_inputs(image))
    verdict = replay(found_in(messages, HEAD), CELL, CELL)
    assert len(asked) == 2 and verdict.first is not None and verdict.first.name.startswith("axis.X"), verdict.first


def recorded_x(message: Message) -> int:
    """Of the correction, as it stands in the image."""
    return int.from_bytes(unpack_inputs(message.payload).values[INPUT >> 3 : (INPUT >> 3) + 2], "big", signed=True)


def test_a_cell_without_the_output_parts_as_soon_as_the_axes_move(recorded: Recorded) -> None:
    verdict = replay(found_in(recorded.robot.messages, HEAD), CELL, replace(CELL, shared_output=()))
    assert verdict.first is not None and "rc_out" in verdict.first.name
