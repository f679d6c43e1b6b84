"""A cell of several kinematics in virtual time, each ordered by a command source of its own: dispatcher, planner's inside, core, drives."""

from collections import deque
from collections.abc import Mapping, Sequence

from gateway.assembly.planner import lane_programs_of
from gateway.assembly.programs import mask_of, robot_meant, robots_of, team_meant
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import LaneState
from gateway.pure.image.records.planner import (
    BlockRecord,
    PieceRecord,
    ProgramFacts,
    Say,
    pack_block,
    pack_piece,
    pack_planner,
    piece_size,
    run_record,
    unpack_block,
    unpack_piece,
    unpack_planner,
)
from hil_tests.lab.virtual.cell_bench import CellBench

A_CYCLE = 4  # pieces the core takes from the ring


class Lanes:
    """`texts`: programs by number; `kinematics`: name of the robot each moves, "" where its text says it."""

    def __init__(self, bench: CellBench, texts: Mapping[int, str], kinematics: Mapping[int, str]) -> None:
        self.bench, self.cell = bench, bench.cell
        masks = {n: mask_of(self.cell, robots_of(self.cell, text, kinematics.get(n, ""))) for n, text in texts.items()}
        facts = {n: ProgramFacts(str(n), mask) for n, mask in masks.items()}
        bench.dispatcher = self.dispatcher = CommandDispatcher(bench.dispatcher.axes, bench.dispatcher._plan, 1, facts)
        self.programs = lane_programs_of(
            self.cell,
            lambda named, number: robot_meant(
                self.cell, named, kinematics.get(number, "") if number > 0 else self.cell.robot[-number - 1].name
            ),
            lambda number: texts[number],
            lambda named, _: team_meant(self.cell, named),
            lambda number: masks[number],
        )
        self._held: list[PieceRecord] = []
        self.lines: deque[BlockRecord] = deque()  # of streams, to be said
        self.taken = 1  # of them in a turn
        bench.each = self._turn
        self.dispatcher.planner = self.programs.state
        bench.run(0.3)

    def _turn(self) -> None:
        core, count = self.bench.core, len(self.cell.axis)
        records = [run_record(order) for order in self.dispatcher.take_programs()]
        for _ in range(min(self.taken, len(self.lines))):
            records.append(unpack_block(pack_block(self.lines.popleft())))
        while self.programs.prepare(core.state, count):
            pass
        while self.programs.work():
            pass
        self._held += self.programs.turn(records, core.state, count, len(self._held))
        self.dispatcher.planner = unpack_planner(pack_planner(self.programs.state))
        for record in self._held[:A_CYCLE]:
            core.feed(unpack_piece(pack_piece(record, piece_size(count))))
        del self._held[:A_CYCLE]

    def lane(self, n: int) -> LaneState:
        return self.bench.core.state.lanes[n]

    def sets(self) -> list[float]:
        """Of all axes; mm and deg."""
        return self.bench.set()

    def give(self, source: int, code: Code, mask: int = 0, velocity: float = 1.0, targets: Sequence[float] = ()) -> Job:
        return self.bench.give(code, mask, velocity, tuple(targets), source)

    def order(self, source: int, number: int) -> Job:
        job = self.dispatcher.command(source, Command(Code.PROGRAM, number, 1.0, 1.0), self.bench.now)
        self.bench._hand_over()
        return job

    def stream(self, source: int, robot: int, mask: int, *lines: str) -> Job:
        """Of robot n, from 1: what it says first."""
        job = self.dispatcher.order_stream(source, robot, mask)
        self.bench._hand_over()
        self.say(job, *lines)
        return job

    def say(self, job: Job, *lines: str, end: bool = False) -> None:
        """Statements of a stream, from now on one a turn; nothing follows for the time being, or at all (end)."""
        self.lines.extend(BlockRecord(Say.LINE, job.id, line) for line in lines)
        self.lines.append(BlockRecord(Say.END if end else Say.FINISH, job.id))

    def done(self, source: int, code: Code, mask: int = 0, velocity: float = 1.0) -> Job:
        job = self.bench.settle(self.give(source, code, mask, velocity))
        assert job.state is CommandState.DONE, (code.name, job)
        return job

    def ready(self, source: int, mask: int) -> None:
        """Control of these axes' lanes, override, drives on."""
        for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
            self.done(source, code, mask)
