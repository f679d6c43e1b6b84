"""Emulated belts: conveyors with an encoder that sends its count after every SYNC, in bus time.

A belt runs at its speed and changes to another one at its acceleration; the count is in full increments, as an encoder counts.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from protocols.base.machine import Frame, Ns
from protocols.canopen import cob_id as cobid
from protocols.servodyn.plan import SYNC_ID

SYNCS = (SYNC_ID, cobid.SYNC)
LONGEST_NS = 1_000_000_000  # between two SYNCs: after a longer gap the bus was down, and the belt did not move


@dataclass(slots=True)
class EmulatedBelt:
    """speed: increments/s; accel: increments/s2; place: increments; byte, size: position of the count in the telegram."""

    identifier: int
    speed: float = 0.0
    accel: float = 1e6
    place: float = 0.0
    byte: int = 0
    size: int = 4
    silent: bool = False
    now: float = field(init=False)  # speed it has

    def __post_init__(self) -> None:
        self.now = self.speed

    def run(self, seconds: float) -> None:
        """Advance by so much time."""
        ramp = min(abs(self.speed - self.now) / self.accel, seconds)
        end = self.now + math.copysign(self.accel * ramp, self.speed - self.now)
        self.place += 0.5 * (self.now + end) * ramp
        self.now = end if ramp == seconds else self.speed
        self.place += self.now * (seconds - ramp)

    def frame(self) -> Frame:
        """Its telegram now."""
        count = math.floor(self.place) % (1 << (8 * self.size))
        return Frame(self.identifier, bytes(self.byte) + count.to_bytes(self.size, "little"))


class EmulatedBelts:
    """All belts of one bus."""

    def __init__(self, belts: Sequence[EmulatedBelt]) -> None:
        self.all = tuple(belts)
        self._last: Ns | None = None
        self._output: list[Frame] = []

    def receive(self, frames: Iterable[Frame]) -> None:
        """Every SYNC among them is answered."""
        for frame in frames:
            if frame.identifier not in SYNCS or not self.all:
                continue
            step = frame.stamp_ns - self._last if self._last is not None else 0
            self._last = frame.stamp_ns
            for belt in self.all:
                if 0 < step < LONGEST_NS:
                    belt.run(step * 1e-9)
                if not belt.silent:
                    self._output.append(belt.frame())

    def take_output(self) -> list[Frame]:
        """Since the last call."""
        output, self._output = self._output, []
        return output

    def state(self) -> list[dict[str, float]]:
        """Place and speed of each, in increments."""
        return [{"place": belt.place, "speed": belt.now} for belt in self.all]
