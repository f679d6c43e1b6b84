"""The motion stack of VAL 3: movej, movel, movec and the online instructions as calls of an interpreter.

Source: VAL 3 reference, chapter 10 (L5360-6060).  Move instructions queue and return their id; the arm lags behind; a full queue makes
the instruction wait (here: None, and the interpreter tries again).  waitEndMove cancels the blending of the last move; stopMove and
restartMove act at once; resetMotion empties the queue.  The stack has no clock: the owner calls observe() with the state of the arm.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

from motion.errors import MotionError
from motion.program.blocks import Block, Frame, Interpolation, JointTarget, Pace, PoseTarget, Target, Tool, Turning
from motion.program.errors import BlockError
from motion.val3.errors import RuntimeFault
from motion.val3.mdesc import Mdesc

CAPACITY = 100  # moves in the queue: "large but finite" (L5582); AX-417
CONNECTION_SPEED = 0.1  # share of the joint speeds: "reduced speed" (L5487); AX-418
NEAR = 1e-9  # rad or m: "any deviation, even tiny" makes a connection move


@dataclass(frozen=True, slots=True)
class Place:
    """Where the arm is on its path.  block: number of the current block or, at rest after all of them, of the last one done (0: none yet);
    share: part of its way that is made; resting: the set values are constant; waiting: blocks not yet done.
    """

    block: int
    share: float
    resting: bool
    waiting: int
    joints: tuple[float, ...]


class Mover(Protocol):
    """What carries the moves out: planner and stepper."""

    def add(self, block: Block) -> int:
        """Queue a block and return its number.  Raise BlockError when it cannot be run."""
        ...

    def finish(self) -> None:
        """The last block is run to its target: its blending is cancelled."""
        ...

    def stop(self) -> None:
        """Brake on the path and hold."""
        ...

    def resume(self) -> None:
        """Go on."""
        ...

    def abandon(self) -> None:
        """Brake on the path, then forget everything queued."""
        ...

    def place(self) -> Place:
        """As it is now."""
        ...


class Mode(Enum):
    """Working modes in which it matters who confirms a connection move (L5946-5956)."""

    MANUAL, TEST, LOCAL, REMOTE = "manual", "test", "local", "remote"


class Connection(Enum):
    """State of a connection move."""

    NONE = "none"  # the arm is on its path
    OPERATOR = "operator"  # waits for the operator
    RUNNING = "running"


def connects_by_itself(mode: Mode, distance: float, following_error: float, auto: bool) -> bool:
    """Whether a connection move starts without the operator: only in remote mode, there always when the arm is nearer to its path
    than the largest following error, else as autoConnectMove selects (default false)."""
    return mode is Mode.REMOTE and (distance < following_error or auto)


@dataclass(slots=True)
class _Move:
    number: int  # of the block
    id: int


@dataclass(slots=True)
class MotionStack:
    """One arm.  unit_m: length unit of the application in m; following_error: the largest allowed one, per joint."""

    mover: Mover
    following_error: Sequence[float] = ()
    unit_m: float = 1e-3
    capacity: int = CAPACITY
    mode: Mode = Mode.REMOTE
    auto_connect: bool = False
    connection: Connection = Connection.NONE
    _moves: list[_Move] = field(default_factory=list)  # uncompleted moves, and the last completed one
    _next_id: int = 0  # AX-416
    _fault: RuntimeFault | None = None  # of a move that could not be finished
    _stopped: bool = False  # by stopMove
    _dropping: bool = False  # resetMotion brakes
    _start: tuple[float, ...] | None = None  # where the next move must begin (resetMotion(j))
    _last_target: int = 0  # number of the last queued block

    # ---- moves -------------------------------------------------------------------------------------------------------
    def movej(self, target: Target, tool: Tool, mdesc: Mdesc, frame: Frame | None = None) -> int | None:
        """The move's id; None: the queue is full, or the arm still brakes after resetMotion: ask again.  Raises RuntimeFault."""
        return self._queue(Block(Interpolation.PTP, target, tool=tool, frame=frame or Frame()), mdesc)

    def movel(self, target: PoseTarget, tool: Tool, mdesc: Mdesc, frame: Frame | None = None) -> int | None:
        """As movej, on the straight line."""
        return self._queue(Block(Interpolation.LINEAR, target, tool=tool, frame=frame or Frame()), mdesc)

    def movec(self, via: PoseTarget, target: PoseTarget, tool: Tool, mdesc: Mdesc, frame: Frame | None = None) -> int | None:
        """As movej, on the arc from the end of the move before through via; the configuration of via is ignored."""
        return self._queue(Block(Interpolation.CIRCULAR, target, via, tool=tool, frame=frame or Frame(), turning=Turning.VIA), mdesc)

    def _queue(self, block: Block, mdesc: Mdesc) -> int | None:
        mdesc.check()
        self._raise_earlier()
        self.observe()
        if self._dropping or self.mover.place().waiting >= self.capacity:
            return None
        self._connect()
        made = Block(
            block.kind,
            block.target,
            block.via,
            mdesc.pace(self.unit_m),
            mdesc.blending(self.unit_m),
            block.tool,
            block.frame,
            block.turning,
        )
        try:
            number = self.mover.add(made)
        except BlockError as error:
            raise RuntimeFault(error.code or 154, error.what) from error
        given, self._next_id = self._next_id, self._next_id + 1
        self._moves.append(_Move(number, given))
        self._last_target = number
        return given

    def _raise_earlier(self) -> None:
        if self._fault is not None:
            raise RuntimeFault(150, str(self._fault))

    def _connect(self) -> None:
        """resetMotion(j): the next move begins at j; a connection move leads there first."""
        start, self._start = self._start, None
        if start is None:
            return
        here = self.mover.place().joints
        if len(start) != len(here):
            raise RuntimeFault(570, f"{len(start)} joints, the arm has {len(here)}")
        if max(abs(a - b) for a, b in zip(start, here, strict=True)) <= NEAR:
            return
        try:
            self.mover.add(Block(Interpolation.PTP, JointTarget(start), pace=Pace(CONNECTION_SPEED, CONNECTION_SPEED, CONNECTION_SPEED)))
        except BlockError as error:
            raise RuntimeFault(error.code or 154, error.what) from error
        self._begin_connection(start, here)

    def connects(self, path: Sequence[float], here: Sequence[float]) -> Connection:
        """Return how a connection move from here to the path starts: automatically or on the operator's permission."""
        limits = self.following_error or [0.0] * len(here)
        distance = max((abs(a - b) / e if e > 0 else 2.0) for a, b, e in zip(path, here, limits, strict=True))
        alone = connects_by_itself(self.mode, distance, 1.0, self.auto_connect)
        return Connection.RUNNING if alone else Connection.OPERATOR

    def _begin_connection(self, path: Sequence[float], here: Sequence[float]) -> None:
        self.connection = self.connects(path, here)
        if self.connection is Connection.OPERATOR:
            self.mover.stop()

    def confirm_connection(self) -> None:
        """The operator lets the connection move run; nothing happens when none waits."""
        if self.connection is Connection.OPERATOR:
            self.connection = Connection.RUNNING
            if not self._stopped:
                self.mover.resume()

    # ---- online ------------------------------------------------------------------------------------------------------
    def stop_move(self) -> None:
        """Stop on the path and withdraw the permission; returns at once."""
        self._stopped = True
        self.mover.stop()

    def restart_move(self) -> None:
        """Gives the permission back; no effect unless stopMove took it."""
        if self._stopped:
            self._stopped = False
            if self.connection is not Connection.OPERATOR:
                self.mover.resume()

    @property
    def permitted(self) -> bool:
        """False between stopMove and restartMove or resetMotion."""
        return not self._stopped

    def reset_motion(self, start: Sequence[float] | None = None) -> None:
        """Stops, empties the queue, id 0, permission restored; start: where the next move must begin."""
        self.mover.abandon()
        self._moves.clear()
        self._next_id, self._fault, self._stopped, self._last_target = 0, None, False, 0
        self._dropping = True
        self._start = tuple(start) if start is not None else None
        self.connection = Connection.NONE
        self.observe()

    def auto_connect_move(self, active: bool | None = None) -> bool:
        """autoConnectMove: set, or ask with None."""
        if active is not None:
            self.auto_connect = active
        return self.auto_connect

    # ---- questions ---------------------------------------------------------------------------------------------------
    def wait_end_move(self) -> bool:
        """Cancels the blending of the last queued move; True as soon as the command has reached its end (ask again until then).
        Raises RuntimeFault 150 when an earlier move is impossible."""
        self._raise_earlier()
        try:
            self.mover.finish()
        except BlockError as error:
            self._fault = RuntimeFault(error.code or 154, error.what)
            self._raise_earlier()
        self.observe()
        return not self._dropping and self.is_empty()

    def is_empty(self) -> bool:
        """All moves are done, or dropped: the arm may brake yet."""
        return self._dropping or self.mover.place().waiting == 0

    def get_move_id(self) -> float:
        """id of the move under way plus its progress; id + 1 at the end of the last one; 0 before any."""
        self.observe()
        place = self.mover.place()
        for move in self._moves:
            if move.number == place.block:
                return move.id + place.share
        return 0.0

    def set_move_id(self, number: int) -> None:
        """id of the next move that is queued; getMoveId does not change."""
        if number < 0:
            raise RuntimeFault(70, f"move id {number}")
        self._next_id = number

    def observe(self) -> None:
        """Takes in what the arm did meanwhile: call it once a cycle or before asking."""
        place = self.mover.place()
        if self._dropping and place.resting and place.waiting == 0:
            self._dropping = False
        while len(self._moves) > 1 and self._moves[1].number <= place.block:
            del self._moves[0]
        if self.mode is Mode.REMOTE and self.auto_connect:  # switched on while the connection move waited for the operator
            self.confirm_connection()
        if self.connection is Connection.RUNNING and (place.waiting == 0 or (self._moves and place.block >= self._moves[0].number)):
            self.connection = Connection.NONE

    def failed(self, error: MotionError) -> None:
        """The arm could not finish a move that was taken: later instructions raise 150 until resetMotion."""
        code = error.code if isinstance(error, BlockError | RuntimeFault) else 541
        self._fault = RuntimeFault(code or 541, str(error))


@dataclass(slots=True)
class Settling:
    """isSettled: position errors within bounds for a time.  standard_s: half the period of the arm's oscillation (L5923-5939)."""

    standard_s: float
    _since: dict[str, float] = field(default_factory=dict)

    def joints(self, errors: Sequence[float], allowed: Sequence[float], now_s: float) -> bool:
        """No argument: every error below 1 % of the largest allowed one during the standard time."""
        good = all(abs(error) < 0.01 * bound for error, bound in zip(errors, allowed, strict=True))
        return self._held("joints", good, now_s, self.standard_s)

    def tool(self, way: float, turn: float, accuracy: float, turn_accuracy: float | None, time_s: float | None, now_s: float) -> bool:
        """Two or four arguments: the tool within accuracy (m, rad), for the standard or the given time."""
        good = way <= accuracy and (turn_accuracy is None or turn <= turn_accuracy)
        key = f"tool {accuracy} {turn_accuracy}"
        return self._held(key, good, now_s, self.standard_s if time_s is None else time_s)

    def _held(self, key: str, good: bool, now_s: float, time_s: float) -> bool:
        if not good:
            self._since.pop(key, None)
            return False
        return now_s - self._since.setdefault(key, now_s) >= time_s - 1e-12
