"""Enabling inputs as the cycle judges them: set, taken away by a living command source, or lost with it (AX-002, AX-143)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import itemgetter

from gateway.pure.cycle.single_inputs import SingleInputs, is_held
from gateway.pure.image.records.cell import ALL_PERMITS, RC_BYTES, InputImage, Permit, Quality
from protocols.base.machine import Ns

NO_PERMIT = Permit(0)
ALL, BAD = int(ALL_PERMITS), int(Quality.BAD)


@dataclass(frozen=True, slots=True)
class RcNumbers:
    """AX-002: bit numbers of the signals without a number in the manual; movable in the cell."""

    chain: int = 24
    control: int = 25
    feed: int = 26
    run: int = 27
    travel: int = 28
    reset: int = 19  # Control reset (rho3 3.1)
    ready: int = 64
    ready2: int = 65
    drives_on: int = 66
    emergency: int = 67
    in_position: int = 192  # + n-1
    referenced: int = 216  # + n-1
    kinematics: tuple[tuple[int, int, int], ...] = ()  # feed inputs of single kinematics: its number, bit of Permit, RC input (AX-1787)


AS_SHIPPED = RcNumbers()
SIGNAL_AXES = 12  # axes with INPOS and referenced among the RC outputs (AX-508); later axes have none (AX-572)


def free_outputs(numbers: RcNumbers, axes: int) -> frozenset[int]:
    """RC outputs of the image that axisgate itself does not write."""
    own = {numbers.ready, numbers.ready2, numbers.drives_on, numbers.emergency}
    own |= {first + n for first in (numbers.in_position, numbers.referenced) for n in range(min(axes, SIGNAL_AXES))}
    return frozenset(range(8 * RC_BYTES)) - own


PERMITS = (("chain", Permit.CHAIN), ("control", Permit.CONTROL), ("feed", Permit.FEED), ("run", Permit.RUN), ("travel", Permit.TRAVEL))
EVERY = tuple(Permit(bits) for bits in range(int(ALL_PERMITS) + 1))  # arithmetic of flags costs microseconds, a table nothing


@dataclass(frozen=True, slots=True)
class PermitView:
    """One cycle's judgement; the bits are those of Permit as plain numbers, for the cycle asks for them each time."""

    permits: int  # set
    taken: int  # a live command source reports 0
    lost: int  # no source reports any longer
    just_lost: int  # set in the cycle before
    reset: bool  # rising edge of Control reset


class EnablingInputs:
    """Remembers only the state of the cycle before."""

    def __init__(self, numbers: RcNumbers, assumed: Permit, kinematics: Sequence[int] = ()) -> None:
        """`assumed`: inputs that are not wired here and count as 1 ([rc_inputs] assume); kinematics: number of the robot of each axis."""
        self._numbers = numbers
        self.single = SingleInputs(numbers.kinematics, kinematics) if numbers.kinematics else None
        self._before = 0
        self._steady: PermitView | None = None  # the judgement while the bytes stay as they are
        self._seen: tuple[bool, object, object] | None = None
        self.assume(assumed)
        self._reset_bit = True  # a control reset already set at start is not an edge

    def assume(self, assumed: Permit) -> None:
        """From here on these count as 1 and the others are read."""
        self._assumed = int(assumed)
        self._places = [(getattr(self._numbers, name), int(permit)) for name, permit in PERMITS if not permit & assumed]
        self._look = itemgetter(*sorted({number >> 3 for number in (self._numbers.reset, *(number for number, _ in self._places))}))
        self._steady = self._seen = None

    def judge(self, inputs: InputImage, services_ns: Ns, now: Ns) -> PermitView:
        """`services_ns`: last sign of life of the writer of the inputs."""
        held = is_held(services_ns, now)
        seen = (held, self._look(inputs.values), self._look(inputs.quality))
        if seen == self._seen and self._steady is not None:
            return self._steady
        view = self._judge(inputs, held=held)
        # Edges are of this cycle only: the next one with the same bytes has none
        self._seen, self._steady = seen, replace(view, just_lost=0, reset=False)
        return view

    def _judge(self, inputs: InputImage, *, held: bool) -> PermitView:
        permits, lost, quality = self._assumed, 0, inputs.quality
        for number, permit in self._places:
            if not held or quality[number >> 3] == BAD:
                lost |= permit
            elif inputs.values[number >> 3] >> (number & 7) & 1:
                permits |= permit
        just_lost, self._before = self._before & ~permits & lost, permits
        return PermitView(permits, ALL & ~permits & ~lost, lost, just_lost, self._reset_edge(inputs))

    def _reset_edge(self, inputs: InputImage) -> bool:
        number = self._numbers.reset
        bit = inputs.bit(number) and inputs.quality[number >> 3] != BAD
        rising = bit and not self._reset_bit
        self._reset_bit = bit
        return rising
