"""URDFs as users have them: with grippers, joints that follow others, remains of xacro, faults; each gives a robot or a sentence."""

import math
import pathlib
import re
from collections.abc import Sequence

import numpy as np
import pytest

from gateway.files.robots import RobotFaults, load_robot
from hil_tests.unit.motion.kinematics.robots import TX60, apart, arm, sliding, spread, turning, urdf
from motion.errors import MotionError
from motion.geometry.limits import AxisLimits
from motion.kinematics.urdf import Urdf

ARM = urdf(TX60)
OWN = [turning(f"j{n}") for n in range(1, 7)]
XACRO = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" '
HAND = (
    '<link name="left"/><link name="right"/><link name="lens"/>'
    '<joint name="grip" type="prismatic"><parent link="flange"/><child link="left"/><axis xyz="0 1 0"/>'
    '<limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>'
    '<joint name="grip_too" type="prismatic"><parent link="flange"/><child link="right"/><axis xyz="0 -1 0"/><mimic joint="grip"/>'
    '<limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>'
    '<joint name="aim" type="floating"><parent link="l2"/><child link="lens"/></joint></robot>'
)


def joint(name: str, kind: str, parent: str, child: str, *, xyz: str = "0 0 0", axis: str = "0 1 0", more: str = "") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/><axis xyz="{axis}"/>'
        f'<limit lower="-2" upper="2" velocity="1" effort="1"/>{more}</joint>'
    )


def robot_of(*joints: str, links: str = "a b c d e f") -> str:
    return '<robot name="r">' + "".join(f'<link name="{name}"/>' for name in links.split()) + "".join(joints) + "</robot>"


def refusal(text: str, frame: str, limits: Sequence[AxisLimits]) -> str:
    try:
        Urdf(text, frame, limits)
    except (MotionError, ValueError) as error:  # ValueError: of pinocchio
        return str(error)
    return ""


def same_as_the_arm(text: str, frame: str = "flange") -> Urdf:
    assert refusal(text, frame, OWN) == ""
    made, closed = Urdf(text, frame, OWN), arm()
    for q in spread(20, (2.0,) * 6):
        assert apart(made.forward(q), closed.forward(q)) < 1e-12
        near = tuple(value + 0.05 for value in q)
        assert apart(made.forward(made.inverse(closed.forward(q), near)), closed.forward(q)) < 1e-9
    return made


@pytest.mark.parametrize(
    "text",
    [
        ARM.replace("</robot>", HAND),
        ARM.replace('name="f" type="fixed"', 'name="flange" type="fixed"'),  # joint and link of one name
        re.sub(r"<limit [^>]*/>", "", ARM),  # the robot file has them
        re.sub(r"velocity=\"[^\"]*\"", "", ARM).replace('lower="', 'lower="${-pi} '),
        ARM.replace("<robot ", XACRO).replace("<link", "<xacro:property name='w'/><link", 1),
        ARM.replace('xyz="0 1 0"', 'xyz="0 2 0"').replace('type="revolute"', 'type="continuous"'),
    ],
    ids=["gripper and camera", "names", "no limits", "limits of xacro", "xacro", "axes and turns"],
)  # fmt: skip
def test_a_robot_is_the_chain_of_joints_up_to_its_frame(text: str) -> None:
    made = same_as_the_arm(text)
    assert made.names == tuple(f"j{n}" for n in range(1, 7))


def test_a_frame_may_be_a_joint() -> None:
    same_as_the_arm(ARM.replace("</robot>", HAND), frame="f")


THREE = [turning(name) for name in "ABC"]
LEVEL = (  # a palletizer: the parallelogram keeps its hand level
    joint("turn", "revolute", "a", "b", axis="0 0 1"),
    joint("arm", "revolute", "b", "c", xyz="0 0 0.5"),
    joint("forearm", "revolute", "c", "d", xyz="0 0 0.6"),
    joint("level", "revolute", "d", "e", xyz="0.7 0 0", more='<mimic joint="arm" multiplier="-1"/>'),
    joint("level_too", "revolute", "e", "f", more='<mimic joint="level_of_forearm" offset="0.1"/>'),
)
FOREARM = joint("level_of_forearm", "revolute", "f", "g", more='<mimic joint="forearm" multiplier="-1" offset="-0.1"/>')


def test_a_joint_that_follows_another_one_is_no_axis() -> None:
    text = robot_of(*LEVEL[:4], FOREARM.replace('"f"', '"e"').replace('"g"', '"f"'))
    assert refusal(text, "f", THREE) == ""
    made = Urdf(text, "f", THREE)
    assert (made.axes, made.names) == (3, ("turn", "arm", "forearm"))
    for q in spread(20, (1.5, 1.0, 1.0)):
        pose = made.forward(q)
        reach, height = 0.6 * math.sin(q[1]) + 0.7 * math.cos(q[1] + q[2]), 1.1 + 0.6 * (math.cos(q[1]) - 1.0) - 0.7 * math.sin(q[1] + q[2])
        c, s = math.cos(q[0]), math.sin(q[0])
        assert np.allclose(pose.position, (reach * c, reach * s, height), atol=1e-12)
        tilt = np.array(pose.rotation).reshape(3, 3).T @ np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
        assert math.acos(min(1.0, (np.trace(tilt) - 1.0) / 2.0)) == pytest.approx(0.1, abs=1e-6), "the offset alone is left"
        moved = made.jacobian(q)
        for axis in range(3):
            step = tuple(value + 1e-7 * (number == axis) for number, value in enumerate(q))
            change = (np.array(made.forward(step).position) - pose.position) / 1e-7
            assert np.allclose(moved[:3, axis], change, atol=1e-5)
        assert apart(made.forward(made.inverse(pose, tuple(value + 0.05 for value in q))), pose) < 1e-9


def test_a_joint_may_follow_one_that_follows() -> None:
    chained = robot_of(*LEVEL, FOREARM, links="a b c d e f g")
    assert refusal(chained, "g", THREE) == ""
    made = Urdf(chained, "g", THREE)
    straight = np.array(made.forward((0.0, 0.3, 0.4)).rotation)
    assert made.names == ("turn", "arm", "forearm")
    turned = -0.4 - 0.1 + 0.1 - 0.4 - 0.1 + 0.4  # level_too and what it follows, beside arm, level and forearm
    assert straight[0] == pytest.approx(math.cos(turned)) and straight[2] == pytest.approx(math.sin(turned))


def test_a_single_joint_is_a_robot() -> None:
    made = Urdf(robot_of(joint("lift", "prismatic", "a", "b", axis="0 0 1")), "b", [sliding("Z")])
    assert made.jacobian((0.3,)).shape == (6, 1)
    assert made.inverse(made.forward((0.3,)), (0.2,)) == pytest.approx((0.3,))


CHAIN = robot_of(joint("one", "revolute", "a", "b"), joint("two", "prismatic", "b", "c"))
END = "</joint></robot>"
FAULTS = {
    "": "not XML",
    ARM[:700]: "not XML: unclosed token: line 1",
    "<html/>": "its first element is <html>",
    '<robot name="x"><xacro:arm prefix=""/></robot>': "not XML.*xacro: expand it first",
    XACRO + 'name="x"><link name="base"/><xacro:arm/></robot>': "no link or joint 'c'; its links: base; it h.*xacro",
    CHAIN.replace('name="c"', 'name="end"'): "its links: a, b, end",
    CHAIN.replace("0 0 0", "0,1 0 0", 1): "joint 'one' .*origin xyz is '0,1 0 0', not 3 numbers",
    CHAIN.replace("0 0 0", "${h} 0 0", 1): "joint 'one' .*not 3 numbers; it holds xacro",
    CHAIN.replace("0 0 0", "nan 0 0", 1): "not 3 numbers",
    CHAIN.replace("0 1 0", "0 0 0", 1): "joint 'one' .*axis 0 0 0",
    CHAIN.replace("revolute", "planar"): "joint 'one' of the URDF is planar",
    CHAIN.replace('type="revolute"', ""): "joint 'one' of the URDF is of no type",
    CHAIN.replace('<child link="b"/>', ""): "joint 'one' of the URDF names no child link",
    CHAIN.replace('parent link="a"', 'parent link="x"'): "is attached to the link 'x'",
    CHAIN.replace('parent link="a"', 'parent link="c"'): "form a loop",
    CHAIN.replace('"two"', '"one"'): "two joints named 'one'",
    CHAIN.replace('child link="c"', 'child link="b"'): "two joints that carry the link 'b'",
    CHAIN.replace(END, '<mimic joint="three"/>' + END): "'two' of the URDF follows 'three', which is not a moving joint",
    CHAIN.replace(END, '<mimic joint="two"/>' + END): "'two' of the URDF follows itself",
    CHAIN.replace(END, '<mimic joint="one" multiplier="x"/>' + END): "mimic multiplier is 'x', not a number",
    CHAIN.replace("prismatic", "fixed"): "2 axes for 1 joints of the URDF: one",
    CHAIN.replace("prismatic", "revolute"): "axis B: joint 'two' of the URDF turns, so its unit is deg, not m",
    re.sub("revolute|prismatic", "fixed", CHAIN): "this has 0",
}  # fmt: skip


@pytest.mark.parametrize("text", FAULTS)
def test_what_is_wrong_with_a_urdf_is_said(text: str) -> None:
    assert re.search(FAULTS[text], refusal(text, "c", [turning("A"), sliding("B")]))


def test_a_robot_file_names_a_urdf_that_is_not_utf_8(tmp_path: pathlib.Path) -> None:
    (tmp_path / "arm.urdf").write_bytes(ARM.replace('name="arm"', 'name="größe"').encode("latin-1"))
    own = tmp_path / "own.toml"
    axis = 'unit = "deg"\nlower = -1\nupper = 1\nspeed = 1\naccel = 1\njerk = 1\nsource = "x"\n'
    head = 'format = 1\n[robot]\nname = "r"\nkind = "urdf"\nsource = "x"\n[urdf]\nfile = "arm.urdf"\nframe = "flange"\n'
    own.write_text(head + "".join(f'[[axis]]\nname = "A{n}"\n{axis}' for n in range(6)))
    with pytest.raises(RobotFaults, match=r"urdf.file: arm.urdf is not UTF-8: byte 15 is F6h"):
        load_robot(str(own))
