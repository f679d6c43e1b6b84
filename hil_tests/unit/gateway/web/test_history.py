"""AX-805: what a value was over hours, in bounded memory; thinned hours keep their extremes."""

import math

import pytest

from gateway.observer.names import Entry
from gateway.web.history import HOURS, MOST_POINTS, History, Series
from gateway.web.trends import number_of, shown_unit

HOUR = 3600.0


def test_a_value_is_kept_where_it_changes_and_stays_to_the_end() -> None:
    history = History()
    for second in range(100):
        history.take(float(second), {"a": 1.0 if 40 <= second < 60 else 0.0})
    assert history.since("a", 10.0, 99.0) == ([10.0, 40.0, 60.0, 99.0], [0.0, 1.0, 0.0, 0.0])
    assert history.since("a", 50.0, 99.0) == ([50.0, 60.0, 99.0], [1.0, 0.0, 0.0])
    assert history.since("b", 10.0, 99.0) == ([], [])


def test_a_value_that_was_not_known_leaves_a_gap_once() -> None:
    series = Series()
    for second, value in enumerate((1.0, math.nan, math.nan, 2.0)):
        series.take(float(second), value, MOST_POINTS)
    times, values = series.since(0.0, 4.0, 100)
    assert times == [0.0, 1.0, 3.0, 4.0]
    assert [math.isnan(value) for value in values] == [False, True, False, False]


def test_hours_of_a_value_that_never_rests_stay_bounded_and_keep_their_extremes() -> None:
    series = Series()
    for second in range(round(8 * HOUR)):
        value = math.sin(second / 500.0) + (100.0 if second == 7000 else -50.0 if second == 9000 else 0.0)
        series.take(float(second), value, MOST_POINTS)
    assert len(series.times) <= MOST_POINTS
    for most in (MOST_POINTS, 500):
        times, values = series.since(0.0, 8 * HOUR, most)
        assert max(values) > 99.0 and min(values) < -50.0 and times == sorted(times)
        assert 2 * most // 10 < len(times) <= 1.1 * most + 5
    last, _ = series.since(7.5 * HOUR, 8 * HOUR, MOST_POINTS)
    assert len(last) == pytest.approx(1800, abs=2), "the newest part is whole"


def test_what_is_older_than_a_day_goes() -> None:
    series = Series()
    for minute in range(5 * 24 * 60):
        series.take(60.0 * minute, float(minute % 2), 2048)
    assert series.times[-1] - series.times[0] < 1.5 * HOURS * HOUR


@pytest.mark.parametrize(
    "type_, where, unit, told, number, shown",
    [
        ("KF", "2", "0.1 mm", "ff83", -12.5, "mm"),
        ("DH", "2", "", "ffffffff", -1.0, ""),
        ("KG", "4", "mm", "0b4b0800", 1200.5, "mm"),
        ("REAL", "4", "mm", "44961000", 1200.5, "mm"),
        ("KH", "1DR", "", "1264", 100.0, ""),
        ("KY", "1", "", "0102", 258.0, ""),
    ],
)
def test_a_word_is_a_number_of_its_type_and_unit(type_: str, where: str, unit: str, told: str, number: float, shown: str) -> None:
    entry = Entry(f"db:10:{where}", "DB 10", "a name", (), "word", type_, unit)
    assert number_of(entry, [told, 2, None, False]) == pytest.approx(number)
    assert shown_unit(entry) == shown
    assert math.isnan(number_of(entry, [told, 0, None, False])) and math.isnan(number_of(entry, None))
