"""A portal that a correction moves, in virtual time: dispatcher, planner's inside, core with [alter], emulated drives; no process."""

import pathlib
import re
import struct
from collections.abc import Callable

from gateway.assembly.alter import alter_of_cell
from gateway.assembly.axes import core_axes
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.cycle.core_settings import CoreParts
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import CellState, Motion, Quality, pack_cell_state, unpack_cell_state
from hil_tests.lab.virtual.cell_bench import CellBench
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot

PORTAL = pathlib.Path(__file__).parents[3] / "configs" / "cells" / "portal.toml"
P5_MS = 8
INPUT, LIFE, STATUS, WAIT = 512, 616, 512, 464
BYTES = (*range(INPUT >> 3, (INPUT >> 3) + 12), LIFE >> 3)
ALTER = f"[alter]\ninput = {INPUT}\nlife = {LIFE}\nstatus = {STATUS}\nevery_ms = 16\n\n"
HEAD = "robot portal\nangles val3\naxes mm mm mm deg\nstart 100 100 50 0\n"


def with_alter(text: str, table: str = ALTER) -> str:
    """The portal's cell file with a correction from the PLC, and absolute axes that are where programs begin."""
    text = re.sub(r'home            = \{ by = "gateway".*\}', 'home            = { by = "none" }', text)
    for axis, place in (("X", 100.0), ("Y", 100.0), ("Z", 50.0), ("C", 0.0)):
        text = re.sub(rf"(\[plant\.axis\.{axis}\][^\[]*?start +=) [\d.]+", rf"\g<1> {place}", text)
    owners = ", ".join(f'"{byte}" = "plc"' for byte in (WAIT >> 3, (LIFE >> 3) - 1, *BYTES))  # a register is written whole
    text = re.sub(r"owner = \{.*\}", f"owner = {{ {owners} }}", text)
    return text.replace("# ---- the emulated machine", table + "# ---- the emulated machine")


CELL = load_cell(str(PORTAL), with_alter(PORTAL.read_text()))


class AlterRobot(ServodynRobot):
    """With a correction."""

    def _new_core(self) -> CycleLogic:
        period = self.period_ns / 1e9
        return CycleLogic(
            core_axes(self.cell, self.p5_ms), period, self.generation, parts=CoreParts(alter=alter_of_cell(self.cell, self.p5_ms))
        )


class AlterBench(Planned):
    """Command source 1 orders programs and writes the correction: `correct` returns it (mm, deg) for each cycle in which it is sent."""

    def __init__(self, robot: CellBench | None = None) -> None:
        self.speaks = True
        self.correct: Callable[[], tuple[float, ...]] = lambda: (0.0,) * 6
        self.seen: list[CellState] = []
        super().__init__(robot or AlterRobot(P5_MS, cell=CELL))
        self.programs.cell.altered = (1,)
        self.home()

    def home(self) -> "AlterBench":
        """Drives on, a correction that is alive and 0, the axes where programs begin."""
        self.speaks, self.planner.alive, self.correct = True, True, lambda: (0.0,) * 6
        self.bench.permit(WAIT, value=False)
        if self.state.motion is not Motion.IDLE:  # what another test left behind
            for code in (Code.STOP, Code.ABANDON):
                self.bench.settle(self.bench.give(code, 0xF))
            self.until(lambda s: s.motion is Motion.IDLE)
        assert self.bench.settle(self.bench.give(Code.ENABLE, 0xF)).state is CommandState.DONE
        if max(abs(a - b) for a, b in zip(self.bench.set(), (100.0, 100.0, 50.0, 0.0), strict=True)) > 1e-9:
            assert self.finished(self.begin("ptp joints 100 100 50 0")).state is CommandState.DONE
        self.driven()
        return self

    def _turn(self) -> None:
        super()._turn()
        inputs = self.bench.inputs
        self.seen.append(unpack_cell_state(pack_cell_state(self.state)))
        for octet in BYTES:
            inputs.quality[octet] = Quality.GOOD
        if self.speaks:
            struct.pack_into(">6h", inputs.values, INPUT >> 3, *(round(100.0 * value) for value in self.correct()))
            inputs.values[LIFE >> 3] = (inputs.values[LIFE >> 3] + 1) & 0xFF

    def begin(self, *lines: str) -> Job:
        """Command source 1 orders a program of these lines."""
        self.seen.clear()
        return self.order(HEAD + "\n".join(lines))

    def finished(self, job: Job) -> Job:
        """Runs until the job has an outcome and the axes rest."""
        self.bench.settle(job)
        self.until(lambda s: s.motion is Motion.IDLE)
        self.bench.run(0.04)
        return job

    def answer(self) -> tuple[int, int, int]:
        """Answer to alter(), mode, alterStopTime in ms, as the command source reads them."""
        answer, mode, left = struct.unpack_from(">bBh", self.bench.core.outputs, STATUS >> 3)
        return answer, mode, left

    def still(self) -> bool:
        """No set value changes any more."""
        before = self.bench.set()
        self.bench.run(0.3)
        return max(abs(a - b) for a, b in zip(before, self.bench.set(), strict=True)) < 1e-9
