"""Look-ahead over many short blocks: never starved, never slow, limits kept (goal 8; LinuxCNC #4154)."""

import pytest

from hil_tests.lab.virtual.contour import SPEED, stream


@pytest.mark.slow
@pytest.mark.timeout(240)
def test_1_500_segments_of_1_mm_are_streamed_without_starving() -> None:
    found = stream(1_500, 0.01)  # `axisgate bench motion` and `make soak` stream more
    assert found.starved == 0
    assert found.waiting >= 256, "looks ahead at least 256 blocks"
    assert found.slowest > 0.5 * SPEED
    assert found.accel <= 1.02 and found.jerk <= 1.05
