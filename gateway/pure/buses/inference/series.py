"""A recording cut into cycles, and the bits of each message over time."""

import itertools
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from protocols.base.machine import Frame, Ns

LEAST = 100  # cycles: less proves nothing
SHARE = 0.8  # share of the cycles in which a cyclic message is present
MANY, FEW = 1.5, 5  # flips: a higher bit that flips this much more often begins a new number
CARRY = 0.3  # share of a bit's flips with which the bit below flips too: below it they are not neighbours in one number


@dataclass(frozen=True, slots=True)
class Series:
    """One message: a value for each cycle, as the little-endian word of its (perhaps reversed) bytes."""

    identifier: int
    length: int
    words: tuple[int, ...]
    order: float  # mean place in the burst, 0 first
    changes: tuple[tuple[int, ...], ...]  # for each bit the cycles in which it differs from the cycle before

    def flips(self, bit: int) -> tuple[int, ...]:
        return self.changes[bit]

    def values(self, start: int, bits: int, signed: bool) -> list[int]:
        """The number in `bits` bits from `start`."""
        mask, sign = (1 << bits) - 1, (1 << bits - 1) if signed else 0
        return [((word >> start & mask) ^ sign) - sign for word in self.words]


@dataclass(frozen=True, slots=True)
class Cycles:
    """The cyclic part of a recording."""

    sync: int | None  # identifier, None: no message begins the cycle without data
    period_ns: Ns
    messages: tuple[Series, ...]


@dataclass(frozen=True, slots=True)
class Piece:
    """Neighbouring bits that count as one number; `top`: first bit above that changes for something else."""

    start: int
    bits: int
    top: int
    flips: int  # of its lowest bit


def cut(frames: Sequence[Frame], reverse: bool) -> Cycles | None:
    """Frames into cycles; None when nothing in them comes in a cycle.  `reverse`: bytes backwards, for numbers with the high byte first."""
    kinds = Counter(frame.identifier for frame in frames)
    if not kinds or max(kinds.values()) < LEAST:
        return None
    empty = [number for number, count in kinds.items() if count >= LEAST and all(not f.data for f in frames if f.identifier == number)]
    leader = max(empty or kinds, key=lambda number: kinds[number])
    starts = [n for n, frame in enumerate(frames) if frame.identifier == leader]
    gaps = [frames[b].stamp_ns - frames[a].stamp_ns for a, b in itertools.pairwise(starts)]
    lengths = {frame.identifier: len(frame.data) for frame in reversed(frames)}
    words: dict[int, list[int]] = defaultdict(list)
    places: dict[int, list[int]] = defaultdict(list)
    for number, (first, after) in enumerate(zip(starts, [*starts[1:], len(frames)], strict=True)):
        for place, frame in enumerate(frames[first:after]):
            known = words[frame.identifier]
            if frame.data and len(known) <= number and len(frame.data) == lengths[frame.identifier]:
                word = int.from_bytes(frame.data, "big" if reverse else "little")
                known += [known[-1] if known else word] * (number - len(known))  # cycles in which it did not come
                known.append(word)
                places[frame.identifier].append(place)
    wanted = SHARE * len(starts)
    messages = tuple(
        _series(number, lengths[number], (*found, *[found[-1]] * (len(starts) - len(found))), sum(places[number]) / len(places[number]))
        for number, found in sorted(words.items())
        if len(places[number]) >= wanted
    )
    return Cycles(leader if empty else None, round(median(gaps)) if gaps else 0, messages)


def _series(identifier: int, length: int, words: tuple[int, ...], order: float) -> Series:
    changes: list[list[int]] = [[] for _ in range(8 * length)]
    for n, (before, word) in enumerate(itertools.pairwise(words), 1):
        differs = before ^ word
        while differs:
            low = differs & -differs
            changes[low.bit_length() - 1].append(n)
            differs ^= low
    return Series(identifier, length, words, order, tuple(map(tuple, changes)))


def pieces(series: Series) -> list[Piece]:
    """The changing bits of a message, cut where a number ends."""
    width = 8 * series.length
    flips = [series.flips(bit) for bit in range(width)]
    found: list[tuple[int, int]] = []
    begin: int | None = None
    for bit in range(width + 1):
        if begin is not None and (bit == width or not flips[bit] or _border(flips[bit - 1], flips[bit])):
            found.append((begin, bit))
            begin = None
        if bit < width and flips[bit] and begin is None:
            begin = bit
    tops = [*(start for start, _ in found[1:]), width][: len(found)]
    return [Piece(start, end - start, top, len(flips[start])) for (start, end), top in zip(found, tops, strict=True)]


def _border(below: Sequence[int], above: Sequence[int]) -> bool:
    """In a number a bit flips less often than the one below it, and when it flips by a carry that one flips too."""
    if len(above) > MANY * len(below) + FEW:
        return True
    together = len(set(below) & set(above))
    return together < CARRY * len(above)
