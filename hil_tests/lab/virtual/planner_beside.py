"""The planner's inside beside a cell in virtual time: one turn a cycle, and what the ring carries meanwhile."""

from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.records.planner import PieceRecord, pack_piece, piece_size, run_record, unpack_piece
from gateway.pure.planning.planner import Programs
from gateway.pure.planning.turn import follow, standing

A_CYCLE = 2  # pieces the core takes from the ring


class PlannerBeside:
    """`alive` False: a planner that died; what it had put into the ring is still carried."""

    def __init__(self, programs: Programs, axes: int) -> None:
        self.programs, self.axes, self.alive = programs, axes, True
        self.held: list[PieceRecord] = []

    def turn(self, core: CycleLogic, office: CommandDispatcher) -> None:
        if self.alive:
            said = [run_record(order) for order in office.take_programs()]
            while self.programs.preparing:
                self.programs.prepare(standing(core.state, self.axes))
            while self.programs.working and not self.programs.work():
                pass
            self.held += follow(self.programs, said, core.state, self.axes)
            office.planner = self.programs.state
        for record in self.held[:A_CYCLE]:
            self.feed(core, record)
        del self.held[:A_CYCLE]

    def feed(self, core: CycleLogic, record: PieceRecord) -> None:
        """One record of the ring."""
        core.feed(unpack_piece(pack_piece(record, piece_size(self.axes))))
