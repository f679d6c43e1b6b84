"""A cell in virtual time that runs BAPS2 programs: emulated drives, cycle core, planner, control and interpreter without a process, each
record through its bytes."""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace

from drivers.drives.servodyn_family import ServodynFamily
from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.assembly.axes import core_axes
from gateway.assembly.contact_regions import OFFSETS
from gateway.assembly.controllers import make_control
from gateway.assembly.cycle_belts import belts_of, pack_counters
from gateway.assembly.interpreter import language_of
from gateway.assembly.path_outputs import functions_of
from gateway.assembly.pic import pic_bytes
from gateway.assembly.planner import lane_programs_of
from gateway.assembly.plant import bus_settings
from gateway.assembly.programs import machines_of_cell, team_meant
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.rho3.signals.control import RhoControl
from gateway.pure.controllers.rho3.signals.hosted import HostedPrograms
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.cycle.core_settings import CoreParts, CoreRules
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import RC_BYTES, CellState, Motion, Quality, pack_cell_state, unpack_cell_state
from gateway.pure.image.records.interpreter import (
    Fact,
    pack_channels,
    pack_facts,
    pack_report,
    unpack_channels,
    unpack_facts,
    unpack_report,
)
from gateway.pure.image.records.planner import (
    BlockRecord,
    Say,
    pack_block,
    piece_size,
    run_record,
    unpack_block,
    unpack_piece,
)
from gateway.pure.image.records.planner import pack_piece as packed_piece
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.base.hosting import View, as_reported, paths_of
from gateway.pure.languages.base.requests import RuntimeFault
from gateway.pure.planning.trial import Files
from gateway.pure.planning.turn import positions
from hil_tests.lab.virtual.cell_bench import CellBench
from hil_tests.lab.virtual.planner_region import PlannerRegion
from hil_tests.lab.virtual.servodyn_bus import CODEC
from motion.errors import MotionError
from motion.geometry.units import from_si
from motion.planner.robot import Machine

AUTOMATIC, ACKNOWLEDGE, RESET = 23, 62, 19
KEEP, ABORT, SELECT, PARITY, CODE = 61, 80, 81, 83, 88
SELECTION = (KEEP, ABORT, SELECT, PARITY, *range(CODE, CODE + 8))
FIRST_INPUT = 464
PIC_SOURCE = 2
CELL: Cell = load_cell("palletiser")
HEAD = """;;CONTROL = RHO3
;;KINEMATICS : (1 = PORTAL)
;;PORTAL.JC_NAMES = A1, A2, A3, A4
;;PORTAL.WC_NAMES = X, Y, Z, C
"""


class VirtualPort:
    """What programs see and say."""

    def __init__(self, identity: int) -> None:
        self.view = View()
        self.identity = identity
        self.said: deque[bytes] = deque()
        self.lines: deque[bytes] = deque()
        self.words: list[str] = []
        self.correction = b""

    def say(self, what: str, **facts: Fact) -> None:
        self.said.append(pack_facts({"say": what, "id": self.identity, **facts}))

    def output(self, channel: int, value: float) -> None:
        self.say("output", channel=channel, value=value)

    def ask_path(self, ticket: int, program: str, robot: int) -> None:
        self.say("path", ticket=ticket, program=program, robot=robot)

    def line(self, job: int, text: str) -> None:
        self.lines.append(pack_block(BlockRecord(Say.LINE, job, text)))

    def whole(self, job: int) -> None:
        self.lines.append(pack_block(BlockRecord(Say.WHOLE, job)))

    def finish(self, job: int) -> None:
        self.lines.append(pack_block(BlockRecord(Say.FINISH, job)))

    def end(self, job: int) -> None:
        self.lines.append(pack_block(BlockRecord(Say.END, job)))

    def started(self, run: int, program: str, kind: str, parent: int) -> None:
        self.say("started", run=run, program=program, kind=kind, parent=parent)

    def over(self, run: int, how: str, fault: RuntimeFault | None, place: str) -> None:
        code, text = (fault.code, fault.text) if fault is not None else (0, "")
        self.say("over", run=run, how=how, code=code, text=text, place=place)

    def report(self, program: str, line: int, text: str) -> None:
        self.words.append(f"{program} line {line}: {text}")

    def correct(self, record: bytes) -> None:
        self.correction = record

    def panel(self, text: str) -> None:
        self.say("panel", text=text)

    def send(self, what: str, **facts: Fact) -> None:
        self.say(what, **facts)


class ServodynBench(CellBench):
    """With as many axes as the cell has."""

    def _drives(self) -> tuple[ServodynSlave, ServodynFamily]:
        family = ServodynFamily(CODEC, [(n, n + 1) for n in range(len(self.cell.axis))])
        return ServodynSlave(bus_settings(self.cell, self.cell.bus[0].name, self.p5_ms), CODEC), family

    def _new_core(self) -> CycleLogic:
        period, cell = self.period_ns / 1e9, self.cell
        return CycleLogic(
            core_axes(cell, self.p5_ms),
            period,
            self.generation,
            CoreRules(finish_without_services=self.finish, override_step=cell.cell.override_step),
            CoreParts(belts_of(cell, self.p5_ms) if cell.belt else None, functions_of(cell, self.p5_ms)),
        )


class ProgramCell:
    """`programs`: name -> source, without the lines before PROGRAM; `files`: others of the memory."""

    def __init__(self, files: Mapping[str, str | bytes], cell: Cell = CELL) -> None:
        self.cell = cell
        self.bench = ServodynBench(cell=cell)
        self.bench.dispatcher = CommandDispatcher(self.bench.dispatcher.axes, self.bench.dispatcher._plan, 1, {})
        self.errors = ErrorList()
        owners = dict.fromkeys(range(RC_BYTES), 1) | dict.fromkeys(pic_bytes(cell), PIC_SOURCE)
        control, _ = make_control(cell, owners, {"rack": 1, "pic": PIC_SOURCE}, self.bench.dispatcher, self.errors, self.bench.now)
        assert isinstance(control, RhoControl)
        self.control = control
        if control.pic is not None:
            control.pic.take = self._take_pic
        self.hosted = control.hosted = HostedPrograms(control)
        self.planning = lane_programs_of(cell, self._machine, self._text, lambda kinematics, _: team_meant(cell, kinematics), lambda _: 0)
        self.planner_region = PlannerRegion()
        self.planning.cell.files = Files(self._file, 4000)
        self.memory = Memory({name: text if isinstance(text, bytes) else text.encode() for name, text in files.items()})
        self.told: list[str] = []
        self.outputs: list[tuple[float, int, bool]] = []  # s, RC output, value: user outputs as they change
        self.places: list[tuple[float, ...]] = []  # set values of each cycle, in units
        self._before = bytes(RC_BYTES)
        self._pieces: deque[bytes] = deque()
        self.born(1)
        self.bench.each = self.turn
        self.bench.permit(AUTOMATIC, ACKNOWLEDGE, RESET, *SELECTION, *range(FIRST_INPUT, FIRST_INPUT + 16), value=False)
        self.bench.permit(AUTOMATIC)
        self.bench.run(0.2)
        if control.pic is not None:
            return  # the PIC switches the drives on
        for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
            job = self.bench.settle(self.bench.give(code, mask=(1 << len(cell.axis)) - 1))
            assert job.state.name == "DONE", (code, job)

    def born(self, identity: int) -> None:
        """An interpreter begins."""
        self.port: VirtualPort | None = VirtualPort(identity)
        self.language = language_of(self.cell, self.memory, self.port, 4)

    def _machine(self, name: str, number: int) -> Machine:
        """As the planner process has it."""
        return machines_of_cell(self.cell)[-number - 1 if number < 0 else 0]

    def _text(self, number: int) -> str:
        raise MotionError(f"program {number}: no such file")

    # ---- one cycle

    def turn(self) -> None:
        bench, now = self.bench, self.bench.now
        state = unpack_cell_state(pack_cell_state(bench.core.state))
        self.places.append(tuple(from_si(axis.set, own.unit) for axis, own in zip(state.axes, self.cell.axis, strict=False)))
        self._services(state, now)
        records = [unpack_block(pack_block(run_record(order))) for order in bench.dispatcher.take_programs()]
        bench._hand_over()
        if self.port is not None:
            self._interpreter(self.port, state, now)
            records += [unpack_block(data) for data in self.port.lines]
            self.port.lines.clear()
        records += [BlockRecord(Say.END, job) for job in self.hosted.ending]
        self.hosted.ending.clear()
        axes = len(self.cell.axis)
        while self.planning.prepare(state, axes):
            pass
        while self.planning.work():
            pass
        self._pieces += [packed_piece(each, piece_size(axes)) for each in self.planning.turn(records, state, axes, len(self._pieces))]
        assert positions(state, axes)
        bench.dispatcher.planner = self.planner_region.through(self.planning.state)
        for _ in range(min(2 * len(self.planning.lanes), len(self._pieces))):
            bench.core.feed(unpack_piece(self._pieces.popleft()))

    def _services(self, state: CellState, now: int) -> None:
        port = self.port
        report: dict[str, object] = {"id": 0}
        if port is not None:
            rows = [as_reported(row) for row in self.language.rows()]
            report = {"id": port.identity, "programs": [as_reported(row) for row in self.language.catalogue()], "processes": rows}
            report |= self.language.test.shown(self.bench.now)
        self.hosted.report(unpack_report(pack_report(report)), alive=port is not None)
        while port is not None and port.said:
            self.hosted.hear(unpack_facts(port.said.popleft()), now)
        self.hosted.step(now)
        self.told += self.control.step(self.bench.inputs, bytes(self.bench.core.outputs), state, now, heard=True)
        self.hosted.step(now)
        self.told += self.hosted.sentences
        self.hosted.sentences.clear()
        outputs = self.control.outputs
        first = self.control.setup.numbers.first_output
        for channel in range(1, 17):
            bit = first + channel - 1
            value, before = outputs[bit >> 3] >> (bit & 7) & 1, self._before[bit >> 3] >> (bit & 7) & 1
            if value != before:
                self.outputs.append((now / 1e9, channel, bool(value)))
        self._before = outputs

    def _interpreter(self, port: VirtualPort, state: CellState, now: int) -> None:
        planner = self.planner_region.through(self.planning.state)
        axes = list(zip(self.cell.axis, state.axes, strict=False))
        port.view = View(
            unpack_channels(pack_channels(self.control.seen())),
            tuple(from_si(axis.set, own.unit) for own, axis in axes),
            tuple(from_si(axis.measured, own.unit) if state.measured_mask >> n & 1 else None for n, (own, axis) in enumerate(axes)),
            paths_of(planner, state),
            tuple(from_si(axis.actual, own.unit) for own, axis in axes),
            belts=self.belt_counters(),
            belt_types=tuple(kind for kind, _ in planner.types),
        )
        orders, self.hosted.orders = self.hosted.orders, []
        for order in (unpack_facts(pack_facts(each)) for each in orders):
            self._obey(order, port, now)
        self.language.turn(now)

    def _obey(self, order: dict[str, Fact], port: VirtualPort, now: int) -> None:
        match order["do"]:
            case "hello":
                self.language.stop_all(now)
            case "start":
                self.language.start_run(str(order["program"]), int(order["run"]), now)
            case "stop":
                self.language.stop_run(int(order["run"]), now)
            case "fail":
                self.language.stop_run(int(order["run"]), now, RuntimeFault(int(order["code"]), str(order["text"])))
            case "given":
                self.language.path_given(int(order["ticket"]), int(order["job"]))
            case "over":
                code = int(order["code"])
                self.language.path_over(int(order["ticket"]), RuntimeFault(code, str(order["text"])) if code else None, now)
            case _:
                self.language.hear(order, now)

    def _take_pic(self, outputs: bytes, now: int) -> None:
        """As the command source `pic` does."""
        for octet in pic_bytes(self.cell):
            self.bench.inputs.values[octet], self.bench.inputs.quality[octet] = outputs[octet], Quality.GOOD

    def belt_counters(self) -> tuple[float, ...]:
        """Through the bytes of their region."""
        belts = self.bench.core.belts
        counters = OFFSETS.unpack(pack_counters(belts)) if belts is not None else ()
        return tuple(from_si(value, belt.unit) for value, belt in zip(counters, self.cell.belt, strict=False))

    def _file(self, name: str, number: int) -> bytes:
        """As the planner process reads them."""
        if name not in self.memory.files:
            raise MotionError(f"{name}: no such file")
        return self.memory.files[name]

    # ---- what tests do

    def dies(self) -> None:
        """End the interpreter; what it has sent and is not yet read is lost."""
        self.port = None

    def start(self, name: str) -> int:
        """As the panel does; number of the run."""
        return self.hosted.run_of(self.control.start(name))

    def until(self, test: Callable[[], bool], seconds: float = 30.0) -> None:
        for _ in range(round(seconds * 250)):
            if test():
                return
            self.bench.cycle()
        raise AssertionError(f"never: {self.told}, {self.language.rows()}, {self.bench.core.state.motion}")

    def ends(self, run: int, seconds: float = 60.0) -> tuple[str, int, str, str]:
        """Runs until a program is over, and the axes rest: how, code, text, place."""
        self.until(lambda: run in self.hosted.results, seconds)
        self.until(lambda: self.bench.core.state.motion in (Motion.IDLE, Motion.STOPPED))
        return self.hosted.results[run]

    def run(self, name: str, seconds: float = 60.0) -> tuple[str, int, str, str]:
        return self.ends(self.start(name), seconds)

    def at(self) -> tuple[float, ...]:
        """Set values, rounded."""
        return tuple(round(value, 3) + 0.0 for value in self.places[-1])

    def give(self, channel: int, value: bool = True) -> None:
        """A user input."""
        self.bench.permit(FIRST_INPUT + channel - 1, value=value)


def one(body: str, declared: str = "", name: str = "P", points: str = "") -> dict[str, str]:
    """A memory with one program."""
    files = {f"{name}.QLL": f"{HEAD}PROGRAM {name}\n{declared}\nBEGIN\n{body}\nPROGRAM_END\n"}
    return files | ({f"{name}.PKT": points} if points else {})


def with_axes(cell: Cell, **speed: float) -> Cell:
    """Other speeds of all axes."""
    return replace(cell, axis=tuple(replace(axis, limits=replace(axis.limits, **speed)) for axis in cell.axis))
