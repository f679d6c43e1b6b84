"""VAL 3, chapters 9.4 to 9.6: frames, tools, points."""

import math
from collections.abc import Callable

import pytest

from hil_tests.unit.motion.kinematics.robots import arm, spread, unlike
from motion.kinematics.base import FREE, SAME, Configuration, Elbow, Shoulder, Wrist
from motion.val3.cartesian import (
    Arm,
    Frame,
    Point,
    Tool,
    appro,
    compose_point,
    distance,
    link_frame,
    link_point,
    link_tool,
    new_flange,
    new_world,
    position,
    set_frame,
    tool_position,
)
from motion.val3.errors import RuntimeFault
from motion.val3.trsf import Trsf
from motion.val3.trsf import distance as between

DEG = ("deg",) * 6


def same(one: Trsf, two: Trsf, most: float = 1e-9) -> bool:
    return max(abs(a - b) for a, b in zip(one, two, strict=True)) <= most


def code(action: Callable[[], object]) -> int:
    """Number of the run-time error; 0: it went through."""
    try:
        action()
    except RuntimeFault as fault:
        return fault.code
    return 0


@pytest.mark.requirement("VAL-FRM-01", by="motion.val3.cartesian:set_frame")
def test_set_frame_from_three_points() -> None:
    world = new_world()
    result = Frame(Trsf(1, 2, 3), world)

    def on(x: float, y: float, z: float) -> Point:
        return Point(Trsf(x, y, z), FREE, world)

    assert set_frame(on(100, 0, 0), on(100, 50, 0), on(70, 20, 0), result) == 0
    assert same(result.trsf, Trsf(100, 0, 0, 0, 0, 90))
    for x, xy, answer in ((on(100, 0, 0), on(0, 1, 0), -1), (on(200, 0, 0), on(300, 0, 0), -2), (on(200, 0, 0), on(300, 0.001, 0), -2)):
        assert set_frame(on(100, 0, 0), x, xy, result) == answer
        assert same(result.trsf, Trsf(100, 0, 0, 0, 0, 90)), "untouched"
    assert code(lambda: set_frame(on(0, 0, 0), Point(), on(0, 1, 0), result)) == 162


def test_set_frame_in_a_moved_reference_and_for_a_frame_that_hangs_on_nothing() -> None:
    world = new_world()
    table = Frame(Trsf(500, 0, 0, 0, 0, 30), world)
    one, two, three = (Point(Trsf(*values), FREE, table) for values in ((10, 0, 0), (20, 0, 0), (10, 5, 1)))
    free, hung = Frame(), Frame(Trsf(), world)
    assert (set_frame(one, two, three, free), set_frame(one, two, three, hung)) == (0, 0)
    assert free.reference is table
    assert hung.reference is world
    assert same(position(free, world), position(hung, world))
    assert same(position(one, free), Trsf(0, 0, 0, *position(table, free)[3:]), 1e-9)


@pytest.mark.requirement("VAL-FRM-02", by=("motion.val3.cartesian:link_frame", "motion.val3.cartesian:position"))
def test_link_moves_a_frame_in_the_world_and_keeps_its_numbers() -> None:
    world = new_world()
    one, two = Frame(Trsf(100, 0, 0), world), Frame(Trsf(0, 10, 0, 0, 0, 90), world)
    assert position(two, world) == pytest.approx(Trsf(0, 10, 0, 0, 0, 90), abs=1e-9)
    link_frame(two, one)
    assert two.trsf == Trsf(0, 10, 0, 0, 0, 90)
    assert same(position(two, world), Trsf(100, 10, 0, 0, 0, 90))
    assert same(position(two, one), two.trsf)


@pytest.mark.requirement("VAL-PNT-01", by="motion.val3.cartesian:appro")
def test_appro_lies_100_mm_back_along_the_points_own_z() -> None:
    world = new_world()
    down = Point(Trsf(300, 200, 50, 180, 0, 20), Configuration(shoulder=Shoulder.LEFTY), world)
    above = appro(down, Trsf(0, 0, -100))
    assert same(above.trsf, Trsf(300, 200, 150, 180, 0, 20)), "z of the point looks down, so back is up"
    assert (above.frame, above.config) == (world, down.config)
    assert code(lambda: appro(Point(), Trsf())) == 162


@pytest.mark.requirement("VAL-PNT-02", by="motion.val3.cartesian:compose_point")
def test_compose_turns_about_the_origin_of_the_reference() -> None:
    world = new_world()
    table = Frame(Trsf(100, 0, 0), world)
    point = Point(Trsf(200, 0, 0), Configuration(elbow=Elbow.POSITIVE), world)
    turned = compose_point(point, table, Trsf(0, 0, 0, 0, 0, 90))
    assert isinstance(turned, Point) and same(turned.trsf, Trsf(100, 100, 0, 0, 0, 90)), "x, y move, too"
    assert (turned.frame, turned.config) == (world, point.config)
    restored = turned.trsf._replace(x=200, y=0, z=0)
    assert same(restored, Trsf(200, 0, 0, 0, 0, 90)), "with x, y, z restored only the orientation is new"
    at_origin = compose_point(Point(Trsf(), FREE, table), table, Trsf(0, 0, 0, 0, 0, 90))
    assert same(at_origin.trsf, Trsf(0, 0, 0, 0, 0, 90)), "at the origin nothing moves"
    shifted = compose_point(point, Frame(Trsf(0, 0, 0, 0, 0, 90), world), Trsf(10, 0, 0))
    assert same(shifted.trsf, Trsf(200, 10, 0)), "a shift is given in the reference's axes"
    assert code(lambda: compose_point(Point(), table, Trsf())) == 162


@pytest.mark.requirement("VAL-PNT-03", by=("motion.val3.cartesian:distance", "motion.val3.cartesian:position"))
def test_the_distance_of_two_points_is_that_of_their_places_in_the_world() -> None:
    world = new_world()
    one = Point(Trsf(10, 20, 30, 4, 5, 6), FREE, Frame(Trsf(100, 50, 0, 10, 20, 30), world))
    two = Point(Trsf(-70, 0, 15, 0, 0, 90), FREE, Frame(Trsf(0, -30, 80, 0, 90, 0), world))
    turned = Point(Trsf(1, 2, 3), FREE, Frame(Trsf(10, 0, 0, 0, 0, 90), world))
    assert position(turned, world) == pytest.approx(Trsf(8, 1, 3, 0, 0, 90), abs=1e-9)
    expected = between(position(one, world), position(two, world))
    assert expected > 100
    assert math.isclose(distance(one, two), expected, abs_tol=1e-9)


@pytest.mark.requirement("VAL-PNT-04", by="motion.val3.cartesian:Point.linked")
def test_a_point_that_was_never_linked_is_error_162() -> None:
    world = new_world()
    free = Point(Trsf(1, 2, 3))
    assert code(free.linked) == 162
    assert Point(Trsf(1, 2, 3), FREE, world).linked() is world
    uses: tuple[Callable[[], object], ...] = (
        lambda: position(free, world),
        lambda: distance(free, Point(Trsf(), FREE, world)),
        lambda: appro(free, Trsf()),
        lambda: compose_point(free, world, Trsf()),
        lambda: Arm(arm(), DEG).point_to_joint(new_flange(), (0,) * 6, free),
    )
    assert [code(use) for use in uses] == [162] * 5
    assert same(position(link_point(free, world), world), free.trsf)


def test_what_hangs_on_nothing_or_on_a_changed_root_has_its_own_number() -> None:
    world, flange = new_world(), new_flange()
    assert code(lambda: position(Frame(), world)) == 163
    assert code(lambda: position(Point(Trsf(), FREE, Frame()), world)) == 163
    assert code(lambda: tool_position(Tool(), flange)) == 164
    world.trsf, flange.trsf = Trsf(1), Trsf(0, 0, 0, 1)
    assert code(lambda: position(Frame(Trsf(), world), world)) == 161
    assert code(lambda: tool_position(Tool(Trsf(), flange), flange)) == 160
    ring = Frame()
    link_frame(ring, ring)
    assert code(ring.in_world) == 165


def test_a_tool_on_a_tool() -> None:
    flange = new_flange()
    changer, gripper = Tool(Trsf(0, 0, 50), flange), Tool(Trsf(10, 0, 20, 0, 90, 0))
    link_tool(gripper, changer)
    assert same(tool_position(gripper, flange), Trsf(10, 0, 70, 0, 90, 0))
    assert same(tool_position(gripper, changer), gripper.trsf)


@pytest.mark.requirement("VAL-PNT-05", by=("motion.val3.cartesian:Arm.point_to_joint", "motion.val3.cartesian:Arm.joint_to_point"))
def test_joint_to_point_and_back_with_the_same_configuration() -> None:
    world, flange = new_world(), new_flange()
    tool = Tool(Trsf(0, 30, 120, 0, 45, 0), flange)
    table = Frame(Trsf(200, -100, 50, 0, 0, 25), world)
    robot = Arm(arm(), DEG)
    for joint in spread(40, (170, 120, 140, 170, 110, 170)):
        point = robot.joint_to_point(tool, table, joint)
        assert isinstance(point, Point)
        assert point.config == robot.config(joint)
        back = robot.point_to_joint(tool, (0,) * 6, point)
        assert back is not None
        assert unlike(back, joint) < 1e-6
    assert same(robot.here(tool, table, joint).trsf, point.trsf)


@pytest.mark.requirement("VAL-PNT-05", by="motion.val3.cartesian:Arm.point_to_joint")
def test_out_of_reach_or_in_the_wrong_configuration_is_false() -> None:
    world, flange = new_world(), new_flange()
    robot = Arm(arm(j3=(0.0, 2.5)), DEG)
    joint = (10.0, 20.0, 60.0, 30.0, 40.0, 50.0)
    point = robot.joint_to_point(flange, world, joint)
    back = robot.point_to_joint(flange, joint, point)
    assert back is not None
    assert unlike(back, joint) < 1e-9
    far = Point(Trsf(5000), FREE, world)
    assert robot.point_to_joint(flange, joint, far) is None
    bent_back = Point(point.trsf, Configuration(elbow=Elbow.NEGATIVE), world)
    assert robot.point_to_joint(flange, joint, bent_back) is None, "only within the other elbow's travel"
    kept = Point(point.trsf, SAME, world)
    assert robot.point_to_joint(flange, joint, kept) is not None
    other = (10.0, 20.0, 60.0, 30.0, -40.0, 50.0)
    flipped = robot.point_to_joint(flange, other, kept)
    assert flipped is not None
    assert robot.config(flipped).wrist is Wrist.NEGATIVE, "same as the joints one comes from"


@pytest.mark.requirement("VAL-PNT-05", by="motion.kinematics.choice:nearest_turn")
def test_an_axis_of_several_turns_takes_the_one_nearest_to_the_initial_joints() -> None:
    world, flange = new_world(), new_flange()
    robot = Arm(arm(j6=(-9.0, 9.0)), DEG)
    joint = (10.0, 20.0, 60.0, 30.0, 40.0, 50.0)
    point = robot.joint_to_point(flange, world, joint)
    for initial, answer in ((0.0, 50.0), (300.0, 410.0), (240.0, 410.0), (-250.0, -310.0), (500.0, 410.0)):
        found = robot.point_to_joint(flange, (*joint[:5], initial), point)
        assert found is not None
        assert math.isclose(found[5], answer, abs_tol=1e-9), initial
    wide = robot.joint_to_point(flange, world, (*joint[:5], 200.0))
    for initial, answer in ((380.0, 200.0), (400.0, 200.0), (25.0, 200.0), (15.0, -160.0), (-400.0, -160.0)):
        found = robot.point_to_joint(flange, (*joint[:5], initial), wide)
        assert found is not None, "a turn beyond +-515.7 deg is none"
        assert math.isclose(found[5], answer, abs_tol=1e-9), initial


def test_joints_of_another_arm_are_error_570() -> None:
    assert code(lambda: Arm(arm(), DEG).config((0, 0, 0, 0))) == 570
