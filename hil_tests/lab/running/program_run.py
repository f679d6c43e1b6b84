"""A cell whose programs a PLC orders, as real processes: program files next to the cell file, PLC 2 that orders them, a record of the set
values."""

import contextlib
import os
import pathlib
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from gateway.assembly.axis_signals import INPUT_SIGNALS
from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import mask_word
from gateway.pure.image.records.cell import AxisFlag, CellState, Motion, get_bit, unpack_cell_state
from gateway.pure.image.records.planner import PlannerState, unpack_planner
from gateway.runtime.regions import RegionReader, recv_fds
from gateway.runtime.supervisor_client import ask
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.partners.plc2 import DONE, ENABLE, OVERRIDE, REQUEST, RESET, RESUME, STOP, Status
from hil_tests.lab.running.cell_running import CellRun, running_cell
from hil_tests.lab.virtual.planned_bench import Driven
from motion.planner.route import Route
from motion.program.text.reader import read

CELLS = pathlib.Path(__file__).parents[3] / "configs" / "cells"
PROGRAM = 13
PROBE = 464  # RC input USER_1: the PLC's; enabling inputs are assumed, so that a silent PLC takes none of them away
NOT_THERE = AxisFlag.UNCONFIGURED | AxisFlag.LOST
ON_PATH = 2e-6  # m or rad: set values of the cycle against the route as planned on paper


class ProgramRun:
    """One run; made by `program_run`."""

    def __init__(self, run: CellRun, programs: dict[int, str]) -> None:
        self.run, self.plc, self.texts = run, run.plc, programs
        self.cell = load_cell(run.cell)
        self.axes = len(self.cell.axis)
        self.all = mask_word((1 << self.axes) - 1, self.axes)
        self.machine = machine_of_cell(self.cell)
        with ask(run.name, "regions") as connection:
            self._fds = recv_fds(connection)
        self._state, self._planner = RegionReader(self._fds["axes"], "axes"), RegionReader(self._fds["planner"], "planner")
        self._outputs = RegionReader(self._fds["rc_out"], "rc_out")

    def close(self) -> None:
        for fd in self._fds.values():
            os.close(fd)

    # ---- what is seen ----------------------------------------------------------------------------------------------------
    def state(self) -> CellState:
        payload = self._state.read()
        assert payload is not None
        return unpack_cell_state(payload)

    def planner(self) -> PlannerState:
        payload = self._planner.read()
        assert payload is not None
        return unpack_planner(payload)

    def output(self, number: int) -> bool:
        """RC output as command sources read it."""
        payload = self._outputs.read()
        assert payload is not None
        return get_bit(payload, number)

    def sets(self) -> tuple[float, ...]:
        """Set values, SI."""
        return tuple(axis.set for axis in self.state().axes[: self.axes])

    def watch(self, what: str, holds: Callable[[CellState], bool], seconds: float = 20.0) -> Array:
        """Set values sampled until it holds; (n, axes)."""
        until, rows = time.monotonic() + seconds, []
        while time.monotonic() < until:
            state = self.state()
            rows.append([axis.set for axis in state.axes[: self.axes]])
            if holds(state):
                return np.array(rows)
            time.sleep(0.003)
        raise AssertionError(f"{what}: {self.state()} {self.planner()}\n{self.run.words()}")

    def still(self, seconds: float = 0.4) -> bool:
        """No set value changes meanwhile."""
        before = self.sets()
        time.sleep(seconds)
        return max(abs(a - b) for a, b in zip(before, self.sets(), strict=True)) < 1e-12

    def path(self, number: int, start: Sequence[float]) -> Array:
        """Return the program's path from where the axes were, densely; (n, axes)."""
        program, route = read(self.texts[number]), Route(self.machine, start)
        for block in program.blocks:
            route.add(block)
        route.finish()
        return np.concatenate([s.path.at(np.linspace(0.0, s.path.length, 400))[:, : self.axes] for s in route.take()])

    # ---- what is done ----------------------------------------------------------------------------------------------------
    def command(self, code: int, mask: int = 0, velocity: float = 1.0) -> Status:
        """PLC 2's command, whatever comes of it."""
        return self.plc.command(code, mask, velocity)

    def probe(self, value: bool) -> None:
        """PLC 2 writes RC input PROBE."""
        self.coil(PROBE, value)

    def coil(self, number: int, value: bool) -> None:
        """PLC 2 writes an RC input."""
        with self.plc._lock:
            assert not self.plc._client.write_coil(number, value).isError()

    def plc_outputs(self, bit: int, word: int) -> tuple[bool, int]:
        """What PLC 2 reads: a discrete input, and the input register that begins at RC output `word`."""
        with self.plc._lock:
            client = self.plc._client
            return bool(client.read_discrete_inputs(bit, count=1).bits[0]), int(
                client.read_input_registers(word // 16, count=1).registers[0]
            )

    def ready(self) -> None:
        """Every drive is started up; control, drives on, override 100 %."""
        self.watch("drives are started up", lambda s: s.cycle > 0 and not any(a.flags & NOT_THERE for a in s.axes[: self.axes]), 60.0)
        for code, mask in ((REQUEST, 0), (RESET, 0), (ENABLE, self.all), (OVERRIDE, 0)):
            self.run.command(code, mask)

    def moving(self, number: int, velocity: float = 1.0, seconds: float = 0.3) -> None:
        """Ordered, and under way for so long."""
        self.plc.send(PROGRAM, number, velocity)
        self.watch("it moves", lambda s: s.motion is Motion.RUNNING and s.piece > 0)
        time.sleep(seconds)

    def slowed_stopped_resumed(self, stop_here: Callable[[], bool], stopped_there: Callable[[], bool]) -> Driven:
        """Program 1 from rest to rest: at 30 %, stopped on the way, on at 60 and 100 %; what the emulator recorded of it."""
        self.ready()
        assert self.command(OVERRIDE, 0, 0.3).state == DONE
        since = self.run.record().rows[-1].stamp_ns
        self.plc.send(PROGRAM, 1)
        self.watch("where it is stopped", lambda s: s.piece > 0 and stop_here(), 60.0)
        assert self.command(STOP).state == DONE
        self.watch("stopped on the path", lambda s: s.motion is Motion.STOPPED)
        assert self.still() and stopped_there(), "on the way"
        assert self.command(OVERRIDE, 0, 0.6).state == DONE
        assert self.command(RESUME).state == DONE
        assert self.command(OVERRIDE, 0, 1.0).state == DONE
        self.watch("at rest", lambda s: s.motion is Motion.IDLE, 60.0)
        assert self.still() and not self.state().failed_job
        record = self.run.record()
        return Driven(self.cell, replace(record, rows=tuple(row for row in record.rows if row.stamp_ns >= since)), self.run.p5_ms / 1e3)


@contextlib.contextmanager
def program_run(
    folder: pathlib.Path, cell: str, programs: dict[int, str], name: str = "programs", change: Callable[[str], str] = lambda text: text
) -> Iterator[ProgramRun]:
    """The shipped cell with these programs in place of its own; `change`: of the finished text."""
    head, _, rest = (CELLS / f"{cell}.toml").read_text().partition("[[program]]")
    tables = "".join(f'[[program]]\nnumber = {number}\nfile = "p{number}.txt"\n\n' for number in programs)
    for number, text in programs.items():
        (folder / f"p{number}.txt").write_text(text)
    path = folder / f"{cell}.toml"
    head = head.replace('owner = { "3" = "plc" }', f'owner = {{ "{PROBE >> 3}" = "plc" }}\nassume = {list(INPUT_SIGNALS)}')
    path.write_text(change(head + tables + rest[rest.index("# ---- drives") :]))
    with running_cell(str(path), name) as run, contextlib.closing(ProgramRun(run, programs)) as found:
        yield found


def away(rows: Array, path: Array) -> float:
    """Largest distance of set values from the polyline of a path, m and rad alike."""
    a, way = path[:-1], np.diff(path, axis=0)
    square = np.maximum(np.sum(way * way, axis=1), 1e-18)
    worst = 0.0
    for row in rows:
        share = np.clip(np.sum((row - a) * way, axis=1) / square, 0.0, 1.0)
        worst = max(worst, float(np.min(np.linalg.norm(a + share[:, None] * way - row, axis=1))))
    return worst


def along(state: CellState, path: Array) -> float:
    """Return the share of the path that the set values have covered, by its nearest place."""
    here = np.array([axis.set for axis in state.axes[: path.shape[1]]])
    return int(np.argmin(np.linalg.norm(path - here, axis=1))) / len(path)
