"""Stop times out of positions told on a bus (AX-432)."""

import pytest

from gateway.tools.drives.loss_test_on_bus import Track, judged
from protocols.base.machine import Ns, ms

LOST: Ns = ms(10_000)


def track(react_ms: int, stop_ms: int, speed_inc_ms: int = 10, emergency: int = 0, until_ms: int = 1000) -> Track:
    """Constant speed up to `react_ms` after the loss, a straight ramp to rest at `stop_ms`, sampled every 8 ms."""
    found, place = Track(emergency_ns=LOST + ms(emergency) if emergency else 0), 0.0
    for t in range(-200, until_ms, 8):
        found.places.append((LOST + ms(t), round(place)))
        share = 1.0 if t < react_ms else max(0.0, (stop_ms - t) / max(1, stop_ms - react_ms))
        place += 8 * speed_inc_ms * share
    return found


def test_reaction_rest_and_way_of_a_ramp() -> None:
    found = judged(track(react_ms=152, stop_ms=400), LOST)
    assert found is not None and found.stopped
    assert found.speed_inc_s == pytest.approx(10_000, rel=0.01)
    assert 152 < found.reaction_ms <= 152 + 60, "seen by its slope"
    assert found.stop_ms == pytest.approx(400, abs=16)
    assert found.way_inc == pytest.approx(10 * 152 + 10 * 248 / 2, abs=120)


def test_an_emergency_reports_the_reaction_before_the_slope_does() -> None:
    found = judged(track(react_ms=152, stop_ms=400, emergency=153), LOST)
    assert found is not None and found.reaction_ms == 153


@pytest.mark.parametrize("speed", [10, -10])
def test_a_drive_that_runs_on_does_not_stand_and_has_no_reaction(speed: int) -> None:
    found = judged(track(react_ms=5000, stop_ms=6000, speed_inc_ms=speed), LOST)
    assert found is not None and not found.stopped and found.reaction_ms == float("inf")


def test_a_drive_that_stood_has_nothing_to_react_to() -> None:
    found = judged(track(react_ms=0, stop_ms=1, speed_inc_ms=0), LOST)
    assert found is not None and (found.reaction_ms, found.way_inc, found.stopped) == (0.0, 0, True)


def test_a_drive_that_sent_nothing_before_or_after_the_loss_is_not_judged() -> None:
    late, early = track(0, 1), track(0, 1)
    late.places = [place for place in late.places if place[0] > LOST]
    early.places = [place for place in early.places if place[0] <= LOST]
    assert judged(late, LOST) is None and judged(early, LOST) is None
