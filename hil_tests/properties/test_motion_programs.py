"""Random programs of an arm, a SCARA and a portal: limits, path and tool under random orders.  `make soak` drives 1,000."""

import pytest

from hil_tests.soak.motion import judged


@pytest.mark.parametrize("seed", [1, 2, 6])
def test_a_program_keeps_the_limits_of_its_axes_its_path_and_the_speeds_of_its_tool(seed: int) -> None:
    found = judged(seed)
    assert found.good, found
