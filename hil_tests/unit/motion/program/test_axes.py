"""rho 3: interruptible axes (section 3), disabled axes (section 11), several axes on one set-point output (section 17)."""

import pytest

from motion.axes.disabled import DisabledAxes
from motion.axes.errors import DRIVE_ON_NOT_ALLOWED, DRIVE_ON_NOT_AVAILABLE, AxisError
from motion.axes.interruptible import DriveOn
from motion.axes.shared import SharedOutput, groups
from motion.errors import MotionError

ON, OFF = (True, True, True), (True, True, False)
SET, ACTUAL = (1.0, 2.0, 3.0), (1.1, 2.1, 3.1)


def switched_on() -> DriveOn:
    axes = DriveOn(3)
    axes.update(False, ON, SET, ACTUAL, moving=False, program=False)
    return axes


def refusal(axes: DriveOn, target: tuple[float, ...], *, until: bool = False) -> str:
    """Text of the error a move from (1, 2, 3) meets; empty: it may run."""
    try:
        axes.check_move((1.0, 2.0, 3.0), target, until=until)
    except AxisError as error:
        return f"{error.axis} {error.text}"
    return ""


@pytest.mark.requirement("RHO-MOT-46", by="motion.axes.interruptible:DriveOn.update")
def test_drive_on_0_takes_the_axis_out_of_the_loop_and_its_position_follows() -> None:
    axes = switched_on()
    assert axes.update(False, ON, SET, ACTUAL, moving=True, program=True) == SET
    assert axes.update(False, OFF, SET, ACTUAL, moving=True, program=True) == (1.0, 2.0, 3.1)
    assert axes.update(False, OFF, SET, (1.1, 2.1, 4.0), moving=True, program=True) == (1.0, 2.0, 4.0)
    back = axes.update(False, ON, SET, (1.1, 2.1, 4.5), moving=False, program=True)
    assert back == (1.0, 2.0, 4.5), "set := actual when it comes back"


@pytest.mark.requirement("RHO-MOT-46", by="motion.axes.interruptible:DriveOn.check_move")
def test_a_move_of_a_disabled_axis_is_refused_by_what_the_axes_really_do() -> None:
    axes = switched_on()
    assert refusal(axes, (1.0, 2.0, 9.0)) == ""
    axes.update(False, OFF, SET, ACTUAL, moving=False, program=True)
    assert refusal(axes, (5.0, 7.0, 3.0)) == "", "axes 1 and 2 go on, also in world coordinates"
    assert refusal(axes, (1.0, 2.0, 3.001)) == "3 DRIVE ON not avail."


@pytest.mark.requirement("RHO-MOT-46", by="motion.axes.interruptible:DriveOn.accept")
def test_coming_back_in_a_program_needs_move_until_before_the_next_block() -> None:
    axes = switched_on()
    axes.update(False, OFF, SET, ACTUAL, moving=False, program=True)
    axes.update(False, ON, SET, ACTUAL, moving=False, program=True)
    assert refusal(axes, (5.0, 2.0, 3.0)) == f"3 {DRIVE_ON_NOT_AVAILABLE}"
    axes.accept(until=False)
    assert refusal(axes, (5.0, 2.0, 3.0)) != "", "MOVE TO @POS does not count"
    assert refusal(axes, (1.0, 2.0, 3.5), until=True) == ""
    axes.accept(until=True)
    assert refusal(axes, (5.0, 2.0, 9.0)) == ""


def test_without_a_program_nothing_has_to_be_accepted() -> None:
    axes = switched_on()
    axes.update(False, OFF, SET, ACTUAL, moving=False, program=False)
    axes.update(False, ON, SET, ACTUAL, moving=False, program=False)
    assert refusal(axes, (1.0, 2.0, 9.0)) == ""
    axes.update(False, OFF, SET, ACTUAL, moving=False, program=True)
    axes.update(False, ON, SET, ACTUAL, moving=False, program=True)
    axes.program_ended()
    assert refusal(axes, (1.0, 2.0, 9.0)) == ""


def test_coming_back_while_the_kinematic_moves_is_not_allowed() -> None:
    axes = switched_on()
    axes.update(False, OFF, SET, ACTUAL, moving=True, program=True)
    with pytest.raises(AxisError, match=DRIVE_ON_NOT_ALLOWED) as caught:
        axes.update(False, ON, SET, ACTUAL, moving=True, program=True)
    assert caught.value.axis == 3 and axes.on == [True, True, False]


def test_the_group_signal_overrules_the_single_ones() -> None:
    axes = switched_on()
    axes.update(True, (False, False, False), SET, ACTUAL, moving=False, program=False)
    assert axes.on == [True, True, True]
    with pytest.raises(MotionError, match="signals"):
        axes.update(True, (True,), SET, ACTUAL, moving=False, program=False)


@pytest.mark.requirement("RHO-MOT-47", by="motion.axes.disabled:DisabledAxes.update")
@pytest.mark.requirement("RHO-MOT-47", by="motion.axes.disabled:DisabledAxes.outputs")
def test_bit_216_disables_at_once_warns_1408_and_stays_until_a_restart() -> None:
    axes = DisabledAxes(3)
    assert axes.outputs((1.0, 2.0, 3.0)) == (1.0, 2.0, 3.0)
    assert axes.update((True, False, False)) == (1408,)
    assert axes.update((True, False, False)) == (), "told once"
    assert DisabledAxes(3).update((False, True, True)) == (1409, 1410)
    assert axes.outputs((1.0, 2.0, 3.0)) == (0.0, 2.0, 3.0)
    axes.update((False, False, False))
    assert axes.disabled == (True, False, False) and axes.warnings == (1408,), "0 has no effect before a restart"
    with pytest.raises(AxisError, match=DRIVE_ON_NOT_AVAILABLE):
        axes.check_move((0.0, 0.0, 0.0), (0.1, 0.0, 0.0))
    axes.check_move((0.0, 0.0, 0.0), (0.0, 5.0, 5.0))
    again = DisabledAxes(3)
    again.update((False, False, False))
    assert again.disabled == (False, False, False)


def test_a_disabled_axis_stays_out_whatever_its_drive_on_says() -> None:
    axes = DriveOn(3)
    axes.update(True, ON, SET, ACTUAL, moving=False, program=False, locked=(False, True, False))
    assert axes.on == [True, False, True]
    with pytest.raises(MotionError, match="20"):
        DisabledAxes(21)


@pytest.mark.requirement("RHO-MOT-48", by="motion.axes.shared:groups")
@pytest.mark.requirement("RHO-MOT-48", by="motion.axes.shared:SharedOutput.step")
def test_17_1_three_axes_on_output_1_of_which_one_moves_at_a_time() -> None:
    assert groups({0: 101, 1: 102, 2: 103, 3: 2}) == {1: (0, 1, 2)}
    assert groups({0: 302, 1: 301, 4: 1, 5: 99}) == {3: (1, 0)}
    for numbers, words in (({0: 100}, "running numbers"), ({0: 102}, "running numbers"), ({0: 201, 1: 201}, "given twice")):
        with pytest.raises(MotionError, match=words):
            groups(numbers)
    output = SharedOutput((0, 1, 2), (0.05, 0.05, 0.05))
    volts = (1.0, 2.0, 3.0)
    assert output.step((True, True, True), volts, 0.0) == 0.0, "idle: 0 V"
    assert output.step((True, False, True), volts, 0.01) == 2.0
    assert output.step((True, True, True), volts, 0.02) == 2.0, "in position, correction time runs"
    assert output.step((True, True, True), volts, 0.071) == 0.0
    assert output.step((True, False, True), volts, 0.08) == 2.0
    assert output.step((True, True, True), volts, 0.10) == output.step((True, True, True), volts, 0.14) == 2.0, "50 ms from here"
    assert output.step((True, True, True), volts, 0.16) == 0.0
    assert output.step((False, True, True), volts, 0.2) == 1.0, "free for another axis"
    for moving, axis in (((False, True, False), 3), ((False, False, True), 2)):
        with pytest.raises(AxisError, match="servo error") as caught:
            output.step(moving, volts, 0.3)
        assert caught.value.axis == axis and "axis 1" in str(caught.value)


def test_the_last_jogged_axis_may_keep_the_output() -> None:
    output = SharedOutput((0, 1), (0.0, 0.0), keep_last=True)
    assert output.step((False, True), (1.0, 2.0), 0.0, jog=True) == 1.0
    assert output.step((True, True), (1.0, 2.0), 9.0, jog=True) == 1.0
    assert output.step((True, False), (1.0, 2.0), 10.0, jog=True) == 2.0
    assert output.step((True, True), (1.0, 2.0), 11.0, jog=False) == 0.0


@pytest.mark.parametrize("p401", [{0: 101, 1: 103}, {0: 101, 1: 101}, {0: 102}])
def test_running_numbers_have_no_gap(p401: dict[int, int]) -> None:
    with pytest.raises(MotionError, match="P401"):
        groups(p401)
