"""One turn of the planner's inside on the published state of the cycle.  Pure."""

from collections.abc import Callable, Sequence

from gateway.pure.image.records.cell import AxisFlag, CellState, LaneState, Motion
from gateway.pure.image.records.planner import BlockRecord, PieceRecord
from gateway.pure.planning.cycle_view import CycleView
from gateway.pure.planning.planner import Programs

ON = int(AxisFlag.ON)


def positions(state: CellState, count: int) -> list[float]:
    """Set values of the first `count` axes; m and rad."""
    return [axis.set for axis in state.axes[:count]]


def busy() -> bool:
    """For a law that a turn has begun there is time in the next one."""
    return False


def follow(
    programs: Programs, records: Sequence[BlockRecord], state: CellState, count: int, lane: LaneState | None = None, waiting: int = 0,
    spare: Callable[[], bool] = busy,
) -> list[PieceRecord]:  # fmt: skip
    """records: new ones; state: the cycle's, of a cell with `count` axes; lane: the one these programs are on, None: the cell is one;
    waiting: records in the ring of pieces that the cycle had not taken when it published the state; spare: whether the turn has time for
    the law that it begins.  What is due for that ring."""
    axes = state.axes[:count]
    own = state if lane is None else lane
    backlog = programs.cell.backlog
    backlog.waiting = waiting
    view = CycleView(
        state.generation,
        own.piece,
        positions(state, count),
        moving=own.motion is not Motion.IDLE,
        taken=state.taken,
        failed=programs.state.job if state.failure(programs.state.job) else 0,
        parts=own.parts,
        engaged=state.engaged,
        met=own.met,
        measured=[axis.measured if state.measured_mask >> n & 1 else None for n, axis in enumerate(axes)],
        override=own.override,
        off=sum([1 << n for n, axis in enumerate(axes) if not int(axis.flags) & ON]),
        waiting=backlog.waiting,
        reached=backlog.reached,
        way=own.progress,
    )
    made = programs.turn(records, view)
    while programs.working and spare():
        if programs.work():
            made += programs.go_on()
            break
    if made:
        programs.handed_on(backlog.add(len(made)))
    return made
