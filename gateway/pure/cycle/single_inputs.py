"""Feed allow and feed hold of single kinematics: they hold the path of one lane, the others continue (AX-1787).  Pure."""

from collections.abc import Sequence

from gateway.pure.image.records.cell import InputImage, Quality
from protocols.base.machine import Ns, ms

INPUTS_HOLD = ms(4_000)  # enabling inputs outlive a services restart by this much (AX-143)
BAD = int(Quality.BAD)


def is_held(services_ns: Ns, now: Ns) -> bool:
    """`services_ns`: last sign of life of the writer of the inputs."""
    return services_ns != 0 and now - services_ns < INPUTS_HOLD


class SingleInputs:
    """They act in addition to the inputs of the cell: a kinematic moves where both are set."""

    def __init__(self, places: Sequence[tuple[int, int, int]], kinematics: Sequence[int]) -> None:
        """places: kinematic, bit of Permit, RC input; kinematics: number of the robot of each axis."""
        self._places = [(sum(1 << n for n, own in enumerate(kinematics) if own == number), permit, at) for number, permit, at in places]
        self._was_set = [False] * len(places)
        self._withheld: list[tuple[int, int]] = []  # axes, bits of Permit

    def judge(self, inputs: InputImage, services_ns: Ns, now: Ns) -> int:
        """Once per cycle; axes (bit n-1 = axis n) of the kinematics with an input that is lost since the cycle before."""
        held, just_lost, withheld = is_held(services_ns, now), 0, []
        for n, (mask, permit, number) in enumerate(self._places):
            known = held and inputs.quality[number >> 3] != BAD
            is_set = known and bool(inputs.values[number >> 3] >> (number & 7) & 1)
            if not is_set:
                withheld.append((mask, permit))
                if self._was_set[n] and not known:
                    just_lost |= mask
            self._was_set[n] = is_set
        self._withheld = withheld
        return just_lost

    def withheld(self, axes: int) -> int:
        """Bits of Permit that are missing for some of these axes."""
        missing = 0
        for mask, permit in self._withheld:
            if mask & axes:
                missing |= permit
        return missing
