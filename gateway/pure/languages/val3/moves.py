"""The arm of a virtual run: the motion stack on planner and follower in virtual time, and the list of moves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from gateway.pure.languages.val3.errors import Rte
from motion.errors import MotionError
from motion.geometry.frames import compose
from motion.geometry.units import from_si, to_si
from motion.planner.arm import QUIET, Arm
from motion.planner.robot import machine_of
from motion.program.blocks import Block, Interpolation, JointTarget, Pace, PoseTarget
from motion.program.blocks import Frame as BlockFrame
from motion.program.blocks import Tool as BlockTool
from motion.robot import Robot, kinematics_of
from motion.sync.alter import Alter, Mode
from motion.sync.altered import AlteredArm, AlterMotion
from motion.val3.cartesian import Arm as Geometry
from motion.val3.cartesian import Frame, Point, Tool
from motion.val3.errors import RuntimeFault
from motion.val3.mdesc import Mdesc
from motion.val3.stack import CONNECTION_SPEED, Connection, MotionStack, Place
from motion.val3.trsf import Trsf

PERIOD_S = 0.004
STILL = QUIET + 5  # cycles at rest after which the arm is left alone


@dataclass
class Moves:
    """What the instructions on moves act on.  Joints in deg and mm."""

    robot: Robot
    start: tuple[float, ...] = ()
    list: "list[dict[str, object]]" = field(default_factory=list)
    arm: Arm = field(init=False)
    altered: AlteredArm = field(init=False)
    stack: MotionStack = field(init=False)
    alters: AlterMotion = field(init=False)
    geometry: Geometry = field(init=False)
    timed: ClassVar[bool] = True  # it moves with the clock of the application
    _cycle: tuple[tuple[float, ...], tuple[float, ...]] | None = None  # set values before and after the last cycle, SI; None: at rest

    def __post_init__(self) -> None:
        self.units = tuple(axis.limits.unit for axis in self.robot.axes)
        self.machine = machine_of(self.robot)
        start = tuple(to_si(value, unit) for value, unit in zip(self.start or (0.0,) * len(self.units), self.units, strict=True))
        self._begin(start)
        own = tuple(unit for axis, unit in zip(self.robot.axes, self.units, strict=True) if axis.role is None)
        self.geometry = Geometry(
            kinematics_of(self.robot), own if len(own) == kinematics_of(self.robot).axes else self.units, self.robot.base
        )
        self._open: list[dict[str, object]] = []
        self.blocked = False  # no power, hold or emergency stop
        self._stopping = False  # alter has been informed of the stop
        self._away: tuple[float, ...] | None = None  # where the arm was moved to while its path waited, SI
        self._back: Arm | None = None  # the connection move
        self._key: tuple[float, bool, bool] = (1.0, False, False)
        self._still = 0  # cycles at rest

    def _begin(self, start: Sequence[float]) -> None:
        self.arm = Arm(self.machine, start, PERIOD_S)
        self.altered = AlteredArm(self.arm, self.machine.kinematics, Alter(PERIOD_S))
        self.stack = MotionStack(self.altered)
        self.alters = AlterMotion(self.stack, self.altered, self._nominal())

    def _nominal(self) -> tuple[float, ...]:
        """Joint speeds, rad/s or m/s."""
        return tuple(limit.speed for limit in self.machine.limits[: self.machine.kinematics.axes])

    def restart(self, joints: Sequence[float]) -> None:
        """The arm is at rest where it is; its joints count anew (deg and mm)."""
        self._begin(self._si(joints))

    def _si(self, joints: Sequence[float]) -> tuple[float, ...]:
        return tuple(to_si(value, unit) for value, unit in zip(joints, self.units, strict=True))

    @property
    def position(self) -> tuple[float, ...]:
        """Set values, SI: of the path with its alteration, or off the path."""
        return self.altered.joints if self._away is None else self._away

    # ---- questions -------------------------------------------------------------------------------------------------------
    def joints(self) -> tuple[float, ...]:
        """As commanded."""
        return tuple(from_si(value, unit) for value, unit in zip(self.position, self.units, strict=True))

    def in_range(self, joints: Sequence[float]) -> bool:
        """Inside the software limits."""
        values = zip(joints, self.units, self.robot.limits, strict=False)
        return all(limit.lower - 1e-12 <= to_si(value, unit) <= limit.upper + 1e-12 for value, unit, limit in values)

    @property
    def place(self) -> Place:
        """Of the arm on its path."""
        return self.altered.place()

    @property
    def resting(self) -> bool:
        """The set values no longer change."""
        return self.arm.resting

    @property
    def braking(self) -> bool:
        """The arm moves without power: a virtual one loses it before its stop."""
        return not self.arm.resting

    @property
    def errors(self) -> tuple[float, ...]:
        """Position errors, deg and mm: the virtual arm has none."""
        return (0.0,) * len(self.units)

    @property
    def forces(self) -> tuple[float, ...]:
        """Forces of the joints, Nm and N: the virtual arm has no load."""
        return (0.0,) * len(self.units)

    def settled(self, tool: Tool | None = None, accuracy_m: float = 0.0, turn: float | None = None, seconds: float | None = None) -> bool:
        """The virtual arm follows without error: settled where it rests.  turn: rad."""
        return self.resting

    # ---- orders ----------------------------------------------------------------------------------------------------------
    def joint_move(self, joints: Sequence[float], tool: Tool, mdesc: Mdesc, unit_m: float, note: dict[str, object]) -> int | None:
        """movej, alterMovej to a joint position."""
        if not self.in_range(joints):
            raise RuntimeFault(520, "the target")
        target = JointTarget(self._si(joints))
        return self._noted(self._with(unit_m).movej(target, self._tool(tool), mdesc), note)

    def point_move(
        self, kind: str, points: Sequence[Point], tool: Tool, mdesc: Mdesc, unit_m: float, note: dict[str, object]
    ) -> int | None:
        """movej, movel, movec to points, or alterMovej and its like."""
        targets = [PoseTarget(compose(self.robot.base.inverse(), point.in_world()), point.config) for point in points]
        stack, hand = self._with(unit_m), self._tool(tool)
        match kind.lower().removeprefix("alter"):
            case "movej":
                number = stack.movej(targets[0], hand, mdesc)
            case "movel":
                number = stack.movel(targets[0], hand, mdesc)
            case _:
                number = stack.movec(targets[0], targets[1], hand, mdesc)
        return self._noted(number, note)

    def _with(self, unit_m: float) -> MotionStack:
        self.stack.unit_m = unit_m
        return self.stack

    @staticmethod
    def _tool(tool: Tool) -> BlockTool:
        return BlockTool(pose=tool.on_flange())

    def _noted(self, number: int | None, note: dict[str, object]) -> int | None:
        if number is not None:
            made: dict[str, object] = {"id": number, **note, "end_s": None}
            self.list.append(made)
            self._open.append(made)
        return number

    def reset(self, start: Sequence[float] | None = None) -> None:
        """resetMotion: drop the queued moves."""
        if self._away is not None:  # the next move begins where the arm is
            self.arm.joints = self.altered.joints = self._away
            self._away, self._back = None, None
        self.stack.reset_motion(self._si(start) if start is not None else None)
        self._open.clear()

    def alter_begin(self, reference: Frame | Tool, mdesc: Mdesc, unit_m: float) -> int:
        """alterBegin: a frame of the world, or a tool."""
        self.alters.unit_m = unit_m
        if isinstance(reference, Tool):
            return self.alters.alter_begin(self._tool(reference), mdesc)
        return self.alters.alter_begin(BlockFrame("alter", compose(self.robot.base.inverse(), reference.in_world())), mdesc)

    def alterable(self, on: bool) -> None:
        """The next move is an alterable one."""
        self.altered.alterable = on

    def alter(self, change: Trsf) -> int:
        """1, 0, -1, -2, -3."""
        return self.altered.alter.alter(change)

    def alter_end(self) -> int:
        """1, -1, -3."""
        return self.altered.alter.end()

    def alter_stop_time(self) -> float:
        """alterStopTime, s."""
        return self.altered.alter.stop_time()

    def push(self, joints: Sequence[float]) -> bool:
        """The arm is moved off its path, by jogging or by hand; False: it is under program control, or the position is none."""
        if not self.blocked or len(joints) != len(self.units) or not self.in_range(joints) or not self.arm.resting:
            return False
        there = self._si(joints)
        self._away, self._back = (None if there == self.altered.joints else there), None
        return True

    # ---- time ------------------------------------------------------------------------------------------------------------
    @property
    def idle(self) -> bool:
        """The arm rests, and nothing has been ordered since that could move it."""
        key = (self.arm.override, self.arm._held, self.arm._dropping)
        if key != self._key or not self.arm.resting:
            self._key, self._still = key, 0
        quiet = self._still > STILL and self.arm._quiet > STILL and not self.arm._dropping
        return quiet and self.altered.alter.mode is Mode.OFF and not self.altered._later

    def step(self, now_s: float, override: float) -> str | None:
        """One system cycle; the text of a move that could not be run on."""
        self.arm.override = 0.0 if self.blocked else override
        self._stops()
        if self._away is not None:
            self._connect(override)
            return None
        if self.idle:
            self._cycle = None
            return None
        before = self.altered.joints
        self._still += 1
        fault = self.altered.fault
        try:
            self.altered.step()
        except MotionError as error:
            self.stack.failed(error)
            self.altered.abandon()
            self._open.clear()
            return str(error)
        self._cycle = (tuple(before), tuple(self.altered.joints))
        self.stack.observe()
        if self.altered.fault is not None and fault is None:
            self.stack.failed(self.altered.fault)
            return str(self.altered.fault)
        waiting = self.altered.place().waiting
        while len(self._open) > waiting:
            self._open.pop(0)["end_s"] = round(now_s, 6)
        return None

    def _stops(self) -> None:
        """Power, hold and stopMove end the time in which alter is accepted."""
        stopping = self.blocked or not self.stack.permitted
        if stopping and not self._stopping:
            self.altered.alter.stopping()
        elif self._stopping and not stopping:
            self.altered.alter.running()
        self._stopping = stopping

    def _connect(self, override: float) -> None:
        """The connection move: back to where the path was left, at reduced speed, before anything else (L5483-5487)."""
        assert self._away is not None
        if self.blocked or not self.stack.permitted or not self.altered.place().waiting:
            return
        path = self.altered.joints
        if self._back is None:
            self._back = Arm(self.machine, self._away, PERIOD_S)
            self._back.add(Block(Interpolation.PTP, JointTarget(path), pace=Pace(CONNECTION_SPEED, CONNECTION_SPEED, CONNECTION_SPEED)))
            self._back.finish()
            self.stack.connection = self.stack.connects(path, self._away)
        if self.stack.connection is Connection.OPERATOR and self.stack.connects(path, self._away) is Connection.OPERATOR:
            return
        self.stack.connection = Connection.RUNNING
        self._back.override = override
        before = self._away
        self._away = self._back.step()
        self._cycle = (tuple(before), tuple(self._away))
        if self._back.resting and self._back.place().waiting == 0:
            self._away, self._back, self.stack.connection = None, None, Connection.NONE

    @property
    def connecting(self) -> bool:
        """A connection move is under way or waits for the operator."""
        return self._back is not None or self.stack.connection is not Connection.NONE

    def confirm(self) -> None:
        """The operator lets the connection move run."""
        if self._back is not None:
            self.stack.connection = Connection.RUNNING
        else:
            self.stack.confirm_connection()

    def speed_at(self, tool: Tool) -> float:
        """m/s of the tool centre point, of the commanded positions (L5964)."""
        if self._cycle is None or self._cycle[0] == self._cycle[1]:
            return 0.0
        hand = tool.on_flange()
        before, after = (compose(self.machine.forward(joints), hand).position for joints in self._cycle)
        return math.dist(before, after) / PERIOD_S


def refused(fault: RuntimeFault) -> Rte:
    """A move refused by its instruction: 154 with the 5xx as its cause; other codes stay."""
    return Rte(154, str(fault)) if fault.code >= 500 else Rte(fault.code, fault.detail)
