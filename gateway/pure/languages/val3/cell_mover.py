"""Moves of a VAL 3 application as blocks of one stream to the planner (AX-930): the `Mover` of the motion stack in a cell.

Every block is checked when its instruction issues it, from where the previous one ends.  A stream that ends before its blocks are done
(power off, emergency stop) leaves them here: the next stream begins with a connection move to the place where the path was left.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.base.path import Path, Stretch
from gateway.pure.languages.base.requests import Ns, RuntimeFault
from gateway.pure.languages.val3.cell_alter import CellAlter
from motion.errors import MotionError
from motion.geometry.conventions import CONVENTIONS
from motion.geometry.frames import IDENTITY, Pose
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.program.blocks import Block, Interpolation, JointTarget, Pace, Tool
from motion.program.errors import BlockError
from motion.program.text.alter import written
from motion.program.text.writer import written_move
from motion.val3.stack import CONNECTION_SPEED, NEAR, Place

WAYS = CONVENTIONS["val3"]
AHEAD = 24  # blocks the planner has, and is not done with
JUDGED = 400  # blocks after which the judge begins anew, so that it does not grow
AGAIN_NS = 1_000_000_000  # a stream that was refused is asked for again
ROBOT = 1  # an application has the only one of its cell
CONNECTS = 0  # number of a connection move
PATIENCE = 50  # cycles for which an alterable path waits for its alterBegin


@dataclass(slots=True)
class _Item:
    """One block.  index: in its stream, from 1."""

    number: int
    block: Block
    index: int = 0
    alterable: bool = False


@dataclass(eq=False)
class StreamMover:
    """One robot of the cell.  joints: its set values, m and rad."""

    port: Port
    machine: Machine
    program: str
    joints: Callable[[], Sequence[float]]
    said: Callable[[str], None]  # why the cell does not move, for a person
    change: CellAlter
    alterable: bool = False  # whether the next add() is alterable
    allowed: bool = False  # power, control, no hold
    left: tuple[float, ...] | None = None  # where the path was left
    connect: bool = False  # the connection move may run
    held: bool = False  # by stopMove
    _path: Path = field(init=False)
    _altered: Stretch | None = field(init=False, default=None)  # its last part is an alterable one
    _plain: bool = field(init=False, default=False)  # an alterable path is under way without alterBegin
    _asked: int = field(init=False, default=0)  # cycles for which an alterable path has waited for its alterBegin
    _judge: Planner | None = field(init=False, default=None)
    _waiting: deque[_Item] = field(init=False, default_factory=deque)
    _handed: deque[_Item] = field(init=False, default_factory=deque)
    _number: int = field(init=False, default=0)
    _done: int = field(init=False, default=0)  # number of the last block that is done
    _finishing: bool = field(init=False, default=False)
    _dropping: bool = field(init=False, default=False)
    _tools: dict[Pose, str] = field(init=False, default_factory=dict)  # of the stream
    _refused: str = field(init=False, default="")
    _again: Ns = field(init=False, default=0)  # 0: at once
    _before: tuple[float, ...] = field(init=False, default=())
    _still: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self._path = Path(self.port)

    # ---- the Mover of the motion stack
    def add(self, block: Block) -> int:
        """BlockError: it cannot be run from where the one before ends."""
        self._judged(block)
        self._number += 1
        self._waiting.append(_Item(self._number, block, alterable=self.alterable))
        self._finishing = False
        if not self.alterable:
            self.change.used = False
        return self._number

    def _judged(self, block: Block) -> None:
        empty = not self._waiting and not self._handed
        if self._judge is None or empty or self._judge.waiting > JUDGED:
            start = tuple(self.joints()) if self._judge is None or empty else self._judge.position
            self._judge = Planner(self.machine, self.left or start if empty else start, capacity=1 << 20)
        self._judge.add(block)

    @property
    def apart(self) -> bool:
        """Return whether a standard move waits after the current alterable path."""
        return self._altered is not None and any(not item.alterable for item in self._waiting)

    def finish(self) -> None:
        """The last block is run to its target."""
        self._finishing = True

    def stop(self) -> None:
        """Brake on the path and hold."""
        self.held = True
        self.port.send("halt")

    def resume(self) -> None:
        """Go on."""
        self.held = False
        self.port.send("go")

    def abandon(self) -> None:
        """Brake on the path, then forget everything queued."""
        self._waiting.clear()
        self._handed.clear()
        self._judge, self.left, self.connect, self._finishing, self.held = None, None, False, False, False
        self._done, self._altered, self._plain, self._asked = self._number, None, False, 0
        self.change.over(failed=self.change.locked)
        if self._path.now is not None:
            self._dropping = True
            self.port.send("drop")
            self._path.release(self)

    def place(self) -> Place:
        """Block under way, its share, rest, blocks not done."""
        waiting = sum(item.number != CONNECTS for items in (self._handed, self._waiting) for item in items)
        under_way, share = self._done, 1.0
        stretch, path = self._path.held_by(self), self.port.view.path_of(1)
        if stretch is not None and stretch.job and path.job == stretch.job:
            item = next((each for each in self._handed if each.index == path.block), None)
            if item is not None and item.number != CONNECTS:
                under_way, share = item.number, path.share
        return Place(under_way, share, self.resting, waiting, tuple(self.joints()))

    @property
    def resting(self) -> bool:
        """The set values no longer change, and no stream is being given up; of an altered path the one that is altered (L6265)."""
        altered = self._altered
        if altered is not None and not self._dropping and self._path.held_by(self) is altered and altered.passed >= altered.count:
            return True
        return self._still > 1 and not self._dropping

    @property
    def streaming(self) -> bool:
        """The cell moves, or is asked to."""
        return self._path.now is not None

    # ---- time
    def step(self, now: Ns) -> None:
        """Once a system cycle."""
        here = tuple(self.joints())
        self._still = self._still + 1 if here == self._before else 0
        self._before = here
        self._path.look()
        stretch = self._path.held_by(self)
        if stretch is not None:
            while self._handed and self._handed[0].index <= stretch.passed:
                self._done = max(self._handed.popleft().number, self._done)
        if now >= self._again:
            self._again = 0
        self._go(here)
        self._end_altered()
        self._finish()

    def hand_on(self) -> None:
        """Between two system cycles: what the tasks have given since.  Alterable moves and what connects wait for the cycle."""
        if self._waiting and not self._waiting[0].alterable and self.left is None:
            self._go(self._before)
        self._finish()

    def _go(self, here: tuple[float, ...]) -> None:
        if self._again or not self.allowed or self._dropping or self.held:
            return
        stretch = self._ready(here)
        while stretch is not None and self._waiting and len(self._handed) < AHEAD and self._fits(stretch, self._waiting[0]):
            self._hand_on(stretch, self._waiting.popleft())

    def _finish(self) -> None:
        stretch = self._path.held_by(self)
        if stretch is not None and self._finishing and not self._waiting:
            self._path.finish(stretch)

    def _ready(self, here: tuple[float, ...]) -> Stretch | None:
        """The stream, if blocks may be handed on now."""
        if not self._waiting:
            return self._path.held_by(self)
        if self.left is not None:
            if max(abs(a - b) for a, b in zip(self.left, here, strict=True)) > NEAR:
                if not self.connect:
                    return None
                pace = Pace(CONNECTION_SPEED, CONNECTION_SPEED, CONNECTION_SPEED)
                self._waiting.appendleft(_Item(CONNECTS, Block(Interpolation.PTP, JointTarget(self.left), pace=pace)))
            self.left, self.connect = None, False
        return self._path.wanted(self, self.program, ROBOT)

    def _fits(self, stretch: Stretch, item: _Item) -> bool:
        """A standard move waits for the end of the altered path before it."""
        if self._altered is not None:
            return item.alterable and self._altered is stretch
        part = self.change.part
        if item.alterable and part is None and not self._plain:
            self._asked += 1
            if self._asked < PATIENCE:
                return False
        self._plain, self._asked = item.alterable and part is None, 0
        if item.alterable and part is not None and not self.change.on_path:
            kind, way = ("tool", part.reference.pose) if isinstance(part.reference, Tool) else ("frame", part.reference.pose)
            values = " ".join(f"{value:.13g}" for value in WAYS.values(way))
            self._path.hand_on(stretch, f"{kind} {part.reference.name} {values}", block=False)
            self._path.hand_on(stretch, written(part), block=False)
            self.change.on_path, self._altered = True, stretch
        return True

    def _end_altered(self) -> None:
        """After alterEnd: end the stream with its path; later moves begin where the arm is."""
        stretch = self._altered
        if stretch is None or stretch.ended or not self.change.ended:
            return
        if (self._waiting and not self._waiting[0].alterable) or (not self._waiting and stretch.passed >= stretch.count):
            self._path.hand_on(stretch, "alter_end", block=False)
            self._path.release(self)

    def _hand_on(self, stretch: Stretch, item: _Item) -> None:
        block = item.block
        if block.tool.pose != IDENTITY:
            name = self._tools.get(block.tool.pose)
            if name is None:
                name = self._tools[block.tool.pose] = f"T{len(self._tools) + 1}"
                values = " ".join(f"{value:.13g}" for value in WAYS.values(block.tool.pose))
                self._path.hand_on(stretch, f"tool {name} {values}", block=False)
            block = replace(block, tool=Tool(name, block.tool.pose))
        units = tuple(limit.unit for limit in self.machine.limits)
        item.index = self._path.hand_on(stretch, written_move(block, WAYS, units))
        self._handed.append(item)

    def given(self, ticket: int, job: int) -> None:
        """The cell moves for the application."""
        self._path.given(ticket, job)
        self._tools.clear()
        self._refused = ""
        self.port.line(job, "angles val3")
        self.port.line(job, f"axes {' '.join(limit.unit for limit in self.machine.limits)}")

    def over(self, ticket: int, error: RuntimeFault | None, now: Ns) -> MotionError | None:
        """It does not any more; what made a block fail."""
        stretch = self._path.ended(ticket, error)
        if stretch is None:
            return None
        dropped, self._dropping = self._dropping, False
        if dropped:
            return None
        if stretch is self._altered:
            apart, self._altered = self.apart, None
            self.change.over(failed=error is not None, apart=apart)
            if error is not None:
                self.abandon()
                return BlockError(error.text)
        if error is None:
            self._done = max((item.number for item in self._handed), default=self._done)
            self._handed.clear()
            return None
        if not stretch.job:  # refused: nothing has moved
            self._again = now + AGAIN_NS
            if error.text != self._refused:
                self._refused = error.text
                self.said(f"the arm does not move: {error.text}")
            return None
        path = self.port.view.path_of(1)
        circular = bool(self._handed) and self._handed[0].block.kind is Interpolation.CIRCULAR and path.share > 0.0
        if path.failed_job == stretch.job or circular:
            self.abandon()
            return BlockError(error.text, code=path.fault_code if path.failed_job == stretch.job else 0)
        self.said(f"the path is left: {error.text}")
        self._wait_again()
        return None

    def _wait_again(self) -> None:
        """Blocks not done go to a stream to come."""
        self._waiting.extendleft(reversed([item for item in self._handed if item.number != CONNECTS]))
        self._handed.clear()
        if self._waiting:
            self.left = tuple(self.joints())

    def end(self) -> None:
        """End the application: drop the remainder of its path."""
        if self._waiting or self._handed:
            self.abandon()
        else:
            self._path.release(self)

    def forget(self) -> None:
        """Forget the stream: the services have restarted and know none."""
        self._path.drop()
        self._wait_again()
