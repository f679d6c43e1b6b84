"""ROBOTstar V on whole paths: PTP with a lead axis, path speed and acceleration, path time."""

import math

import numpy as np
import pytest

from hil_tests.lab.answers import answers
from hil_tests.lab.arms import Array, at, differences, portal, robot, run, tool_speed
from motion.conventions import VAL3
from motion.kinematics.identity import Identity
from motion.limits import limits_from
from motion.planner.arm import Arm
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.program.blocks import JointTarget, PoseTarget
from motion.program.errors import BlockError
from motion.program.reis import MachineData, Mode, Path

P = 2e-3
START = at(0)


def moved(path: Path, machine: Machine, start: tuple[float, ...]) -> Array:
    arm = Arm(machine, start, P)
    for block in path.blocks():
        arm.add(block)
    arm.finish()
    return run(arm)


@pytest.mark.requirement("RSV-MOT-02", by="motion.planner.runs:_lead")
@answers
def test_ptp_geschw_50_is_half_the_speed_of_the_axis_with_the_largest_travel() -> None:
    limits = tuple(
        limits_from(f"A{n}", "deg", lower=-180, upper=180, speed=speed, accel=2000, jerk=50_000) for n, speed in ((1, 200.0), (2, 60.0))
    )
    path = Path(JointTarget((0.0, 0.0)))
    path.set("PTP_GESCHW", 50)
    path.set("PTP_BESCHL", 100)
    path.position(JointTarget((math.radians(90), math.radians(40))))
    rows = moved(path, Machine(Identity(limits), limits), (0.0, 0.0))
    peaks = np.degrees(np.abs(differences(rows, P, 1)).max(axis=0))
    assert peaks[0] == pytest.approx(100.0, rel=2e-3), "50 % of 200 deg/s"
    assert peaks[1] == pytest.approx(100.0 * 40 / 90, rel=2e-3), "the other one only keeps up: 74 % of its own limit"


@pytest.mark.requirement("RSV-MOT-04", by="motion.program.reis:Path._pace")
@answers
def test_bahn_geschw_100_and_50_percent_of_2000_give_ramps_of_1000_and_a_steady_100() -> None:
    path = Path(START, MachineData(RACC_MAX=2000.0))
    for name, value in (("BEWEG_ART", Mode.LINEAR), ("BAHN_GESCHW", 100), ("BAHN_BESCHL", 50)):
        path.set(name, value)
    path.position(at(150))
    rows = moved(path, portal(jerk=5e6), (0.0, 0.0, 0.0))
    speed = tool_speed(rows, P) * 1e3
    pull = np.abs(np.diff(speed)) / P
    assert speed.max() == pytest.approx(100.0, rel=2e-3)
    assert float(np.mean(speed > 99.5)) > 0.8, "a long steady phase"
    assert pull.max() == pytest.approx(1000.0, rel=0.02)


@pytest.mark.requirement("RSV-MOT-14", by="motion.planner.timegiven:time_given")
@answers
def test_bahn_zeit_4_takes_4_s_and_the_next_move_has_its_speed_again() -> None:
    path = Path(START)
    for name, value in (("BEWEG_ART", Mode.LINEAR), ("BAHN_GESCHW", 200), ("BAHN_ZEIT", 4.0)):
        path.set(name, value)
    path.position(at(100))
    path.position(at(100, 100))
    rows = moved(path, portal(), (0.0, 0.0, 0.0))
    speed = tool_speed(rows, P)
    first, second = rows[:-1, 1] < 1e-9, rows[:-1, 1] >= 1e-9
    running = np.nonzero(first & (speed > 1e-7))[0]
    assert (running[-1] - running[0] + 1) * P == pytest.approx(4.0, abs=0.02)
    assert speed[first].max() == pytest.approx(0.1 / (4.0 * 0.75), rel=2e-3), "25 % up, 25 % down"
    assert speed[second].max() == pytest.approx(0.2, rel=2e-3)


@pytest.mark.requirement("RSV-MOT-18", by="motion.planner.timegiven:check_time")
@answers
def test_an_additional_axis_that_cannot_keep_the_time_is_706_and_one_of_the_arm_611() -> None:
    own = portal()
    slow = limits_from("E1", "mm", lower=0, upper=1000, speed=50, accel=500, jerk=20_000)
    machine = Machine(own.kinematics, (*own.limits, slow))

    def fault(extra: float, seconds: float) -> tuple[int, str]:
        path = Path(START)
        path.set("BEWEG_ART", Mode.LINEAR)
        path.set("BAHN_ZEIT", seconds)
        path.position(PoseTarget(at(100).pose, extra=(extra,)))
        route = Route(machine, (0.0, 0.0, 0.0, 0.0))
        try:
            for block in path.blocks():
                route.add(block)
        except BlockError as error:
            return error.code, error.axis
        return 0, ""

    assert fault(0.1, 4.0) == (0, "")
    assert fault(0.3, 4.0) == (706, "E1")
    assert fault(0.0, 0.04) == (611, "x")


def test_an_additional_axis_keeps_step_with_the_path() -> None:
    own = portal()
    machine = Machine(own.kinematics, (*own.limits, limits_from("E1", "mm", lower=0, upper=1000, speed=500, accel=5000, jerk=200_000)))
    path = Path(START)
    for name, value in (("BEWEG_ART", Mode.LINEAR), ("BAHN_GESCHW", 300), ("UEBERSCHL", True), ("BAHN_RADIUS", 10)):
        path.set(name, value)
    for target, extra in ((at(100), 0.05), (at(100, 100), 0.2)):
        path.position(PoseTarget(target.pose, extra=(extra,)))
    rows = moved(path, machine, (0.0, 0.0, 0.0, 0.0))
    straight = rows[rows[:, 0] < 0.089]
    assert straight[:, 3] == pytest.approx(straight[:, 0] * 0.5, abs=1e-9)
    assert rows[-1] == pytest.approx([0.1, 0.1, 0.0, 0.2], abs=1e-9)


def test_the_same_program_runs_on_the_six_axis_arm() -> None:
    machine = robot("tx60-like")
    start = (0.0, math.radians(30), math.radians(90), 0.0, math.radians(60), 0.0)
    x, y, z, a, b, c = VAL3.values(machine.kinematics.forward(start))
    path = Path(PoseTarget(machine.kinematics.forward(start)))
    for name, value in (("BEWEG_ART", Mode.LINEAR), ("BAHN_GESCHW", 250), ("UEBERSCHL", True), ("BAHN_DISTANZ", 3)):
        path.set(name, value)
    path.position(PoseTarget(VAL3.pose((x, y + 60, z, a, b, c))))
    path.position(PoseTarget(VAL3.pose((x - 60, y + 60, z, a, b, c))))
    arm = Arm(machine, start, P)
    for block in path.blocks():
        arm.add(block)
    arm.finish()
    rows = run(arm)
    corner = np.array([x, y + 60, z]) * 1e-3
    places = np.array([machine.kinematics.forward([float(v) for v in row]).position for row in rows])
    assert float(np.min(np.linalg.norm(places - corner, axis=1))) == pytest.approx(0.003, abs=5e-5), "missed by 3 mm"
