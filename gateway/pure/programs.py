"""The planner process without its rings: records in, records out, once a turn.  Pure.

A job is a program: BEGIN, statements of the text form, FINISH as often as wanted, END.  Nothing of a job is handed to the cycle before
FINISH, END or enough look-ahead; a fault in a block ends the job, and what was handed on before ends at rest.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from gateway.pure.plannerrecords import AHEAD, BlockRecord, Part, PieceRecord, PlannerState, Say
from motion.errors import MotionError
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.program.errors import BlockError
from motion.program.text import Reader
from motion.timed import encode_timed

QUIET_TURNS = 6  # turns without a new block after which what is known is run


@dataclass
class Programs:
    """One kinematic of a run.  machine_of: robot name -> machine (a file is read there: not this module's business)."""

    machine_of: Callable[[str], Machine]
    mask_of: Callable[[Machine], int]
    state: PlannerState = PlannerState()
    generation: int = 0
    _planner: Planner | None = None
    _reader: Reader = field(default_factory=Reader)
    _quiet: int = 0
    _ended: bool = False
    _last_id: int = 0  # of the pieces handed on
    _begins: dict[int, float] = field(default_factory=dict)  # piece -> tau
    _spare: int = 1  # ids go on over jobs: a chain never meets an older number

    def turn(
        self, records: Sequence[BlockRecord], generation: int, piece: int, standing: Sequence[float], *, moving: bool
    ) -> list[PieceRecord]:
        """records: new ones; generation, piece, standing, moving: of the cycle (piece 0: none under way)."""
        out: list[PieceRecord] = []
        if generation != self.generation:
            self.generation = generation
            self._drop(standing)
        self._quiet += 1
        for record in records:
            out += self._heard(record, standing, moving)
        return out + self._plan(piece, moving)

    # ---- what is said ------------------------------------------------------------------------------------------------------
    def _heard(self, record: BlockRecord, standing: Sequence[float], moving: bool) -> list[PieceRecord]:
        self._quiet = 0
        if record.say is Say.DROP:
            self._drop(standing)
            return []
        if record.say is Say.BEGIN:
            if self.state.job and not self._ended:
                return []  # one job at a time; whoever orders sees that its job did not begin
            self.state = PlannerState(job=record.job, failed_job=self.state.failed_job)
            self._reader, self._planner, self._ended = Reader(), None, False
        if record.job != self.state.job:
            return []
        try:
            self._obey(record, standing)
        except MotionError as error:
            self._fail(error, standing)
        return []

    def _obey(self, record: BlockRecord, standing: Sequence[float]) -> None:
        if record.text:
            self._reader.statement(record.text)
        for block in self._reader.take():
            planner = self._planner = self._planner or self._made(standing)
            planner.add(block)
        if record.say is Say.FINISH and self._planner is not None:
            self._planner.finish()
            self._quiet = QUIET_TURNS
        if record.say is Say.END:
            self._ended = True
            if self._planner is not None:
                self._planner.finish()
            self._quiet = QUIET_TURNS

    def _made(self, standing: Sequence[float]) -> Planner:
        machine = self.machine_of(self._reader.robot)
        mask = self.mask_of(machine)
        places = [standing[n] for n in range(len(standing)) if mask >> n & 1]
        self._begins.clear()
        return Planner(machine, places, mask=mask, capacity=1 << 20, next_id=self._spare)

    def _fail(self, error: MotionError, standing: Sequence[float]) -> None:
        block, code = (error.block, error.code) if isinstance(error, BlockError) else (0, 0)
        self.state = replace(
            self.state, failed_job=self.state.job, fault=str(error), fault_block=block, fault_code=code, job=0, ended=True, waiting=0
        )
        self._planner, self._ended = None, True

    def _drop(self, standing: Sequence[float]) -> None:
        self._planner, self._ended = None, True
        self._begins.clear()
        self.state = replace(self.state, job=0, waiting=0, ended=True)

    # ---- what is handed on ---------------------------------------------------------------------------------------------------
    def _plan(self, piece: int, moving: bool) -> list[PieceRecord]:
        planner, state = self._planner, self.state
        if planner is None or not state.job:
            if state.job and self._ended and not state.ended:  # a program without blocks
                self.state = replace(state, ended=True, job=0)
                return [PieceRecord(Part.LAST, state.job, self.generation)]
            return []
        tau = self._tau(piece, planner)
        out: list[PieceRecord] = []
        if len(self._begins) < AHEAD:
            at = planner.end
            for made in planner.plan(tau, hurry=self._quiet > QUIET_TURNS):
                if made.new_tail:
                    at = self._begins[made.id]
                    for number in [number for number in self._begins if number >= made.id]:
                        del self._begins[number]
                self._begins[made.id] = at
                at += made.duration
                self._last_id, self._spare = made.id, made.id + 1
                out.append(PieceRecord(Part.PIECE, state.job, self.generation, encode_timed(made)))
        for number in [number for number in self._begins if number < piece - 1]:
            del self._begins[number]
        block, share = planner.place(tau)
        last = self._ended and not planner.open and not state.ended
        if last:
            out.append(PieceRecord(Part.LAST, state.job, self.generation))
        self.state = replace(
            self.state, block=block, share=share, waiting=planner.waiting, handed=state.handed + len(out), ended=state.ended or last
        )
        if self.state.ended and not moving and piece in (0, self._last_id) and not out:
            self.state = replace(self.state, job=0)
        return out

    def _tau(self, piece: int, planner: Planner) -> float:
        """Where the follower may be at the latest: the end of the piece under way."""
        begins = self._begins
        if piece in begins:
            return begins.get(piece + 1, planner.end)
        return 0.0 if not begins or piece < min(begins) else planner.end
