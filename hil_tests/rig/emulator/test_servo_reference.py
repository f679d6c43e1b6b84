"""The bare step in C (hil_tests/bench/servo_ref.c) and the Python model are the same arithmetic."""

import pytest

from hil_tests.bench.emulator_bench import ALL_ON, reference, same_in_python


@pytest.mark.cref
def test_the_model_in_c_ends_where_the_model_in_python_ends() -> None:
    _, position = reference(1, 500, ALL_ON)
    assert abs(position) > 10.0
    assert same_in_python(500, ALL_ON) == pytest.approx(position, abs=1e-9)
