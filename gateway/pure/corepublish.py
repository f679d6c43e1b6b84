"""What others see of the core: the state of every axis, and the RC outputs that tell of drives, positions and references.  Pure."""

from collections.abc import Sequence

from drivers.drives.family import Power
from drivers.drives.limits import LagState
from gateway.pure.coreaxis import HeldAxis
from gateway.pure.permits import RcNumbers
from gateway.pure.records import AxisFlag, AxisState, CellState, Motion, set_bit, set_bits

AT_REST_S = 0.02  # in position: inside the window for this long
# The cycle asks for these several times an axis: arithmetic of enum flags costs microseconds, numbers and tables nothing.
FLAGS = tuple(AxisFlag(bits) for bits in range(1 << len(AxisFlag)))
ENABLED, REFERENCED, IN_POSITION, FAULT, LOST, HOMING, WARNING, ON, UNCONFIGURED = (int(flag) for flag in AxisFlag)
POWER_NUMBERS = {power: power.value for power in Power}


class Publisher:
    """Of one core; `state` and `outputs` are written in place, once a cycle."""

    def __init__(self, state: CellState, outputs: bytearray, numbers: RcNumbers, period_s: float) -> None:
        self._state, self._outputs, self._numbers, self._period = state, outputs, numbers, period_s

    def publish(self, axes: Sequence[HeldAxis]) -> None:
        """After the motion was judged: `state.motion` stands."""
        state, outputs, numbers = self._state, self._outputs, self._numbers
        at_rest = state.motion in (Motion.IDLE, Motion.STOPPED)
        in_position = referenced = 0
        for n, axis in enumerate(axes):
            bits = self._axis(state.axes[n], axis, at_rest=at_rest)
            in_position |= (bits & IN_POSITION != 0) << n
            referenced |= (bits & REFERENCED != 0) << n
        powers = [axis.power for axis in axes]
        state.ready = not state.emergency and Power.FAULT not in powers and Power.LOST not in powers
        set_bit(outputs, numbers.ready, state.ready)
        set_bit(outputs, numbers.ready2, state.ready)
        set_bit(outputs, numbers.drives_on, powers.count(Power.ENABLED) == len(powers))
        set_bit(outputs, numbers.emergency, state.emergency)
        set_bits(outputs, numbers.in_position, len(axes), in_position)
        set_bits(outputs, numbers.referenced, len(axes), referenced)

    def _axis(self, out: AxisState, axis: HeldAxis, *, at_rest: bool) -> int:
        """The bits of AxisFlag."""
        drive, power = axis.drive, axis.power
        out.actual = actual = axis.scaling.to_si(drive.position_inc)
        out.set, out.speed, out.lag = axis.set, axis.speed, axis.behind
        out.torque = drive.torque_permille / 1000.0
        enabled = power is Power.ENABLED
        axis.quiet = axis.quiet + 1 if enabled and at_rest and abs(axis.set - actual) <= axis.plan.window else 0
        flags = (
            enabled * ENABLED
            | axis.referenced * REFERENCED
            | (axis.quiet * self._period >= AT_REST_S) * IN_POSITION
            | (power is Power.FAULT) * FAULT
            | (power is Power.LOST) * LOST
            | (axis.run is not None or axis.by_drive) * HOMING
            | (axis.tracking.lag.state is LagState.WARNING) * WARNING
            | axis.wanted * ON
            | (not drive.configured) * UNCONFIGURED
        )
        out.flags, out.fault_code, out.power, out.finding = FLAGS[flags], drive.fault_code, POWER_NUMBERS[power], axis.finding
        return flags
