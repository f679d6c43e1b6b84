"""The arm and the SCARA of one cell with eight belts: the SCARA's four axes follow the arm's six.

Belts B1 .. B3 (types 1, 2, 3) are the arm's, B5 .. B7 the SCARA's, both follow B4, each along another direction of its base.  Both have a
measuring input, and one correction moves whichever robot's program runs.
"""

import struct
from collections.abc import Callable
from typing import Any

import numpy as np

from drivers.drives.family import BusFamily
from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.io.belts import EmulatedBelt, EmulatedBelts
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion, Quality
from gateway.pure.image.records.planner import ProgramFacts
from gateway.recording.replay import Bench
from hil_tests.lab.cells.arm_and_scara import cell_text
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.carried_cell import ARM
from hil_tests.lab.running.belt_run import INCREMENT
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned
from hil_tests.lab.virtual.recorded_belts import TappedPlanner
from hil_tests.lab.virtual.recorded_bench import RecordedBench
from motion.sync.belts import SET_COUNTER
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid

FIRST_ID = 0x1F0
TYPES = {1: 1, 2: 2, 3: 3, 4: 1, 5: 1, 6: 2, 7: 3, 8: 1}
FOLLOW = {**dict.fromkeys((1, 2, 3), '"arm"'), 4: '["arm", "scara"]', **dict.fromkeys((5, 6, 7, 8), '"scara"')}
BY_Y, BY_X = "[0.0, 1.0, 0.0]", "[1.0, 0.0, 0.0]"  # P503
PROBE, CORRECTION, LIFE, STATUS = (300, 308), 512, 616, 512
IO = 700  # RC output of the SCARA's IO logic
WIRED = (*(number >> 3 for number in PROBE), *range(CORRECTION >> 3, (CORRECTION >> 3) + 12), LIFE >> 3)

TABLES = f"""[alter]
input    = {CORRECTION}
life     = {LIFE}
status   = {STATUS}
every_ms = 4
robot    = ["arm", "scara"]

[[measuring]]
channel = 610
input   = {PROBE[0]}
robot   = "arm"
latch   = "fIn0"

[[measuring]]
channel = 620
input   = {PROBE[1]}
robot   = "scara"

[[path_output]]
kind     = "iol"
function = 2
output   = {IO}
robot    = "scara"

"""
HEADS = {
    "arm": "robot tx60-like\nangles val3\nstart 0 30 90 0 60 0\n",
    "scara": "robot sr60-like\nangles val3\naxes deg deg mm deg\nstart 0 90 -200 0\n",
}
MASKS = {"arm": 0b0000111111, "scara": 0b1111000000}
STARTS = {"arm": "0 30 90 0 60 0", "scara": "0 90 -200 0"}


def belt_table(number: int) -> str:
    """[[belt]] and its plant."""
    factors = f"factors = {BY_X}\nfactors_of = {{ scara = {BY_Y} }}" if number == 4 else f"factors = {BY_Y}"
    head = f'[[belt]]\nname = "B{number}"\ntype = {TYPES[number]}\nincrement = 0.1\nbus = "drives"\nid = {FIRST_ID + number}\n'
    return f"{head}simulated = 50.0\nrobot = {FOLLOW[number]}\n{factors}\n\n[plant.belt.B{number}]\naccel = 2000.0\n\n"


def with_belts(text: str) -> str:
    """The cell of both robots with belts, correction, inputs, and the signals of them from the PLC."""
    owners = ", ".join(f'"{byte}" = "plc"' for byte in sorted({*WIRED, (LIFE >> 3) - 1, SET_COUNTER >> 3, 399 >> 3, 464 >> 3}))
    begin, end = text.index("owner = {"), text.index("# ---- drives")
    line = text.index("\n", begin)
    belts = "".join(map(belt_table, TYPES))
    return f"{text[:begin]}owner = {{ {owners} }}{text[line:end]}{belts}{TABLES}{text[end:]}"


CELL = load_cell(str(ARM), with_belts(cell_text()))
P5_MS, EVERY = 8, 0x3FF
HEAD: dict[str, Any] = {"p5_ms": P5_MS, "simulated": True, "buses": ["drives"], "stamp_ns": 0, "zeros": {}}


class TwoRobots(RecordedBench, Cell402Bench):
    """With eight encoders; `counted`: their counts at each SYNC."""

    def _drives(self) -> tuple[Cia402Slave, BusFamily]:
        self.emulated = EmulatedBelts([EmulatedBelt(belt.id, accel=2.0 / INCREMENT) for belt in self.cell.belt])
        self.counted: list[list[float]] = []
        return super()._drives()

    def _new_core(self) -> CycleLogic:
        core, _, (self.encoders,) = Bench(self.cell, HEAD, {}).core()
        core.state.generation = self.generation
        return core

    def cycle(self, count: int = 1) -> None:
        """The encoders answer the SYNC as the drives do; the tap sees their telegrams."""
        for _ in range(count):
            self.bus.encoders = self.encoders
            self.emulated.receive([Frame(cobid.SYNC, stamp_ns=self.now)])
            self.others = [frame._replace(stamp_ns=self.now + 2) for frame in self.emulated.take_output()]
            for frame in self.others:
                self.encoders[frame.identifier].hear(frame.data)
            self.counted.append([INCREMENT * int.from_bytes(frame.data, "little", signed=True) for frame in self.others])
            self._one()


class OnBelts(Planned):
    """Command source 1 orders programs of either robot; `correct` returns the correction (mm, deg) for each cycle in
    which it is sent."""

    def __init__(self, cell: Cell = CELL) -> None:
        self.robots = TwoRobots(P5_MS, cell=cell)
        self.correct: Callable[[], tuple[float, ...]] = lambda: (0.0,) * 6
        self.begun = 0
        self.zeros: dict[int, float] = {}  # m: what the encoders said when their counters were set
        super().__init__(self.robots)
        self.bench.dispatcher.programs = {n: ProgramFacts(robot, MASKS[robot]) for n, robot in enumerate(MASKS, 1)}
        self.planner = TappedPlanner(self.programs, len(cell.axis), self.robots.tap)
        for number in PROBE:
            self.bench.permit(number, value=False)
        self.driven()

    def _turn(self) -> None:
        super()._turn()
        inputs = self.bench.inputs
        for octet in WIRED:
            inputs.quality[octet] = Quality.GOOD
        struct.pack_into(">6h", inputs.values, CORRECTION >> 3, *(round(100.0 * value) for value in self.correct()))
        inputs.values[LIFE >> 3] = (inputs.values[LIFE >> 3] + 1) & 0xFF

    @property
    def parts(self) -> int:
        """Of the program ordered last, that are over; a robot on its belt (type 1) counts as one."""
        return self.state.parts - self.begun

    def drive(self, belt: int, speed: float) -> None:
        """m/s, from now on."""
        self.robots.emulated.all[belt - 1].speed = self.robots.emulated.all[belt - 1].now = speed / INCREMENT

    def started(self, belt: int, speed: float) -> None:
        """The belt runs, its counter begins at 0."""
        self.drive(belt, speed)
        self.bench.run(0.1)
        self.bench.permit(SET_COUNTER + belt - 1)
        self.bench.cycle()
        self.zeros[belt] = self.robots.counted[-1][belt - 1]
        self.bench.permit(SET_COUNTER + belt - 1, value=False)
        self.bench.cycle()

    def belt(self, number: int) -> Array:
        """(SYNCs,) m: its value by the encoder after each SYNC since the order."""
        return np.array(self.robots.counted)[:, number - 1] - self.zeros[number]

    def begin(self, robot: str, *lines: str) -> Job:
        """A program of these lines, its record from here on."""
        self.driven()
        self.begun = self.state.parts
        self.robots.counted.clear()
        self.text = HEADS[robot] + "\n".join(lines)
        job = self.bench.dispatcher.command(1, Command(Code.PROGRAM, list(MASKS).index(robot) + 1, 1.0, 1.0), self.bench.now)
        self.bench._hand_over()
        return job

    def finished(self, job: Job) -> Job:
        """Runs until the job has an outcome and the axes rest."""
        self.bench.settle(job)
        self.until(lambda s: s.motion is Motion.IDLE)
        self.bench.run(0.2)
        return job

    def home(self) -> "OnBelts":
        """Every belt at rest, drives on, the axes where programs begin."""
        for belt in TYPES:
            self.drive(belt, 0.0)
        self.correct = lambda: (0.0,) * 6
        if self.state.emergency:
            assert self.bench.settle(self.bench.give(Code.FAULT_RESET, EVERY)).state is CommandState.DONE
        assert self.bench.settle(self.bench.give(Code.ENABLE, EVERY)).state is CommandState.DONE
        for robot, place in STARTS.items():
            job = self.finished(self.begin(robot, f"ptp joints {place}"))
            assert job.state is CommandState.DONE, job
        return self
