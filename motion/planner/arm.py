"""Planner and follower together: an arm in virtual time, one step a period.  What the planner process and the cycle are apart.

It is the `Mover` of the VAL 3 motion stack, and what tests, plots and interpreters run programs on without processes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from motion.execution.follower import Follower, Progress
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.program.blocks import Block
from motion.program.team import Shared
from motion.val3.stack import Place

QUIET = 5  # periods without a new block after which the known blocks are run


@dataclass
class Arm:
    """One kinematic, or a team of several.  period_s: of a step; override: 0 .. 1."""

    machine: Machine | Team
    start: Sequence[float]
    period_s: float = 1e-3
    capacity: int = 512
    override: float = 1.0
    planner: Planner = field(init=False)
    joints: tuple[float, ...] = field(init=False)
    progress: Progress | None = field(init=False, default=None)
    _follower: Follower = field(init=False)
    _loaded: bool = field(init=False, default=False)
    _quiet: int = field(init=False, default=0)
    _held: bool = field(init=False, default=False)
    _dropping: bool = field(init=False, default=False)

    def __post_init__(self) -> None:
        self.joints = tuple(self.start)
        self.planner = Planner(self.machine, self.joints, capacity=self.capacity)
        self._follower = Follower(self.machine.axes, self.period_s)

    # ---- what an interpreter calls ---------------------------------------------------------------------------------------
    def add(self, block: Block | Shared) -> int:
        """Queue a block and return its number.  Raise BlockError."""
        self._quiet = 0
        return self.planner.add(block)

    def finish(self) -> None:
        """The last block is run to its target."""
        self.planner.finish()
        self._quiet = QUIET

    def stop(self) -> None:
        """Brake on the path and hold."""
        self._held = True

    def resume(self) -> None:
        """Go on."""
        self._held = False

    def abandon(self) -> None:
        """Brake on the path, then forget everything."""
        self._dropping, self._held = True, False
        if self.resting:
            self._drop()

    @property
    def resting(self) -> bool:
        """The set values no longer change."""
        return not self._loaded or self.progress is None or self.progress.still or self.progress.at_end

    @property
    def prepared(self) -> int:
        """Blocks added that have not begun."""
        block, share = self.planner.place(self._follower.tau)
        under_way = 0 if share >= 1.0 or block == 0 else 1
        return max(self.planner.waiting - under_way, 0)

    def place(self) -> Place:
        """Block, progress, rest, blocks that wait, joints."""
        block, share = self.planner.place(self._follower.tau) if self._loaded else self.planner.place(0.0)
        return Place(block, share, self.resting, self.planner.waiting, self.joints)

    # ---- time ------------------------------------------------------------------------------------------------------------
    def step(self) -> tuple[float, ...]:
        """One period further: the set values (axes,)."""
        if not self._dropping:
            self._quiet += 1
            for piece in self.planner.plan(self._follower.tau, hurry=self._quiet > QUIET):
                self._follower.load(piece)
                self._loaded = True
        if not self._loaded:
            if self._dropping:
                self._drop()
            return self.joints
        held = self._held or self._dropping
        self.progress = self._follower.step(0.0 if held else self.override)
        self.joints = tuple(self.progress.q.get(axis, (value, 0.0))[0] for axis, value in enumerate(self.joints))
        if self._dropping and self.resting:
            self._drop()
        return self.joints

    def _drop(self) -> None:
        self._follower = Follower(self.machine.axes, self.period_s)
        self.planner.reset(self.joints)
        self._loaded = self._dropping = False
        self.progress = None
