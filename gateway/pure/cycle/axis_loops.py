"""The work of a cycle for each of its axes: set values, supervision, published state.  Pure.

`AxisLoops` is built twice: `InPython` is the reference, gateway/cycle/native/axes.c does the same in C where it was built (AX-320).  A
property test compares them.
"""

from collections.abc import Sequence
from typing import Protocol

from drivers.drives.family import Actual, Demand, Power, SetRecord
from drivers.drives.limits import LagState
from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.image.records.cell import FLAGS, AxisFlag, AxisState

AT_REST_S = 0.02  # in position: inside the window for this long
# The cycle asks for these several times an axis: as plain numbers
ENABLED, REFERENCED, IN_POSITION, FAULT, LOST, HOMING, WARNING, ON, UNCONFIGURED = (int(flag) for flag in AxisFlag)
_new = tuple.__new__  # of a record without counting its fields again: once an axis and cycle


class AxisLoops(Protocol):
    """Each of them once a cycle, in this order; `axes` are changed in place."""

    def drive_axes(
        self, axes: list[HeldAxis], actuals: Sequence[Actual | None], q: Sequence[float], speeds: Sequence[float], reset: bool, /
    ) -> tuple[list[SetRecord], bool, bool]: ...

    def watch_axes(self, axes: list[HeldAxis], actuals: Sequence[Actual | None], first: int, /) -> int: ...

    def show_axes(self, states: list[AxisState], axes: list[HeldAxis], at_rest: bool, period_s: float, /) -> tuple[int, int, int, int]: ...


class InPython:
    """The twin."""

    @staticmethod
    def drive_axes(
        axes: list[HeldAxis], actuals: Sequence[Actual | None], q: Sequence[float], speeds: Sequence[float], reset: bool, /
    ) -> tuple[list[SetRecord], bool, bool]:
        """One pass over the axes: set values; whether every drive follows and none lost its increments; whether one did something by
        itself.  q, speeds: (axes,) of the path, m or rad, per s."""
        values: list[SetRecord] = []
        settled, eventful = True, False
        for axis, actual, at, speed in zip(axes, actuals, q, speeds, strict=True):
            drive, scaling = axis.drive, axis.scaling
            axis.active_inc, axis.received_inc, axis.sent_inc = axis.received_inc, axis.sent_inc, drive.set_inc
            if axis.led:
                axis.led = False
            elif drive.follows and not axis.by_drive:
                axis.set, axis.speed = at, speed
            else:
                axis.speed = 0.0
            inc = round(scaling.zero_inc + axis.set * scaling.sent_per_unit)  # as to_inc and to_rpm: a call costs as much as the sum
            limit_switch = axis.referenced and axis.limited
            demand = (axis.wanted, reset, inc, axis.speed * scaling.rpm_per_unit, limit_switch, axis.by_drive)
            values.append(drive.step(actual, _new(Demand, demand)))
            power = drive.power
            if power is not axis.power:
                axis.power, axis.power_number = power, power.value
            if not drive.follows or drive.epoch != axis.epoch:
                settled = False
            if drive.events:
                eventful = True
            axis.behind = (axis.active_inc - drive.position_inc) / scaling.inc_per_unit
        return values, settled, eventful

    @staticmethod
    def watch_axes(axes: list[HeldAxis], actuals: Sequence[Actual | None], first: int, /) -> int:
        """Return the index of the first axis, from `first` on, whose lag is too large; -1: none.  Later axes are not examined yet."""
        for n in range(first, len(axes)):
            axis, actual = axes[n], actuals[n]
            gap, axis.gap = axis.gap, actual is None
            if gap or actual is None or axis.by_drive or not axis.drive.follows:  # a drive that references leads its position itself
                axis.tracking.clear()  # after a gap: the first answer may be the one that was missing, one cycle old (AX-560)
            elif number := axis.tracking.check(axis.active_inc, axis.behind):
                axis.finding = number
                return n
        return -1

    @staticmethod
    def show_axes(states: list[AxisState], axes: list[HeldAxis], at_rest: bool, period_s: float, /) -> tuple[int, int, int, int]:
        """What others see of the axes into `states`: flags any of them has, ENABLED if all have it, and by axis in position, referenced."""
        in_position = referenced = some = 0
        every, place = ENABLED, 1
        for out, axis in zip(states, axes, strict=False):
            bits = _show(out, axis, at_rest, period_s)
            some |= bits
            every &= bits
            if bits & IN_POSITION:
                in_position |= place
            if bits & REFERENCED:
                referenced |= place
            place <<= 1
        return some, every, in_position, referenced


def _show(out: AxisState, axis: HeldAxis, at_rest: bool, period_s: float) -> int:
    """The bits of AxisFlag."""
    drive, power, scaling = axis.drive, axis.power, axis.scaling
    out.actual = actual = (drive.position_inc - scaling.zero_inc) / scaling.inc_per_unit
    out.set, out.speed, out.lag = axis.set, axis.speed, axis.behind
    out.torque = drive.torque_permille / 1000.0
    flags = 0
    if power is Power.ENABLED:
        flags = ENABLED
        axis.quiet = axis.quiet + 1 if at_rest and abs(axis.set - actual) <= axis.plan.window else 0
        if axis.quiet and axis.quiet * period_s >= AT_REST_S:
            flags |= IN_POSITION
    else:
        axis.quiet = 0
        if power is Power.FAULT:
            flags = FAULT
        elif power is Power.LOST:
            flags = LOST
    if axis.referenced:
        flags |= REFERENCED
    if axis.wanted:
        flags |= ON
    if axis.run is not None or axis.by_drive:
        flags |= HOMING
    if axis.tracking.lag.state is LagState.WARNING:
        flags |= WARNING
    if not drive.configured:
        flags |= UNCONFIGURED
    out.flags, out.fault_code, out.power, out.finding = FLAGS[flags], drive.fault_code, axis.power_number, axis.finding
    return flags


PYTHON: AxisLoops = InPython()
