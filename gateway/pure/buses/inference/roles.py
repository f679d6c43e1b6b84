"""Which message is whose set value or actual value, and which bit switched the drive on."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gateway.pure.buses.inference.series import Cycles, Series
from gateway.pure.buses.inference.signals import Found, flag_bits, of_message, steady_bits, without_torque

LAGS = 6  # cycles a drive may lag behind its set value
ANSWER_S = 2.0  # a bit that follows comes so soon
NEAR = 0.02  # of the way: a switch is at one position
SET_CHAIN = ("drive_on", "enable")
ACTUAL_CHAIN = ("power_on", "enabled")
DOUBT = 0.7  # the order alone names a bit: never surer than this


@dataclass(frozen=True, slots=True)
class Axis:
    """A set value and the actual value that follows it; identifiers."""

    number: int
    set_id: int
    actual_id: int
    confidence: float


@dataclass(frozen=True, slots=True)
class Inferred:
    """The complete proposal."""

    cycles: Cycles
    reverse: bool  # numbers have their high byte first
    axes: tuple[Axis, ...]
    signals: tuple[Found, ...]

    def of(self, identifier: int) -> list[Found]:
        """The signals of one message, in the order of their bits."""
        return sorted((each for each in self.signals if each.identifier == identifier), key=lambda each: each.start)


def infer(cycles: Cycles, reverse: bool) -> Inferred:
    """Fields of all messages, axes, and the names of their bits."""
    known: dict[int, list[Found]] = {series.identifier: of_message(series) for series in cycles.messages}
    places = {found.identifier: found for each in known.values() for found in each if found.name == "position_inc"}
    by_id = {series.identifier: series for series in cycles.messages}
    axes = tuple(_pairs(by_id, places))
    for axis in axes:
        set_, actual = by_id[axis.set_id], by_id[axis.actual_id]
        place = places[axis.actual_id]
        known[axis.set_id] = without_torque(known[axis.set_id])
        known[axis.set_id] += _set_bits(set_, known[axis.set_id], cycles)
        way = actual.values(place.start, place.bits, True)
        known[axis.actual_id] += _actual_bits(set_, actual, known, way, cycles)
    return Inferred(cycles, reverse, axes, tuple(found for each in known.values() for found in each))


def _pairs(by_id: Mapping[int, Series], places: Mapping[int, Found]) -> list[Axis]:
    """Of two positions that run alike the one that is ahead is the set value."""
    ways = {number: by_id[number].values(place.start, place.bits, True) for number, place in places.items()}
    rated: list[tuple[float, int, int]] = []
    for (a, first), (b, second) in itertools.permutations(ways.items(), 2):
        score = _leads(first, second)
        if score > 0.0:
            rated.append((score, a, b))
    axes: list[Axis] = []
    used: set[int] = set()
    for score, a, b in sorted(rated, reverse=True):
        if not {a, b} & used:
            used |= {a, b}
            axes.append(Axis(0, a, b, score))
    ordered = sorted(axes, key=lambda axis: axis.set_id)
    return [Axis(n, axis.set_id, axis.actual_id, axis.confidence) for n, axis in enumerate(ordered, 1)]


def _leads(a: Sequence[int], b: Sequence[int]) -> float:
    """How sure it is that b follows a: 0 not at all."""
    size = min(len(a), len(b)) - LAGS
    way = max(a) - min(a)
    if size < 10 or way == 0:
        return 0.0

    def distance(ahead: int) -> float:
        """Mean distance when b is `ahead` cycles late (or early)."""
        first, second = (a, b[ahead:]) if ahead >= 0 else (a[-ahead:], b)
        return sum(abs(x - y) for x, y in zip(first[:size], second[:size], strict=False)) / size

    later, earlier = min(distance(n) for n in range(1, LAGS + 1)), min(distance(-n) for n in range(1, LAGS + 1))
    if later >= earlier or later > 0.05 * way:
        return 0.0
    return min(0.98, 1.0 - later / way)


def _edges(series: Series, bit: int, up: bool) -> list[int]:
    return [n for n in series.flips(bit) if (series.words[n] >> bit & 1) == up]


def _set_bits(series: Series, taken: Sequence[Found], cycles: Cycles) -> list[Found]:
    """drive_on is the first to rise, enable the next, in the order the manual's boosters need (AX-105)."""
    bits = flag_bits(series, taken)
    rising = sorted((edges[0], bit) for bit in bits if (edges := _edges(series, bit, True)) and not series.words[0] >> bit & 1)
    named: dict[int, Found] = {}
    order = 0
    last = -1
    for cycle, bit in rising:
        if order < len(SET_CHAIN):
            name = SET_CHAIN[order] if cycle != last else f"{SET_CHAIN[order - 1]}_too_{bit}"
            order += cycle != last
            why = f"rose as number {order} of the set value's bits, {_falls(series, bit)}"
            named[bit] = Found(series.identifier, name, bit, 1, False, DOUBT, why)
        last = cycle
    return [named.get(bit, _unknown(series, bit)) for bit in bits] + _constants(series, taken)


def _falls(series: Series, bit: int) -> str:
    return f"fell {len(_edges(series, bit, False))} times"


def _unknown(series: Series, bit: int) -> Found:
    return Found(series.identifier, f"bit_{bit}", bit, 1, False, 0.1, f"changed {len(series.flips(bit))} times, meaning unknown")


def _constants(series: Series, taken: Sequence[Found]) -> list[Found]:
    return [Found(series.identifier, f"bit_{bit}", bit, 1, False, 0.1, "always 1, meaning unknown") for bit in steady_bits(series, taken)]


@dataclass(frozen=True, slots=True)
class _Follower:
    """A bit of the actual value that rises after one of the set value's bits."""

    bit: int
    cause: str  # name of that bit, "": it follows none
    rise: int  # cycles after it
    fall: int
    share: float  # of its rising edges


def _actual_bits(set_: Series, actual: Series, known: Mapping[int, list[Found]], way: Sequence[int], cycles: Cycles) -> list[Found]:
    """power_on follows drive_on, enabled follows enable and falls before the brake; a switch has a position; the rest is unnamed."""
    taken = known[actual.identifier]
    causes = {found.name: found.start for found in known[set_.identifier] if found.name in SET_CHAIN}
    limit = round(ANSWER_S * 1e9 / max(cycles.period_ns, 1))
    out: list[Found] = []
    used: set[str] = set()
    followers = [_follower(set_, actual, bit, causes, limit) for bit in flag_bits(actual, taken)]
    for each in sorted(followers, key=lambda each: (each.rise, each.fall, each.bit)):
        twins = sum((other.cause, other.rise, other.fall) == (each.cause, each.rise, each.fall) for other in followers) - 1
        switch = _switch(actual, each.bit, way)
        if switch is not None and each.share < 1.0:
            out.append(Found(actual.identifier, "reference_switch", each.bit, 1, False, DOUBT, switch))
        elif each.cause:
            out.append(_named(actual, each, used, twins))
        else:
            out.append(_unknown(actual, each.bit))
    return out + _constants(actual, taken)


def _named(actual: Series, each: _Follower, used: set[str], twins: int) -> Found:
    first = ACTUAL_CHAIN[SET_CHAIN.index(each.cause)]
    later = "brake_open" if each.cause == "enable" else ""
    name = next((name for name in (first, later) if name and name not in used), f"bit_{each.bit}")
    used.add(name)
    why = f"follows {each.cause} after {each.rise} cycles, falls {each.fall} after it, in {100 * each.share:.0f} % of its edges"
    why += f"; {twins} other bits do the same" if twins else ""
    return Found(actual.identifier, name, each.bit, 1, False, DOUBT * each.share / (1 + twins), why)


def _follower(set_: Series, actual: Series, bit: int, causes: Mapping[str, int], limit: int) -> _Follower:
    """The cause that came last before the bit rose."""
    best = _Follower(bit, "", 1 << 30, 1 << 30, 0.0)
    for name, cause in causes.items():
        rise, share = _delay(_edges(set_, cause, True), _edges(actual, bit, True), limit)
        fall, _ = _delay(_edges(set_, cause, False), _edges(actual, bit, False), limit)
        if share and (share, -rise) > (best.share, -best.rise):
            best = _Follower(bit, name, rise, fall, share)
    return best


def _delay(causes: Sequence[int], edges: Sequence[int], limit: int) -> tuple[int, float]:
    """Longest delay of the edges that have a cause within `limit` cycles before, and their share."""
    delays = [min((edge - cause for cause in causes if 0 <= edge - cause <= limit), default=None) for edge in edges]
    met = [delay for delay in delays if delay is not None]
    return (max(met), len(met) / len(edges)) if met else (1 << 30, 0.0)


def _switch(actual: Series, bit: int, way: Sequence[int]) -> str | None:
    """All its edges lie at one or two positions, and there are at least two edges."""
    edges = actual.flips(bit)
    span = max(way) - min(way)
    if len(edges) < 2 or span == 0:
        return None
    here = sorted(way[n] for n in edges)
    groups = 1 + sum(b - a > NEAR * span for a, b in itertools.pairwise(here))
    moving = all(way[n] != way[n - 1] for n in edges)
    if not moving or groups > 2 or groups == len(here):
        return None
    return f"all {len(edges)} edges at {groups} position{'s' if groups > 1 else ''} (about {here[0]})"
