"""The arm of an application in a cell: the motion stack on the stream to the planner, positions as the drives have them."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.base.requests import Ns, RuntimeFault
from gateway.pure.languages.val3.cell_alter import AlterPlace, CellAlter
from gateway.pure.languages.val3.cell_mover import StreamMover
from gateway.pure.languages.val3.moves import Moves
from motion.geometry.frames import compose
from motion.geometry.units import from_si, to_si
from motion.planner.robot import Machine
from motion.program.blocks import Frame as BlockFrame
from motion.program.blocks import Tool as BlockTool
from motion.robot import Robot
from motion.val3 import errors
from motion.val3.cartesian import Frame, Tool
from motion.val3.mdesc import Mdesc
from motion.val3.stack import Connection, MotionStack, Settling
from motion.val3.trsf import Trsf

STANDARD_S = 0.1  # AX-931: half the period of the oscillation of an arm


@dataclass(frozen=True, slots=True)
class JointFacts:
    """Of each joint.  largest: following error, in its unit; rated: force at the rated torque of its motor, Nm or N."""

    largest: tuple[float, ...] = ()
    rated: tuple[float, ...] = ()


class CellMoves(Moves):
    """machine: with the limits of the cell; largest, rated: JointFacts."""

    timed = False  # it moves with its cell

    def __init__(
        self, robot: Robot, machine: Machine, port: Port, largest: Sequence[float], said: Callable[[str], None],
        place: AlterPlace | None = None, rated: Sequence[float] = (),
    ) -> None:  # fmt: skip
        self._port, self._own, self._said, self._place = port, machine, said, place
        self._facts = JointFacts(tuple(largest), tuple(rated))
        self._settling = Settling(STANDARD_S)
        self.powered = False
        self._now: Ns = 0
        self._fault: str | None = None
        super().__init__(robot)

    def _begin(self, start: Sequence[float]) -> None:
        super()._begin(start)
        self.machine = self._own
        self.change = CellAlter(self._port, self._place)
        self.mover = StreamMover(self._port, self._own, "val3", self._set, self._said, self.change)
        following = [to_si(value, unit) for value, unit in zip(self._facts.largest, self.units, strict=True)]
        self.stack = MotionStack(self.mover, following)

    # ---- positions
    def _units_of(self, places: Sequence[float]) -> tuple[float, ...]:
        return tuple(places[: len(self.units)]) or (0.0,) * len(self.units)

    def _set(self) -> tuple[float, ...]:
        """Set values of the cycle, m and rad."""
        own = self._units_of(self._port.view.set)
        return tuple(to_si(value, unit) for value, unit in zip(own, self.units, strict=True))

    def _actual(self) -> tuple[float, ...]:
        own = self._units_of(self._port.view.actual)
        return tuple(to_si(value, unit) for value, unit in zip(own, self.units, strict=True))

    @property
    def position(self) -> tuple[float, ...]:
        """As commanded while there is power, else as the encoders have it (L4902)."""
        return self._set() if self.powered else self._actual()

    @property
    def errors(self) -> tuple[float, ...]:
        """Set less actual values, deg and mm."""
        pairs = zip(self._set(), self._actual(), self.units, strict=True)
        return tuple(from_si(wanted - found, unit) for wanted, found, unit in pairs) if self.powered else (0.0,) * len(self.units)

    @property
    def forces(self) -> tuple[float, ...]:
        """Nm or N, from the torque that each drive reports (L5982-5992); 0 where its rated torque is not known."""
        shares = self._port.view.torque[: len(self._facts.rated)]
        return tuple(share * rated for share, rated in zip(shares, self._facts.rated, strict=True)) if shares else super().forces

    @property
    def resting(self) -> bool:
        """The set values no longer change."""
        return self.mover.resting

    @property
    def braking(self) -> bool:
        """Never: a cell stops its axes before it switches them off; later their set values follow the encoders, which are not at rest."""
        return False

    def settled(self, tool: Tool | None = None, accuracy_m: float = 0.0, turn: float | None = None, seconds: float | None = None) -> bool:
        """Position errors within bounds for a time (L5904-5939)."""
        now_s = self._now / 1e9
        if tool is None:
            return self._settling.joints(self.errors, self._facts.largest, now_s) and self.resting
        hand = tool.on_flange()
        wanted, found = (compose(self.machine.forward(places), hand) for places in (self._set(), self._actual()))
        way = math.dist(wanted.position, found.position)
        between = compose(wanted.inverse(), found).rotation
        angle = math.acos(max(-1.0, min(1.0, (between[0] + between[4] + between[8] - 1.0) / 2.0)))
        return self._settling.tool(way, angle, accuracy_m, turn, seconds, now_s) and self.resting

    # ---- orders
    def _noted(self, number: int | None, note: dict[str, object]) -> int | None:
        return number

    def reset(self, start: Sequence[float] | None = None) -> None:
        """resetMotion: drop the queued moves."""
        self.stack.reset_motion(self._si(start) if start is not None else None)
        self.change.dropped()

    def restart(self, joints: Sequence[float]) -> None:
        """resetTurn shifts an encoder: not in a cell."""
        raise errors.RuntimeFault(153, "resetTurn in a cell: axisgate axis zero sets positions")

    def alter_begin(self, reference: Frame | Tool, mdesc: Mdesc, unit_m: float) -> int:
        """0 waits for its path, -1, -2, -3; RuntimeFault 100..106."""
        if isinstance(reference, Tool):
            return self.change.begin(BlockTool("ALTER", reference.on_flange()), mdesc, unit_m, apart=self.mover.apart)
        frame = BlockFrame("ALTER", compose(self.robot.base.inverse(), reference.in_world()))
        return self.change.begin(frame, mdesc, unit_m, apart=self.mover.apart)

    def alterable(self, on: bool) -> None:
        """The next move is an alterable one."""
        self.mover.alterable = on

    def alter(self, change: Trsf) -> int:
        """1, 0, -1, -2, -3."""
        return self.change.alter(change)

    def alter_end(self) -> int:
        """1, -1, -3."""
        return self.change.end()

    def alter_stop_time(self) -> float:
        """alterStopTime, s."""
        return self.change.stop_time()

    def hand_on(self) -> None:
        """At the end of a turn: its moves go to the planner, not a system cycle later."""
        self.mover.hand_on()

    def correct(self, now: Ns) -> None:
        """At the end of a turn: the correction for the cycle."""
        self.change.correct(now)

    def push(self, joints: Sequence[float]) -> bool:
        """Nothing pushes the arm but the cell."""
        return False

    def confirm(self) -> None:
        """The operator lets the connection move run."""
        self.mover.connect = True
        self.stack.confirm_connection()

    @property
    def connecting(self) -> bool:
        """The path was left, and is not met yet."""
        return self.mover.left is not None or self.stack.connection is not Connection.NONE

    @property
    def idle(self) -> bool:
        """Nothing is asked of the arm."""
        return not self.mover.streaming and self.stack.is_empty()

    # ---- time
    def step(self, now_s: float, override: float) -> str | None:
        """One system cycle; the text of a move that could not be run on."""
        self._now = round(now_s * 1e9)
        here = self._set()
        mover = self.mover
        mover.allowed = not self.blocked
        if mover.left is not None and self.stack.connects(mover.left, here) is Connection.RUNNING:
            mover.connect = True
        mover.step(self._now)
        self._cycle = (self._cycle[1] if self._cycle is not None else here, here)
        self.stack.observe()
        fault, self._fault = self._fault, None
        return fault

    def over(self, ticket: int, error: RuntimeFault | None) -> None:
        """The cell does not move for the application any more."""
        failed = self.mover.over(ticket, error, self._now)
        if failed is not None:
            self.stack.failed(failed)
            self._fault = str(failed)
