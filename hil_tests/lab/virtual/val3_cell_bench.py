"""A cell in virtual time that runs a VAL 3 application: emulated drives, cycle core, planner, control and interpreter without a process,
each record through its bytes."""

import pathlib
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace

import configs
from gateway.assembly.axes import core_axes
from gateway.assembly.controllers import make_control
from gateway.assembly.core import core_parts
from gateway.assembly.planner import cell_programs
from gateway.assembly.programs import machines_of_cell, mask_of, team_meant
from gateway.assembly.val3_application import setup_of
from gateway.cell_file.load import load_cell
from gateway.files.val3_disk import read_disk
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.val3.application import HostedApplication
from gateway.pure.controllers.val3.io.control import Val3Control
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.cycle.correction_inputs import laid_over
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import (
    RC_BYTES,
    AxisFlag,
    CellState,
    Permit,
    get_bit,
    pack_cell_state,
    unpack_cell_state,
)
from gateway.pure.image.records.correction import unpack_correction
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
from gateway.pure.languages.base.hosting import View, as_reported, paths_of
from gateway.pure.languages.base.requests import RuntimeFault
from gateway.pure.languages.val3.cell_run import CellRun
from gateway.pure.languages.val3.disk import Disk
from gateway.pure.planning.planner import Programs
from gateway.pure.planning.turn import follow, positions
from gateway.services.val3_programs import Val3Programs
from hil_tests.lab.virtual.baps2_bench import VirtualPort
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planner_region import PlannerRegion
from motion.errors import MotionError
from motion.geometry.units import from_si
from motion.planner.robot import Machine

FOLDER = pathlib.Path(configs.__file__).parent / "cells" / "cs8" / "usrapp"
CELL: Cell = load_cell("cs8")
assert CELL.val3 is not None
SETUP = setup_of(CELL, CELL.val3)
PART, DONE, VALVE = 704, 704, 705  # RC input, RC outputs
TOOL = 90  # a commissioning tool


class AlteredBench(Cell402Bench):
    """With the correction of the application."""

    def _new_core(self) -> CycleLogic:
        period = self.period_ns / 1e9
        return CycleLogic(core_axes(self.cell, self.p5_ms), period, self.generation, parts=core_parts(self.cell, self.p5_ms))


class Val3Cell:
    """files: of the disk, None: the shipped ones; name: of the application."""

    def __init__(self, files: Mapping[str, bytes] | None = None, name: str = "cycle", *, autostart: bool = False) -> None:
        self.cell = cell = CELL
        self.bench = AlteredBench(cell=cell)
        self.bench.dispatcher = CommandDispatcher(self.bench.dispatcher.axes, self.bench.dispatcher._plan, 1, {})
        control, _ = make_control(cell, dict.fromkeys((3, 88), 1), {"plc": 1}, self.bench.dispatcher, ErrorList(), self.bench.now)
        assert isinstance(control, Val3Control)
        self.control = control
        mask = mask_of(cell, machines_of_cell(cell)[0])
        self.hosted = HostedApplication(control, self.bench.dispatcher, mask, autostart=autostart)
        self.programs = Val3Programs(control, self.hosted)
        self.planning = Programs(cell_programs(cell, self._machine, self._text, lambda kinematics, number: team_meant(cell, kinematics)))
        self.planner_region = PlannerRegion()
        self.disk = Disk(dict(files)) if files is not None else read_disk(FOLDER)
        self.setup = replace(SETUP, name=name, folder=name)
        self.told: list[str] = []
        self.outputs: list[tuple[float, int, bool]] = []  # s, RC output, value: those of the points as they change
        self.places: list[tuple[float, ...]] = []  # set values of each cycle, deg
        self.fresh = True
        self._before = bytes(RC_BYTES)
        self._pieces: deque[bytes] = deque()
        self.born(1)
        self.bench.each = self.turn
        self.put(PART, False)
        self.bench.run(0.3)

    def born(self, identity: int) -> None:
        """An interpreter begins."""
        self.port: VirtualPort | None = VirtualPort(identity)
        self.language = CellRun(self.setup, self.port, lambda: self.disk)
        self.language.read()
        self.fresh = identity == 1

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
        while self.planning.preparing:
            self.planning.prepare(positions(state, len(self.cell.axis)))
        while self.planning.working and not self.planning.work():
            pass
        axes = len(self.cell.axis)
        self._pieces += [
            packed_piece(each, piece_size(axes))
            for each in follow(self.planning, records, state, axes, waiting=len(self._pieces), spare=lambda: True)
        ]
        bench.dispatcher.planner = self.planner_region.through(self.planning.state)
        for _ in range(min(2, len(self._pieces))):
            bench.core.feed(unpack_piece(self._pieces.popleft()))

    def _services(self, state: CellState, now: int) -> None:
        port = self.port
        report: dict[str, object] = {"id": 0}
        if port is not None:
            rows = [as_reported(row) for row in self.language.rows()]
            programs = [as_reported(row) for row in self.language.catalogue()]
            report = {"id": port.identity, "fresh": self.fresh, "programs": programs, "processes": rows, **self.language.seen(now)}
        self.hosted.report(unpack_report(pack_report(report)), alive=port is not None)
        while port is not None and port.said:
            self.hosted.hear(unpack_facts(port.said.popleft()), now)
        self.hosted.step(now)
        self.control.step(self.bench.inputs, bytes(self.bench.core.outputs), state, now, heard=True)
        self.hosted.step(now)
        self.told += self.hosted.sentences
        self.hosted.sentences.clear()
        outputs = self.control.outputs
        for bit in range(DONE, DONE + 8):
            if get_bit(outputs, bit) != get_bit(self._before, bit):
                self.outputs.append((now / 1e9, bit, get_bit(outputs, bit)))
        self._before = outputs

    def _interpreter(self, port: VirtualPort, state: CellState, now: int) -> None:
        planner = self.planner_region.through(self.planning.state)
        axes = list(zip(self.cell.axis, state.axes, strict=False))
        port.view = View(
            unpack_channels(pack_channels(self.programs.seen())),
            tuple(from_si(axis.set, own.unit) for own, axis in axes),
            (),
            paths_of(planner, state),
            tuple(from_si(axis.actual, own.unit) for own, axis in axes),
            sum(1 << n for n, (_, axis) in enumerate(axes) if axis.flags & AxisFlag.ENABLED),
            state.motion,
            state.override,
            not state.emergency and bool(state.permits & Permit.CHAIN),
            torque=tuple(axis.torque for _, axis in axes),
        )
        orders, self.hosted.orders = self.hosted.orders, []
        for order in (unpack_facts(pack_facts(each)) for each in orders):
            self._obey(order, now)
        while self.language.turn(now):
            pass
        alter = self.cell.alter
        if port.correction and alter is not None:
            self.bench.inputs = laid_over(self.bench.inputs, unpack_correction(port.correction), alter.input >> 3)
            port.correction = b""

    def _obey(self, order: dict[str, Fact], now: int) -> None:
        match order["do"]:
            case "start":
                self.fresh = False
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

    def dies(self) -> None:
        """End the interpreter; what it has sent and is not yet read is lost."""
        self.port = None

    def put(self, bit: int, value: bool = True) -> None:
        """An RC input of the PLC."""
        self.bench.permit(bit, value=value)

    def power(self) -> None:
        """A tool switches on and gives control back."""
        every = (1 << len(self.cell.axis)) - 1
        for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE, Code.RELEASE_CONTROL):
            job = self.bench.settle(self.bench.give(code, mask=every, source=TOOL))
            assert job.state.name == "DONE", (code, job)

    def start(self, name: str = "") -> int:
        """As `axisgate program start` does; number of the run."""
        answer = self.programs.answer({"do": "start", "name": name or self.setup.name}, 0)
        assert isinstance(answer.get("run"), int), answer
        return int(str(answer["run"]))

    def until(self, test: Callable[[], bool], seconds: float = 30.0) -> None:
        for _ in range(round(seconds * 250)):
            if test():
                return
            self.bench.cycle()
        raise AssertionError(f"never: {self.told}, {self.words}, {self.language.rows()}, {self.bench.core.state.motion}")

    @property
    def words(self) -> list[str]:
        """The log of the application."""
        return self.port.words if self.port is not None else []

    def ends(self, run: int, seconds: float = 60.0) -> tuple[str, int, str, str]:
        """Runs until it is over: how, code, text, place."""
        self.until(lambda: run in self.hosted.results, seconds)
        return self.hosted.results[run]

    def run(self, seconds: float = 60.0) -> tuple[str, int, str, str]:
        return self.ends(self.start(), seconds)

    def value(self, name: str) -> object:
        """A global of the application that runs."""
        assert self.language.own is not None
        container = self.language.own.data[name]
        return container[0] if isinstance(container, list) else container

    def at(self) -> tuple[float, ...]:
        """Set values, deg."""
        return tuple(round(value, 3) + 0.0 for value in self.places[-1])
