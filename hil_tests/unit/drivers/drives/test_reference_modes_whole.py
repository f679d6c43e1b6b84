"""rho3 2.8 against the emulated booster: all four modes end where the mechanics say, with its lag and its own switch."""

import math

import pytest

from drivers.drives.reference_settings import ReferenceMove
from drivers.drives.referencing import Referencing, RunState
from drivers.drives.scaling import Scaling
from drivers.emulator.servo.settings import ServoSettings
from hil_tests.lab.virtual.one_axis import OneAxis

GEAR = 4.1
TURN_RAD = 2 * math.pi  # of the motor
AXIS_RAD = GEAR * TURN_RAD  # motor for one turn of the axis


def referenced(mode: int, turns: int, edge_deg: float, position_deg: float = 0.0, offset_deg: float = 0.0) -> OneAxis:
    """The cam's edge stands `edge_deg` (at the resolver) from the axis' zero, and comes by once each axis turn; the axis is `turns` off.

    The search goes downwards; the resolver shows 0 in the axis' zero.
    """
    edge = turns * AXIS_RAD + math.radians(edge_deg)
    settings = ServoSettings(
        start_rad=edge + 5.0, reference_switch_from_rad=edge - 3.0, reference_switch_to_rad=edge, following_error_rad=20.0
    )
    axis = OneAxis(Scaling(gear=GEAR), settings)
    axis.enable()
    speed = 2.0 / GEAR  # rad/s of the axis
    rad = math.radians
    run = Referencing(
        ReferenceMove(
            direction=-1, speed=speed, slow_speed=speed / 4, accel=4.0, jerk=60.0,
            position=rad(position_deg), offset=rad(offset_deg), mode=mode,
        ).at_motor(axis.scaling),
        axis.drive.position_inc,
    )  # fmt: skip
    step = None
    for _ in range(40_000):
        actual = axis.actual
        step = run.step(axis.drive.position_inc, actual is not None and actual.reference_switch, axis.period_ns * 1e-9)
        axis.set = axis.goal = axis.scaling.to_si(step.set_inc)
        axis.cycle()
        if step.state is not RunState.RUNNING:
            break
    assert step is not None and step.state is RunState.DONE and run.zero_inc is not None, step
    axis.run(0.3)
    axis.scaling = axis.scaling.with_zero(run.zero_inc)
    return axis


def shaft_turns(axis: OneAxis) -> float:
    return axis.shaft_rad / TURN_RAD


@pytest.mark.parametrize("turns", [-2, 0, 3])
def test_mode_1_comes_back_to_the_axis_zero_from_any_turn(turns: int) -> None:
    axis = referenced(1, turns, edge_deg=8.0, position_deg=12.0, offset_deg=5.0)
    assert math.degrees(axis.position) == pytest.approx(17.0, abs=0.05)  # P207 + P208
    assert shaft_turns(axis) == pytest.approx(GEAR * 5.0 / 360, abs=0.002)  # P208 away from its own zero


@pytest.mark.parametrize("turns", [-2, 0, 3])
def test_mode_3_stays_and_knows_how_far_it_is_from_the_axis_zero(turns: int) -> None:
    axis = referenced(3, turns, edge_deg=8.0, position_deg=12.0)
    assert axis.position == pytest.approx(axis.shaft_rad / GEAR + math.radians(12.0), abs=2e-3)
    assert shaft_turns(axis) == pytest.approx(GEAR * turns + 8.0 / 360, abs=0.1)  # stopped just behind the edge


def test_mode_2_counts_from_the_encoder_zero_next_to_the_edge() -> None:
    axis = referenced(2, 1, edge_deg=20.0, position_deg=12.0)
    zero = round((AXIS_RAD + math.radians(20.0)) / TURN_RAD)  # number of the encoder turn next to the edge
    assert axis.position == pytest.approx((axis.shaft_rad - zero * TURN_RAD) / GEAR + math.radians(12.0), abs=2e-3)
    assert shaft_turns(axis) == pytest.approx(4.1 + 20.0 / 360, abs=0.1)


def test_mode_0_runs_on_to_the_encoder_zero_behind_the_switch() -> None:
    axis = referenced(0, 1, edge_deg=20.0, position_deg=12.0)
    assert shaft_turns(axis) == pytest.approx(math.floor((AXIS_RAD + math.radians(20.0)) / TURN_RAD), abs=0.002)
    assert math.degrees(axis.position) == pytest.approx(12.0, abs=0.05)
