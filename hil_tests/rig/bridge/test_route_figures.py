"""`axisgate bench route` in small: a value goes from the command source to the bus and back through routes, judged by bus stamps."""

import statistics

from hil_tests.bench import route_drive
from hil_tests.bench.route_bench import BOTH_WAYS_LIMIT, ONE_WAY_LIMIT, measure
from hil_tests.lab.running.cell_running import P5_MS


def test_half_of_all_values_are_on_the_bus_and_back_within_the_bounds_of_the_bench() -> None:
    """The bench judges the 99th percentile on a quiet machine; a shared one is judged by its median."""
    out, back = measure(25, P5_MS)
    assert len(out) == len(back) == 25 and min(out) > 0
    assert statistics.median(out) <= ONE_WAY_LIMIT
    assert statistics.median(back) <= BOTH_WAYS_LIMIT


def test_a_drive_at_the_end_of_a_route_has_moved_and_is_seen_at_the_door_within_the_bound_of_the_bench() -> None:
    acts, back = route_drive.measure(12, P5_MS)
    assert len(acts) == len(back) == 12 and min(acts) > 1, "a set value is activated by the next SYNC"
    assert statistics.median(back) <= BOTH_WAYS_LIMIT
