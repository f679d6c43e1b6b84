"""A portal with belts, a correction, measuring inputs and outputs led by coordinates, whose axes a stream of blocks moves: line by line in
virtual time, answered by block."""

import re
import struct

from gateway.assembly.alter import alter_of_cell
from gateway.assembly.axes import core_axes
from gateway.assembly.belts import belt_facts
from gateway.assembly.cycle_belts import encoders_of
from gateway.assembly.limits import limits_of
from gateway.assembly.path_outputs import output_places
from gateway.assembly.planner import cell_programs
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cycle.belts import CoreBelts
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.cycle.core_settings import CoreParts
from gateway.pure.cycle.path_outputs import CoreOutputs
from gateway.pure.image.records.cell import Quality, get_bit
from gateway.pure.image.records.planner import BlockRecord, PlannerState, Say
from gateway.pure.planning.planner import Programs
from gateway.pure.planning.streams import StreamPrograms
from gateway.pure.planning.team import no_team
from gateway.pure.planning.trial import Files
from hil_tests.lab.running.belt_run import with_belts
from hil_tests.lab.virtual.alter_bench import ALTER, BYTES, INPUT, LIFE
from hil_tests.lab.virtual.belt_bench import PORTAL, BeltBench
from motion.files import bnr
from motion.files.bnr import Header

PROBE, FAST, LATCH, SEEN, PART = 464, 465, 466, 467, 468  # RC inputs
IO, WORD, SWITCHED = 416, 432, 400  # RC outputs
TABLES = f"""
[[measuring]]
channel = 610
input   = {PROBE}

[[measuring]]
channel = 611
input   = {FAST}

[[measuring]]
channel = 612
input   = {LATCH}
latch   = "fIn0"

[[path_output]]
kind     = "iol"
function = 2
output   = {IO}

[[path_output]]
kind     = "ppo"
function = 3
output   = {WORD}
"""


def with_all(text: str) -> str:
    """The portal's cell file with everything a stream may ask for."""
    owners = ", ".join(f'"{byte}" = "plc"' for byte in sorted({*BYTES, (LIFE >> 3) - 1, PROBE >> 3, (PROBE >> 3) + 1}))
    text = re.sub(r"owner = \{.*\}", f"owner = {{ {owners} }}", with_belts(text))
    return text.replace("# ---- the emulated machine", f"{ALTER}{TABLES}\n# ---- the emulated machine")


CELL = load_cell(str(PORTAL), with_all(PORTAL.read_text()))
ROWS = [[0.1 * k, 0.0, 0.0, 0.0] for k in range(1, 21)]  # mm, from where the axes are
HEADING = ("angles rho3", "axes mm mm mm deg")


def curve(start: tuple[float, ...]) -> bytes:
    """A file of set points that leads 2 mm along X and back."""
    rows = [*ROWS, *ROWS[-2::-1], [0.0] * 4]
    return bnr.encode(Header(time_base_us=4000, axes=4), [[a + b for a, b in zip(start, row, strict=True)] for row in rows])


class StreamBench(BeltBench):
    """`job` is the stream under way."""

    def __init__(self) -> None:
        self.speaks = True
        super().__init__(CELL)
        self.permit(PROBE, FAST, LATCH, SEEN, PART, value=False)
        self.job = self.begin()

    def _new_core(self) -> CycleLogic:
        period, kinematics = self.period_ns / 1e9, {1: self.machine.kinematics}
        self.belts = CoreBelts(belt_facts(self.cell), kinematics, [limits_of(axis) for axis in self.cell.axis], period)
        self.encoders = encoders_of(self.cell, "drives", self.belts)
        functions = CoreOutputs(output_places(self.cell), kinematics, period)
        alter = alter_of_cell(self.cell, self.p5_ms)
        return CycleLogic(core_axes(self.cell, self.p5_ms), period, 1, parts=CoreParts(self.belts, functions, alter))

    def another_planner(self, before: PlannerState) -> None:
        made = cell_programs(self.cell, lambda *_: self.machine, lambda _: self.text, no_team)
        made.files, made.systems = Files(lambda name, number: curve((110.0, 100.0, 50.0, 0.0)), 4000), self.axes + len(self.cell.belt)
        self.programs: Programs = StreamPrograms(made)
        self.planner = self._beside()

    def _turn(self) -> None:
        super()._turn()
        for octet in BYTES:
            self.inputs.quality[octet] = Quality.GOOD
        struct.pack_into(">6h", self.inputs.values, INPUT >> 3, *[0] * 6)
        if self.speaks:
            self.inputs.values[LIFE >> 3] = (self.inputs.values[LIFE >> 3] + 1) & 0xFF

    # ---- the stream ----------------------------------------------------------------------------------------------------
    def begin(self) -> Job:
        """A stream of the portal; the axes rest."""
        self.job = self.dispatcher.order_stream(1, 1, self.all)
        self._hand_over()
        self.seen.clear()
        self.planner.say(self.job.id, *HEADING)
        return self.job

    def say(self, *lines: str, finish: bool = True) -> None:
        """Statements, one a turn; finish: nothing follows for the time being."""
        self.planner.say(self.job.id, *lines, finish=finish)

    def order_of(self, say: Say, text: str = "") -> None:
        """Another record of the stream."""
        self.planner.lines.append(BlockRecord(say, self.job.id, text))

    def hold(self) -> None:
        """The stream rests on its path."""
        self.dispatcher.hold_move(self.job)
        self._hand_over()

    def go(self) -> None:
        """Resume."""
        self.dispatcher.go_on_with(self.job)
        self._hand_over()

    def retrace(self) -> None:
        """Back along its path."""
        self.dispatcher.go_on_with(self.job, back=True)
        self._hand_over()

    def flush(self) -> None:
        """As a tool does it: the axes brake at once."""
        self.hold()
        self.order_of(Say.FLUSH)

    def end(self) -> Job:
        """Nothing follows any more: until the stream has an outcome."""
        self.order_of(Say.END)
        return self.finished(self.job)

    def state(self) -> PlannerState:
        return self.programs.state

    def passed(self, block: int, seconds: float = 20.0) -> None:
        """Until this block is over."""
        for _ in range(round(seconds * 1e9 / self.period_ns)):
            if self.state().passed >= block:
                return
            assert self.job.open, (self.state(), self.job)
            self.cycle()
        raise AssertionError(f"never: {self.state()}, {self.core.state.motion}")

    def at(self) -> tuple[float, ...]:
        """Set values; mm and deg."""
        return tuple(round(place, 6) + 0.0 for place in self.set())

    def output(self, number: int) -> bool:
        return get_bit(self.core.outputs, number)
