"""The planner: blocks in, timed pieces out, in any number; and the position of the axes in terms of blocks.

What is known of the path is planned from rest to rest; as more becomes known, the tail that has not begun is planned anew from where
the committed motion is at full speed (design 6).  Everything passed on ends at rest, so a cycle without news from the planner stops
on the path.  Pure: the caller passes the progress of the follower (tau, time at full speed since the chain began).
"""

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter

from motion.errors import MotionError
from motion.execution.timed import TimedPiece
from motion.kinematics.base import Joints
from motion.planner.block_search import few_are_new, within_search
from motion.planner.commit import TooLongError, timed_pieces
from motion.planner.committed import Origin, Planned, block_ends, runs_between, state_behind, stretches_of
from motion.planner.corner_choice import PAUSE_S, quicker
from motion.planner.cutting import beyond, rest_of
from motion.planner.given_times import time_given
from motion.planner.growing import Growing
from motion.planner.law_cache import KnownLaws
from motion.planner.marks import Mark, check_outputs, has_marks, marks_of
from motion.planner.path_checks import Slowed
from motion.planner.quick_law import width_s
from motion.planner.robot import Machine
from motion.planner.route import Route, RouteState
from motion.planner.runs import Run, make_run
from motion.planner.stretch import Stretch
from motion.planner.team import Team, worst
from motion.planner.team_route import TeamRoute
from motion.program.blocks import Block, Called, Output
from motion.program.errors import BlockError
from motion.program.factors import FULL, Factors
from motion.program.team import Shared
from motion.timing.law import EndlessError, Law
from motion.timing.slices import Slices, Work

LOOK_AHEAD = 512  # blocks that may wait (owed: 256)
WINDOW = 256  # stretches one law spans at most
IN_TIME, PATIENCE = 0.3, 8.0  # of the lead: a tail that is made later comes too late; and so many times the lead at most, then
LEAD_S = 0.15  # a tail that begins sooner is not replaced any more: its replacement might come too late
AHEAD_S = 2.0  # with more than this ahead no piece is handed on, not even urgently: without the planner the axes would run all of it
HORIZON_S = 0.6  # with more than this ahead (at full speed) the tail is left alone; laws: AX-421
LED_S = 0.42  # the same for a law that is refined each time (AX-961)
LED_PIECES = 1.15  # times as many pieces: such a tail has more than the one before it
FEW, FEW_LEADS = 4, 1.6  # and where not every fourth stretch is new, with more than so many leads ahead
NAMED = 32  # stretches in a run up to which its pieces end where blocks end
SMALLEST = 1e-9
STOPS = attrgetter("stop")
PASSED = 1e-6  # share of a block that may be left where a piece ends with it
NO_WAY = "this action needs a motion to attach to: there is none before or after the block"


@dataclass
class Planner:
    """add() blocks; plan() returns the pieces that are due.  A caller that must not wait: begin(), work() until it is True, take()."""

    machine: Machine | Team
    start: Sequence[float]
    mask: int | None = None  # which axes of the cell the machine's are
    capacity: int = LOOK_AHEAD
    factors: Factors = FULL
    next_id: int = 1
    slowed: dict[int, Slowed] = field(init=False, default_factory=dict)  # block -> what its worst axis cannot keep
    lead_s: float = LEAD_S
    carried_s: float = 0.0  # transfer time of a piece to the axes; a new tail is valid when all of it has arrived
    queued_s: float = 0.0  # until the previous pieces have reached the axes: a new tail follows them
    horizon_s: float = HORIZON_S
    ahead_s: float = AHEAD_S
    window: int = WINDOW
    cuts: bool = False  # cut() may be called: the route after each waiting block is kept
    _route: Route | TeamRoute = field(init=False)
    _fresh: deque[Stretch] = field(init=False, default_factory=deque)  # known, not planned
    _planned: deque[Planned] = field(init=False, default_factory=deque)
    _done: int = field(init=False, default=0)  # blocks completed by the axes
    _laws: KnownLaws = field(init=False, default_factory=KnownLaws)
    _marks: list[Mark] = field(init=False, default_factory=list)
    _work: Slices[list[TimedPiece]] | None = field(init=False, default=None)  # the law that is being made
    _tau: float = field(init=False, default=0.0)  # as of the last begin()
    _patience: float = field(init=False, default=1.0)  # times the lead, once a tail came too late
    _behind: deque[tuple[int, RouteState]] = field(init=False, default_factory=deque)  # blocks not done, and the route after each
    _looked: deque[tuple[float, Planned, tuple[int, float]]] = field(init=False, default_factory=lambda: deque(maxlen=2))  # tau, law: place
    searched: bool = field(init=False, default=False)  # some block has BLOCK_SEARCH
    _given: int = field(init=False, default=0)  # last block of stretches another route made

    def __post_init__(self) -> None:
        self._route = TeamRoute(self.machine, self.start) if isinstance(self.machine, Team) else Route(self.machine, self.start)
        if self.cuts and isinstance(self._route, Route):
            self._behind.append((0, self._route.kept()))

    @property
    def robot(self) -> Machine:
        """The one robot this planner is for; MotionError for a team."""
        if isinstance(self.machine, Team):
            raise MotionError("several kinematics: this is possible for one robot only")
        return self.machine

    # ---- blocks --------------------------------------------------------------------------------------------------------
    @property
    def waiting(self) -> int:
        """Blocks added and not yet done, the one under way among them; as of the last plan() or place()."""
        return self.added - self._done

    @property
    def room(self) -> int:
        """Blocks that may be added now."""
        return max(self.capacity - self.waiting, 0)

    @property
    def added(self) -> int:
        """Number of the last block."""
        return max(self._route.added, self._given)

    @property
    def position(self) -> Joints:
        """Where the axes will be after everything that was added."""
        return self._route.position

    @property
    def end(self) -> float:
        """tau at which everything committed is over."""
        return self._planned[-1].end if self._planned else 0.0

    @property
    def begins(self) -> dict[int, float]:
        """Piece -> tau, of the last law."""
        return {number: at for at, number in self._planned[-1].cuts} if self._planned else {}

    @property
    def open(self) -> bool:
        """More of the path is known, or will be without another block, than was committed."""
        return bool(self._fresh) or self._route.pending or self._work is not None

    def add(self, block: Block | Shared) -> int:
        """Add the next block (a shared one for a team) and return its number, from 1.  Raise BlockError, or MotionError when full."""
        if not self.room:
            raise MotionError(f"{self.waiting} blocks are waiting, {self.capacity} may")
        match self._route, block:
            case TeamRoute() as team, Shared() as step:
                number = team.add(step)
            case Route() as route, Block() as own:
                number = route.add(own)
            case _:
                raise MotionError("a team runs shared blocks, a single robot its own")
        self._take()
        if self.cuts and isinstance(self._route, Route):
            self._behind.append((number, self._route.kept()))
            while len(self._behind) > 1 and self._behind[1][0] < self._done:
                self._behind.popleft()
        return number

    def ending(self, block: Block | None = None) -> Work[None]:
        """What the next block, or finish() (None), would work out for long, in slices; before either of them.  Raises BlockError."""
        yield from self._route.ending(block) if isinstance(self._route, Route) else ()

    def finish(self) -> None:
        """The last block is run to its target and the axes stop there."""
        self._route.finish()
        self._take()
        if self._fresh and (left := self._route.left()):
            self._fresh[-1] = replace(self._fresh[-1], ending=(*self._fresh[-1].ending, *left))

    def given(self, stretches: Sequence[Stretch]) -> None:
        """Up to a rest, made by another route, instead of blocks."""
        self._fresh.extend(stretches)
        self.searched = self.searched or any(stretch.source.ahead > 0 for stretch in stretches)
        self._given = max([self._given, *(stretch.last for stretch in stretches)])

    def cut(self, number: int) -> bool:
        """Drop the blocks after this one, so that the axes stop at its end.  Return False when part of their path is already handed on:
        the axes must come to rest first (remaining()).  Raise MotionError.
        """
        state = state_behind(self._behind, self._planned, number)
        while not self.work():
            pass
        if any(beyond(each, number, state) for planned in self._planned for each in planned.run.stretches):
            return False
        self._fresh = deque(each for each in self._fresh if not beyond(each, number, state))
        assert isinstance(self._route, Route)
        self._route.back_to(state)
        self.finish()
        return True

    def remaining(self, number: int, between: tuple[float, float], places: Sequence[float]) -> list[Stretch]:
        """From where the axes rest on their path (`places`, at a tau in between) to the end of this block; empty: they are beyond it.
        Nothing else is done with this planner then.  Raises MotionError."""
        state = state_behind(self._behind, self._planned, number)
        runs, known = runs_between(self._planned, between), [*stretches_of(self._planned), *self._fresh]
        self._fresh.clear()
        assert isinstance(self._route, Route)
        self._route.back_to(state)
        self.finish()
        ahead = [*(each for each in known if not beyond(each, number, state)), *self._fresh]
        return rest_of(ahead, runs, places)

    def left(self) -> tuple[Called | Output, ...]:
        """Calls and outputs of blocks without way for which no path is left; valid after finish()."""
        return self._route.left()

    def _take(self) -> None:
        for stretch in self._route.take():
            check_outputs(stretch)
            self._fresh.append(stretch)
            self.searched = self.searched or stretch.source.ahead > 0
            self.slowed |= worst([(stretch.block, stretch)])

    def reset(self, position: Sequence[float]) -> None:
        """Everything is dropped, a new chain begins (tau 0); the axes are here."""
        self._route.reset(position)
        self._fresh.clear()
        self._marks.clear()
        self.slowed.clear()
        self._planned.clear()
        self._laws.forget()
        self._work = None
        self._tau, self._patience = 0.0, 1.0
        self._done = self._route.added

    # ---- laws ----------------------------------------------------------------------------------------------------------
    def plan(self, tau: float, *, hurry: bool = False) -> list[TimedPiece]:
        """Pieces to hand on now, in order.  hurry: also the tail that could wait (nothing more will come soon)."""
        pieces: list[TimedPiece] = []
        while self.begin(tau, hurry=hurry):
            while not self.work():
                pass
            pieces += self.take()
            if self.end - tau > 2 * self.horizon_s:
                break
        return pieces

    @property
    def working(self) -> bool:
        """Return whether a law is being made or its pieces wait for take()."""
        return self._work is not None

    def begin(self, tau: float, *, hurry: bool = False) -> bool:
        """One more law, where one is due and none is being made; whether there is one."""
        self.place(tau)
        self._tau = tau
        if self._work is None and self._fresh:
            work = self._next(tau, hurry)
            self._work = None if work is None else Slices(work)
        return self._work is not None

    def work(self) -> bool:
        """A slice of the law; True: its pieces are there, or there is none.  Raises MotionError where the path has no law."""
        try:
            return self._work is None or self._work.go()
        except MotionError:
            self._work = None
            raise

    def take(self) -> list[TimedPiece]:
        """The pieces of the law, once; empty while it is being made."""
        if self._work is None or not self._work.made:
            return []
        (pieces,) = self._work.made
        self._work = None
        return pieces

    def take_marks(self) -> list[Mark]:
        """Outputs on the pieces handed on since the last call; marks of pieces a new tail replaces are void."""
        marks, self._marks = self._marks, []
        return marks

    def _next(self, tau: float, hurry: bool) -> Work[list[TimedPiece]] | None:
        """One more law, or None when it can wait."""
        ahead, ready = self.end - tau, self._ready(tau)
        if not ready or (ahead > self.lead_s and few_are_new(self._fresh, ready)):
            return None
        known = self._fresh[ready - 1].stop or ready >= self.window
        horizon = self.ahead_s if hurry else self.horizon_s
        if self._planned and self._planned[-1].led and not known:
            horizon = min(horizon, LED_S)
            if ahead > FEW_LEADS * self.lead_s and FEW * ready < len(self._planned[-1].run.stretches):
                return None
        if ahead > max(horizon, 2.0 * self.lead_s * self._patience + self._carried()):
            return None
        if not self._planned or self._planned[-1].stops:
            if not (known or hurry or ready < len(self._fresh) or any(map(STOPS, self._fresh))):
                return None
            return self._from_rest(self._window(ready))
        cut = self._cut(tau)
        if cut is not None:
            return self._extended(*cut, ready)
        if ahead > self.lead_s and not known:
            return None
        return self._from_rest(self._window(ready))

    def _ready(self, tau: float) -> int:
        """Return how many fresh stretches may be planned; BLOCK_SEARCH limits the number of blocks after the current one."""
        return within_search(self._fresh, self.place(tau)[0]) if self.searched else len(self._fresh)

    def _window(self, most: int) -> list[Stretch]:
        """So many fresh stretches, up to the next stop or as many as one law spans."""
        row: list[Stretch] = []
        while self._fresh and len(row) < min(most, self.window):
            row.append(self._fresh.popleft())
            if row[-1].stop:
                break
        return row

    def _cut(self, tau: float) -> tuple[float, int] | None:
        """(tau, id) of the first piece of the last law that may still be replaced."""
        last = self._planned[-1]
        if last.quick is None and not last.led:
            return None
        lead = max(self.lead_s * self._patience, self.lead_s * IN_TIME + self._carried()) + self.queued_s
        return next(((at, number) for at, number in last.cuts if at >= tau + lead), None)

    def _carried(self) -> float:
        """s until all pieces of a tail are with the axes: about as many as the law it replaces has, and one for each new stretch."""
        if not self._planned:
            return 0.0
        share = LED_PIECES if self._planned[-1].led else 1.0
        return self.carried_s * share * (len(self._planned[-1].cuts) + len(self._fresh))

    def _from_rest(self, row: list[Stretch]) -> Work[list[TimedPiece]]:
        """Return a separate law: a near-optimal one where the path ends at rest for good, a quick one where it will continue."""
        if row[-1].stop:
            row, *later = yield from quicker(row, self.machine, self._laws.seconds(self.factors), self.factors)
            self._back(stretch for part in later for stretch in part)
        try:
            if row[-1].stop:
                run = make_run(row, self.machine, self.factors)
                pace = row[0].source.pace
                if pace.time is not None and all(stretch.block == row[0].block for stretch in row):
                    law = time_given(run.path.length, pace.time, pace.ramp, width_s(run.limits))
                else:
                    law = (yield from self._laws.law(run, self.factors)).later(PAUSE_S if self._planned else 0.0)
                yield
                return self._commit(run, law, self.end, None, Origin(None, 0, 0.0))
            begun = yield from Growing(self.machine, self.factors).begun(row, self.end)
            if isinstance(begun, list):
                self._back(stretch for part in begun for stretch in part)
                return []
            return self._commit(begun.run, begun.law, self.end, None, begun.origin)
        except (TooLongError, EndlessError) as error:
            fewer = self._half(row, error)
        yield
        return (yield from self._from_rest(fewer))

    def _half(self, row: list[Stretch], error: TooLongError | EndlessError) -> list[Stretch]:
        """Fewer stretches of a motion whose law has more pieces than the ring holds: it is handed on in parts, as one is that becomes known
        block by block.  A single one that has too many is an error."""
        if len(row) == 1 or row[0].source.pace.time is not None:
            raise BlockError(str(error), block=error.block if isinstance(error, TooLongError) else row[0].block) from error
        middle = len(row) // 2
        self._back(row[middle:])
        return row[:middle]

    def _back(self, row: Iterable[Stretch]) -> None:
        """They are the next ones to be planned again."""
        self._fresh.extendleft(reversed(list(row)))

    def _extended(self, at: float, first_id: int, ready: int) -> Work[list[TimedPiece]]:
        """Replace the last law from this piece on by one that continues along the path known since."""
        last, row = self._planned[-1], self._window(ready)
        try:
            grown = yield from Growing(self.machine, self.factors).gone_on(last, at, row)
        except MotionError:
            # Already too fast for the following path: the committed part ends at rest before it, and the path continues from there.
            self._back(row)
            self._planned[-1] = replace(last, quick=None, led=False)
            return []
        if at < self._tau + self.lead_s * IN_TIME:  # the axes came too near while it was made: from further ahead
            self._back(row)
            self._patience = min(2.0 * self._patience, PATIENCE)
            return []
        before = self.next_id, self._marks
        try:
            pieces = self._commit(grown.run, grown.law, at, first_id, grown.origin)
            carried = self.queued_s + self.carried_s * len(pieces)
            if at < self._tau + self.lead_s * IN_TIME + carried:  # the last of them would come too late
                self._planned.pop()
                self.next_id, self._marks = before
                self._back(row)
                self._patience = min(2.0 * self._patience, PATIENCE)
                return []
        except TooLongError:  # fewer stretches at once; a single one begins at rest
            self._back(row)
            if len(row) > 1:
                return (yield from self._extended(at, first_id, len(row) // 2))
            self._planned[-1] = replace(last, quick=None, led=False)
            return []
        self._back(grown.later)
        self._patience = 1.0
        place = len(self._planned) - 2
        self._planned[place] = replace(last, end=at, cuts=tuple(c for c in last.cuts if c[0] < at), quick=None, led=False)
        return pieces

    def _commit(self, run: Run, law: Law, begin: float, first_id: int | None, origin: Origin) -> list[TimedPiece]:
        number = self.next_id if first_id is None else first_id
        blocks = block_ends(run) if len(run.stretches) <= NAMED else ()
        path, limits = run.driven
        if isinstance(self.machine, Machine):
            limits = limits.whole(*self.machine.shares)
        try:
            new, whole = first_id is not None, self.cuts and origin.quick is None and not origin.led and not has_marks(run)
            pieces = timed_pieces(path, limits, law, first_id=number, mask=self.mask, blocks=blocks, new_tail=new, whole=whole)
        except TooLongError as error:
            error.block = run.place(error.s)[0]
            raise
        self.next_id = number + len(pieces)
        self._marks = [mark for mark in self._marks if mark.piece < number] + marks_of(run, law, pieces, goes_on=first_id is not None)
        cuts, at = [], begin
        for piece in pieces:
            cuts.append((at, piece.id))
            at += piece.duration
        stops = run.stretches[-1].stop
        self._planned.append(Planned(run, law, begin, at, tuple(cuts), stops, *origin))
        return pieces

    # ---- where the axes are --------------------------------------------------------------------------------------------
    def place(self, tau: float) -> tuple[int, float]:
        """(block, share of its way) at tau; (0, 0.0) before the first block.  Laws that are over are forgotten (but for the last)."""
        while len(self._planned) > 1 and self._planned[0].end <= tau:
            self._planned.popleft()
        if not self._planned:
            if not self._fresh and self._work is None and not self._route.pending:
                self._done = self._route.added  # all without way: no law exists with which they could end
            return self._done, 1.0 if self._done else 0.0
        now = self._planned[0]
        looked = next((place for at, law, place in self._looked if at == tau and law is now), None)  # two are asked for, again and again
        if looked is None:
            looked = now.run.place(now.s(tau))
            self._looked.append((tau, now, looked))
        block, share = looked
        if tau >= self.end and now.stops and not self._fresh and self._work is None:
            block, share = (self.added if not self._route.pending else now.run.stretches[-1].block), 1.0
        self._done = max(self._done, block if share >= 1.0 else block - 1)
        return block, share

    def passed(self, tau: float) -> int:
        """Blocks that are over at tau, which the last law has."""
        last = self._planned[-1]
        block, share = last.run.place(last.s(tau))
        return block if share >= 1.0 - PASSED else block - 1

    def states(self, tau: float) -> tuple[float, float, float]:
        """(s, sdot, sddot) at full speed, for judges."""
        now = next((one for one in self._planned if one.end >= tau), self._planned[-1])
        return now.state(tau)
