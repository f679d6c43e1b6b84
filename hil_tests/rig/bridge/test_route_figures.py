"""`axisgate bench route` in small: a value goes from the command source to the bus and back through routes, judged by bus stamps."""

import statistics

from hil_tests.bench import route_drive
from hil_tests.bench.route_bench import BOTH_WAYS_LIMIT, ONE_WAY_LIMIT, measure
from hil_tests.lab.running.cell_running import P5_MS

ACTIVATED_AND_LATCHED = 2.0  # cycles: the SYNC that activates a set value, the SYNC that latches what has moved (AX-001)


def test_half_of_all_values_are_on_the_bus_and_back_within_the_bounds_of_the_bench() -> None:
    """The bench judges the 99th percentile on a quiet machine; a shared one is judged by its median."""
    out, back = measure(25, P5_MS)
    assert len(out) == len(back) == 25 and min(out) > 0
    assert statistics.median(out) <= ONE_WAY_LIMIT
    assert statistics.median(back) <= BOTH_WAYS_LIMIT


def test_a_drive_with_the_limits_of_its_cell_gets_its_set_value_and_is_seen_within_the_bounds_of_the_bench() -> None:
    """What the gateway takes of the way: to the set value, and from the drive's telegram to the read-back; the rest is the axis' own."""
    orders, acts, back = route_drive.measure(12, P5_MS)
    assert len(orders) == len(acts) == len(back) == 12 and min(orders) > 0
    assert all(act - order > 1 for order, act in zip(orders, acts, strict=True)), "a set value is activated by the next SYNC"
    assert statistics.median(orders) <= ONE_WAY_LIMIT
    own = [order + ACTIVATED_AND_LATCHED + seen - act for order, act, seen in zip(orders, acts, back, strict=True)]
    assert statistics.median(own) <= BOTH_WAYS_LIMIT


def test_the_axis_of_the_bench_has_the_limits_of_its_cell() -> None:
    assert all("accel" not in part and "jerk" not in part for pair in route_drive.QUICK for part in pair)
