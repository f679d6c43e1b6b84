"""The error list: first-out, counts, bound, and what clears what (rho3 3.3, 9.1)."""

from gateway.pure.image.error_list import ErrorList, Reset
from gateway.runtime.exit_codes import Exit
from protocols.base.machine import ms


def test_the_first_error_stays_first_and_repeats_are_counted() -> None:
    errors = ErrorList()
    assert errors.report(528, "cell", ms(1), source="rho3", reset=Reset.CONTROL_RESET)
    assert errors.report(7, "axis.X", ms(2))
    assert not errors.report(528, "cell", ms(9), source="rho3")
    first = errors.first
    assert first is not None
    assert (first.code, first.count, first.first_ns, first.last_ns, first.text_id) == (528, 2, ms(1), ms(9), "rho3.528")
    assert [record.code for record in errors.records] == [528, 7]


def test_one_code_in_two_places_is_two_errors() -> None:
    errors = ErrorList()
    assert errors.report(7, "axis.X", 0) and errors.report(7, "axis.Y", 0) and errors.report(7, "axis.X", 0, source="drive")
    assert len(errors.records) == 3


def test_the_list_is_bounded_and_keeps_what_came_first() -> None:
    errors = ErrorList(capacity=2)
    assert [errors.report(code, "x", code) for code in (1, 2, 3, 3)] == [True, True, False, False]
    assert [record.code for record in errors.records] == [1, 2] and errors.lost == 2


def test_an_error_leaves_only_when_its_cause_is_gone_and_the_right_is_enough() -> None:
    errors = ErrorList()
    errors.report(1, "x", 0, reset=Reset.ACKNOWLEDGE)
    errors.report(2, "x", 0, reset=Reset.CONTROL_RESET)
    assert errors.acknowledge(Reset.CONTROL_RESET) == 0  # both causes stand
    errors.gone(1, "x")
    errors.gone(2, "x")
    assert errors.acknowledge(Reset.ACKNOWLEDGE) == 1
    assert [record.code for record in errors.records] == [2]
    errors.report(2, "x", 5)  # it is back: the acknowledgement has to wait again
    assert errors.acknowledge(Reset.CONTROL_RESET) == 0
    errors.gone(2, "x")
    assert errors.acknowledge(Reset.CONTROL_RESET) == 1 and errors.first is None


def test_an_error_that_clears_itself_goes_with_its_cause() -> None:
    errors = ErrorList()
    errors.report(1, "line.plc", 0, reset=Reset.ITSELF)
    errors.gone(1, "line.plc")
    errors.gone(1, "line.plc")  # twice gone is no fault
    assert errors.first is None


def test_exit_codes() -> None:
    assert [code.value for code in (Exit.OK, Exit.FINDING, Exit.INVALID, Exit.ENVIRONMENT)] == [0, 1, 2, 3]
