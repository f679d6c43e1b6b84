"""A portal under alter in virtual time: motion stack, planner and follower, alteration."""

from dataclasses import dataclass, field

import numpy as np

from hil_tests.lab.cells.arms import Array, portal
from motion.planner.arm import Arm
from motion.sync.alter import Alter
from motion.sync.altered import AlteredArm, AlterMotion
from motion.val3.stack import MotionStack

P = 1e-3


@dataclass
class Altered:
    """axes: of the portal; nominal: joint speeds, m/s."""

    axes: str = "xyz"
    nominal: float = 2.0
    enabled: bool = True
    arm: AlteredArm = field(init=False)
    stack: MotionStack = field(init=False)
    moves: AlterMotion = field(init=False)
    inner: Arm = field(init=False)
    rows: list[tuple[float, ...]] = field(init=False, default_factory=list)
    theory: list[tuple[float, ...]] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        machine = portal(self.axes)
        self.inner = Arm(machine, (0.0,) * len(self.axes), P)
        self.arm = AlteredArm(self.inner, machine.kinematics, Alter(P, self.enabled))
        self.stack = MotionStack(self.arm)
        self.moves = AlterMotion(self.stack, self.arm, (self.nominal,) * len(self.axes))

    @property
    def alter(self) -> Alter:
        return self.arm.alter

    def run(self, periods: int) -> Array:
        """Set values of these periods, (n, axes) m."""
        start = len(self.rows)
        for _ in range(periods):
            self.rows.append(self.arm.step())
            self.theory.append(self.inner.joints)
        return np.array(self.rows[start:])

    def steps(self) -> Array:
        """(n - 1,) m: largest change of an axis from period to period."""
        return np.asarray(np.abs(np.diff(np.array(self.rows), axis=0)).max(axis=1))
