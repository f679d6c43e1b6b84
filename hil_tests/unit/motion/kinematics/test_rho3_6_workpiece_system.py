"""rho 3 Releases part 1, TO06 section 6: WC_FRAME, WC_SYSTEM, P313, and which points they change."""

import math

import numpy as np
import pytest

from hil_tests.unit.motion.kinematics.robots import scara, sliding, turning
from motion.errors import LimitError, MotionError
from motion.geometry.conventions import RHO3
from motion.geometry.frames import IDENTITY, Pose, translation
from motion.geometry.limits import AxisLimits
from motion.kinematics.identity import Identity
from motion.kinematics.portal import Portal
from motion.rho3.kinematic import Rho3Kinematic
from motion.rho3.wc import WC_UR, Assignment, WcFrame, WcSystems

SLIDE = WcFrame(0, 0, 30, 0, 0, 0)
MM = [AxisLimits(name, -2.0, 2.0, 1.0, 10.0, 100.0, "mm") for name in "XYZ"]
DEG = [AxisLimits(name, -7.0, 7.0, 1.0, 10.0, 100.0, "deg") for name in "CBA"]
NEAR = (0.0,) * 6
KINEMATIC = "motion.rho3.kinematic:Rho3Kinematic."


def close(one: tuple[float, ...], two: tuple[float, ...], most: float = 1e-9) -> bool:
    return len(one) == len(two) and max(abs(a - b) for a, b in zip(one, two, strict=True)) <= most


def portal(systems: WcSystems, origin: Pose = IDENTITY) -> Rho3Kinematic:
    limits = [*MM, *DEG]
    return Rho3Kinematic("PAINT_1", Portal("xyzcba", limits), limits, systems, origin=origin)


@pytest.mark.requirement("RHO-MOT-31", by=("motion.rho3.kinematic:Rho3Kinematic.original", "motion.rho3.wc:WcSystems.select"))
def test_a_frame_of_z_30_lifts_every_point_by_30() -> None:
    systems = WcSystems()
    machine = portal(systems)
    assert machine.original((100, 200, 10, 5, 6, 7)) == pytest.approx((100, 200, 10, 5, 6, 7)), "no frame yet"
    assert machine.jc((100, 200, 10, 0, 0, 0), NEAR)[:3] == pytest.approx((100, 200, 10))
    systems.select("PAINT_1", SLIDE)
    assert close(machine.original((100, 200, 10, 5, 6, 7)), (100, 200, 40, 5, 6, 7))
    assert machine.jc((100, 200, 10, 0, 0, 0), NEAR)[:3] == pytest.approx((100, 200, 40))


@pytest.mark.requirement("RHO-MOT-31", by="motion.geometry.conventions:rotation_zyx")
def test_dc_turns_about_z_then_db_about_the_new_y_then_da_about_the_new_x() -> None:
    systems = WcSystems()
    machine = portal(systems)
    systems.select("PAINT_1", WcFrame(0, 0, 0, 90, 0, 90))
    assert close(machine.original((1, 0, 0, 0, 0, 0))[:3], (0, 1, 0)), "x goes where dc turned it"
    assert close(machine.original((0, 1, 0, 0, 0, 0))[:3], (0, 0, 1)), "y' by da about x''"
    assert close(machine.original((0, 0, 1, 0, 0, 0))[:3], (1, 0, 0))
    assert close(machine.original((0, 0, 0, 0, 0, 0))[3:], (90, 0, 90))
    systems.select("PAINT_1", WcFrame(0, 0, 0, 0, 90, 90))
    assert close(machine.original((1, 0, 0, 0, 0, 0))[:3], (0, 0, -1)), "db about y', after dc"
    assert close(machine.original((0, 1, 0, 0, 0, 0))[:3], (-1, 0, 0))
    systems.select("PAINT_1", WcFrame(7, 8, 9, 130, -25, 40))
    about = {axis: np.array(turn) for axis, turn in zip("zyx", elementary(40, -25, 130), strict=True)}
    turned = about["z"] @ about["y"] @ about["x"]
    for point in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (10, -20, 30)):
        expected = tuple(float(value) for value in turned @ np.array(point) + np.array((7, 8, 9)))
        assert close(machine.original((*point, 0, 0, 0))[:3], expected), "z, then the new y, then the new x: Rz Ry Rx"


def elementary(z: float, y: float, x: float) -> tuple[list[list[float]], ...]:
    """Rotations about z, y and x (deg), each as it stands in any book."""
    (cz, sz), (cy, sy), (cx, sx) = ((math.cos(math.radians(a)), math.sin(math.radians(a))) for a in (z, y, x))
    return [[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]], [[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]], [[1, 0, 0], [0, cx, -sx], [0, sx, cx]]


@pytest.mark.requirement("RHO-MOT-32", by=("motion.rho3.wc:WcSystems.active", "motion.rho3.wc:WcSystems.started_up"))
def test_the_system_stays_after_end_and_abort_and_goes_with_a_start_up() -> None:
    systems = WcSystems()
    assert systems.active("PAINT_1") == WC_UR
    systems.select("PAINT_1", SLIDE)
    systems.program_ended("PAINT_1")  # by END, by an emergency stop, by a reset: all alike
    assert systems.active("PAINT_1") == SLIDE
    assert systems.active("PAINT_2") == WC_UR, "each kinematic has its own"
    systems.started_up()
    assert systems.active("PAINT_1") == WC_UR


def test_a_frame_belongs_to_one_kinematic_and_has_a_short_name() -> None:
    with pytest.raises(MotionError, match="belongs to PAINT_2"):
        WcSystems().select("PAINT_1", WcFrame(kinematic="PAINT_2", name="SLIDE1_K2"))
    with pytest.raises(MotionError, match="12 characters"):
        WcFrame(name="SLIDE_NUMBER_1")
    with pytest.raises(MotionError, match="six finite"):
        WcFrame(dx=math.nan)


@pytest.mark.requirement("RHO-MOT-33", by=("motion.rho3.wc:Assignment.put", "motion.rho3.wc:Assignment.pose"))
def test_p313_of_a_side_machine_sends_x_to_the_belt_and_ignores_rotations() -> None:
    side = Assignment((4, 1, 2, 0, 0, 0))  # (YK, ZK, AK, BNK)
    systems = WcSystems()
    limits = [sliding("YK"), sliding("ZK"), turning("AK", -7, 7), sliding("BNK")]
    machine = Rho3Kinematic("SIDE", Identity(limits), limits, systems, assignment=side, components=4)
    systems.select("SIDE", WcFrame(50, 7, 9, 0, 0, 0))
    assert close(machine.original((10, 20, 30, 40)), (17, 29, 30, 90)), "x shift on component 4, y on 1, z on 2"
    systems.select("SIDE", WcFrame(0, 0, 0, 15, 25, 0))
    turned = machine.original((10, 20, 30, 40))
    assert turned[2] == 30, "no component for orientations: AK stays"
    systems.select("SIDE", WcFrame(0, 0, 0, 0, 0, 90))
    assert close(machine.original((10, 20, 30, 40)), (40, 20, 30, -10)), "the position is corrected wholly"


@pytest.mark.requirement("RHO-MOT-33", by="motion.rho3.wc:Assignment.moved")
def test_p313_of_a_top_machine_corrects_b_with_component_3() -> None:
    top = Assignment((4, 1, 2, 0, 3, 0))
    point = top.moved((10, 20, 30, 40), RHO3.pose((0, 0, 0, 0, 25, 0)))
    assert math.isclose(point[2], 55)
    for numbers in ((1, 1, 0, 0, 0, 0), (-1, 0, 0, 0, 0, 0)):
        with pytest.raises(MotionError, match="P313"):
            Assignment(numbers)
    with pytest.raises(MotionError, match="does not have"):
        top.pose((1, 2, 3))


@pytest.mark.requirement("RHO-MOT-34", by=("motion.rho3.kinematic:Rho3Kinematic.wc", "motion.rho3.kinematic:Rho3Kinematic.jc"))
def test_world_points_and_the_functions_jc_and_wc_follow_the_frame_and_joint_points_do_not() -> None:
    systems = WcSystems()
    machine = portal(systems)
    axes = (100.0, 200.0, 40.0, 10.0, 0.0, 0.0)
    assert close(machine.wc(axes), (100, 200, 40, 0, 0, 10))
    systems.select("PAINT_1", WcFrame(100, 0, 30, 0, 0, 90))
    assert close(machine.wc(axes), (200, 0, 10, 0, 0, -80)), "WC(@p) and POS"
    assert machine.joint_point(axes) == axes, "@POS, @points"
    assert close(machine.jc(machine.wc(axes), axes), axes)
    assert close(machine.oc(axes), (100, 200, 40, 0, 0, 10)), "original coordinates"


@pytest.mark.requirement("RHO-MOT-34", by=(KINEMATIC + "jc", KINEMATIC + "wc", KINEMATIC + "joint_point"))
def test_jc_and_wc_of_one_point_in_each_frame_by_hand() -> None:
    """A portal: axes are x, y, z, so what a frame does can be said in numbers."""
    systems = WcSystems()
    machine = portal(systems)
    point, joints = (10.0, 20.0, 30.0, 0.0, 0.0, 0.0), (500.0, 600.0, 700.0, 0.0, 0.0, 0.0)
    by_hand = {  # frame: (axes of JC(point), place of WC(@joints))
        WC_UR: ((10, 20, 30), (500, 600, 700)),
        WcFrame(100, 0, 0, 0, 0, 0): ((110, 20, 30), (400, 600, 700)),
        WcFrame(0, 0, 0, 0, 0, 90): ((-20, 10, 30), (600, -500, 700)),
        WcFrame(100, 200, 300, 0, 0, 180): ((90, 180, 330), (-400, -400, 400)),
    }
    for frame, (axes, place) in by_hand.items():
        systems.select("PAINT_1", frame)
        assert machine.jc(point, NEAR)[:3] == pytest.approx(axes, abs=1e-9), frame
        assert machine.wc(joints)[:3] == pytest.approx(place, abs=1e-9), frame
        assert machine.joint_point(joints) == joints, "@POS and @points"


@pytest.mark.requirement("RHO-MOT-34", by=(KINEMATIC + "check_working_range", KINEMATIC + "set_working_range"))
def test_limit_min_and_limit_max_are_places_of_the_frame_and_belong_to_the_range() -> None:
    systems = WcSystems()
    machine = portal(systems)
    machine.set_working_range((0, 0, 0, -180, -180, -180), (300, 300, 50, 180, 180, 180))
    systems.select("PAINT_1", WcFrame(100, 0, 0, 0, 0, 0))
    for x, inside in ((99.999, False), (100.0, True), (100.001, True), (399.999, True), (400.0, True), (400.001, False)):
        joints = (x, 10.0, 10.0, 0.0, 0.0, 0.0)
        if inside:
            machine.check_place(joints)
            continue
        with pytest.raises(LimitError) as beyond:
            machine.check_place(joints)
        assert beyond.value.axis == "PAINT_1 component 1" and beyond.value.value == pytest.approx(x - 100)
    machine.set_working_range(upper=(0, 300, 50, 180, 180, 180))  # LIMIT_MIN may equal LIMIT_MAX
    with pytest.raises(LimitError):
        machine.check_place((100.001, 10.0, 10.0, 0.0, 0.0, 0.0))
    with pytest.raises(MotionError, match="component 2 of LIMIT_MIN is 301, of LIMIT_MAX 300"):
        machine.set_working_range(lower=(0, 301, 0, -180, -180, -180))


@pytest.mark.requirement("RHO-MOT-34", by=(KINEMATIC + "check_working_range", KINEMATIC + "set_working_range"))
def test_the_working_range_moves_with_the_frame_and_the_software_limits_stay() -> None:
    systems = WcSystems()
    machine = portal(systems)
    machine.set_working_range((0, 0, 0, -180, -180, -180), (300, 300, 50, 180, 180, 180))
    here = (100.0, 200.0, 60.0, 0.0, 0.0, 0.0)
    with pytest.raises(LimitError) as fault:
        machine.check_place(here)
    assert (fault.value.axis, fault.value.upper) == ("PAINT_1 component 3", 50)
    systems.select("PAINT_1", SLIDE)
    machine.check_place(here)  # 30 in the workpiece's z
    systems.select("PAINT_1", WcFrame(-5000, 0, 0, 0, 0, 0))
    machine.check_software_limits(here)  # machine coordinates
    with pytest.raises(LimitError) as far:
        machine.check_software_limits((2100.0, 0, 0, 0, 0, 0))
    assert far.value.axis == "X"
    with pytest.raises(MotionError, match="LIMIT_MIN"):
        machine.set_working_range(lower=(400, 0, 0, 0, 0, 0))


@pytest.mark.requirement("RHO-MOT-34", by="motion.rho3.kinematic:Rho3Kinematic.check_software_limits")
def test_software_limits_name_the_axis_whatever_frame_is_active() -> None:
    systems = WcSystems()
    machine = portal(systems)
    for frame in (WC_UR, WcFrame(500, 500, 500, 10, 20, 30)):
        systems.select("PAINT_1", frame)
        with pytest.raises(LimitError) as fault:
            machine.check_software_limits((0.0, -2000.1, 0.0, 0.0, 0.0, 0.0))
        assert (fault.value.axis, fault.value.lower) == ("Y", -2000)


def test_display_levels_of_mode_7_1() -> None:
    systems = WcSystems()
    machine = portal(systems)
    assert set(machine.display(NEAR)) == {"JC", "WC"}
    systems.select("PAINT_1", SLIDE)
    assert machine.display(NEAR) == {"JC": NEAR, "WC": (0, 0, -30, 0, 0, 0), "OC": NEAR}
    systems.select("PAINT_1", WcFrame())
    assert set(machine.display(NEAR)) == {"JC", "WC"}, "all 0 is WC_UR"


def test_p310_shifts_the_original_system_and_a_tool_the_point() -> None:
    systems = WcSystems()
    machine = portal(systems, origin=translation(0.1, 0.0, 0.0))
    axes = (100.0, 200.0, 40.0, 0.0, 0.0, 0.0)
    assert close(machine.oc(axes), (0, 200, 40, 0, 0, 0))
    assert close(machine.jc((0, 200, 40, 0, 0, 0), axes), axes)
    machine.change_tool(translation(0.0, 0.0, -0.12))
    assert close(machine.oc(axes), (0, 200, -80, 0, 0, 0))
    assert machine.joint_point(axes) == axes
    assert close(machine.jc((0, 200, -80, 0, 0, 0), axes), axes)
    with pytest.raises(MotionError, match="at rest"):
        machine.change_tool(IDENTITY, at_rest=False)


def test_mirroring_is_in_the_workpieces_own_system() -> None:
    machine = portal(WcSystems())
    point = (100.0, 20.0, 30.0, 10.0, 20.0, 30.0)
    across = machine.mirror(point, "xz")
    assert close(across, (100, -20, 30, -10, 20, -30))
    assert close(machine.mirror(across, "xz"), point)
    twice = machine.mirror(machine.mirror(point, "xz"), "yz")
    assert close(twice[:3], (-100, -20, 30))
    with pytest.raises(MotionError, match="mirror"):
        machine.mirror(point, "x")


def test_a_scara_with_four_components() -> None:
    robot = scara()
    units = ("deg", "deg", "mm", "deg")
    limits = [AxisLimits(a.name, a.lower, a.upper, a.speed, a.accel, a.jerk, unit) for a, unit in zip(robot.limits, units, strict=True)]
    machine = Rho3Kinematic("SR60", robot, limits, WcSystems(), assignment=Assignment((1, 2, 3, 0, 0, 4)), components=4)
    axes = (20.0, 40.0, -100.0, 30.0)
    flange_up = machine.oc(axes)
    assert math.isclose(flange_up[2], 200)
    assert math.isclose(flange_up[3], 90)
    with pytest.raises(MotionError, match="4 components"):
        machine.jc((1, 2, 3), axes)
