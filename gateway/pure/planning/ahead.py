"""How far the statements of a stream may be ahead of the planner: the ring to it is one for all lanes of a cell (AX-1788).  Pure."""

from gateway.pure.image.records.planner import BLOCKS, BlockRecord, PlannerState, Say

KEPT = 64  # records of the ring that orders to the cell and to streams have for themselves
REMEMBERED = 64  # streams that are counted; of older ones nothing comes any more


def room(planner: PlannerState) -> int:
    """Return how many statements of one stream may be in transit, in addition to those of the other lanes."""
    return BLOCKS // (1 + len(planner.others)) - KEPT


class StatementsAhead:
    """Of the streams of an interpreter, whose programs do not know how many statements wait."""

    def __init__(self) -> None:
        self._said: dict[int, int] = {}  # job -> records
        self._read: dict[int, int] = {}  # job -> how many of them were read, as last reported by the planner
        self._over: set[int] = set()  # jobs that have lost one

    def passed(self, record: BlockRecord, planner: PlannerState) -> BlockRecord | None:
        """Return what enters the ring: the record; without room for it a report that its stream has lost statements, and then nothing more
        of that stream.
        """
        job = record.job
        if job in self._over:
            return None
        said = self._said.setdefault(job, 0)
        self._forget()
        state = planner.of(job)
        if state.job == job:
            self._read[job] = state.heard
        if said - self._read.get(job, 0) >= (most := room(planner)):
            self._over.add(job)
            return BlockRecord(Say.LOST, job, f"1 {most}")
        self._said[job] = said + 1
        return record

    def _forget(self) -> None:
        while len(self._said) > REMEMBERED:
            oldest = next(iter(self._said))
            del self._said[oldest]
            self._read.pop(oldest, None)
            self._over.discard(oldest)
