"""rho 3 Releases part 1, section 11 (L4119-4208): SF 3, set machine position."""

import math

import pytest

from motion.errors import LimitError, MotionError
from motion.geometry.limits import AxisLimits
from motion.kinematics.scara import Scara
from motion.measure.machine import MachinePosition, reference_speed_warning
from motion.rho3.kinematic import Rho3Kinematic
from motion.rho3.wc import Assignment, WcSystems

DEG = math.pi / 180
LIMITS = (
    AxisLimits("SC1", -130 * DEG, 130 * DEG, 1.0, 1.0, 1.0, "deg"),
    AxisLimits("SC2", -140 * DEG, 140 * DEG, 1.0, 1.0, 1.0, "deg"),
    AxisLimits("SC3", -0.2, 0.2, 1.0, 1.0, 1.0, "mm"),
    AxisLimits("SC4", -300 * DEG, 300 * DEG, 1.0, 1.0, 1.0, "deg"),
)
MEASURED = (30 * DEG, 40 * DEG, 0.05, 250 * DEG)


def control() -> tuple[MachinePosition, Rho3Kinematic]:
    """As it is after a start-up."""
    robot = Scara(0.35, 0.25, 0.3, LIMITS, down=False)
    kinematic = Rho3Kinematic("SCARA", robot, LIMITS, WcSystems(), assignment=Assignment((1, 2, 3, 0, 0, 4)), components=4)
    return MachinePosition(LIMITS, belts=1), kinematic


def flange(q1: float, q2: float, q3: float, q4: float) -> tuple[float, ...]:
    """x, y, z in mm and the angle in deg, written down anew from the geometry."""
    a, b = math.radians(q1), math.radians(q1 + q2)
    return 350 * math.cos(a) + 250 * math.cos(b), 350 * math.sin(a) + 250 * math.sin(b), 300 + q3, q1 + q2 + q4


def within_travel(machine: MachinePosition, kinematic: Rho3Kinematic) -> bool:
    try:
        kinematic.check_software_limits(machine.joints(MEASURED))
    except LimitError:
        return False
    return True


@pytest.mark.requirement("RHO-MOT-37", by="motion.measure.machine:MachinePosition.mach_pos")
@pytest.mark.requirement("RHO-MOT-37", by="motion.measure.machine:MachinePosition.block")
@pytest.mark.requirement("RHO-MOT-37", by="motion.measure.machine:MachinePosition.joints")
def test_sf_3_then_a_dummy_move_makes_pos_new_limits_follow_and_a_restart_undoes() -> None:
    machine, kinematic = control()
    assert machine.joints(MEASURED) == pytest.approx((30, 40, 50, 250))
    assert within_travel(machine, kinematic)

    machine.mach_pos((100.0, -20.0, -40.0, 250.0 - 360.0), MEASURED)
    assert machine.joints(MEASURED) == pytest.approx((100, -20, -40, -110)), "@POS is new at once"
    assert kinematic.wc(machine.taken_over(MEASURED))[:3] == pytest.approx(flange(30, 40, 50, 250)[:3]), "POS is the old one"
    machine.block()  # MOVE_REL SCARA @(0,0,0,0)
    assert kinematic.wc(machine.taken_over(MEASURED)) == pytest.approx(flange(100, -20, -40, -110)), "POS is new, by the transformation"

    machine.mach_pos((140.0, -20.0, -40.0, -110.0), MEASURED)
    assert not within_travel(machine, kinematic), "P204/P205 refer to the new position: 140 deg is outside +-130"

    machine, kinematic = control()  # start-up
    machine.block()
    assert machine.joints(MEASURED) == pytest.approx((30, 40, 50, 250))
    assert kinematic.wc(machine.taken_over(MEASURED))[:3] == pytest.approx(flange(30, 40, 50, 250)[:3])


@pytest.mark.requirement("RHO-MOT-37", by="motion.measure.machine:MachinePosition.machine")
def test_travel_from_there_on_counts_in_new_positions_and_mpos_too() -> None:
    machine, _ = control()
    machine.mach_pos((0.0, 0.0, 0.0, 0.0), MEASURED)
    later = (35 * DEG, 40 * DEG, 0.06, 240 * DEG)
    assert machine.machine(later) == pytest.approx((5 * DEG, 0.0, 0.01, -10 * DEG))
    assert machine.joints(later) == pytest.approx((5.0, 0.0, 10.0, -10.0))
    assert machine.commanded(machine.machine(later)) == pytest.approx(later), "what the drives get is where they count"


def test_belts_in_the_point_are_ignored_and_single_axes_may_be_set() -> None:
    machine, _ = control()
    at_pos = list(machine.joints(MEASURED))
    at_pos[3] -= 360.0
    machine.mach_pos((*at_pos, 1234.5), MEASURED)
    assert machine.joints(MEASURED) == pytest.approx((30, 40, 50, -110))


def test_referencing_uses_p207_again_for_that_axis() -> None:
    machine, _ = control()
    machine.mach_pos((1.0, 2.0, 3.0, 4.0), MEASURED)
    machine.block()
    machine.referenced(3)
    assert machine.joints(MEASURED) == pytest.approx((1, 2, 3, 250)) == machine.taken_over(MEASURED)


def test_what_cannot_be_set_is_refused_and_changes_nothing() -> None:
    machine, _ = control()
    for point, at_rest in (((1.0, 2.0), True), ((1.0, 2.0, 3.0, float("nan")), True), ((1.0, 2.0, 3.0, 4.0), False)):
        with pytest.raises(MotionError):
            machine.mach_pos(point, MEASURED, at_rest=at_rest)
    assert machine.joints(MEASURED) == pytest.approx((30, 40, 50, 250))
    with pytest.raises(MotionError, match="4 axes"):
        machine.machine((1.0,))


def test_different_reference_speeds_are_reported() -> None:
    assert reference_speed_warning(50.0, 50.0) == ""
    assert "P108" in reference_speed_warning(100.0, 50.0)
