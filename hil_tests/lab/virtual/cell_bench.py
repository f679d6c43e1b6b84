"""A whole cell in virtual time: dispatcher, core and the emulated drives of the demo cell; no process, clock or file after the start."""

from collections.abc import Callable

from drivers.drives.family import Actual, BusFamily
from drivers.drives.servodyn_family import ServodynFamily
from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.assembly.axes import axis_facts, core_axes, make_planner
from gateway.assembly.axis_signals import rc_numbers
from gateway.assembly.plant import bus_settings
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.cycle.core_settings import CoreRules
from gateway.pure.image.records.cell import (
    MOST_AXES,
    InputImage,
    OrderRecord,
    Quality,
    pack_cell_state,
    pack_order,
    set_bit,
    unpack_cell_state,
    unpack_order,
)
from hil_tests.lab.virtual.servodyn_bus import CODEC
from motion.execution.pieces import record_size
from protocols.base.machine import Frame, Ns

START: Ns = 1_000_000_000_000
ALL = 0x3F
ENABLING = range(24, 29)
DEMO: Cell = load_cell("demo")
FAMILY = ServodynFamily(CODEC, [(n, n + 1) for n in range(6)])


class CellBench:
    """One command source (number 1) commands; `silent` axes do not answer, `late` ones when the next cycle waits for its own; time is
    `now`."""

    def __init__(self, p5_ms: int = 4, *, finish_without_services: bool = False, cell: Cell = DEMO) -> None:
        self.cell, self.p5_ms = cell, p5_ms
        self.period_ns: Ns = p5_ms * 1_000_000
        self.now: Ns = START
        self.slave, self.family = self._drives()
        self.finish = finish_without_services
        self.generation = 1
        self.core = self._new_core()
        self.dispatcher = CommandDispatcher(axis_facts(cell), make_planner(cell), 1)
        self.inputs = InputImage()
        self.services_alive = True
        self.services_ns: Ns = START
        self.silent: set[int] = set()
        self.late: set[int] = set()
        self._kept: dict[int, Actual] = {}
        self.orders: list[OrderRecord] = []
        self.burst: list[Frame] = self.family.burst(self.core.idle())
        self.each: Callable[[], None] = lambda: None
        self.permit(*ENABLING)

    def _drives(self) -> tuple[ServodynSlave | Cia402Slave, BusFamily]:
        """The emulated drives of the cell's first bus, and our language to them."""
        return ServodynSlave(bus_settings(self.cell, self.cell.bus[0].name, self.p5_ms), CODEC), FAMILY

    def _new_core(self) -> CycleLogic:
        period, step = self.period_ns / 1e9, self.cell.cell.override_step
        axes = core_axes(self.cell, self.period_ns / 1e6)
        rules = CoreRules(rc_numbers(self.cell), finish_without_services=self.finish, override_step=step)
        return CycleLogic(axes, period, self.generation, rules)

    def permit(self, *bits: int, value: bool = True) -> None:
        """RC inputs as a living command source writes them."""
        for bit in bits:
            set_bit(self.inputs.values, bit, value)
            self.inputs.quality[bit >> 3] = Quality.GOOD

    def cycle(self, count: int = 1) -> None:
        """SYNC burst, answers, core, dispatcher; then the next grid instant."""
        for _ in range(count):
            stamped = [frame._replace(stamp_ns=self.now) for frame in self.burst]
            self.slave.receive(stamped, self.now)
            actuals: list[Actual | None] = [None] * len(self.cell.axis)
            for frame in self.slave.take_output():
                heard = self.family.hear(frame)
                if heard is None or heard.axis + 1 in self.silent:
                    continue
                if heard.axis + 1 in self.late:
                    self._kept[heard.axis] = heard.actual
                else:
                    actuals[heard.axis] = self._kept.pop(heard.axis, heard.actual)  # the first one counts, the next comes too late
            if self.services_alive:
                self.services_ns = self.now
            orders, self.orders = self.orders, []
            values = self.core.step(actuals, self.inputs, orders, self.services_ns, self.now)
            self.burst = self.family.burst(values)
            if self.services_alive:
                self.dispatcher.observe(unpack_cell_state(pack_cell_state(self.core.state)), self.now)
                self._hand_over()
            self.each()
            self.now += self.period_ns

    def run(self, seconds: float) -> None:
        self.cycle(round(seconds * 1e9 / self.period_ns))

    def _hand_over(self) -> None:
        """Through the ring's bytes, as in the real thing; orders of another generation are dropped there."""
        for order in self.dispatcher.take_orders():
            record = unpack_order(pack_order(order, record_size(len(self.cell.axis))))
            if record.generation == self.generation:
                self.orders.append(record)

    def give(self, code: Code, mask: int = ALL, velocity: float = 1.0, targets: tuple[float, ...] = (), source: int = 1) -> Job:
        """One fresh command of a command source."""
        places = (*targets, *[0.0] * MOST_AXES)[:MOST_AXES]
        job = self.dispatcher.command(source, Command(code, mask, velocity, 1.0, places), self.now)
        self._hand_over()
        return job

    def settle(self, job: Job, seconds: float = 20.0) -> Job:
        """Run until the job has an outcome; AssertionError when it never has."""
        for _ in range(round(seconds * 1e9 / self.period_ns)):
            if not job.open:
                return job
            self.cycle()
        raise AssertionError(f"job {Code(job.code).name} is still {job.state.name} after {seconds} s")

    def ready(self) -> "CellBench":
        """Control, override, drives on, referenced: what most tests start from."""
        self.run(0.3)
        for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE, Code.REFERENCE):
            job = self.settle(self.give(code))
            assert job.state.name == "DONE", (code.name, job)
        return self

    def restart_cycle(self) -> None:
        """A new cycle process: a new core, nothing left in the ring for it."""
        self.generation += 1
        self.core = self._new_core()
        self.orders = []
        self.burst = self.family.burst(self.core.idle())

    def actual(self) -> list[float]:
        """Positions in mm and deg as published."""
        return [axis.actual / fact.si for axis, fact in zip(self.core.state.axes, self.dispatcher.axes, strict=False)]

    def set(self) -> list[float]:
        """Set positions in mm and deg."""
        return [axis.set / fact.si for axis, fact in zip(self.core.state.axes, self.dispatcher.axes, strict=False)]
