"""What a CAN bus has to carry in a cycle, frame by frame, and whether it fits.

Source: can.md C4 (frame lengths, cycle contents), rho3 2.1 and 2.2 (SERVODYN identifiers, I/O blocks), CiA 301 (identifiers).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from protocols.base.can_bits import frame_bits, plain_bits, worst_bits

SAMPLES = 64  # payloads from which `typical` is computed
BLOCKING_BYTES = 8  # the longest frame that may just have begun when SYNC is due: nothing can take that away


@dataclass(frozen=True, slots=True)
class Traffic:
    """One frame of a cell's plan."""

    what: str
    identifier: int
    length: int  # data bytes
    every_ms: float | None = None  # None: once in each cycle
    acyclic: bool = False  # at most one of these a cycle; shown apart


@dataclass(frozen=True, slots=True)
class Times:
    """Microseconds on the wire: without stuffing, for mixed data, and the worst there is."""

    plain: float
    typical: float
    worst: float

    def __add__(self, other: "Times") -> "Times":
        return Times(self.plain + other.plain, self.typical + other.typical, self.worst + other.worst)

    def scaled(self, factor: float) -> "Times":
        return Times(self.plain * factor, self.typical * factor, self.worst * factor)


NOTHING = Times(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Judgement:
    """Does it fit?"""

    cycle: Times  # us in each cycle, slower frames by their share
    acyclic: Times  # us of one acyclic exchange a cycle on top
    sync_blocked: float  # us SYNC may have to wait for a frame that has just begun
    shortest_ms: int  # shortest cycle that carries all of it in the worst case
    fits: bool  # worst case, one acyclic exchange and the blocking frame included


def times(one: Traffic, bitrate: int) -> Times:
    """us of one such frame."""
    us = 1e6 / bitrate
    return Times(plain_bits(one.length) * us, _typical(one.identifier, one.length) * us, worst_bits(one.length) * us)


def judge(plan: Sequence[Traffic], bitrate: int, cycle_ms: float) -> Judgement:
    """bitrate: bit/s."""
    always = [one for one in plan if not one.acyclic]
    cycle = _sum([times(one, bitrate).scaled(cycle_ms / one.every_ms if one.every_ms else 1.0) for one in always])
    acyclic = _sum([times(one, bitrate) for one in plan if one.acyclic])
    blocked = worst_bits(BLOCKING_BYTES) * 1e6 / bitrate
    shortest = next(n for n in range(1, 10_000) if _need(always, acyclic, blocked, bitrate, n) <= 1000.0 * n)
    fits = _need(always, acyclic, blocked, bitrate, cycle_ms) <= 1000.0 * cycle_ms
    return Judgement(cycle, acyclic, blocked, shortest, fits)


def _need(always: Sequence[Traffic], acyclic: Times, blocked: float, bitrate: int, cycle_ms: float) -> float:
    """Return the worst us in one cycle; a slower frame may fall completely into it."""
    return sum(times(one, bitrate).worst for one in always if not one.every_ms or one.every_ms >= cycle_ms) + acyclic.worst + blocked


def _sum(parts: Sequence[Times]) -> Times:
    total = NOTHING
    for part in parts:
        total += part
    return total


@cache
def _typical(identifier: int, length: int) -> float:
    """Mean over mixed payloads of a fixed linear congruence: the same figure on every machine."""
    state, bits = 12345, 0
    for _ in range(SAMPLES):
        data = bytearray()
        for _ in range(length):
            state = (1103515245 * state + 12345) & 0x7FFFFFFF
            data.append(state >> 16 & 0xFF)
        bits += frame_bits(identifier, bytes(data))
    return bits / SAMPLES
