"""Robot files: the shipped ones, what is wrong with others, and how much one cell may hold."""

import math
import pathlib

import pytest

from gateway.files.find import PACKAGED
from gateway.files.robots import RobotFaults, load_robot
from hil_tests.unit.motion.kinematics.robots import apart, spread, turning, unlike
from motion.errors import MotionError
from motion.kinematics.base import Kinematics
from motion.kinematics.coupled import Coupled
from motion.kinematics.group import Group, Role
from motion.robot import AxisOfRobot, Installation, Kind, Robot, ScaraGeometry, kinematics_of, workspace_of

SHIPPED = ("portal", "sr60-like", "tx60-like", "tx60-on-track", "reis-like", "turntables")
TEXT = (PACKAGED / "robots" / "sr60-like.toml").read_text()
ADDITIONAL = """
[[additional]]
name = "T"
unit = "mm"
lower = 0
upper = 3000
speed = 1000
accel = 3000
jerk = 30000
source = "assumed"
role = "carrier"
direction = [1, 0, 0]
"""


def reached(robot: Robot) -> None:
    """Joints inside the travel come back through forward and inverse."""
    kinematics: Kinematics = kinematics_of(robot)
    middles = [(axis.lower + axis.upper) / 2 for axis in robot.limits]
    halves = [(axis.upper - axis.lower) / 2 for axis in robot.limits]
    for point in spread(40, (0.99,) * kinematics.axes):
        q = tuple(middle + half * value for middle, half, value in zip(middles, halves, point, strict=True))
        pose = kinematics.forward(q)
        back = kinematics.inverse(pose, q)
        assert apart(kinematics.forward(back), pose) < 1e-9
        assert unlike(back, q) < 1e-6


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_robots_reach_what_their_joints_reach(name: str) -> None:
    robot = load_robot(name)
    assert robot.name == name
    assert robot.source
    assert all(axis.source for axis in robot.axes)
    reached(robot)


def test_all_shipped_files_are_tested() -> None:
    assert {path.stem for path in (PACKAGED / "robots").glob("*.toml")} == set(SHIPPED)


def test_a_tx60_is_as_long_as_published() -> None:
    arm = kinematics_of(load_robot("tx60-like"))
    assert arm.forward((0.0,) * 6).position == pytest.approx((0.0, 0.02, 1.045))
    level = arm.forward((0.0, math.pi / 2, 0.0, 0.0, 0.0, 0.0)).position
    assert level == pytest.approx((0.67, 0.02, 0.375))


def test_joints_of_the_reis_like_arm_count_as_on_such_arms() -> None:
    arm = kinematics_of(load_robot("reis-like"))
    x, y, z = arm.forward((0.0,) * 6).position
    assert (x, y, z) == pytest.approx((0.2 + 0.75 + 0.12, 0.0, 0.7 + 0.65 + 0.1)), "upright, forearm level"
    assert arm.forward((0.5, 0.0, 0.0, 0.0, 0.0, 0.0)).position[1] < 0, "axis 1 counts clockwise"


def test_a_robot_that_stands_somewhere_in_the_cell() -> None:
    moved = load_robot("my.toml", TEXT.replace('angles = "rho3"', 'angles = "rho3"\nbase = [1000, 0, 500, 0, 0, 90]'))
    q = (0.0, 0.0, -0.1, 0.0)
    space = workspace_of(moved)
    assert space.tcp(q).position == pytest.approx((1.0, 0.6, 0.7))
    assert unlike(space.joints(space.tcp(q), q), q) < 1e-9


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("format = 1", "format = 2", "format"),
        ('kind = "scara"', 'kind = "delta"', "robot.kind"),
        ('kind = "scara"', 'kind = "arm6"', "arm6"),
        ("arm = 350", "arm = -350", "scara.arm"),
        ("arm = 350", "arm = nan", "scara.arm"),
        ("speed = 360", "speed = 0", "axis.A1.speed"),
        ('name = "A2"', 'name = "A2"\ncolour = "red"', "axis.A2.colour"),
        ("lower = -135", "lower = 136", "robot"),
        ('angles = "rho3"', 'angles = "zyz"', "robot.angles"),
        ("height = 300\n", "", "scara.height"),
        ("[scara]", "[scara", "file"),
    ],
)
def test_a_fault_names_file_key_and_value(old: str, new: str, key: str) -> None:
    assert old in TEXT
    with pytest.raises(RobotFaults) as faults:
        load_robot("my.toml", TEXT.replace(old, new, 1))
    assert key in [where for where, _ in faults.value.faults]
    assert str(faults.value).startswith(f"my.toml: {faults.value.faults[0][0]}: ")


def test_all_faults_are_reported_in_one_run() -> None:
    with pytest.raises(RobotFaults) as faults:
        load_robot(
            "my.toml", TEXT.replace("speed = 360", "speed = 0").replace("accel = 4200", "accel = true").replace("arm = 350", "arm = 0", 1)
        )
    assert [key for key, _ in faults.value.faults] == ["scara.arm", "axis.A1.speed", "axis.A2.accel"]
    with pytest.raises(FileNotFoundError, match="tx60-like"):
        load_robot("tx61")


def test_couplings_and_additional_axes_of_a_file() -> None:
    coupled = TEXT.replace('angles = "rho3"', 'angles = "rho3"\ncoupling = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.002], [0, 0, 0, 1]]')
    robot = load_robot("my.toml", coupled + ADDITIONAL)
    made = kinematics_of(robot)
    assert isinstance(made, Group)
    assert isinstance(made.main, Coupled)
    assert made.axes == 5
    assert robot.axes[4].role is Role.CARRIER
    there, here = made.forward((0.1, 0.2, -0.1, 0.3, 1.0)), made.forward((0.1, 0.2, -0.1, 0.3, 0.0))
    assert there.position[0] - here.position[0] == pytest.approx(1.0)
    reached(robot)


def test_a_urdf_beside_its_robot_file(tmp_path: pathlib.Path) -> None:
    from hil_tests.unit.motion.kinematics.robots import TX60, urdf

    (tmp_path / "arm.urdf").write_text(urdf(TX60))
    text = (PACKAGED / "robots" / "tx60-like.toml").read_text()
    head, tail = text.split("[arm6]")[0], text[text.index("[[axis]]") :]
    own = tmp_path / "mine.toml"
    own.write_text(head.replace('kind = "arm6"', 'kind = "urdf"') + '[urdf]\nfile = "arm.urdf"\nframe = "flange"\n' + tail)
    numeric, closed = kinematics_of(load_robot(str(own))), kinematics_of(load_robot("tx60-like"))
    assert apart(numeric.forward((0.1,) * 6), closed.forward((0.1,) * 6)) < 1e-12


def simple(name: str, axes: int = 1) -> Robot:
    return Robot(name, Kind.IDENTITY, None, tuple(AxisOfRobot(turning(f"{name}{n}"), "assumed") for n in range(axes)))


def test_one_cell_holds_16_kinematics_32_axes_and_8_belts() -> None:
    full = Installation(tuple(simple(f"K{n}_", 2) for n in range(16)), belts=8)
    assert len(full.robots) == 16
    for robots, belts, words in (
        (tuple(simple(f"K{n}_") for n in range(17)), 0, "17 kinematics, at most 16"),
        ((simple("A", 24), simple("B", 9)), 0, "33 axes, at most 32"),
        ((simple("A"),), 9, "9 belts, at most 8"),
        ((simple("A"),), -1, "-1 belts"),
        ((simple("A"), simple("A")), 0, "two kinematics are named A; two axes are named A0"),
    ):
        with pytest.raises(MotionError, match=words):
            Installation(robots, belts)


def test_additional_axes_come_last() -> None:
    axes = (AxisOfRobot(turning("e"), "assumed", Role.FREE), AxisOfRobot(turning("a"), "assumed"))
    with pytest.raises(MotionError, match="come last"):
        kinematics_of(Robot("r", Kind.SCARA, ScaraGeometry(0.3, 0.2, 0.1), axes))
