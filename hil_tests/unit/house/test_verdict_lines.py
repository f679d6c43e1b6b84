"""A line of the demo's summary."""

import math

from hil_tests.lab.judges.verdicts import at_most


def test_what_was_not_measured_does_not_hold_and_is_called_so() -> None:
    assert at_most("lag, %", math.nan, 5).line() == "FAIL  lag, %: not measured (<= 5)"
    assert at_most("lag, %", 0.16071, 5).line() == "ok    lag, %: 0.1607 (<= 5)"
