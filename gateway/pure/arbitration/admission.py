"""Checks of a command before it becomes an order to the cycle: its numbers and axes, the enabling inputs, drives on and referenced.

Each check raises Refusal with the reason and the missing condition.
"""

import math
from collections.abc import Mapping, Sequence

from gateway.pure.arbitration.axis_masks import axes_with, names_of
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.jobs import AxisFacts, Job
from gateway.pure.image.reasons import Reason, Refusal
from gateway.pure.image.records.cell import AxisFlag, CellState, Permit

TINY, TRAVELS = 1e-6, 10.0  # AX-010: what looks like a number in another format


class Admission:
    """Conditions of the commands of one cell."""

    def __init__(self, axes: Sequence[AxisFacts]) -> None:
        self._axes = tuple(axes)
        self.barred = 0  # axes the interface has disabled
        self.listen_only: Mapping[int, str] = {}  # axes on a bus to which nothing is sent, and why (AX-436)

    @property
    def every_axis(self) -> int:
        """Mask of all axes."""
        return (1 << len(self._axes)) - 1

    def _with(self, flag: AxisFlag, cell: CellState) -> int:
        return axes_with(flag, cell, len(self._axes))

    def to_be_enabled(self, job: Job, cell: CellState) -> int:
        """Axes of a move that have to be enabled.  A program does without axes that were switched off or disabled one by one
        (rho 3 L1295-1330): it ends where it would move one of them."""
        off = job.mask & ~self._with(AxisFlag.ENABLED, cell)
        amiss = self._with(AxisFlag.ON | AxisFlag.FAULT | AxisFlag.LOST | AxisFlag.UNCONFIGURED, cell) & ~self.barred
        return job.mask if job.code != Code.PROGRAM or off == job.mask or off & amiss else job.mask & ~off

    def check_sent(self, mask: int) -> None:
        """The buses of these axes are not listen-only."""
        for axis, why in self.listen_only.items():
            if mask >> axis & 1:
                raise Refusal(Reason.NOT_READY, why)

    @staticmethod
    def check_rates(command: Command, override: float) -> None:
        """Velocity and acceleration are above 0 and at most 100 %, and the override is not zero."""
        for name, value in (("velocity", command.velocity), ("acceleration", command.acceleration)):
            if not 0.0 < value <= 1.0:
                raise Refusal(Reason.RATE, f"{name} {value:.2%}; 0.01..100 %")
        if override <= 0.0:
            raise Refusal(Reason.OVERRIDE_ZERO)

    @staticmethod
    def check_plausible(axis: AxisFacts, value: float, *, relative: bool) -> None:
        """AX-010: a target that only a number read in the wrong format would have."""
        travel = axis.high - axis.low
        if not math.isfinite(value) or (value != 0.0 and abs(value) < TINY) or abs(value) > TRAVELS * travel:
            kind = "distance" if relative else "target"
            raise Refusal(
                Reason.FORMAT_SUSPICION,
                f"{axis.name} {kind} {value:.3g} {axis.unit} looks like KG read as IEEE (travel {travel:g} {axis.unit})",
            )

    def check_named(self, job: Job) -> None:
        """The command names axes of the cell."""
        if job.mask == 0 or job.mask & ~self.every_axis:
            raise Refusal(Reason.MASK, f"{job.mask:04X}h; this cell has {len(self._axes)} axes: 0001h..{self.every_axis:04X}h")

    def check_axes(self, job: Job) -> None:
        """The command names axes of the cell, none of them disabled at the interface."""
        self.check_named(job)
        if job.mask & self.barred and job.code != Code.DISABLE:
            raise Refusal(Reason.DRIVES_OFF, f"{names_of(self._axes, job.mask & self.barred)} disabled at the interface")

    def check_reference_run(self, cell: CellState, mask: int) -> None:
        """An axis with an absolute encoder has no reference run: its zero has to be set."""
        missing = mask & ~self._with(AxisFlag.REFERENCED, cell)
        names = ", ".join(axis.name for n, axis in enumerate(self._axes) if missing >> n & 1 and axis.absolute)
        if names:
            raise Refusal(
                Reason.NOT_REFERENCED, f'{names}: home.by = "none" and no zero is known; set it: axisgate axis zero CELL AXIS --at POSITION'
            )

    @staticmethod
    def check_enabling(cell: CellState) -> None:
        """The emergency stop chain is closed and the enabling input of the control is set."""
        if cell.emergency or not cell.permits & Permit.CHAIN:
            raise Refusal(Reason.EMERGENCY_STOP)
        if not cell.permits & Permit.CONTROL:
            raise Refusal(Reason.CONTROL_NOT_ALLOWED)

    def check_travel(self, cell: CellState, mask: int, *, referenced: bool = True) -> None:
        """Feed and travel are enabled and the axes are on; `referenced`: they are referenced, too."""
        if not cell.permits & ~cell.withheld(mask) & Permit.FEED:
            raise Refusal(Reason.FEED_NOT_ALLOWED, names_of(self._axes, mask) if cell.permits & Permit.FEED else "")
        if not cell.permits & Permit.TRAVEL:
            raise Refusal(Reason.TRAVEL_NOT_ALLOWED)
        for flag, reason in ((AxisFlag.ENABLED, Reason.DRIVES_OFF), (AxisFlag.REFERENCED, Reason.NOT_REFERENCED)):
            missing = mask & ~self._with(flag, cell)
            if missing and (flag is AxisFlag.ENABLED or referenced):
                raise Refusal(reason, names_of(self._axes, missing))

    def ptp_targets(self, mask: int, command: Command, start: Sequence[float], *, relative: bool) -> list[float]:
        """Target of each axis, m or rad; `start`: its present set value in the same unit."""
        target = list(start)
        for n, axis in enumerate(self._axes):
            if mask >> n & 1:
                self.check_plausible(axis, command.targets[n], relative=relative)
                wanted = command.targets[n] + (start[n] / axis.si if relative else 0.0)
                if not axis.low <= wanted <= axis.high and not (relative and axis.endless):
                    raise Refusal(Reason.TARGET_LIMIT, f"{axis.name} {wanted:.3f} {axis.unit}; {axis.low:g}..{axis.high:g} {axis.unit}")
                target[n] = wanted * axis.si
        return target
