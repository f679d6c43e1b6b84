"""Streams of blocks that a commissioning tool writes itself: statements of the text form in, answers by block out (AX-970)."""

from collections.abc import Sequence

from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.image.records.planner import TEXT_BYTES, BlockRecord, PlannerState, Say

AHEAD = 512  # blocks said and not over
MOVES = ("ptp", "linear", "circular", "spline", "move", "move_file")
THEN = {"": None, "finish": Say.FINISH, "end": Say.END}


class ToolStreams:
    """One at a time of each lane."""

    def __init__(self, office: CommandDispatcher, statements: list[BlockRecord]) -> None:
        """statements: what goes to the planner behind its orders."""
        self._office, self._statements = office, statements
        self._said: dict[int, int] = {}  # job -> blocks

    def begin(self, job: Job) -> None:
        """Nothing is said of it yet; those that are over are forgotten."""
        self._said = {job.id: 0}

    def say(self, job: Job, lines: Sequence[str], then: str) -> None:
        """Statements; then: "finish", nothing follows for the time being, "end", nothing follows.  ValueError: none of them is taken."""
        if not job.open:
            raise ValueError(f"the stream is over: {job.state.name.lower()} {job.detail}".rstrip())
        if then not in THEN:
            raise ValueError(f"then {then!r}; finish, end are known")
        long = next((n for n, line in enumerate(lines, 1) if len(line.encode()) > TEXT_BYTES), 0)
        if long:
            raise ValueError(f"statement {long} has more than {TEXT_BYTES} bytes")
        blocks = sum(line.split()[:1] != [] and line.split()[0] in MOVES for line in lines)
        waiting = self._said.get(job.id, 0) - self._state(job).passed
        if waiting + blocks > AHEAD:
            raise ValueError(f"{waiting} blocks wait, {AHEAD} may: say more when some of them are over")
        self._said[job.id] = self._said.get(job.id, 0) + blocks
        self._statements += [BlockRecord(Say.LINE, job.id, line) for line in lines]
        mark = THEN[then]
        if mark is not None:
            self._statements.append(BlockRecord(mark, job.id))

    def _state(self, job: Job) -> PlannerState:
        planner = self._office.planner
        found = PlannerState() if planner is None else planner.of(job.id)
        return found if job.id in (found.job, found.failed_job) else PlannerState()

    def answer(self, job: Job) -> dict[str, object]:
        """Blocks said and over, the one under way, inputs that came or not, the fault with its block and number."""
        state, si = self._state(job), [axis.si for axis in self._office.axes]
        answers = [
            {"block": block, "met": met, "places": [None if at is None else at / one for at, one in zip(places, si, strict=False)]}
            for block, met, places in state.answers
        ]
        return {
            "said": self._said.get(job.id, 0),
            "passed": state.passed,
            "block": state.block,
            "share": state.share,
            "answers": answers,
            "fault": state.fault if state.failed_job == job.id else "",
            "fault_block": state.fault_block if state.failed_job == job.id else 0,
        }
