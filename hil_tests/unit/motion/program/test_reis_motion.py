"""ROBOTstar V on whole paths: PTP with a lead axis, path speed and acceleration, path time."""

import math

import numpy as np
import pytest

from hil_tests.lab.cells.arms import Array, at, differences, portal, robot, run, tool_speed
from hil_tests.lab.cells.reis_path import Path
from motion.geometry.conventions import VAL3
from motion.geometry.limits import limits_from
from motion.kinematics.identity import Identity
from motion.planner.arm import Arm
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.program.blocks import Interpolation, JointTarget, PoseTarget
from motion.program.errors import BlockError

P = 2e-3
START = at(0)


def moved(path: Path, machine: Machine, start: tuple[float, ...], period_s: float = P) -> Array:
    arm = Arm(machine, start, period_s)
    for block in path.blocks():
        arm.add(block)
    arm.finish()
    return run(arm)


@pytest.mark.requirement("RSV-MOT-02", by="motion.planner.caps:_lead")
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


@pytest.mark.requirement("RSV-MOT-04", by="gateway.pure.languages.robotstar.lines:_speeds")
def test_bahn_geschw_100_and_50_percent_of_2000_give_ramps_of_1000_and_a_steady_100() -> None:
    path = Path(START)
    for name, value in (("BEWEG_ART", "LINEAR"), ("BAHN_GESCHW", 100), ("BAHN_BESCHL", 50)):
        path.set(name, value)
    path.position(at(150))
    rows = moved(path, portal(jerk=5e6), (0.0, 0.0, 0.0))
    speed = tool_speed(rows, P) * 1e3
    pull = np.abs(np.diff(speed)) / P
    assert speed.max() == pytest.approx(100.0, rel=2e-3)
    assert float(np.mean(speed > 99.5)) > 0.8, "a long steady phase"
    assert pull.max() == pytest.approx(1000.0, rel=0.02)


@pytest.mark.requirement("RSV-MOT-14", by="motion.planner.given_times:time_given")
def test_bahn_zeit_4_takes_4_s_and_the_next_move_has_its_speed_again() -> None:
    path = Path(START)
    for name, value in (("BEWEG_ART", "LINEAR"), ("BAHN_GESCHW", 200), ("BAHN_ZEIT", 4.0)):
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


@pytest.mark.requirement("RSV-MOT-15", by="motion.planner.given_times:time_given")
def test_bahn_zeit_10_goes_up_for_the_share_of_iacc_time_stays_and_goes_down_for_it_again() -> None:
    for share, steady in ((20, 6.0), (50, 0.0)):
        path = Path(START)
        for name, value in (("BEWEG_ART", "LINEAR"), ("IACC_TIME", share), ("BAHN_ZEIT", 10.0)):
            path.set(name, value)
        path.position(at(200))
        period = 5 * P
        speed = tool_speed(moved(path, portal(), (0.0, 0.0, 0.0), period), period)
        running = np.nonzero(speed > 1e-7)[0]
        begin, end = running[0] * period, (running[-1] + 1) * period
        ramp, top = share / 100 * 10.0, 0.2 / (10.0 * (1.0 - share / 100))
        assert end - begin == pytest.approx(10.0, abs=0.02)
        assert speed.max() == pytest.approx(top, rel=2e-3)
        assert float(np.sum(speed > 0.999 * top) * period) == pytest.approx(steady, abs=0.1), "constant phase"
        t = (np.arange(len(speed)) + 0.5) * period - begin
        up, down = (t > 0.1) & (t < ramp - 0.1), (t > 10.0 - ramp + 0.1) & (t < 9.9)
        assert speed[up] == pytest.approx(top * t[up] / ramp, abs=0.02 * top), "evenly up"
        assert speed[down] == pytest.approx(top * (10.0 - t[down]) / ramp, abs=0.02 * top), "evenly down"


@pytest.mark.requirement("RSV-MOT-01", by="gateway.pure.languages.robotstar.lines:line")
def test_without_a_motion_command_two_positions_are_joint_synchronous_moves() -> None:
    limits = tuple(limits_from(f"A{n}", "deg", lower=-180, upper=180, speed=60.0 + 40 * n, accel=500, jerk=20_000) for n in range(3))
    path = Path(JointTarget((0.0, 0.0, 0.0)))
    targets = ((0.8, -0.3, 0.05), (0.1, 0.6, 0.4))
    for target in targets:
        path.position(JointTarget(target))
    assert [block.kind for block in path.blocks()] == [Interpolation.PTP] * 2, "the default"
    rows = moved(path, Machine(Identity(limits), limits), (0.0, 0.0, 0.0))
    there = int(np.argmin(np.linalg.norm(rows - np.array(targets[0]), axis=1)))
    assert rows[there] == pytest.approx(targets[0], abs=1e-9) and rows[-1] == pytest.approx(targets[1], abs=1e-9)
    for leg, start, end in ((rows[: there + 1], (0.0, 0.0, 0.0), targets[0]), (rows[there:], targets[0], targets[1])):
        shares = (leg - np.array(start)) / (np.array(end) - np.array(start))
        assert np.ptp(shares, axis=1) == pytest.approx(np.zeros(len(leg)), abs=1e-8), "all axes start and end together"


@pytest.mark.requirement("RSV-MOT-05", by="gateway.pure.languages.robotstar.lines:line")
@pytest.mark.requirement("RSV-MOT-05", by="motion.planner.block_paths:_arc")
def test_zirk_makes_an_arc_of_each_two_positions_and_ptp_ends_it() -> None:
    path = Path(START)
    path.set("BEWEG_ART", "ZIRK_MIN_ORI")
    path.set("BAHN_GESCHW", 300)
    d, e, f, g = (100.0, 100.0), (200.0, 0.0), (250.0, -80.0), (400.0, -100.0)
    for x, y in (d, e, f, g):
        path.position(at(x, y))
    path.set("BEWEG_ART", "PTP")
    path.position(at(0, 50))
    assert [block.kind for block in path.blocks()] == [Interpolation.CIRCULAR] * 2 + [Interpolation.PTP]
    rows = moved(path, portal(), (0.0, 0.0, 0.0))[:, :2] * 1e3
    at_e = int(np.argmin(np.linalg.norm(rows - np.array(e), axis=1)))
    at_g = int(np.argmin(np.linalg.norm(rows - np.array(g), axis=1)))
    assert 0 < at_e < at_g and rows[at_e] == pytest.approx(e, abs=1e-3) and rows[at_g] == pytest.approx(g, abs=1e-3)
    first, second = circle((0.0, 0.0), d, e), circle(e, f, g)
    for part, (x, y, radius), via in ((rows[: at_e + 1], first, d), (rows[at_e : at_g + 1], second, f)):
        assert float(np.abs(np.hypot(part[:, 0] - x, part[:, 1] - y) - radius).max()) < 1e-3, "on its circle"
        assert float(np.linalg.norm(part - np.array(via), axis=1).min()) < 1.0, "through its auxiliary point"
    last = rows[at_g:]
    away = np.abs((last[:, 0] - 400.0) * (50.0 + 100.0) - (last[:, 1] + 100.0) * (0.0 - 400.0)) / math.hypot(400.0, 150.0)
    assert float(away.max()) < 1e-3, "a portal's PTP is straight: no circle any more"


def circle(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> tuple[float, float, float]:
    """Centre and radius through three points."""
    rows = np.array([[2 * (p[0] - a[0]), 2 * (p[1] - a[1])] for p in (b, c)])
    x, y = np.linalg.solve(rows, np.array([p[0] ** 2 + p[1] ** 2 - a[0] ** 2 - a[1] ** 2 for p in (b, c)]))
    return float(x), float(y), math.dist((x, y), a)


def rounded(first_speed: float = 100.0, second_speed: float = 100.0, **values: float) -> tuple[Array, Array]:
    """Places (mm) and speeds (mm/s) of a right angle at (100, 0)."""
    path = Path(START)
    path.set("BEWEG_ART", "LINEAR")
    for name, value in {"BAHN_BESCHL": 100.0, "UEBERSCHL": True, **values}.items():
        path.set(name, value)
    path.set("BAHN_GESCHW", first_speed)
    path.position(at(100))
    path.set("BAHN_GESCHW", second_speed)
    path.set("UEBERSCHL", False)
    path.position(at(100, 100))
    rows = moved(path, portal(), (0.0, 0.0, 0.0))
    return rows[:-1, :2] * 1e3, tool_speed(rows, P) * 1e3


@pytest.mark.requirement("RSV-MOT-07", by="motion.planner.runs:_flyby")
def test_iv_flyby_s_is_the_share_of_the_mean_speed_in_the_middle_of_the_corner() -> None:
    for share, wanted in ((100, 150.0), (50, 75.0)):
        places, speed = rounded(100.0, 200.0, BAHN_RADIUS=30, IV_FLYBY_S=share)
        inside = np.linalg.norm(places - np.array([100.0, 0.0]), axis=1) < 30.0
        middle = int(np.argmin(np.abs((100.0 - places[:, 0]) - places[:, 1]) + 1e3 * ~inside))
        assert speed[middle] == pytest.approx(wanted, rel=0.01), share


def test_iv_flyby_s_0_rests_once_in_the_middle_of_the_rounded_corner_and_goes_on() -> None:
    places, speed = rounded(100.0, 200.0, BAHN_RADIUS=30, IV_FLYBY_S=0)
    resting = np.nonzero(speed[20:-20] < 1.0)[0] + 20
    assert 1 <= len(resting) <= 8 and resting[-1] - resting[0] < 8, "one short rest, no creeping"
    x, y = places[resting[len(resting) // 2]]
    assert (100.0 - x, y) == pytest.approx((0.1875 * 30, 0.1875 * 30), abs=0.02), "the middle of the same rounded path"
    assert len(places) < 800, "a stop costs no more than braking and starting"


@pytest.mark.requirement("RSV-MOT-08", by="motion.planner.route:Route._leave")
@pytest.mark.requirement("RSV-MOT-08", "RSV-MOT-09", by="gateway.pure.languages.robotstar.lines:_passed")
def test_bahn_radius_10_leaves_10_mm_before_and_rejoins_10_mm_after_and_bahn_distanz_has_priority() -> None:
    corner = np.array([100.0, 0.0])

    def seen(**values: float) -> tuple[float, float, float]:
        """(mm before and behind the point where the lines are left and joined, mm by which it is missed)"""
        places, _ = rounded(**values)
        off = (places[:, 1] > 1e-4) & (100.0 - places[:, 0] > 1e-4)
        begin, end = np.nonzero(off)[0][[0, -1]]
        return 100.0 - places[begin - 1, 0], places[end + 1, 1], float(np.linalg.norm(places - corner, axis=1).min())

    before, behind, missed = seen(BAHN_RADIUS=10, BAHN_DISTANZ=0.0)
    assert 9.0 < before <= 10.3 and 9.0 < behind <= 10.3 and missed == pytest.approx(0.1875 * 10 * math.sqrt(2), abs=0.02)
    before, behind, missed = seen(BAHN_RADIUS=10, BAHN_DISTANZ=3)
    assert missed == pytest.approx(3.0, abs=0.02), "DISTANZ has priority"
    assert before > 10.5 and behind > 10.5


@pytest.mark.requirement("RSV-MOT-10", by=("gateway.pure.languages.robotstar.lines:_passed", "motion.planner.spline_rows:curve_of"))
def test_a_spline_goes_through_its_points_whatever_bahn_radius_says() -> None:
    points = ((40.0, 30.0), (80.0, -10.0), (130.0, 20.0), (170.0, 0.0))

    def way(radius: float, rounding: bool) -> Array:
        path = Path(START)
        for name, value in (("BEWEG_ART", "SPLINE"), ("UEBERSCHL", rounding), ("BAHN_RADIUS", radius), ("BAHN_GESCHW", 200)):
            path.set(name, value)
        for x, y in points:
            path.position(at(x, y))
        return moved(path, portal(), (0.0, 0.0, 0.0))

    plain, other = way(1.0, False), way(25.0, True)
    assert plain.shape == other.shape and float(np.abs(plain - other).max()) < 1e-12, "BAHN_RADIUS has no effect"
    for x, y in points:
        assert float(np.linalg.norm(plain[:, :2] * 1e3 - np.array([x, y]), axis=1).min()) < 0.25, "a sample beside each point"
    steps = np.diff(plain[:, :2], axis=0)
    moving = steps[np.linalg.norm(steps, axis=1) > 1e-5]
    turns = np.abs(np.diff(np.unwrap(np.arctan2(moving[:, 1], moving[:, 0]))))
    assert float(turns.max()) < 0.05, "the tangent is continuous"


@pytest.mark.requirement("RSV-MOT-18", by="motion.planner.given_times:check_time")
def test_an_additional_axis_that_cannot_keep_the_time_is_706_and_one_of_the_arm_611() -> None:
    own = portal()
    slow = limits_from("E1", "mm", lower=0, upper=1000, speed=50, accel=500, jerk=20_000)
    machine = Machine(own.kinematics, (*own.limits, slow))

    def fault(extra: float, seconds: float) -> tuple[int, str]:
        path = Path(START)
        path.set("BEWEG_ART", "LINEAR")
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
    assert fault(0.1, 3.0) == (0, "") and fault(0.1, 2.5) == (706, "E1"), "100 mm at 50 mm/s, with a quarter of the time up and one down"
    assert fault(0.3, 4.0) == (706, "E1")
    assert fault(0.0, 0.04) == (611, "x")


def test_an_additional_axis_keeps_step_with_the_path() -> None:
    own = portal()
    machine = Machine(own.kinematics, (*own.limits, limits_from("E1", "mm", lower=0, upper=1000, speed=500, accel=5000, jerk=200_000)))
    path = Path(START)
    for name, value in (("BEWEG_ART", "LINEAR"), ("BAHN_GESCHW", 300), ("UEBERSCHL", True), ("BAHN_RADIUS", 10)):
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
    for name, value in (("BEWEG_ART", "LINEAR"), ("BAHN_GESCHW", 250), ("UEBERSCHL", True), ("BAHN_DISTANZ", 3)):
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
