"""Streams of blocks that a commissioning tool writes itself: statements of the text form in, answers by block out (AX-970)."""

from collections.abc import Sequence
from dataclasses import dataclass

from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.image.reasons import Reason, text
from gateway.pure.image.records.planner import TEXT_BYTES, BlockRecord, PlannerState, Say
from gateway.pure.planning.ahead import room

AHEAD = 512  # blocks sent and not finished
ORDERS = ("hold", "go", "retrace", "flush", "cut", "single", "step", "end_here")
MOVES = ("ptp", "linear", "circular", "spline", "move", "move_file")
THEN = {"": None, "finish": Say.FINISH, "end": Say.END}


@dataclass(slots=True)
class _Stream:
    """blocks, records: number sent to it."""

    job: Job
    blocks: int = 0
    records: int = 0


class ToolStreams:
    """One at a time of each lane."""

    def __init__(self, dispatcher: CommandDispatcher, statements: list[BlockRecord]) -> None:
        """statements: for the planner, after its orders."""
        self._dispatcher, self._statements = dispatcher, statements
        self._streams: dict[int, _Stream] = {}

    def begin(self, job: Job) -> None:
        """Nothing has been sent to it yet; finished ones are removed."""
        self._streams = {number: each for number, each in self._streams.items() if each.job.open} | {job.id: _Stream(job)}

    def say(self, job: Job, lines: Sequence[str], then: str) -> None:
        """Statements; then: "finish", nothing follows for the time being, "end", nothing follows.  ValueError: none of them is accepted."""
        if not job.open:
            raise ValueError(_over(job))
        if then not in THEN:
            raise ValueError(f"then {then!r}; finish, end are known")
        long = next((n for n, line in enumerate(lines, 1) if len(line.encode()) > TEXT_BYTES), 0)
        if long:
            raise ValueError(f"statement {long} has more than {TEXT_BYTES} bytes")
        blocks = sum(line.split()[:1] != [] and line.split()[0] in MOVES for line in lines)
        stream, state = self._streams.setdefault(job.id, _Stream(job)), self._state(job)
        waiting = stream.blocks - state.passed
        if waiting + blocks > AHEAD:
            raise ValueError(f"{waiting} blocks wait, {AHEAD} may: say more when some of them are over")
        mark = THEN[then]
        if self._floods(stream, len(lines) + (mark is not None), state.heard):
            return
        stream.blocks += blocks
        self._add(stream, *(BlockRecord(Say.LINE, job.id, line) for line in lines))
        if mark is not None:
            self._add(stream, BlockRecord(mark, job.id))

    def _floods(self, stream: "_Stream", count: int, heard: int) -> bool:
        """More statements than the ring can hold besides those of the other lanes: only this stream ends (AX-1788)."""
        most = room(self._dispatcher.planner or PlannerState())
        if stream.records - heard + count <= most:
            return False
        self._add(stream, BlockRecord(Say.LOST, stream.job.id, f"{count} {most}"))
        return True

    def _add(self, stream: "_Stream", *records: BlockRecord) -> None:
        stream.records += len(records)
        self._statements += records

    # ---- orders ------------------------------------------------------------------------------------------------------------
    def order(self, job: Job, what: str, block: int | None, *, on: bool) -> None:
        """One of ORDERS (AX-1080).  block: of "cut"; on: of "single".  ValueError, Refusal: nothing is done."""
        if not job.open:
            raise ValueError(_over(job))
        state, stream = self._state(job), self._streams.setdefault(job.id, _Stream(job))
        if state.bound and what in ("hold", "retrace", "flush", "cut", "end_here"):
            raise ValueError(f"{what}: block {state.block} follows {state.bound}, which cannot wait: stop ends the stream")
        match what:
            case "hold":
                self._dispatcher.hold_move(job)
            case "go" | "retrace":
                self._dispatcher.go_on_with(job, back=what == "retrace")
            case "flush" | "end_here":
                self._dispatcher.hold_move(job)  # the axes brake at once, the planner drops the waiting pieces
                job.reason, job.detail = Reason.NONE, ""
                self._add(stream, BlockRecord(Say.FLUSH, job.id), *([BlockRecord(Say.END, job.id)] if what == "end_here" else []))
            case "cut":
                self._cut(stream, state, block)
            case "single":
                self._forward(what, state)
                self._add(stream, BlockRecord(Say.SINGLE, job.id, "on" if on else "off"))
            case "step":
                self._forward(what, state)
                if not state.withheld and state.passed >= stream.blocks:
                    raise ValueError("step: no block waits; say the next one first")
                self._add(stream, BlockRecord(Say.STEP, job.id))
            case _:
                raise ValueError(f"do {what!r}; begin, say, look, {', '.join(ORDERS)} are known")

    def _cut(self, stream: _Stream, state: PlannerState, block: int | None) -> None:
        said = stream.blocks
        if block is None or not 0 <= block <= said:
            raise ValueError(f"cut after block {block}; the stream has blocks 1 .. {said}" if said else "cut: the stream has no block")
        under_way = max(state.block, min(state.passed + 1, said))
        if block < under_way:
            raise ValueError(f"cut after block {block}: the axes are in block {under_way}; cut after that one, or flush")
        self._forward("cut", state)
        self._add(stream, BlockRecord(Say.CUT, stream.job.id, str(block)))

    @staticmethod
    def _forward(what: str, state: PlannerState) -> None:
        if state.back:
            raise ValueError(f"{what}: the axes have gone back to block {state.block}: continue first")

    def _state(self, job: Job) -> PlannerState:
        planner = self._dispatcher.planner
        found = PlannerState() if planner is None else planner.of(job.id)
        return found if job.id in (found.job, found.failed_job, found.job_before) else PlannerState()

    def answer(self, job: Job) -> dict[str, object]:
        """Blocks sent and finished, the one in progress, inputs met or not, the fault with its block and number."""
        state, si = self._state(job), [axis.si for axis in self._dispatcher.axes]
        answers = [
            {"block": block, "met": met, "places": [None if at is None else at / one for at, one in zip(places, si, strict=False)]}
            for block, met, places in state.answers
        ]
        return {
            "said": self._streams[job.id].blocks if job.id in self._streams else 0,
            "passed": state.passed,
            "block": state.block,
            "share": state.share,
            "answers": answers,
            "fault": state.fault if state.failed_job == job.id else "",
            "fault_block": state.fault_block if state.failed_job == job.id else 0,
            "fault_code": state.fault_code if state.failed_job == job.id else 0,
            "withheld": state.withheld,
            "order_fault": state.order_fault,
            **self._motion(job, state, si),
        }

    def _motion(self, job: Job, state: PlannerState, si: list[float]) -> dict[str, object]:
        """Where the axes of the stream are, in their own units, and where they were measured last; whether they move, and which way."""
        cell = self._dispatcher.cell
        if cell is None:
            return {}
        own = [(n, one) for n, one in enumerate(si) if job.mask >> n & 1]
        return {
            "motion": cell.motion_of(job.span).name,
            "back": state.back,
            "position": [cell.axes[n].set / one for n, one in own],
            "measured": [cell.axes[n].measured / one if cell.measured_mask >> n & 1 else None for n, one in own],
        }


def _over(job: Job) -> str:
    """Why it accepts nothing any more."""
    why = job.detail or (text(job.reason) if job.reason is not Reason.NONE else "")
    return f"the stream is over: {job.state.name.lower()}" + (f": {why}" if why else "")
