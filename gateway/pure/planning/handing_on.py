"""What of a job is handed on to the cycle: pieces that are due, the marks on them, where parts end.  Pure."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from gateway.pure.image.records.planner import VOID, Part, PieceRecord, PlannerState, SwitchAt, job_over, restated, switch_record
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.chain import Chain
from gateway.pure.planning.cycle_view import ALWAYS, CycleView
from gateway.pure.planning.job import Job
from gateway.pure.planning.parts import Measuring, ending, later_fault
from gateway.pure.planning.reading import Reading
from gateway.pure.planning.team import machines_in
from gateway.pure.planning.trial import Files, Trial
from gateway.pure.planning.warnings import Slowing
from gateway.pure.planning.workpiece_systems import CellSystems
from motion.errors import MotionError
from motion.execution.timed import encode_timed
from motion.planner.file_plan import FilePlan
from motion.planner.marks import Mark, at_rest
from motion.planner.planner import LEAD_S, Planner
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.program.errors import BlockError, TextError
from motion.program.text.reader import Reader
from motion.program.text.team import TeamReader
from motion.sync.facts import BeltFacts

CARRIED_S = 0.003  # transfer time of a piece through the ring; a new tail has about as many pieces as the one that it replaces
TAKEN_S = 0.0035  # the same where the cycle reads only one piece a period: a long tail with less time comes too late
QUIET_TURNS = 6  # turns without a new block after which the known blocks are run


class HandingOn:
    """One job: the current part, and how much of it the cycle has.  Its parts are made in gateway.pure.planning.planner."""

    def __init__(self, cell: CellPrograms, lane: str = "") -> None:
        """lane: name of its kinematic, in a cell where each moves independently."""
        self.cell, self._lane = cell, f"{lane}: " if lane else ""
        self.slowing = Slowing()  # sentences about blocks that have begun
        self.workpiece = CellSystems()
        self.state = PlannerState()
        self._job = Job(Trial((), Files()), Measuring({}))
        self._out: list[PieceRecord] = []
        self._quiet = 0
        self._chain = Chain()
        self._seen = CycleView()  # of the turn before
        self._belts: Sequence[BeltFacts] = ()  # as programs have set them since the cycle began (SF 21)
        self._reading = Reading()  # records, and lines of a program of the cell

    @property
    def generation(self) -> int:
        """Of the cycle it works for."""
        return self._seen.generation

    def _robots(self) -> Machine | Team:
        """Those the text names, or whose stream it is; raises MotionError."""
        read, job = self._job.reader, self._job
        if job.robots is None:
            whose = self.cell.team_of(read.kinematics(), job.number) if isinstance(read, TeamReader) else None
            job.robots = whose or self.cell.machine_of(read.robot if isinstance(read, Reader) else "", job.number)
        return job.robots

    def _own_places(self, position: Sequence[float]) -> list[float]:
        """Return the positions of the job's robots; position: that of all axes of the cell."""
        mask = self.cell.mask_of(self._robots())
        return [position[n] for n in range(len(position)) if mask >> n & 1]

    def _made(self, position: Sequence[float], robots: Machine | Team | None = None) -> Planner:
        """robots: that move, where not all of the job do."""
        machine = robots or self._robots()
        mask = self.cell.mask_of(machine)
        places = [position[n] for n in range(len(position)) if mask >> n & 1]
        chain, job = self._chain, self._job
        return Planner(machine, places, mask=mask, capacity=1 << 20, next_id=chain.spare, factors=job.factors, cuts=job.streams)

    @property
    def working(self) -> bool:
        """A law is being made: work() continues it between two turns when there is time."""
        return self._job.planner is not None and self._job.planner.working

    def work(self) -> bool:
        """One slice of it; True: it is made, and its pieces come with the next turn."""
        try:
            return self._job.planner is None or self._job.planner.work()
        except MotionError as error:
            self._fail_in_part(error)
            return True

    def _fail_in_part(self, error: MotionError) -> None:
        """Fail like _fail; the maker of the law counts the blocks of the current part."""
        self._fail(later_fault(error, self._job.before) if isinstance(error, BlockError) else error)

    def _fail(self, error: MotionError) -> None:
        if isinstance(error, TextError) and not error.line:  # blocks of a stream have numbers and no lines
            error = BlockError(f"{error.key}: {error.what}" if error.key else error.what, block=len(self._job.line_of) + 1)
        block, code = (error.block, error.code) if isinstance(error, BlockError) else (0, 0)
        line = self._job.line_of[block - 1] if 0 < block <= len(self._job.line_of) else 0
        words = self._lane + (f"line {line}: {error}" if line and not isinstance(error, TextError) else str(error))
        job = self.state.job
        self.state = replace(
            self.state, failed_job=job, fault=words, fault_block=block, fault_code=code, job=0, ended=True, waiting=0, warning=""
        )
        self._job.over()
        self._reading.stop()
        self._out.append(PieceRecord(Part.FAULT, job, self.generation))

    def _plan(self) -> None:
        planner, state, piece = self._job.planner, self.state, self._seen.piece
        if not state.job or self._job.lines is not None or self._seen.taken < state.job or self._job.handed:
            return
        if planner is None:
            if self._job.ended and not state.ended:  # a program without blocks
                self.state = job_over(state, ended=True)
                self.workpiece.reached(ALWAYS)
                self._out.append(PieceRecord(Part.LAST, state.job, self.generation))
            return
        waits = self._chain.sent > self._seen.reached
        tau = self._chain.tau(piece, planner.end, waits=waits)
        before = len(self._out)
        try:
            self._hand_on(planner, tau)
        except MotionError as error:
            self._fail_in_part(error)
            return
        self._chain.forget()
        block, share = planner.place(self._chain.near_to(tau, piece, self._seen.position, self._seen.way))
        block = max(block, min(self._job.blocks, 1))  # a part that has begun is at its first block, whether its path is there or not
        over = self._job.closed and not planner.open and not state.ended
        last = over and self._job.last_part
        if over and self._job.streams and isinstance(planner, Planner):
            self._mark(at_rest(each)._replace(piece=self._chain.spare) for each in planner.left())
        if over and not last:
            self._job.handed, self._job.blocks = True, planner.added
            self._rest(planner)
        if last:
            self._out.append(PieceRecord(Part.LAST, state.job, self.generation))
        new, speed = len(self._out) - before, self._job.factors.velocity * self._seen.override
        state = self.state
        passed = self._job.before + self._chain.passed(piece, planner.added if not planner.open else 0)
        warning = self.slowing.look(planner.slowed, self._job.before, block, speed, self._job.line_of)
        waiting, block, ended = planner.waiting, self._job.before + block, state.ended or last
        was = state.block, state.share, state.passed, state.waiting, state.ended, state.warning
        if new or was != (block, share, passed, waiting, ended, warning):
            handed = state.handed + new
            self.state = restated(
                state, block=block, share=share, passed=passed, waiting=waiting, handed=handed, ended=ended, warning=warning
            )
        if self.state.ended and not (self._seen.moving or waits or new) and piece in (0, self._chain.last_id):
            self.state = job_over(self.state, warning="")
            self.workpiece.reached(ALWAYS)

    def _rest(self, planner: Planner | FilePlan) -> None:
        """The part under way ends where its path does, and another one follows."""
        later, job, generation = self._job.trial.later, self.state.job, self.generation
        self._out.append(ending(later[0], self._belts, job, generation) if later else PieceRecord(Part.REST, job, generation))
        if later and later[0].inside is not None:  # what follows begins there, on the belt
            self._job.start = planner.position
            self._job.begins(later.popleft())

    def _mark(self, marks: Iterable[Mark]) -> None:
        assert self._job.planner is not None
        for mark in marks:
            machine = machines_in(self._job.planner.machine)[mark.member]
            own = self.cell.mask_of(machine), self.cell.kinematic_of(machine)
            self._out.append(self._job.measuring.marked(mark, *own, self.state.job, self.generation))

    def _hand_on(self, planner: Planner | FilePlan, tau: float) -> None:
        """Pieces that are due; raises MotionError where a path has no law."""
        if self._chain.full:
            return
        job = self.state.job
        if isinstance(planner, Planner):
            planner.queued_s = TAKEN_S * self._seen.waiting
        if isinstance(planner, Planner) and (self._job.streams or planner.searched):  # a new tail counts when all of it is there
            planner.lead_s, planner.carried_s = LEAD_S + CARRIED_S * self._chain.ahead, TAKEN_S
        planner.begin(tau, hurry=self._quiet > QUIET_TURNS)
        planner.work()
        pieces = planner.take()
        marks, begins = planner.take_marks(), planner.begins if pieces else {}
        for made in pieces:
            if made.new_tail:
                self._out.append(switch_record(job, self.generation, SwitchAt(made.id, 0.0, VOID)))
            self._chain.add(made, begins[made.id], planner.passed(begins[made.id]) if isinstance(planner, Planner) else 0, self._job.before)
            self._mark(mark for mark in marks if mark.piece == made.id)
            self._out.append(PieceRecord(Part.PIECE, job, self.generation, encode_timed(made)))
