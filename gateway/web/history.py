"""History of every value over the last hours: one look a second, stored only when a value changed, older changes thinned to their extremes.

The memory is limited: a value has at most MOST_POINTS points, all values together ALL_POINTS.  Thinning halves the
older half of a value's points: the last hour stays complete, older hours keep the minimum and maximum of each step.  Times are of the
monotonic clock, so a corrected wall clock bends no curve.
"""

import math
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Mapping

MOST_POINTS, LEAST_POINTS, ALL_POINTS = 8192, 256, 4_000_000  # 16 bytes a point
HOURS = 24
GROUP = 4  # points thinned to two

Points = tuple[list[float], list[float]]


class Series:
    """Changes of one value; NaN: it was not known from then on."""

    def __init__(self) -> None:
        self.times, self.values = array("d"), array("d")

    def take(self, at: float, value: float, most: int) -> None:
        """The value of this moment."""
        if self.values and (value == self.values[-1] or (math.isnan(value) and math.isnan(self.values[-1]))):
            return
        self.times.append(at)
        self.values.append(value)
        if len(self.times) > most:
            self._thin(at)

    def _thin(self, at: float) -> None:
        old = bisect_left(self.times, at - HOURS * 3600.0)
        half = len(self.times) // 2
        times, values = array("d"), array("d")
        for first in range(max(0, old - 1), half, GROUP):
            places = range(first, min(first + GROUP, half))
            known = [n for n in places if not math.isnan(self.values[n])]
            keep = {min(known, key=self.values.__getitem__), max(known, key=self.values.__getitem__)} if known else {first}
            gap = [n for n in places if math.isnan(self.values[n])]
            for n in sorted({*keep, *gap[:1]}):
                times.append(self.times[n])
                values.append(self.values[n])
        self.times, self.values = times + self.times[half:], values + self.values[half:]

    def since(self, begin: float, end: float, most: int) -> Points:
        """The value at `begin`, its changes, the value at `end`; more than `most` points become extremes of equal pieces of time."""
        first = bisect_right(self.times, begin) - 1
        times, values = list(self.times[max(0, first) :]), list(self.values[max(0, first) :])
        if not times:
            return [], []
        if first >= 0:
            times[0] = begin
        times, values = _pieces(times, values, begin, end, most)
        if end > times[-1]:
            times.append(end)
            values.append(values[-1])
        return times, values


def _pieces(times: list[float], values: list[float], begin: float, end: float, most: int) -> Points:
    if len(times) <= most:
        return times, values
    width = (end - begin) / (most / 3)  # first, least and greatest of a piece
    kept_t: list[float] = []
    kept_v: list[float] = []
    place = 0
    while place < len(times):
        stop = max(place + 1, bisect_right(times, times[place] + width))
        known = [n for n in range(place, stop) if not math.isnan(values[n])] or [place]
        last = stop - 1  # the value at the end of the piece is the one that lasts
        for n in sorted({min(known, key=values.__getitem__), max(known, key=values.__getitem__), last}):
            kept_t.append(times[n])
            kept_v.append(values[n])
        place = stop
    return kept_t, kept_v


class History:
    """All values of one cell by their ids."""

    def __init__(self) -> None:
        self._all: dict[str, Series] = {}
        self.began = math.nan

    def take(self, at: float, values: Mapping[str, float]) -> None:
        """One look, `at` in s; times rise."""
        if math.isnan(self.began):
            self.began = at
        most = min(MOST_POINTS, max(LEAST_POINTS, ALL_POINTS // max(1, len(self._all))))
        for name, value in values.items():
            series = self._all.get(name)
            if series is None:
                series = self._all[name] = Series()
            series.take(at, value, most)

    def since(self, name: str, begin: float, end: float, most: int = 2000) -> Points:
        """([], []): nothing is known of this value."""
        series = self._all.get(name)
        return series.since(begin, end, most) if series is not None else ([], [])
