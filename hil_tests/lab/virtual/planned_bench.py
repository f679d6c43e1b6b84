"""A robot's cell in virtual time: dispatcher, planner's inside, core, emulated drives; and what the robot did by the emulator's record."""

from collections.abc import Callable, Sequence

import numpy as np

from drivers.drives.family import BusFamily
from drivers.drives.servodyn_family import ServodynFamily
from drivers.emulator.servo.record import Record, read
from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.assembly.axis_scaling import scaling_of
from gateway.assembly.limits import limits_of
from gateway.assembly.planner import cell_programs
from gateway.assembly.plant import bus_settings, motor_rad
from gateway.assembly.programs import machine_of_cell, robot_meant, team_meant
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.enabling_inputs import AS_SHIPPED, free_outputs
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import CellState
from gateway.pure.image.records.planner import ProgramFacts
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.planner import Programs
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.virtual.cell_bench import CellBench
from hil_tests.lab.virtual.planner_beside import PlannerBeside
from hil_tests.lab.virtual.servodyn_bus import CODEC
from motion.geometry.frames import IDENTITY, Pose
from motion.geometry.units import to_si
from motion.planner.robot import Machine


class ServodynRobot(CellBench):
    """A cell of any number of SERVODYN axes, modules 1 .. n in their order."""

    def _drives(self) -> tuple[ServodynSlave, BusFamily]:
        settings = bus_settings(self.cell, self.cell.bus[0].name, self.p5_ms)
        return ServodynSlave(settings, CODEC), ServodynFamily(CODEC, [(n, n + 1) for n in range(len(self.cell.axis))])


class Planned:
    """Command source 1 orders programs; one turn of the planner a cycle."""

    def __init__(self, bench: CellBench) -> None:
        self.bench, self.cell, self.machine = bench, bench.cell, machine_of_cell(bench.cell)
        every, self.text = (1 << len(self.cell.axis)) - 1, ""
        bench.dispatcher = CommandDispatcher(bench.dispatcher.axes, bench.dispatcher._plan, 1, {1: ProgramFacts("it", every)})
        if len(self.cell.robot) > 1:
            self.programs = Programs(
                cell_programs(self.cell, self._robot, lambda _: self.text, lambda named, _: team_meant(self.cell, named))
            )
        else:
            free = free_outputs(AS_SHIPPED, len(self.cell.axis))
            self.programs = Programs(CellPrograms(lambda *_: self.machine, lambda _: every, lambda _: self.text, free))
        self.planner = PlannerBeside(self.programs, len(self.cell.axis))
        bench.each = self._turn
        bench.dispatcher.planner = self.programs.state
        bench.run(0.3)
        for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
            assert bench.settle(bench.give(code, every)).state is CommandState.DONE

    @property
    def state(self) -> CellState:
        return self.bench.core.state

    def _robot(self, named: str, number: int) -> Machine:
        return robot_meant(self.cell, named)

    def _turn(self) -> None:
        self.planner.turn(self.bench.core, self.bench.dispatcher)

    def order(self, text: str) -> Job:
        self.text = text
        job = self.bench.dispatcher.command(1, Command(Code.PROGRAM, 1, 1.0, 1.0), self.bench.now)
        self.bench._hand_over()
        return job

    def done(self, code: Code, velocity: float = 1.0) -> None:
        """A command, through to its end."""
        assert self.bench.settle(self.bench.give(code, velocity=velocity)).state is CommandState.DONE

    def until(self, holds: Callable[[CellState], bool], seconds: float = 30.0) -> None:
        for _ in range(round(seconds * 1e9 / self.bench.period_ns)):
            if holds(self.state):
                return
            self.bench.cycle()
        raise AssertionError(f"not within {seconds} s: {self.state}")

    def driven(self) -> "Driven":
        """Since the last call, or the start."""
        slave = self.bench.slave
        record = read(slave.header() + slave.take_record())
        return Driven(self.cell, record, self.bench.period_ns / 1e9)


class Driven:
    """sets: (SYNCs, axes) where the set values asked the axes to be, actual: (SYNCs, axes) where the mechanics were; m or rad."""

    def __init__(self, cell: Cell, record: Record, period_s: float) -> None:
        self.axes, self.period, self.machine = cell.axis, period_s, machine_of_cell(cell)
        scalings = [scaling_of(axis) for axis in cell.axis]
        units = [to_si(1.0, axis.unit) / (motor_rad(axis, 1.0) - motor_rad(axis, 0.0)) for axis in cell.axis]
        self.sets = np.array([[s.to_si(a.set_inc) for s, a in zip(scalings, row.axes, strict=True)] for row in record.rows])
        actual = np.array([[u * a.position_rad for u, a in zip(units, row.axes, strict=True)] for row in record.rows])
        turn = 2.0 * np.pi * np.abs(units)  # drives may count turns from power-up
        self.actual = actual - np.round((actual[0] - self.sets[0]) / turn) * turn
        self._rounding = np.array([1.0 / abs(s.inc_per_unit) for s in scalings])

    def shares(self) -> tuple[float, float]:
        """Largest speed and acceleration of the set values as shares of the limits; what rounding to increments does is taken off."""
        found = []
        for order, name in ((1, "speed"), (2, "accel")):
            top = np.array([getattr(limits_of(axis), name) for axis in self.axes]) * self.period**order
            found.append(float(np.max((np.abs(np.diff(self.sets, order, axis=0)) - 2.0 ** (order - 1) * self._rounding) / top)))
        return found[0], found[1]

    def places(self, rows: Array, tool: Pose = IDENTITY, frame: Pose = IDENTITY) -> Array:
        """(n, 3) m of the tool centre point, seen from the frame."""
        seen, forward = frame.inverse(), self.machine.forward
        return np.array([(seen @ forward(tuple(float(v) for v in row)) @ tool).position for row in rows])


def off_segment(places: Array, start: Sequence[float], end: Sequence[float]) -> Array:
    """(n,) m: distance of each place from a straight stretch."""
    a, way = np.array(start), np.array(end) - np.array(start)
    share = np.clip((places - a) @ way / (way @ way), 0.0, 1.0)
    return np.asarray(np.linalg.norm(a + share[:, None] * way - places, axis=1))


def off_circle(places: Array, centre: Sequence[float], radius: float) -> Array:
    """(n,) m: distance of each place from a circle that lies flat (in the plane of its centre's z)."""
    away = places - np.array(centre)
    return np.asarray(np.hypot(np.hypot(away[:, 0], away[:, 1]) - radius, away[:, 2]))
