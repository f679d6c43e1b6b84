"""The arm of a virtual run: the motion stack on planner and follower in virtual time, and the list of moves."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from gateway.pure.languages.val3.errors import Rte
from motion.errors import MotionError
from motion.geometry.frames import compose
from motion.geometry.units import from_si, to_si
from motion.planner.arm import QUIET, Arm
from motion.planner.robot import machine_of
from motion.program.blocks import JointTarget, PoseTarget
from motion.program.blocks import Tool as BlockTool
from motion.robot import Robot, kinematics_of
from motion.val3.cartesian import Arm as Geometry
from motion.val3.cartesian import Point, Tool
from motion.val3.errors import RuntimeFault
from motion.val3.mdesc import Mdesc
from motion.val3.stack import MotionStack, Place

PERIOD_S = 0.004
STILL = QUIET + 5  # cycles at rest after which the arm is left alone


@dataclass
class Moves:
    """What the instructions on moves act on.  Joints in deg and mm."""

    robot: Robot
    start: tuple[float, ...] = ()
    list: "list[dict[str, object]]" = field(default_factory=list)
    arm: Arm = field(init=False)
    stack: MotionStack = field(init=False)
    geometry: Geometry = field(init=False)
    speed: float = 0.0  # m/s of the tool centre point

    def __post_init__(self) -> None:
        self.units = tuple(axis.limits.unit for axis in self.robot.axes)
        self.machine = machine_of(self.robot)
        start = tuple(to_si(value, unit) for value, unit in zip(self.start or (0.0,) * len(self.units), self.units, strict=True))
        self.arm = Arm(self.machine, start, PERIOD_S)
        self.stack = MotionStack(self.arm)
        own = tuple(unit for axis, unit in zip(self.robot.axes, self.units, strict=True) if axis.role is None)
        self.geometry = Geometry(
            kinematics_of(self.robot), own if len(own) == kinematics_of(self.robot).axes else self.units, self.robot.base
        )
        self._open: list[dict[str, object]] = []
        self.blocked = False  # no power, hold or emergency stop
        self._key: tuple[float, bool, bool] = (1.0, False, False)
        self._still = 0  # cycles at rest

    # ---- questions -------------------------------------------------------------------------------------------------------
    def joints(self) -> tuple[float, ...]:
        """As commanded."""
        return tuple(from_si(value, unit) for value, unit in zip(self.arm.joints, self.units, strict=True))

    def in_range(self, joints: Sequence[float]) -> bool:
        """Inside the software limits."""
        values = zip(joints, self.units, self.robot.limits, strict=False)
        return all(limit.lower - 1e-12 <= to_si(value, unit) <= limit.upper + 1e-12 for value, unit, limit in values)

    @property
    def place(self) -> Place:
        """Of the arm on its path."""
        return self.arm.place()

    # ---- orders ----------------------------------------------------------------------------------------------------------
    def joint_move(self, joints: Sequence[float], tool: Tool, mdesc: Mdesc, unit_m: float, note: dict[str, object]) -> int | None:
        """movej to a joint position."""
        if not self.in_range(joints):
            raise RuntimeFault(520, "the target")
        target = JointTarget(tuple(to_si(value, unit) for value, unit in zip(joints, self.units, strict=True)))
        return self._noted(self._with(unit_m).movej(target, self._tool(tool), mdesc), note)

    def point_move(
        self, kind: str, points: Sequence[Point], tool: Tool, mdesc: Mdesc, unit_m: float, note: dict[str, object]
    ) -> int | None:
        """movej, movel, movec to points."""
        targets = [PoseTarget(compose(self.robot.base.inverse(), point.in_world()), point.config) for point in points]
        stack, hand = self._with(unit_m), self._tool(tool)
        match kind:
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
        """resetMotion: what is queued is dropped."""
        given = None
        if start is not None:
            given = [to_si(value, unit) for value, unit in zip(start, self.units, strict=True)]
        self.stack.reset_motion(given)
        self._open.clear()

    # ---- time ------------------------------------------------------------------------------------------------------------
    @property
    def idle(self) -> bool:
        """The arm rests, and nothing has been ordered since that could move it."""
        key = (self.arm.override, self.arm._held, self.arm._dropping)
        if key != self._key or not self.arm.resting:
            self._key, self._still = key, 0
        return self._still > STILL and self.arm._quiet > STILL and not self.arm._dropping

    def step(self, now_s: float, override: float) -> str | None:
        """One system cycle; the text of a move that could not be run on."""
        self.arm.override = 0.0 if self.blocked else override
        if self.idle:
            self.speed = 0.0
            return None
        before = self.arm.joints
        self._still += 1
        try:
            self.arm.step()
        except MotionError as error:
            self.stack.failed(error)
            self.arm.abandon()
            self._open.clear()
            return str(error)
        self.speed = self._speed(before)
        self.stack.observe()
        waiting = self.arm.place().waiting
        while len(self._open) > waiting:
            self._open.pop(0)["end_s"] = round(now_s, 6)
        return None

    def _speed(self, before: Sequence[float]) -> float:
        if before == self.arm.joints:
            return 0.0
        first, second = self.machine.forward(before).position, self.machine.forward(self.arm.joints).position
        return float(sum((a - b) ** 2 for a, b in zip(first, second, strict=True)) ** 0.5) / PERIOD_S


def refused(fault: RuntimeFault) -> Rte:
    """A move refused by its instruction: 154 with the 5xx as its cause; other codes stay."""
    return Rte(154, str(fault)) if fault.code >= 500 else Rte(fault.code, fault.detail)
