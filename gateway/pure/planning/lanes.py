"""The planner of a cell of several lanes: a job on each of them, planned in parallel.  Pure.

A program is on the first of the lanes whose axes it moves, as its order is in the cycle.  In a cell of one lane this is Programs and
nothing else.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from gateway.pure.image.records.cell import CellState
from gateway.pure.image.records.planner import BlockRecord, PieceRecord, PlannerState, Say, run_of
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.streams import StreamPrograms
from gateway.pure.planning.turn import busy, follow, positions

REMEMBERED = 64  # jobs whose lane is remembered: the end of a job is reported within a few turns


class LanePrograms:
    """`masks`: axes (bit n-1 = axis n) of each lane; `moved_by`: of a program by its number, of robot n by -n; `names`: of the kinematics
    of the lanes, as far as a lane has one."""

    def __init__(self, cell: CellPrograms, masks: Sequence[int], moved_by: Callable[[int], int], names: Sequence[str] = ()) -> None:
        self.cell = cell
        self.lanes = [StreamPrograms(cell, name) for _, name in zip(masks, (*names, *[""] * len(masks)), strict=False)]
        self._masks, self._moved_by = masks, moved_by
        self._lane_of: dict[int, int] = {}  # job -> lane
        self._share_systems()

    def _share_systems(self) -> None:
        """WC_SYSTEM belongs to a kinematic, whatever lane a program of several was on."""
        for lane in self.lanes[1:]:
            lane.workpiece.active = self.lanes[0].workpiece.active

    @property
    def state(self) -> PlannerState:
        """Of the first lane; of the others in it."""
        first, *others = (lane.state for lane in self.lanes)
        if not others:
            return first
        placed = first.placed
        for other in others:
            placed |= other.placed
        return replace(first, placed=placed, others=tuple(others))

    def follows(self, before: PlannerState) -> None:
        """Adopt the last report of the previous planner."""
        for lane, said in zip(self.lanes, (before, *before.others), strict=False):
            lane.follows(said)
        self._share_systems()

    def turn(
        self, records: Sequence[BlockRecord], state: CellState, count: int, waiting: int = 0, spare: Callable[[], bool] = busy
    ) -> list[PieceRecord]:
        """records: new ones; state: the cycle's, of a cell with `count` axes; waiting: records in the ring of pieces that the cycle has not
        taken; spare: whether there is time for a law that begins in this turn.  What is due for that ring."""
        if len(self.lanes) == 1:
            return follow(self.lanes[0], records, state, count, waiting=waiting, spare=spare)
        heard: list[list[BlockRecord]] = [[] for _ in self.lanes]
        for record in records:
            heard[self._lane(record)].append(record)
        made: list[PieceRecord] = []
        for number, lane in enumerate(self.lanes):
            own = state.lanes[number] if number < len(state.lanes) else None
            made += follow(lane, heard[number], state, count, own, waiting + len(made), spare)
        return made

    def lost(self, count: int) -> None:
        """Statements that did not come; whose they were is not known."""
        for lane in self.lanes:
            lane.lost(count)

    def _lane(self, record: BlockRecord) -> int:
        if record.say in (Say.RUN, Say.STREAM):
            mask = self._moved_by(run_of(record).number if record.say is Say.RUN else -int(record.text))
            self._lane_of[record.job] = next((n for n, own in enumerate(self._masks) if own & mask), 0)
            while len(self._lane_of) > REMEMBERED:
                del self._lane_of[next(iter(self._lane_of))]
        return self._lane_of.get(record.job, 0)

    # ---- work longer than one turn --- -----------------------------------------------------------------------------------
    def prepare(self, state: CellState, count: int) -> bool:
        """Do a slice of each program that is read completely; True: there is more."""
        preparing = [lane for lane in self.lanes if lane.preparing]
        for lane in preparing:
            lane.prepare(positions(state, count))
        return bool(preparing)

    def work(self) -> bool:
        """A slice of each law that is being made; True: there is more."""
        return bool([lane for lane in self.lanes if lane.working and not lane.work()])

    def warnings(self) -> Iterator[tuple[int, str]]:
        """Job and words, each once."""
        for lane in self.lanes:
            for words in lane.slowing.take():
                yield lane.state.job, words
