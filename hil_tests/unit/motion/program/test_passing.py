"""rho 3 Releases part 1, section 6: R, R_PTP, P212 .. P214, and where no passing happens."""

import pytest

from motion.errors import MotionError
from motion.program.blocks import Interpolation
from motion.program.passing import Criterion, Passing, Presets, Range, passed

PTP, LINEAR, CIRCULAR = Interpolation.PTP, Interpolation.LINEAR, Interpolation.CIRCULAR
AXES = Presets(0.015, 1.0, axes=(0.1, 0.2))
SPACE = Presets(0.015, 0.5, axes=(0.1, 0.2), space=0.04, criterion=Criterion.SPACE)


@pytest.mark.requirement("RHO-MOT-08", by="motion.program.passing:Passing.block")
def test_p212_is_taken_without_r_in_the_program_and_p214_chooses_the_criterion() -> None:
    assert Passing(AXES).block(LINEAR) == Range(0.015)
    assert Passing(AXES).block(PTP) == Range(0.0, (0.1, 0.2)), "P214 = 0: a distance for each axis"
    assert Passing(SPACE).block(PTP) == Range(0.02), "P214 = 1: one value for the kinematic, 40 mm times 0.5"


@pytest.mark.requirement("RHO-MOT-09", by="motion.program.passing:Passing.block")
@pytest.mark.requirement("RHO-MOT-09", by="motion.program.passing:Passing.set_radius")
def test_with_r_changes_that_block_alone_and_r_stays() -> None:
    passing = Passing(AXES)
    passing.set_radius(0.05)
    passing.set_factor(1.4)
    assert passing.block(LINEAR, radius=0.02) == Range(0.02)
    assert passing.block(LINEAR) == Range(0.05)
    assert passing.block(PTP, factor=0.5) == Range(0.0, (0.05, 0.1))
    assert passing.block(PTP).axes == pytest.approx((0.14, 0.28))


@pytest.mark.requirement("RHO-MOT-07", by="motion.program.passing:Passing.block")
def test_zero_switches_passing_off() -> None:
    passing = Passing(AXES)
    passing.set_radius(0.0)
    passing.set_factor(0.0)
    assert passing.block(LINEAR).off and passing.block(PTP).off
    assert not passing.block(LINEAR, radius=0.02).off


@pytest.mark.requirement("RHO-MOT-06", by="motion.program.passing:passed")
def test_no_passing_next_to_a_circle_nor_at_a_change_of_type_with_block_slope() -> None:
    assert passed(LINEAR, LINEAR, block_slope=True) and passed(PTP, PTP, block_slope=True)
    assert not passed(PTP, LINEAR, block_slope=True) and not passed(LINEAR, PTP, block_slope=True)
    assert passed(PTP, LINEAR, block_slope=False), "program slope passes there"
    for other in Interpolation:
        assert not passed(CIRCULAR, other, block_slope=False) and not passed(other, CIRCULAR, block_slope=False)


@pytest.mark.parametrize("factor", [0.009, 101.0, -1.0, float("nan")])
def test_r_ptp_outside_its_range_is_refused(factor: float) -> None:
    with pytest.raises(MotionError, match="R_PTP"):
        Passing(AXES).set_factor(factor)
    with pytest.raises(MotionError, match="R_PTP"):
        Passing(AXES).block(PTP, factor=factor)


def test_r_that_is_no_distance_is_refused() -> None:
    for wrong in (-0.001, float("nan"), float("inf")):
        with pytest.raises(MotionError, match="R "):
            Passing(AXES).set_radius(wrong)
    with pytest.raises(MotionError, match="P213"):
        Presets(axes=(-1.0,))
