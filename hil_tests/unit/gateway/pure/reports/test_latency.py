"""The verdict of doctor: percentiles by nearest rank, the clock that is good enough, and the sentence."""

import pytest

from gateway.pure.reports.latency import Measured, verdict


def echo(*times: float) -> Measured:
    return Measured("adapter echo", sorted(times))


def test_percentiles_are_times_that_were_measured() -> None:
    thousand = echo(*map(float, range(1, 1001)))
    assert [thousand.percentile(part) for part in (0.0, 0.5, 0.99, 0.999, 1.0)] == [1.0, 500.0, 990.0, 999.0, 1000.0]
    assert echo(7.0).percentile(0.999) == 7.0 and echo(1.0, 2.0).percentile(0.5) == 1.0
    assert thousand.figures() == {"count": 1000.0, "p50": 500.0, "p99": 990.0, "p99.9": 999.0, "max": 1000.0}


@pytest.mark.parametrize(
    ("time", "good", "words"),
    [
        (3.1, 4, "good for 4 ms, not for 2 ms: adapter echo p99.9 = 3.1 ms"),
        (1.0, 2, "good for 2 ms: adapter echo p99.9 = 1.0 ms"),
        (2.0, 4, "good for 4 ms, not for 2 ms: adapter echo p99.9 = 2.0 ms"),
        (17.0, 32, "good for 32 ms, not for 16 ms: adapter echo p99.9 = 17.0 ms"),
        (32.0, None, "not good for 32 ms: adapter echo p99.9 = 32.0 ms"),
    ],
)
def test_the_sentence(time: float, good: int | None, words: str) -> None:
    found = verdict([echo(*[0.5] * 10, time)])
    assert (found.good, found.words) == (good, words)


def test_one_outlier_in_two_thousand_does_not_decide() -> None:
    assert verdict([echo(*[0.5] * 1999, 50.0)]).good == 2


def test_the_worst_decides_and_is_named() -> None:
    late = Measured("scheduling of this machine", [0.1, 1.5], 0.25)
    assert late.clock() == 8
    assert verdict([echo(3.1), late]).words == "good for 8 ms, not for 4 ms: scheduling of this machine p99.9 = 1.5 ms"
    assert verdict([echo(9.0), late]).words == "good for 16 ms, not for 8 ms: adapter echo p99.9 = 9.0 ms"
    with pytest.raises(ValueError, match="nothing was measured"):
        verdict([])
