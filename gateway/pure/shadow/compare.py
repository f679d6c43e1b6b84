"""Compares axisgate's answers with those of the old controller: equal for which share of the time, else how far apart (AX-493).

axisgate's state is known at every change, that of the old controller only when the tap sees an answer.  Each answer covers
a span: from the request until the answer began.  An entry is equal if axisgate had its value in that span; else the nearest moment at
which axisgate had it is searched, before (axisgate earlier) and after (axisgate later), which is why an answer is judged only when the
horizon has passed.
"""

import math
from collections import deque
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.shadow.addresses import Place
from protocols.base.machine import Ns, ms

HORIZON: Ns = ms(2_000)  # so far apart the same value is still looked for
SLACK: Ns = ms(10)  # two ticks of the services: so exact moments of ours are
LONGEST: Ns = ms(2_000)  # an answer counts for the time since the one before, at most this long
SEARCHED: Ns = ms(50)  # search period for a number that always differs: the search is slow, and an occasional one shows as much
KEPT = 8192  # contents of one block: more than the horizon holds at any pace


@dataclass(slots=True)
class Row:
    """What was found of one place."""

    place: Place
    judged: int = 0
    time: Ns = 0
    different: int = 0
    different_time: Ns = 0
    later: Ns = 0  # largest delay of axisgate's value
    earlier: Ns = 0
    never: int = 0  # ours did not have it within the horizon at all
    largest: float = 0.0  # difference of numbers
    first: tuple[Ns, float, float] | None = None  # moment, there, here
    last: Ns = 0  # moment of the last difference
    changes_there: int = 0
    changes_here: int = 0
    searched: Ns = 0  # moment of the answer that was looked for last
    _there: bytes | None = None
    _here: bytes | None = None

    def saw(self, there: bytes, here: bytes) -> None:
        """Record a counter that runs independently."""
        self.changes_there += self._there not in (None, there)
        self.changes_here += self._here not in (None, here)
        self._there, self._here = there, here


@dataclass(slots=True)
class Block:
    """One data block, area or telegram."""

    name: str
    rows: list[Row]
    judged: int = 0
    time: Ns = 0
    different: int = 0
    different_time: Ns = 0
    last: Ns = 0  # moment of the last answer
    here: deque[tuple[Ns, bytes]] = field(default_factory=lambda: deque(maxlen=KEPT))
    _mask: bytes = b""

    def __post_init__(self) -> None:
        size = max((row.place.at + len(row.place.mask) for row in self.rows), default=0)
        mask = bytearray(size)
        for row in self.rows:
            for n, octet in enumerate(row.place.mask):
                mask[row.place.at + n] |= 0 if row.place.counts else octet
        self._mask = bytes(mask)

    def looks_equal(self, one: bytes, other: bytes, first: int) -> bool:
        """All compared bits of what `one` carries from byte `first` on."""
        mask = self._mask[first : first + len(one)]
        size = len(mask)
        wanted = int.from_bytes(mask, "big")
        there, here = int.from_bytes(one[:size], "big"), int.from_bytes(other[first : first + size].ljust(size, b"\0"), "big")
        return not (there ^ here) & wanted


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer of the old controller."""

    key: Hashable
    asked: Ns
    answered: Ns
    first: int  # byte of the block
    data: bytes


class Comparison:
    """Blocks by their keys; an undeclared block is unknown until `declare`."""

    def __init__(self, slack: Ns = SLACK, horizon: Ns = HORIZON) -> None:
        self.blocks: dict[Hashable, Block] = {}
        self._slack, self._horizon = slack, horizon
        self._waiting: deque[Answer] = deque()

    def declare(self, key: Hashable, name: str, places: Sequence[Place]) -> None:
        """A block that is compared from now on."""
        self.blocks.setdefault(key, Block(name, [Row(place) for place in places]))

    def ours(self, key: Hashable, data: bytes, now: Ns) -> None:
        """What axisgate would answer from now on."""
        here = self.blocks[key].here
        if not here or here[-1][1] != data:
            here.append((now, data))

    def theirs(self, answer: Answer) -> None:
        """Record an answer of the old controller; it is judged when the horizon has passed."""
        self._waiting.append(answer)

    def settle(self, now: Ns) -> None:
        """Judge the answers that are old enough."""
        while self._waiting and now - self._waiting[0].answered >= self._horizon:
            self._judge(self._waiting.popleft())

    def finish(self) -> None:
        """Finish: judge the waiting answers by the known content."""
        while self._waiting:
            self._judge(self._waiting.popleft())

    # ---- one answer --------------------------------------------------------------------------------------------------
    def _judge(self, answer: Answer) -> None:
        block = self.blocks[answer.key]
        weight = min(answer.answered - block.last, LONGEST) if block.last else 0
        block.last = answer.answered
        start, end = answer.asked - self._slack, answer.answered + self._slack
        around = list(_held(block.here, start, end))
        if not around:
            return  # ours did not exist yet
        block.judged += 1
        block.time += weight
        whole = any(block.looks_equal(answer.data, data, answer.first) for _, _, data in around)
        latest = around[-1][2]
        different = False
        for row in block.rows:
            place = row.place
            if place.at < answer.first or place.at + len(place.mask) > answer.first + len(answer.data):
                continue
            there = bytes(answer.first) + answer.data
            row.judged += 1
            row.time += weight
            if place.counts:
                row.saw(place.part(there), place.part(latest))
            elif not whole and not _fits(place, there, [data for _, _, data in around]):
                different = True
                self._differs(row, block, answer, there, latest, weight)
        block.different += different
        block.different_time += weight if different else 0

    def _differs(self, row: Row, block: Block, answer: Answer, there: bytes, here: bytes, weight: Ns) -> None:
        row.different += 1
        row.different_time += weight
        row.last = answer.answered
        was, now = row.place.value(there), row.place.value(here)
        if row.first is None:
            row.first = (answer.answered, was, now)
        if row.place.number is not None and not math.isnan(was - now):
            row.largest = max(row.largest, abs(was - now))
            if 0 < answer.answered - row.searched < SEARCHED:
                return
        row.searched = answer.answered
        apart = _nearest(row.place, there, block.here, answer.asked, answer.answered, self._horizon)
        if apart is None:
            row.never += 1
        elif apart > 0:
            row.later = max(row.later, apart)
        else:
            row.earlier = max(row.earlier, -apart)


def _held(here: deque[tuple[Ns, bytes]], start: Ns, end: Ns) -> Iterator[tuple[Ns, Ns, bytes]]:
    """Yield (from, to, content) of each content held between two moments, in order."""
    found: list[tuple[Ns, Ns, bytes]] = []
    until = end + 1
    for begun, data in reversed(here):
        if begun <= end:
            found.append((begun, until, data))
        until = begun
        if begun <= start:
            break
    return reversed(found)


def _fits(place: Place, there: bytes, contents: Sequence[bytes]) -> bool:
    """Ours held it in one of these contents; a number also on its way from one to the next."""
    wanted = place.part(there)
    parts = [place.part(data) for data in contents]
    if wanted in parts:
        return True
    if place.number is None:
        return False
    number, numbers = place.number(wanted), [place.number(part) for part in parts if len(part) == len(place.mask)]
    low, high = min(numbers, default=math.nan), max(numbers, default=math.nan)
    return low - place.within <= number <= high + place.within


def _nearest(place: Place, there: bytes, here: deque[tuple[Ns, bytes]], asked: Ns, answered: Ns, horizon: Ns) -> Ns | None:
    """Return how much later (earlier: negative) axisgate held the content than the old controller sent it; None: not within the horizon."""
    best: Ns | None = None
    until, after = answered + horizon, b""
    for begun, data in reversed(here):
        moments: list[tuple[Ns, Ns]] = []
        if _fits(place, there, [data]):
            moments.append((begun, until))
        elif after and _fits(place, there, [data, after]):
            moments.append((until, until))  # on its way to the next
        for start, end in moments:
            apart = start - answered if start > answered else min(end - asked, 0)
            if best is None or abs(apart) < abs(best):
                best = apart
        if begun < asked - (horizon if best is None else abs(best)):
            break  # earlier content is further away
        until, after = begun, data
    return best if best is None or abs(best) <= horizon else None


def share(different: Ns, time: Ns, wrong: int, judged: int) -> float:
    """Return the equal share, 0..1: of the time, or of the answers while there is no time yet."""
    if time:
        return 1.0 - different / time
    return 1.0 - wrong / judged if judged else 1.0


def as_data(comparison: Comparison, started: Ns, now: Ns) -> list[Mapping[str, object]]:
    """Blocks in the order they were declared; times in ms since the start, or as named."""
    return [_block_data(block, started, now) for block in comparison.blocks.values() if block.judged]


def _block_data(block: Block, started: Ns, now: Ns) -> Mapping[str, object]:
    differing = [row for row in block.rows if row.different or (row.place.counts and bool(row.changes_there) is not bool(row.changes_here))]
    return {
        "block": block.name,
        "answers": block.judged,
        "time_s": round(block.time / 1e9, 3),
        "equal_percent": round(100.0 * share(block.different_time, block.time, block.different, block.judged), 4),
        "different": block.different,
        "age_s": round((now - block.last) / 1e9, 3),
        "compared": len([row for row in block.rows if row.judged]),
        "places": [_row_data(row, started, now) for row in differing],
    }


def _row_data(row: Row, started: Ns, now: Ns) -> Mapping[str, object]:
    first = None
    if row.first is not None:
        moment, there, here = row.first
        first = {"at_s": round((moment - started) / 1e9, 3), "there": _plain(there), "here": _plain(here)}
    return {
        "place": row.place.label,
        "name": row.place.name,
        "equal_percent": round(100.0 * share(row.different_time, row.time, row.different, row.judged), 4),
        "different": row.different,
        "of": row.judged,
        "later_ms": round(row.later / 1e6, 1),
        "earlier_ms": round(row.earlier / 1e6, 1),
        "never": row.never,
        "largest": row.largest if row.place.number is not None else None,
        "first": first,
        "last_age_s": round((now - row.last) / 1e9, 3) if row.last else None,
        "counts": {"there": row.changes_there, "here": row.changes_here} if row.place.counts else None,
    }


def _plain(value: float) -> float | int | None:
    if math.isnan(value):
        return None
    return int(value) if value == int(value) else round(value, 6)
