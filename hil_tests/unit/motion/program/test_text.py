"""The text form: everything it can say, every fault with line, key and range, and the way back."""

import math

import pytest

from hil_tests.unit.motion.program.close import same_program
from motion.errors import MotionError
from motion.geometry.frames import Pose
from motion.kinematics.base import Shoulder, Wrist
from motion.program.blocks import (
    Flying,
    Interpolation,
    JointTarget,
    Output,
    PoseTarget,
    Program,
    Rounding,
    Slope,
    StartWait,
    Tool,
    Turning,
    Until,
)
from motion.program.errors import TextFaults
from motion.program.text import keys as textkeys
from motion.program.text.reader import read
from motion.program.text.writer import write

WHOLE = """
program demo            # a comment
robot scara
angles val3
axes deg deg mm deg
start 0 90 0 0
tool grip 0 0 100 0 0 0
frame table 500 0 0 0 0 90
point A pose 400 100 50 180 0 30 config=righty,wnegative
point H joints 0 90 -10 0
set speed=50 path=200 radius=10
ptp H blend=off zone=1,1,2,3
linear A tool=grip frame=table slope=block limitmin=100,-400.5,150
circular via pose 400 200 50 180 0 30 to pose 300 100 50 180 0 30 turning=least angle=450 rise=-20 out=7:1@20,8:0 until=!5
spline A extra=100mm,30deg tension=20 tube=0.05 weight=0 time=4 ramp=50
set radius=0
linear A leave=5 reach=20 distance=3 share=40 flyby=75 lead=no arcs=yes
"""


def faults(text: str) -> list[tuple[int, str, str]]:
    with pytest.raises(TextFaults) as caught:
        read(text)
    return [(fault.line, fault.key, fault.what) for fault in caught.value.faults]


def test_everything_the_text_can_say_arrives_in_si() -> None:
    program = read(WHOLE)
    ptp, line, arc, curve, last = program.blocks
    assert (program.name, program.robot, program.units) == ("demo", "scara", ("deg", "deg", "mm", "deg"))
    assert program.start == (0.0, math.pi / 2, 0.0, 0.0)
    assert ptp.kind is Interpolation.PTP and ptp.target == JointTarget((0.0, math.pi / 2, -0.01, 0.0))
    assert ptp.blend.axes == pytest.approx((math.radians(1), math.radians(1), 0.002, math.radians(3)))
    assert line.blend.leave == line.blend.reach == pytest.approx(0.01) and line.blend.rounding is Rounding.CARTESIAN
    assert line.slope is Slope.BLOCK and line.tool == Tool("grip", Pose((0.0, 0.0, 0.1), (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)))
    assert line.pace.path_speed == pytest.approx(0.2) and line.pace.speed == 0.5
    assert line.lowest == pytest.approx((0.1, -0.4005, 0.15)) and line.highest is None and arc.lowest is None
    assert isinstance(line.target, PoseTarget)
    assert (line.target.configuration.shoulder, line.target.configuration.wrist) == (Shoulder.RIGHTY, Wrist.NEGATIVE)
    assert arc.via is not None and arc.turning is Turning.LEAST
    assert (arc.angle, arc.rise) == pytest.approx((math.radians(450), -0.02)) and curve.angle is None
    assert arc.outputs == (Output(7, 1.0, 0.02), Output(8, 0.0)) and arc.until == Until(5, False)
    assert isinstance(curve.target, PoseTarget) and curve.target.extra == pytest.approx((0.1, math.radians(30)))
    assert (curve.pace.time, curve.pace.ramp, curve.curving.tension, curve.curving.weight) == (4.0, 0.5, 0.2, 0.0)
    assert curve.curving.tube == pytest.approx(50e-6)
    assert (last.blend.leave, last.blend.reach, last.blend.distance) == pytest.approx((0.005, 0.02, 0.003))
    assert (last.blend.share, last.blend.flyby) == pytest.approx((0.4, 0.75))


@pytest.mark.parametrize("angles", ["val3", "rho3", "reis"])
def test_what_is_written_reads_back_to_the_same_program(angles: str) -> None:
    program = read(WHOLE)
    once = read(write(program, angles))
    assert same_program(once, program)
    assert write(once, angles) == write(program, angles)


def test_each_fault_has_its_line_its_key_and_the_range_and_all_are_reported() -> None:
    wrong = [
        "linear pose 1 2",
        "foo",
        "linear A speed=1000",
        "linear A bar=3",
        "ptp joints nan 0 0 0",
        "set time=3",
        "linear A flyby=100.1",
        "linear A blend=round",
        "linear B",
        "circular A",
        "ptp joints 1 2 3",
        "linear A until=x",
        "linear A out=7",
        "ptp H config=righty",
        "linear A extra=100",
        "point 7 joints 0 0 0 0",
        "axes deg turn",
        "linear A H",
        "linear A config=up",
        "linear A speed=",
        "linear A tool=hand",
    ]
    start = len(WHOLE.splitlines()) + 1
    told = faults(WHOLE + "\n".join(wrong))
    assert [line for line, _, _ in told] == list(range(start, start + len(wrong)))
    by_line = {line - start: (key, what) for line, key, what in told}
    assert by_line[2] == ("speed", "1000 % is outside 0.01 .. 500 %")
    assert by_line[4][0] == "joints" and "nan deg is outside" in by_line[4][1]
    assert by_line[6] == ("flyby", "100.1 % is outside 0 .. 100 %")
    assert by_line[7] == ("blend", "'round'; one of off, cartesian, joint")
    assert by_line[8][1] == "point 'B' is unknown; A, H are known"
    assert [by_line[n][0] for n in (3, 11, 12, 13, 14, 18, 20)] == ["bar", "until", "out", "config", "extra", "config", "tool"]


@pytest.mark.parametrize("key", textkeys.KEYS, ids=lambda key: str(key.name))
def test_both_ends_of_every_range_are_legal_and_one_step_beyond_is_not(key: textkeys.Key) -> None:
    circle = "circular via pose 1 0 0 0 0 0 to pose 0 1 0 0 0 0"
    move = {"angle": circle, "rise": f"{circle} angle=90"}.get(key.name, "linear pose 0 0 0 0 0 0")
    for value in (key.low, key.high):
        read(f"start 0\n{move} {key.name}={value!r}")
    for value in (key.low - 1e-6 - abs(key.low) * 1e-9, key.high * (1 + 1e-9) + 1e-6, math.nan, math.inf):
        assert faults(f"start 0\n{move} {key.name}={value!r}")[0][:2] == (2, key.name)


def test_angle_and_rise_are_in_a_circular_block_alone() -> None:
    assert faults("start 0\nlinear pose 0 0 0 0 0 0 angle=90")[0][:2] == (2, "angle")
    assert faults("start 0\ncircular via pose 1 0 0 0 0 0 to pose 0 1 0 0 0 0 rise=90")[0][:2] == (2, "rise")
    assert faults("start 0\nset angle=90")[0][:2] == (2, "angle")


@pytest.mark.parametrize(
    ("line", "key"),
    [
        ("linear pose 0 0 0 0 0 0 radius=5 radius=6", "radius"),
        ("set path=5 path=6", "path"),
        ("point A pose 0 0 0 0 0 0 config=righty config=lefty", "config"),
        ("linear pose 0 0 0 0 0 0 out=1:1 out=2:0", "out"),
    ],
)
def test_a_key_given_twice_is_a_slip(line: str, key: str) -> None:
    """The first one was lost: an output that was never set."""
    ((number, where, what),) = faults(f"start 0\n{line}")
    assert (number, where) == (2, key) and what.startswith("is given twice: ")


def test_a_text_without_a_start_or_empty_says_so() -> None:
    assert faults("") == [(0, "start", "is missing: where the axes are before the first block")]
    assert read("start 1 2").blocks == ()


def test_two_tools_of_one_name_cannot_be_written() -> None:
    program = read("start 0\ntool a 0 0 1 0 0 0\nlinear pose 0 0 0 0 0 0 tool=a\ntool a 0 0 2 0 0 0\nlinear pose 0 0 0 0 0 0 tool=a")
    with pytest.raises(MotionError, match="two places"):
        write(program)
    nameless = Program(
        "", "", (0.0,), (program.blocks[0].__class__(Interpolation.PTP, JointTarget((0.0,)), tool=Tool("", program.blocks[0].tool.pose)),)
    )
    with pytest.raises(MotionError, match="without a name"):
        write(nameless)


INPUTS = """
axes deg deg
start 0 0
measure_on ch610 edge=0
iol 2 1 1 5 1 0
ptp joints 1 1
measure_off ch610
measure_on ch620
ptp joints 2 2 wait=!ch611 delay=0.15
ptp joints 3 3 wait=464 until=ch610 within=1.5
"""


def test_measuring_on_the_way_and_waits_before_a_block_arrive_and_are_written_again() -> None:
    program = read(INPUTS)
    first, second, third = program.blocks
    assert first.functions[0] == Flying(610, False) and len(first.functions) == 2 and first.wait is None and first.measures
    assert second.functions == (Flying(610, None), Flying(620, True))
    assert second.wait == StartWait(0, False, 611, 0.15) and second.measures
    assert third.wait == StartWait(464) and third.until == Until(0, True, 610, within=1.5)
    again = read(write(program))
    assert [(b.functions, b.wait, b.until) for b in again.blocks] == [(b.functions, b.wait, b.until) for b in program.blocks]


@pytest.mark.parametrize(
    ("line", "key"),
    [
        ("measure_on", "measure_on"),
        ("measure_on 610", "measure_on"),
        ("measure_on ch610 edge=2", "edge"),
        ("measure_off ch610 edge=1", "measure_off"),
        ("ptp joints 1 1 wait=ch", "wait"),
        ("ptp joints 1 1 delay=1", "delay"),
        ("ptp joints 1 1 wait=5 delay=soon", "delay"),
        ("ptp joints 1 1 wait=5 delay=nan", "delay"),
        ("ptp joints 1 1 wait=5 delay=3601", "delay"),
        ("set wait=5", "wait"),
    ],
)
def test_what_is_no_measuring_and_no_wait_is_reported_with_its_key(line: str, key: str) -> None:
    assert [(number, word) for number, word, _ in faults(f"axes deg deg\nstart 0 0\n{line}\nptp joints 1 1")] == [(3, key)]
