"""The planner process: it receives programs by a ring and sends motion pieces by another.  It may die between any two writes: the cycle's
remaining pieces end at rest on the path, and nothing moves again without a new order.
"""

import argparse
import contextlib
import pathlib
import select
import signal
import time
from collections.abc import Sequence

from gateway.assembly.planner import lane_programs_of
from gateway.assembly.program_memory import in_memory, memory_folder
from gateway.assembly.programs import machines_of_cell, mask_of, read_bnr, robot_meant, team_meant
from gateway.assembly.run import RunPlan, load_plan
from gateway.files.find import read_text
from gateway.pure.image.records.cell import CELL_STATE_LAYOUT, CellState, unpack_cell_state
from gateway.pure.image.records.planner import (
    PIECE_LAYOUT,
    SAY_LAYOUT,
    TAKEN_LAYOUT,
    BlockRecord,
    PlannerState,
    pack_piece,
    pack_planner,
    unpack_block,
    unpack_planner,
    unpack_taken,
)
from gateway.pure.planning.trial import Files
from gateway.runtime.journal import Journal
from gateway.runtime.realtime import Timerfd, die_with_parent, go_ahead
from gateway.runtime.regions import RegionReader, RegionWriter, RingReader, RingWriter, fds_from_text
from motion.errors import MotionError
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.program.team import Kinematic

TURN_NS = 5_000_000
TAKEN = 64  # block records a turn: a long program does not keep the life counter waiting
WORKING_NS = 20_000_000  # per turn at most, for lines of a program that is read completely, and for a law that takes long


class PlannerProcess:
    """One run's planner."""

    def __init__(self, plan: RunPlan, fds: dict[str, int]) -> None:
        self.plan = plan
        self.journal = Journal(plan.journal, "planner")
        self.axes = RegionReader(fds["axes"], "axes", CELL_STATE_LAYOUT)
        self.blocks = RingReader(fds["blocks"], "blocks", SAY_LAYOUT)
        self.lines = RingReader(fds["lines"], "lines", SAY_LAYOUT) if "lines" in fds else None
        self.pieces = RingWriter(fds["pieces"], "pieces", PIECE_LAYOUT)
        self.taken = RegionReader(fds["pieces-taken"], "pieces-taken", TAKEN_LAYOUT)
        self.region = RegionWriter(fds["planner"], "planner")
        self.count = len(plan.cell.axis)
        self.programs = lane_programs_of(plan.cell, self.machine, self.text, self.team, self._mask)
        self.programs.cell.files = Files(self.file, plan.p5_ms * 1000)
        self.programs.cell.systems = self.count + len(plan.cell.belt)
        self._said: PlannerState | None = None  # packed last
        self._packed = b""
        said = self.region.latest()
        if said is not None:
            self.programs.follows(unpack_planner(said))
        self._reported: dict[int, tuple[int, str]] = {}  # lane -> fault in the journal
        self._stop = False
        self._gaps = 0  # statements lost so far

    def machine(self, name: str, number: int) -> Machine:
        """The cell's robot, which a program names or not, or the one of a stream; raises MotionError."""
        if number < 0:
            return machines_of_cell(self.plan.cell)[-number - 1]
        tables = {each.number: each.kinematics for each in self.plan.cell.program}
        machine = robot_meant(self.plan.cell, name, tables.get(number, ""))
        self._as_ordered(machine, number)
        return machine

    def team(self, kinematics: Sequence[Kinematic], number: int) -> Team:
        """The robots a program of several kinematics names; raises MotionError."""
        team = team_meant(self.plan.cell, kinematics)
        self._as_ordered(team, number)
        return team

    def _as_ordered(self, robots: Machine | Team, number: int) -> None:
        """Programs in orders were checked with the axes they had when the run began."""
        if number in self.plan.programs and mask_of(self.plan.cell, robots) & ~self.plan.programs[number].mask:
            raise MotionError(f"program {number} moves other robots than when the run began: start the gateway again")

    def text(self, number: int) -> str:
        """The program as it is in its file now; raises MotionError."""
        try:
            return read_text(pathlib.Path(self.plan.programs[number].path))
        except (KeyError, OSError, UnicodeDecodeError) as error:
            raise MotionError(f"program {number}: {error}") from error

    def file(self, name: str, number: int) -> bytes:
        """A BNR file next to the program, or for a stream in the memory of its programs or next to the cell, as it is now; raises
        MotionError.
        """
        if number in self.plan.programs:
            return read_bnr(self.plan.programs[number].path, name)
        folder = memory_folder(self.plan.cell)
        path = in_memory(folder, name) if folder is not None else pathlib.Path(self.plan.cell.file).with_name(name)
        return read_bnr(str(path), path.name)

    def _mask(self, number: int) -> int:
        """Axes that a program moves; 0: no such program, which its order reports."""
        return self.plan.programs[number].mask if number in self.plan.programs else 0

    def run(self) -> None:
        """Until SIGTERM."""
        signal.signal(signal.SIGTERM, self._on_signal)
        timer = Timerfd()
        timer.set(time.monotonic_ns() + TURN_NS, TURN_NS)
        while not self._stop:
            select.select([timer], (), ())
            if timer.expired():
                self.turn()
        timer.close()
        self.journal.close()

    def _on_signal(self, number: int, frame: object) -> None:
        self._stop = True

    def turn(self) -> None:
        """New statements, state of the cycle, pieces that are due."""
        now = time.monotonic_ns()
        taken = self.taken.read()  # before the state: it includes what counts as taken
        payload = self.axes.read()
        state = CellState() if payload is None else unpack_cell_state(payload)
        records = heard(self.blocks, self.lines)
        self._look_for_gaps()

        def spare() -> bool:
            return time.monotonic_ns() - now < WORKING_NS

        while spare() and self.programs.prepare(state, self.count):
            pass
        while spare() and self.programs.work():
            pass
        waiting = 0 if taken is None else max(self.pieces.published - unpack_taken(taken), 0)
        pieces = self.programs.turn(records, state, self.count, waiting, spare)
        said = self.programs.state
        self._report(said)
        if said != self._said:
            self._said, self._packed = said, pack_planner(said)
        self.region.write(self._packed, now)  # the text of a fault is published before the cycle receives it
        for record in pieces:
            self.pieces.put(pack_piece(record, self.pieces.size))
        self.region.beat(time.monotonic_ns())

    def _look_for_gaps(self) -> None:
        """A writer that lapped us has overwritten statements: the streams they may have belonged to are over."""
        gaps = self.blocks.gaps + (self.lines.gaps if self.lines is not None else 0)
        if gaps > self._gaps:
            self.programs.lost(gaps - self._gaps)
        self._gaps = gaps

    def _report(self, state: PlannerState) -> None:
        for lane, own in enumerate((state, *state.others)):
            fault = (own.failed_job, own.fault)
            if fault != self._reported.get(lane, (0, "")) and own.fault:
                self.journal.write("program", own.fault, job=own.failed_job, block=own.fault_block, code=own.fault_code)
            self._reported[lane] = fault
        for job, words in self.programs.warnings():
            self.journal.write("program", words, job=job, warning=True)


def heard(blocks: RingReader, lines: RingReader | None) -> list[BlockRecord]:
    """New records of the services, then statements of the interpreter.

    A statement is written when its stream is ordered: for statements present before the orders were read, the streams are known. One that
    arrives later waits for the next turn, because the planner would not know its job and drop it (AX-1691).
    """
    known = 0 if lines is None else lines.waiting
    records = [unpack_block(data) for _, data in blocks.take(TAKEN)]
    if lines is not None and known and len(records) < TAKEN:  # more orders may wait, and a stream among them
        records += [unpack_block(data) for _, data in lines.take(min(known, TAKEN))]
    return records


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate planner", description="the planner process; started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    go_ahead()  # like the services: their work for many partners must not starve it
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with contextlib.suppress(KeyboardInterrupt):
        PlannerProcess(load_plan(arguments.plan), fds_from_text(arguments.fds)).run()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
