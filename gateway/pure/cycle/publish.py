"""Published state of the core: the state of every axis, and the RC outputs for drives, positions and references.  Pure."""

from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.cycle.axis_loops import FAULT, LOST, PYTHON, AxisLoops
from gateway.pure.cycle.enabling_inputs import SIGNAL_AXES, RcNumbers
from gateway.pure.image.records.cell import RC_BYTES, CellState, Motion, set_bit, set_bits

IDLE, STOPPED = Motion.IDLE, Motion.STOPPED  # asked in every cycle: Motion.IDLE costs a search in its class


class Publisher:
    """Of one core; `state` and `outputs` are written in place, once a cycle."""

    def __init__(self, state: CellState, outputs: bytearray, numbers: RcNumbers, period_s: float, loops: AxisLoops = PYTHON) -> None:
        self._state, self._outputs, self._numbers, self._period = state, outputs, numbers, period_s
        self._show_axes = loops.show_axes
        self.contacts_lost = False  # a coupler that matters for readiness is away
        self._shown: tuple[bool, bool, bool, int, int] | None = None
        self._bytes: list[tuple[int, int, int]] = []  # of the outputs: index, bits of others, ours

    def publish(self, axes: list[HeldAxis]) -> None:
        """After the motion was judged: `state.motion` is valid."""
        state = self._state
        at_rest = state.motion is IDLE or state.motion is STOPPED
        some, every, in_position, referenced = self._show_axes(state.axes, axes, at_rest, self._period)
        state.ready = not state.emergency and not some & (FAULT | LOST) and not self.contacts_lost
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
            own = min(axes, SIGNAL_AXES)
            every = (1 << own) - 1
            set_bits(mask, first, own, every)
            set_bits(image, first, own, values & every)
        return [(at, 0xFF ^ own, image[at]) for at, own in enumerate(mask) if own]
