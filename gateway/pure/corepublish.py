"""What others see of the core: the state of every axis, and the RC outputs that tell of drives, positions and references.  Pure."""

from collections.abc import Sequence

from drivers.drives.family import Power
from drivers.drives.limits import LagState
from gateway.pure.coreaxis import HeldAxis
from gateway.pure.permits import RcNumbers
from gateway.pure.records import FLAGS, RC_BYTES, AxisFlag, AxisState, CellState, Motion, set_bit, set_bits

AT_REST_S = 0.02  # in position: inside the window for this long
# The cycle asks for these several times an axis: as plain numbers
ENABLED, REFERENCED, IN_POSITION, FAULT, LOST, HOMING, WARNING, ON, UNCONFIGURED = (int(flag) for flag in AxisFlag)


class Publisher:
    """Of one core; `state` and `outputs` are written in place, once a cycle."""

    def __init__(self, state: CellState, outputs: bytearray, numbers: RcNumbers, period_s: float) -> None:
        self._state, self._outputs, self._numbers, self._period = state, outputs, numbers, period_s
        self._shown: tuple[bool, bool, bool, int, int] | None = None
        self._bytes: list[tuple[int, int, int]] = []  # of the outputs: index, bits of others, ours

    def publish(self, axes: Sequence[HeldAxis]) -> None:
        """After the motion was judged: `state.motion` stands."""
        state = self._state
        at_rest = state.motion is Motion.IDLE or state.motion is Motion.STOPPED
        in_position = referenced = some = 0
        every, place = ENABLED, 1
        for out, axis in zip(state.axes, axes, strict=False):
            bits = self._axis(out, axis, at_rest=at_rest)
            some |= bits
            every &= bits
            if bits & IN_POSITION:
                in_position |= place
            if bits & REFERENCED:
                referenced |= place
            place <<= 1
        state.ready = not state.emergency and not some & (FAULT | LOST)
        shown = (state.ready, every != 0, state.emergency, in_position, referenced)
        if shown != self._shown:
            self._shown, self._bytes = shown, self._image(shown, len(axes))
        outputs = self._outputs
        for at, others, ours in self._bytes:
            outputs[at] = outputs[at] & others | ours

    def _image(self, shown: tuple[bool, bool, bool, int, int], axes: int) -> list[tuple[int, int, int]]:
        """What is ours of which byte."""
        ready, drives_on, emergency, in_position, referenced = shown
        mask, image, numbers = bytearray(RC_BYTES), bytearray(RC_BYTES), self._numbers
        singles = ((numbers.ready, ready), (numbers.ready2, ready), (numbers.drives_on, drives_on), (numbers.emergency, emergency))
        for number, value in singles:
            set_bit(mask, number, True)
            set_bit(image, number, value)
        for first, values in ((numbers.in_position, in_position), (numbers.referenced, referenced)):
            set_bits(mask, first, axes, (1 << axes) - 1)
            set_bits(image, first, axes, values)
        return [(at, 0xFF ^ own, image[at]) for at, own in enumerate(mask) if own]

    def _axis(self, out: AxisState, axis: HeldAxis, *, at_rest: bool) -> int:
        """The bits of AxisFlag."""
        drive, power, scaling = axis.drive, axis.power, axis.scaling
        out.actual = actual = (drive.position_inc - scaling.zero_inc) / scaling.inc_per_unit
        out.set, out.speed, out.lag = axis.set, axis.speed, axis.behind
        out.torque = drive.torque_permille / 1000.0
        flags = 0
        if power is Power.ENABLED:
            flags = ENABLED
            axis.quiet = axis.quiet + 1 if at_rest and abs(axis.set - actual) <= axis.plan.window else 0
            if axis.quiet and axis.quiet * self._period >= AT_REST_S:
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
