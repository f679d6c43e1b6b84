"""rho 3 Releases part 1, section 14: what resets A, D and V factors; section 4 and L628: jog speeds and slopes."""

from itertools import product

import pytest

from motion.errors import MotionError
from motion.program.factors import Factors, FactorTable, Operation, option_byte, resets
from motion.program.jog import JogKeys, JogSpeeds, SlopeParameters, manual_speed, world_slopes

SPEEDS = JogSpeeds(0.05, 0.2, (0.1, 0.2), (0.5, 1.0))


def after(operation: Operation, option: int) -> tuple[float, float]:
    """(kinematic, global) V factor after an operation, both 0.5 before."""
    table = FactorTable(2, option)
    table.set_global(velocity=0.5)
    table.set_kinematic(1, velocity=0.5)
    table.happened(operation, 1)
    return table.kinematic_factors(1).velocity, table.global_factors().velocity


@pytest.mark.requirement("RHO-MOT-49", by="motion.program.factors:resets")
@pytest.mark.requirement("RHO-MOT-49", by="motion.program.factors:FactorTable.happened")
def test_14_1_the_table_of_the_option_byte() -> None:
    keep, one = 0.5, 1.0
    as_delivered = {
        Operation.CONTROL_RESET: (keep, one),
        Operation.AUTO_TO_MANUAL: (keep, keep),
        Operation.MANUAL_TO_AUTO: (keep, keep),
        Operation.PROCESS_START: (one, keep),
    }
    assert {operation: after(operation, 0) for operation in Operation} == as_delivered
    byte_97 = {
        Operation.CONTROL_RESET: (one, one),
        Operation.AUTO_TO_MANUAL: (keep, one),
        Operation.MANUAL_TO_AUTO: (keep, one),
        Operation.PROCESS_START: (one, keep),
    }
    assert {operation: after(operation, 97) for operation in Operation} == byte_97
    assert after(Operation.PROCESS_START, 8) == (keep, keep), "bit 3: unchanged"
    assert after(Operation.CONTROL_RESET, 16) == (keep, keep), "bit 4: unchanged"


@pytest.mark.requirement("RHO-MOT-49", by="motion.program.factors:FactorTable.happened")
def test_14_1_speed_acceleration_and_deceleration_are_reset_together_and_of_the_kinematic_concerned_alone() -> None:
    half = Factors(0.5, 0.4, 0.3)

    def left(operation: Operation, option: int, kinematic: int | None) -> tuple[Factors, Factors, Factors]:
        table = FactorTable(2, option)
        for number in (1, 2):
            table.set_kinematic(number, velocity=0.5, acceleration=0.4, deceleration=0.3)
        table.set_global(velocity=0.5, acceleration=0.4, deceleration=0.3)
        table.happened(operation, kinematic)
        return table.global_factors(), table.kinematic_factors(1), table.kinematic_factors(2)

    full = Factors(1.0, 1.0, 1.0)
    assert left(Operation.CONTROL_RESET, 97, 1) == (full, full, half)
    assert left(Operation.CONTROL_RESET, 97, 2) == (full, half, full)
    assert left(Operation.CONTROL_RESET, 97, None) == (full, full, full)
    assert left(Operation.AUTO_TO_MANUAL, 97, 1) == left(Operation.MANUAL_TO_AUTO, 97, 1) == (full, half, half)
    assert left(Operation.AUTO_TO_MANUAL, 2, 2) == left(Operation.MANUAL_TO_AUTO, 4, 2) == (half, half, full)
    assert left(Operation.PROCESS_START, 0, 2) == (half, half, full)
    assert left(Operation.PROCESS_START, 0, None) == (half, full, full)


@pytest.mark.requirement("RHO-MOT-49", by="motion.program.factors:resets")
def test_14_1_an_option_byte_is_0_to_255() -> None:
    assert resets(Operation.PROCESS_START, 0) == (True, False)
    assert resets(Operation.CONTROL_RESET, 255) == (True, False)
    for wrong in (-1, 256):
        with pytest.raises(MotionError, match=f"option byte {wrong} is outside 0 .. 255"):
            resets(Operation.CONTROL_RESET, wrong)


def test_every_bit_acts_on_its_own_entry_alone() -> None:
    for operation, bit in product(Operation, range(8)):
        changed = resets(operation, 1 << bit) != resets(operation, 0)
        assert changed == (bit in operation.value)


def test_a_process_start_with_bit_7_acts_on_all_kinematics() -> None:
    table = FactorTable(2, 128)
    table.set_global(velocity=0.3)
    table.set_kinematic(2, velocity=0.5)
    table.happened(Operation.PROCESS_START, 1)
    assert table.acting(2).velocity == 0.5, "global is 1.0 for the other kinematic too, its own factor stays"


def test_what_acts_is_the_product_and_start_up_is_all_ones() -> None:
    table = FactorTable(1)
    assert table.acting(1) == Factors(1.0, 1.0, 1.0)
    table.set_global(velocity=0.5, acceleration=0.4)
    table.set_kinematic(1, velocity=0.5, deceleration=0.1)
    assert table.acting(1) == Factors(0.25, 0.4, 0.1)


def test_p25_is_the_same_table() -> None:
    assert option_byte([1, 0, 0, 0, 0, 1, 1, 0]) == 97
    for wrong in ([1] * 7, [2, 0, 0, 0, 0, 0, 0, 0]):
        with pytest.raises(MotionError, match="P25"):
            option_byte(wrong)


@pytest.mark.parametrize("value", [-0.01, 1.01, float("nan")])
def test_factors_out_of_range_are_refused(value: float) -> None:
    with pytest.raises(MotionError, match=r"0 \.\. 1"):
        FactorTable(1).set_global(velocity=value)
    with pytest.raises(MotionError, match="kinematic 2"):
        FactorTable(1).acting(2)


@pytest.mark.requirement("RHO-MOT-50", by="motion.program.jog:JogKeys.wanted")
def test_a_jog_key_held_1_5_s_goes_fast_and_a_further_axis_at_once() -> None:
    keys = JogKeys(SPEEDS)
    keys.press(0, 1, 10.0)
    assert keys.wanted(11.49) == (0.1, 0.0)
    assert keys.wanted(11.5) == (0.5, 0.0)
    keys.press(1, -1, 11.6)
    assert keys.wanted(11.6) == (0.5, -1.0)
    keys.release(0)
    keys.release(1)
    assert keys.wanted(12.0) == (0.0, 0.0)
    keys.press(1, 1, 12.1)
    assert keys.wanted(12.1) == (0.0, 0.2), "slow again"


@pytest.mark.requirement("RHO-MOT-50", by="motion.program.jog:manual_speed")
def test_manual_speed_stays_within_p114_in_proportion() -> None:
    assert manual_speed((2.0, -1.0), SPEEDS) == pytest.approx((0.5, -0.25))
    assert manual_speed((0.2, 0.1), SPEEDS) == (0.2, 0.1)


@pytest.mark.requirement("RHO-MOT-50", by="motion.program.jog:SlopeParameters.jogging")
def test_unset_jog_slopes_take_the_values_of_ptp() -> None:
    old = SlopeParameters(2.0, 0.3, 0.1)
    assert old.jogging() == old.automatic() == (2.0, 0.3, 0.1)
    mixed = SlopeParameters(2.0, 0.3, 0.1, p128=1.0, p130=0.0)
    assert mixed.jogging() == (1.0, 0.3, 0.0)
    assert mixed.automatic() == (2.0, 0.3, 0.1)
    assert world_slopes(1.5) == (1.5, 1.5) and world_slopes(1.5, 0.5) == (1.5, 0.5)


def test_speeds_that_contradict_themselves_are_refused() -> None:
    for wrong, word in (((0.05, 0.3, (0.1,), (0.5,)), "VDI"), ((0.2, 0.1, (0.1,), (0.5,)), "P112"), ((0.1, 0.2, (0.6,), (0.5,)), "axis 1")):
        with pytest.raises(MotionError, match=word):
            JogSpeeds(*wrong)
    with pytest.raises(MotionError, match="jog key"):
        JogKeys(SPEEDS).press(2, 1, 0.0)
    with pytest.raises(MotionError, match="speeds"):
        manual_speed((1.0,), SPEEDS)
