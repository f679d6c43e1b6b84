"""Random programs of three kinematics in equal parts: a six-axis arm, a SCARA, and a portal with an axis of rotation.

A target is where the axes stand at random; so it can be reached, but the way there may not be possible: such a block is drawn again.
"""

import random
from typing import NamedTuple

from hil_tests.lab.cells import arms
from motion.errors import MotionError
from motion.geometry.frames import Pose
from motion.geometry.orientation import rotation_by
from motion.planner.route import Route
from motion.program.blocks import Blend, Block, Curving, Frame, Interpolation, JointTarget, Pace, PoseTarget, Rounding, Tool, Turning

ROBOTS = ("portal", "sr60-like", "tx60-like")
HOME = {"portal": (0.6, 0.0, 0.0, 0.0), "sr60-like": (0.3, 1.2, -0.1, 0.0), "tx60-like": (0.0, 0.4, 1.5, 0.0, 0.9, 0.0)}
STEP = {"portal": (0.25, 0.25, 0.2, 1.0), "sr60-like": (0.5, 0.5, 0.07, 1.0), "tx60-like": (0.4, 0.25, 0.3, 0.5, 0.4, 0.8)}
TRIES = 20
KINDS = ("ptp", "ptp to a pose", "line", "line", "line", "arc", "arc", "spline")


class Drawn(NamedTuple):
    """robot: of configs/robots; start: of its axes, m or rad."""

    robot: str
    start: tuple[float, ...]
    blocks: list[Block]


class _Draw:
    def __init__(self, dice: random.Random, name: str) -> None:
        self.dice, self.name, self.machine = dice, name, arms.robot(name)
        self.q, self.frame, self.tool = HOME[name], Frame(), Tool()
        self.flat = name != "tx60-like"

    def pose(self, size: float, angle: float) -> Pose:
        turn = [0.0, 0.0, 1.0] if self.flat else [self.dice.uniform(-1, 1) for _ in "xyz"]
        by = self.dice.uniform(-angle, angle)
        x, y, z = (self.dice.uniform(-size, size) for _ in "xyz")
        return Pose((x, y, z), rotation_by((turn[0] * by, turn[1] * by, turn[2] * by)))

    def stand(self, share: float = 1.0) -> tuple[float, ...]:
        """Somewhere around the home position, no further than a step from here."""
        places = []
        for axis, here, home, step in zip(self.machine.limits, self.q, HOME[self.name], STEP[self.name], strict=True):
            low, high = max(axis.lower, home - 2.0 * step), min(axis.upper, home + 2.0 * step)
            places.append(min(max(here + share * self.dice.uniform(-step, step), low + 1e-3), high - 1e-3))
        return tuple(places)

    def target(self, q: tuple[float, ...]) -> PoseTarget:
        return PoseTarget(self.frame.pose.inverse() @ (self.machine.forward(q) @ self.tool.pose))

    def pace(self) -> Pace:
        dice = self.dice
        return Pace(
            speed=dice.choice((1.0, 1.0, dice.uniform(0.1, 1.0))),
            accel=dice.choice((1.0, 1.0, dice.uniform(0.2, 1.0))),
            decel=dice.choice((1.0, 1.0, dice.uniform(0.2, 1.0))),
            path_speed=dice.choice((None, dice.uniform(0.02, 0.3), dice.uniform(0.3, 2.0))),
            turn_speed=dice.choice((None, None, dice.uniform(0.2, 3.0))),
            path_accel=dice.choice((None, None, dice.uniform(1.0, 10.0))),
            path_decel=dice.choice((None, None, dice.uniform(1.0, 10.0))),
        )

    def blend(self) -> Blend:
        dice = self.dice
        size, other = (dice.choice((0.002, 0.005, 0.02, 0.05)) for _ in "ab")
        share, past = dice.choice((0.5, 0.4)), dice.random() < 0.5
        match dice.randint(0, 6):
            case 0 | 1:
                return Blend(Rounding.CARTESIAN, size, size, share=share, past_circles=past)
            case 2:
                return Blend(Rounding.CARTESIAN, size, other, share=share, past_circles=past)
            case 3:
                return Blend(Rounding.CARTESIAN, distance=size, share=share, past_circles=past)
            case 4:
                return Blend(Rounding.JOINT, size, other, share=share, past_circles=past)
            case _:
                return Blend()

    def made(self, kind: Interpolation, target: JointTarget | PoseTarget, via: PoseTarget | None = None) -> Block:
        tool, frame = (Tool(), Frame()) if isinstance(target, JointTarget) else (self.tool, self.frame)
        turning = self.dice.choice(list(Turning)) if via is not None else Turning.VIA
        return Block(kind, target, via=via, turning=turning, pace=self.pace(), blend=self.blend(), tool=tool, frame=frame)

    def row(self) -> list[Block]:
        """One block, or a row of a spline."""
        dice = self.dice
        kind = dice.choice(KINDS)
        if kind == "spline":
            blocks, pace = [], self.pace()
            tension, here = dice.choice((1.0, 0.5, 0.0)), self.q
            for _ in range(dice.randint(3, 6)):
                self.q = self.stand(0.5)
                curving = Curving(tension=tension)
                blocks.append(
                    Block(Interpolation.SPLINE, self.target(self.q), pace=pace, tool=self.tool, frame=self.frame, curving=curving)
                )
            self.q, self.reached = here, self.q
            return blocks
        self.reached = q = self.stand()
        match kind:
            case "ptp":
                return [self.made(Interpolation.PTP, JointTarget(q))]
            case "ptp to a pose":
                return [self.made(Interpolation.PTP, self.target(q))]
            case "line":
                return [self.made(Interpolation.LINEAR, self.target(q))]
        here, self.q = self.q, tuple((a + b) / 2 for a, b in zip(self.q, q, strict=True))
        via = self.target(self.stand(0.4))
        self.q = here
        return [self.made(Interpolation.CIRCULAR, self.target(q), via)]

    def blocks(self, count: int) -> list[Block]:
        found: list[Block] = []
        while len(found) < count:
            if self.dice.random() < 0.2:
                self.tool = self.dice.choice((Tool(), Tool("t", self.pose(0.1, 0.5))))
            if self.dice.random() < 0.2:
                self.frame = self.dice.choice((Frame(), Frame("f", self.pose(0.3, 2.0))))
            for _ in range(TRIES):
                row = self.row()
                if (ends := self.way([*found, *row])) is not None:
                    found += row
                    self.q = ends
                    break
        return found

    def way(self, blocks: list[Block]) -> tuple[float, ...] | None:
        """Where the axes end; None: it cannot be run."""
        route = Route(self.machine, HOME[self.name])
        try:
            for block in blocks:
                route.add(block)
            route.finish()
            last = route.take()[-1]
        except MotionError:
            return None
        return tuple(last.path.q(last.path.length))


def drawn(seed: int) -> Drawn:
    """The same seed, the same program."""
    name = ROBOTS[seed % len(ROBOTS)]
    draw = _Draw(random.Random(seed), name)
    return Drawn(name, HOME[name], draw.blocks(draw.dice.randint(4, 8)))
