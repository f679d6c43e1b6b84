"""Routes against each other: two that write one place, and rings of routes that would feed themselves."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Span:
    """A stretch of bits in one world ("RC input", "line plc DB 30", "value order.number", ..)."""

    world: str
    first: int = 0
    bits: int = 1

    def meets(self, other: "Span") -> bool:
        """True: both have a bit in common."""
        return self.world == other.world and self.first < other.first + other.bits and other.first < self.first + self.bits


@dataclass(frozen=True, slots=True)
class Joined:
    """One route by its places; `marks` are the places of its validity bit and life counter."""

    name: str
    source: Span
    target: Span
    marks: tuple[Span, ...] = ()

    @property
    def written(self) -> tuple[Span, ...]:
        return (self.target, *self.marks)


def two_writers(routes: Sequence[Joined]) -> list[tuple[str, str, Span]]:
    """(first route, second route, place of the second) for every place two routes, or one route twice, would write."""
    found = []
    for n, route in enumerate(routes):
        spans = route.written
        found += [(route.name, route.name, b) for k, b in enumerate(spans) if any(a.meets(b) for a in spans[:k])]
        for other in routes[:n]:
            found += [(other.name, route.name, b) for b in spans if any(a.meets(b) for a in other.written)]
    return found


def rings(routes: Sequence[Joined]) -> list[tuple[str, ...]]:
    """Each ring of routes once, by the names along it; a route whose target is its own source is one."""
    feeds = {route.name: [other.name for other in routes if any(span.meets(other.source) for span in route.written)] for route in routes}
    found: list[tuple[str, ...]] = []
    for start in feeds:
        ring = _ring_from(start, feeds)
        if ring and not any(set(ring) == set(known) for known in found):
            found.append(ring)
    return found


def _ring_from(start: str, feeds: dict[str, list[str]]) -> tuple[str, ...]:
    """The shortest way from a route back to itself; empty: there is none."""
    ways: list[tuple[str, ...]] = [(start,)]
    seen = set[str]()
    while ways:
        way = ways.pop(0)
        for following in feeds[way[-1]]:
            if following == start:
                return way
            if following not in seen:
                seen.add(following)
                ways.append((*way, following))
    return ()
