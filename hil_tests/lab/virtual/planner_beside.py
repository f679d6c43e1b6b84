"""The planner's core next to a cell in virtual time: one turn a cycle, and what the ring carries meanwhile."""

from collections import deque

from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.records.planner import (
    BlockRecord,
    PieceRecord,
    ProgramOrder,
    Say,
    pack_block,
    pack_piece,
    piece_size,
    run_record,
    unpack_block,
    unpack_piece,
)
from gateway.pure.planning.planner import Programs
from gateway.pure.planning.turn import follow, positions

A_CYCLE = 2  # pieces the core takes from the ring


class PlannerBeside:
    """`alive` False: a planner that died; what it had put into the ring is still carried.  `streams`: the texts of programs are sent line
    by line, one a turn, and move as they become known."""

    streams = False

    def __init__(self, programs: Programs, axes: int) -> None:
        self.programs, self.axes, self.alive = programs, axes, True
        self.held: list[PieceRecord] = []
        self.lines: deque[BlockRecord] = deque()  # of streams, to be said one a turn

    def turn(self, core: CycleLogic, dispatcher: CommandDispatcher) -> None:
        if self.alive:
            said = [record for order in dispatcher.take_programs() for record in self._begun(order)]
            if self.lines:
                said.append(unpack_block(pack_block(self.lines.popleft())))
            while self.programs.preparing:
                self.programs.prepare(positions(core.state, self.axes))
            while self.programs.working and not self.programs.work():
                pass
            self.held += follow(self.programs, said, core.state, self.axes, waiting=len(self.held))
            dispatcher.planner = self.programs.state
        for record in self.held[:A_CYCLE]:
            self.feed(core, record)
        del self.held[:A_CYCLE]

    def _begun(self, order: ProgramOrder) -> list[BlockRecord]:
        if order.robot or not self.streams:
            return [run_record(order)]
        self.lines.clear()
        self.say(order.job, *self.programs.cell.text_of(order.number).splitlines())
        self.lines.append(BlockRecord(Say.END, order.job))
        return [BlockRecord(Say.STREAM, order.job, "1")]

    def say(self, job: int, *lines: str, finish: bool = False) -> None:
        """Statements of a stream, from now on one a turn; finish: nothing follows for the time being."""
        self.lines.extend(BlockRecord(Say.LINE, job, line) for line in lines if line.strip())
        if finish:
            self.lines.append(BlockRecord(Say.FINISH, job))

    def feed(self, core: CycleLogic, record: PieceRecord) -> None:
        """One record of the ring."""
        core.feed(unpack_piece(pack_piece(record, piece_size(self.axes))))
