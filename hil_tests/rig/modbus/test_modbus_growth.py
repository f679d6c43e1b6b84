"""Partners that go wrong, one after another: the server neither grows nor keeps descriptors (long form: bench modbus)."""

import pytest

from hil_tests.bench.modbus_bench import GROWTH_LIMIT, Load, Pair, growth, load, ratio, served


@pytest.mark.cref
def test_two_thousand_failed_connects_leave_nothing_behind() -> None:
    grown, descriptors = growth(2000)
    assert grown < GROWTH_LIMIT and descriptors == 0


@pytest.mark.cref
@pytest.mark.parametrize("kind", ["ours", "pymodbus"])
def test_both_servers_of_the_bench_answer_the_load(kind: str) -> None:
    with served(kind) as (port, _):
        told = load(port, 8, 0.3)
        assert told is not None and told.rate > 100 and told.p99_us > 0


def test_the_ratio_is_the_median_of_neighbours() -> None:
    pair = Pair([Load(300), Load(100), Load(900)], [Load(100), Load(100), Load(100)])
    assert ratio("x", pair, 3.0)["value"] == 3.0 and ratio("x", pair, 3.0)["met"] and not ratio("x", pair, 3.1)["met"]
    assert not ratio("x", Pair(), 1.0)["met"]
