"""A cell in virtual time that runs ROBOTstar programs: emulated drives, cycle core, planner, control, integrated PLC and interpreter
without a process, each record through its bytes."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace

from gateway.assembly.controllers import make_control
from gateway.assembly.planner import cell_programs
from gateway.assembly.programs import machines_of_cell, team_meant
from gateway.assembly.robotstar import arm_of, programs_of_control
from gateway.cell_file.load import load_cell
from gateway.files.robotstar import words
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.reis.control import ReisControl
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import RC_BYTES, CellState, Motion, pack_cell_state, unpack_cell_state
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
    piece_size,
    run_record,
    unpack_block,
    unpack_piece,
)
from gateway.pure.image.records.planner import pack_block as packed_block
from gateway.pure.image.records.planner import pack_piece as packed_piece
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.hosting import View, as_reported, paths_of
from gateway.pure.languages.base.requests import RuntimeFault
from gateway.pure.languages.robotstar.cell_run import CellRun
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.planning.planner import Programs
from gateway.pure.planning.turn import follow, positions
from hil_tests.lab.virtual.baps2_bench import ServodynBench, VirtualPort
from hil_tests.lab.virtual.planner_region import PlannerRegion
from motion.errors import MotionError
from motion.geometry.units import from_si
from motion.planner.robot import Machine

SHIPPED: Cell = load_cell("reis-palletiser")
CELL = replace(  # a turn of a motor is 45 degrees: the emulated drives begin where [plant] has them, near the work
    SHIPPED, axis=tuple(replace(axis, mechanics=replace(axis.mechanics, gear="8:1")) for axis in SHIPPED.axis)
)
AUTO, ACKNOWLEDGE, FIRST_INPUT = 23, 62, 704
SOURCE = 1
MOST_TURNS = 4  # of the interpreter in one cycle, for programs that compute


def at(x: float, y: float, z: float) -> str:
    """A position with the tool down."""
    return f"POSITION #N, X:{x:g}, Y:{y:g}, Z:{z:g}, A:180, B:0, C:180"


def main(body: str, name: str = "P", kind: str = "MPR") -> dict[str, str]:
    """A program with a tool."""
    return {f"{name}.{kind}": f'{kind} "{name}"\nTOOL T\n{body}\nEND\n'}


class ReisCell:
    """`files`: programs of the memory; values: of variables, as kept."""

    def __init__(self, files: dict[str, str], values: dict[str, str] | None = None, cell: Cell = CELL) -> None:
        self.cell = cell
        self.bench = ServodynBench(finish_without_services=cell.cell.on_services_loss == "finish_move", cell=cell)
        self.bench.dispatcher = CommandDispatcher(self.bench.dispatcher.axes, self.bench.dispatcher._plan, 1, {})
        self.errors = ErrorList()
        control, _ = make_control(
            cell, dict.fromkeys(range(RC_BYTES), 1), {"plc": SOURCE}, self.bench.dispatcher, self.errors, self.bench.now
        )
        assert isinstance(control, ReisControl)
        self.control = control
        self.hosted = programs_of_control(cell, control, self.bench.dispatcher)
        self.planning = Programs(cell_programs(cell, self._machine, self._text, lambda kinematics, number: team_meant(cell, kinematics)))
        self.planner_region = PlannerRegion()
        self.files, self.kept = files, values or {}
        self.told: list[str] = []
        self.bits: list[tuple[float, str, int]] = []  # s, byte as Ax or Mx, value: outputs and free markers as they change
        self.places: list[tuple[float, ...]] = []  # X Y Z A B C of the flange in each cycle
        self.joints: list[tuple[float, ...]] = []
        self.lines: list[str] = []  # as handed to the planner
        self._flags = bytes(2048)
        self._pieces: deque[bytes] = deque()
        self.a_cycle = 1 << 10  # pieces the core takes from the ring
        self.born(1)
        self.bench.each = self.turn
        self.bench.permit(AUTO, ACKNOWLEDGE, *range(FIRST_INPUT, FIRST_INPUT + 320), value=False)
        self.bench.permit(AUTO)
        self.bench.run(0.1)
        self.ready()

    def ready(self) -> None:
        """Control, override, drives on."""
        for code in (Code.REQUEST_CONTROL, Code.FAULT_RESET, Code.OVERRIDE, Code.ENABLE):
            job = self.bench.settle(self.bench.give(code, mask=self.mask))
            assert job.state.name == "DONE", (code, job)

    @property
    def mask(self) -> int:
        return (1 << len(self.cell.axis)) - 1

    def born(self, identity: int) -> None:
        """An interpreter begins, with the values that were kept."""
        self.port: VirtualPort | None = VirtualPort(identity)
        self.arm, self.faults = arm_of(self.cell), Faults()
        self.language = CellRun(Memory.read([Source(*each) for each in self.files.items()], words(), self.faults), self.port, self.arm)
        for name, text in self.kept.items():
            assert not self.language.restore(name, text)

    def dies(self) -> None:
        """End the interpreter; what it has sent and is not yet read is lost, what is on the disk stays."""
        self.kept = self.language.values()
        self.port = None

    def _machine(self, name: str, number: int) -> Machine:
        return machines_of_cell(self.cell)[-number - 1 if number < 0 else 0]

    def _text(self, number: int) -> str:
        raise MotionError(f"program {number}: no such file")

    # ---- one cycle
    def turn(self) -> None:
        bench, now = self.bench, self.bench.now
        state = unpack_cell_state(pack_cell_state(bench.core.state))
        self.joints.append(tuple(from_si(axis.set, own.unit) for axis, own in zip(state.axes, self.cell.axis, strict=False)))
        self.places.append(self.arm.actual(self.joints[-1], None).pose)
        self._services(state, now)
        records = [unpack_block(packed_block(run_record(order))) for order in bench.dispatcher.take_programs()]
        bench._hand_over()
        if self.port is not None:
            self._interpreter(self.port, state, now)
            said = [unpack_block(data) for data in self.port.lines]
            self.lines += [record.text for record in said if record.say is Say.LINE]
            records += said
            self.port.lines.clear()
        records += [BlockRecord(Say.END, job) for job in self.hosted.ending]
        self.hosted.ending.clear()
        while self.planning.preparing:
            self.planning.prepare(positions(state, len(self.cell.axis)))
        while self.planning.working and not self.planning.work():
            pass
        axes = len(self.cell.axis)
        self._pieces += [
            packed_piece(each, piece_size(axes)) for each in follow(self.planning, records, state, axes, waiting=len(self._pieces))
        ]
        bench.dispatcher.planner = self.planner_region.through(self.planning.state)
        for _ in range(min(self.a_cycle, len(self._pieces))):
            bench.core.feed(unpack_piece(self._pieces.popleft()))

    def _services(self, state: CellState, now: int) -> None:
        port = self.port
        report: dict[str, object] = {"id": 0}
        if port is not None:
            rows = [as_reported(row) for row in self.language.rows()]
            report = {"id": port.identity, "programs": [as_reported(row) for row in self.language.catalogue()], "processes": rows}
        self.hosted.report(unpack_report(pack_report(report)), alive=port is not None)
        while port is not None and port.said:
            self.hosted.hear(unpack_facts(port.said.popleft()), now)
        self.hosted.step(now)
        self.told += self.control.step(self.bench.inputs, bytes(self.bench.core.outputs), state, now, heard=True)
        self.hosted.step(now)
        self.told += self.hosted.sentences
        self.hosted.sentences.clear()
        flags = self.control.flag_bytes()
        for byte in (*range(512), *range(2008, 2048)):
            if flags[byte] != self._flags[byte]:
                self.bits.append((now / 1e9, f"A{byte - 2008}" if byte >= 2008 else f"M{byte}", flags[byte]))
        self._flags = flags

    def _interpreter(self, port: VirtualPort, state: CellState, now: int) -> None:
        planner = self.planner_region.through(self.planning.state)
        port.view = View(
            unpack_channels(pack_channels(self.hosted.seen())),
            self.joints[-1],
            (None,) * len(self.cell.axis),
            paths_of(planner, state),
        )
        orders, self.hosted.orders = self.hosted.orders, []
        for order in (unpack_facts(pack_facts(each)) for each in orders):
            self._obey(order, now)
        for _ in range(MOST_TURNS):
            if not self.language.turn(now):
                break

    def _obey(self, order: dict[str, Fact], now: int) -> None:
        match order["do"]:
            case "start":
                self.language.start_run(str(order["program"]), int(order["run"]), now)
            case "stop":
                self.language.stop_run(int(order["run"]), now)
            case "given":
                self.language.path_given(int(order["ticket"]), int(order["job"]))
            case "over":
                code = int(order["code"])
                self.language.path_over(int(order["ticket"]), RuntimeFault(code, str(order["text"])) if code else None, now)
            case _:
                self.language.hear(order, now)

    # ---- what tests do
    def start(self, name: str = "P") -> int:
        """As `axisgate program start` does; number of the run."""
        answer = self.hosted.answer({"do": "start", "name": name}, 0)
        assert "run" in answer, answer
        run = answer["run"]
        assert isinstance(run, int)
        return run

    def stop(self, name: str = "P") -> None:
        """As `axisgate program stop` does."""
        assert self.hosted.answer({"do": "stop", "name": name}, 0) == {"ok": True}

    def key(self, name: str, level: bool = True) -> None:
        """A key is pressed or released."""
        self.control.put(f"reis.key.{name}", float(level))
        self.bench.cycle(2)

    def until(self, test: Callable[[], bool], seconds: float = 30.0) -> None:
        for _ in range(round(seconds * 250)):
            if test():
                return
            self.bench.cycle()
        raise AssertionError(f"never: {self.told}, {self.language.rows()}, {self.bench.core.state.motion} {self.where()} {self.lines[-4:]}")

    def ends(self, run: int, seconds: float = 60.0) -> tuple[str, int, str, str]:
        """Runs until the program has stopped and the axes rest: how, code, text, place."""
        self.until(lambda: run in self.hosted.results, seconds)
        self.until(lambda: self.bench.core.state.motion in (Motion.IDLE, Motion.STOPPED))
        return self.hosted.results[run]

    def run(self, name: str = "P", seconds: float = 60.0) -> tuple[str, int, str, str]:
        return self.ends(self.start(name), seconds)

    def where(self) -> tuple[float, ...]:
        """X Y Z of the flange, rounded."""
        return tuple(round(value, 2) + 0.0 for value in self.places[-1][:3])

    def step(self) -> int:
        """Step in work."""
        return self.language.rows()[0].line

    def give(self, byte: int, bit: int, value: bool = True) -> None:
        """A binary input."""
        self.bench.permit(FIRST_INPUT + 8 * byte + bit, value=value)

    def value(self, name: str) -> object:
        """A variable."""
        return dict(line.split(" = ") for text in self.language.values().values() for line in text.splitlines()).get(name)
