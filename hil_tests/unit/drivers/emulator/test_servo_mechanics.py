"""The servo model against closed forms: acceleration, run-out, brake, stiction, the step itself, the encoder."""

from dataclasses import replace
from math import cos, exp, log, pi, sin

import pytest

from drivers.emulator.servo.model import INC_PER_RAD, STEP_NS, Servo, Trip
from drivers.emulator.servo.settings import INC_PER_TURN, ServoSettings
from hil_tests.lab.virtual.servodyn_bus import DriveBus

P5 = 4_000_000
WIDE = ServoSettings(following_error_rad=1e4, speed_limit_rad_s=1000.0, overspeed_rad_s=2000.0)


def steps(seconds: float) -> int:
    return round(seconds * 1e9 / STEP_NS)


def driven(settings: ServoSettings, goal_inc: float, seconds: float) -> Servo:
    servo = Servo(settings)
    servo.open_brake()
    servo.hold()
    servo.follow(goal_inc, 0, P5, 0.0)
    assert servo.run_to(steps(seconds)) is Trip.NONE
    return servo


@pytest.mark.parametrize("load", [0.0, 0.0012, 0.02])
@pytest.mark.parametrize("gravity", [0.0, 4.0])
def test_acceleration_at_the_torque_limit_is_torque_minus_friction_over_inertia(load: float, gravity: float) -> None:
    settings = replace(WIDE, load_inertia_kgm2=load, gravity_nm=gravity, viscous_nms_per_rad=0.0)
    servo = driven(settings, 1e7, 0.010)
    begin = servo.speed_rad_s
    servo.run_to(steps(0.030))
    assert servo.torque_nm == pytest.approx(settings.torque_limit_nm, rel=1e-6)
    expected = (settings.torque_limit_nm - settings.coulomb_nm - gravity) / settings.inertia_kgm2
    assert (servo.speed_rad_s - begin) / 0.020 == pytest.approx(expected, rel=0.02)


def test_the_current_loop_is_first_order_exactly() -> None:
    """Torque demanded from the position tick at step 4: w = T/J (t - tau (1 - exp(-t/tau)))."""
    tau = 0.002
    settings = replace(WIDE, coulomb_nm=0.0, stiction_nm=0.0, viscous_nms_per_rad=0.0, current_time_constant_s=tau)
    servo = driven(settings, 1e7, 4 * STEP_NS * 1e-9)
    for count in (1, 5, 40):
        servo.run_to(4 + count)
        t = count * STEP_NS * 1e-9
        assert servo.torque_nm == pytest.approx(18.0 * (1.0 - exp(-t / tau)), rel=1e-9)
        assert servo.speed_rad_s == pytest.approx(18.0 / settings.inertia_kgm2 * (t - tau * (1.0 - exp(-t / tau))), rel=1e-9)


def test_within_one_increment_the_position_loop_does_nothing() -> None:
    settings = ServoSettings(start_rad=0.7 / INC_PER_RAD, coulomb_nm=0.0, stiction_nm=0.0)
    servo = Servo(settings)
    servo.open_brake()
    servo.hold()
    servo.run_to(steps(0.1))
    assert servo.position_rad == settings.start_rad and servo.torque_nm == 0.0


@pytest.mark.parametrize("step", [64, 65, 66, 67])
def test_the_interpolator_is_continuous_and_reaches_the_goal_one_cycle_later(step: int) -> None:
    servo = Servo(WIDE)
    servo.open_brake()
    servo.hold()
    servo.follow(100.0, 0, P5, 0.0)
    servo.run_to(step)
    before = servo.demand_inc(20_000)
    servo.follow(500.0, 20_000, P5, 0.0)
    assert servo.demand_inc(20_000) == pytest.approx(before)
    servo.run_to(step + 32)
    assert servo.demand_inc(20_000) == pytest.approx((before + 500.0) / 2.0)
    servo.run_to(step + 63)
    assert servo.demand_inc(20_000) < 500.0
    servo.run_to(step + 64)
    assert servo.demand_inc(20_001) == 500.0


@pytest.mark.parametrize("viscous", [0.0, 0.0008, 0.004])
def test_run_out_by_friction(viscous: float) -> None:
    settings = replace(WIDE, viscous_nms_per_rad=viscous, coulomb_nm=0.3, stiction_nm=0.3)
    servo = driven(settings, 1e7, 0.030)
    servo.off()
    servo.run_to(steps(0.050))  # the current has died away
    speed, place, began, inertia = servo.speed_rad_s, servo.position_rad, servo.step, settings.inertia_kgm2
    assert speed > 100.0
    while servo.speed_rad_s:
        servo.run_to(servo.step + 1)
    if viscous:
        time = inertia / viscous * log(1.0 + viscous * speed / 0.3)
        way = inertia * speed / viscous - 0.3 * inertia / viscous**2 * log(1.0 + viscous * speed / 0.3)
    else:
        time, way = inertia * speed / 0.3, inertia * speed**2 / 0.6
    assert (servo.step - began) * STEP_NS * 1e-9 == pytest.approx(time, abs=1.5 * STEP_NS * 1e-9)
    assert servo.position_rad - place == pytest.approx(way, abs=0.1 / INC_PER_RAD)


@pytest.mark.parametrize("torque", [0.359, -0.359])
def test_below_stiction_nothing_moves_at_all(torque: float) -> None:
    servo = Servo(ServoSettings(start_rad=1.0))
    servo.open_brake()
    servo.load_torque(torque)
    for _ in range(200):
        servo.run_to(servo.step + 7)
        assert servo.position_rad == 1.0 and servo.speed_rad_s == 0.0


@pytest.mark.parametrize("torque", [0.361, -0.361])
def test_above_stiction_it_breaks_loose_and_slides_under_coulomb_friction_only(torque: float) -> None:
    settings = ServoSettings(viscous_nms_per_rad=0.0)
    servo = Servo(settings)
    servo.open_brake()
    servo.load_torque(torque)
    servo.run_to(steps(0.001))  # external torque acts from the 1 ms tick
    servo.run_to(steps(0.101))
    expected = -(abs(torque) - settings.coulomb_nm) / settings.inertia_kgm2 * 0.1 * (1 if torque > 0 else -1)
    assert servo.speed_rad_s == pytest.approx(expected, rel=1e-9)


def test_a_closed_brake_holds_gravity_and_an_open_one_lets_it_fall() -> None:
    settings = ServoSettings(gravity_nm=5.0, viscous_nms_per_rad=0.0)
    servo = Servo(settings)
    servo.run_to(steps(0.5))
    assert servo.position_rad == 0.0
    servo.open_brake()
    servo.run_to(steps(0.6))
    fall = (5.0 - settings.coulomb_nm) / settings.inertia_kgm2
    assert servo.speed_rad_s == pytest.approx(-fall * 0.1, rel=1e-6)
    assert servo.position_rad == pytest.approx(-fall * 0.1**2 / 2.0, rel=1e-6)


def test_a_rotary_arms_gravity_follows_the_sine_of_its_angle() -> None:
    servo = Servo(
        ServoSettings(
            gravity_arm_nm=4.0, gravity_arm_gear=50.0, start_rad=25.0 * pi, coulomb_nm=0.0, stiction_nm=0.0, viscous_nms_per_rad=0.0
        )
    )
    servo.open_brake()
    servo.run_to(steps(0.010))
    assert servo.speed_rad_s == pytest.approx(-4.0 * sin(pi / 2) / 0.002 * 0.010, rel=1e-3)


def test_halving_the_step_changes_positions_by_less_than_one_increment_in_10_s() -> None:
    rough = ServoSettings(gravity_nm=2.0, gravity_arm_nm=0.5, gravity_arm_gear=20.0, torque_noise_nm=0.05, kv_per_s=80.0)
    whole, half = (DriveBus(rough, substeps=substeps) for substeps in (1, 2))
    for bus in (whole, half):
        bus.enable()
        bus.move(lambda t: 60_000.0 * (1.0 - cos(1.9 * t)) + 9_000.0 * sin(7.3 * t) * min(t, 1.0))
        bus.run(10.0)
    places = [[row.axes[0].position_rad for row in bus.rows()] for bus in (whole, half)]
    worst = max(abs(a - b) for a, b in zip(*places, strict=True)) * INC_PER_RAD
    assert len(places[0]) > 2500 and max(places[0]) > 40.0
    assert worst < 1.0
    assert worst > 0.0, "both ran with the same step"


def test_the_counter_knows_the_position_within_one_turn_only_at_power_up() -> None:
    for start, offset, expected in ((0.0, 0, 0), (pi, 0, 8192), (-pi / 2, 0, 12288), (13 * pi, 100, 8292), (3 * pi, 16000, 7808)):
        counter = Servo(ServoSettings(start_rad=start, resolver_offset_inc=offset)).latch(0)[1]
        assert counter == pytest.approx(expected, abs=1) and 0 <= counter < INC_PER_TURN


def test_the_counter_is_quantised_and_latched_between_two_steps() -> None:
    servo = driven(WIDE, 2e6, 0.040)
    position, counter = servo.latch(0)
    assert counter == (position * INC_PER_RAD) // 1
    later, _ = servo.latch(31_250)
    assert later - position == pytest.approx(servo.speed_rad_s * 31.25e-6)
    assert servo.speed_rad_s > 50.0


def test_speed_and_torque_stay_within_their_limits() -> None:
    settings = replace(ServoSettings(), following_error_rad=1e4)
    servo = Servo(settings)
    servo.open_brake()
    servo.hold()
    servo.follow(5e6, 0, P5, 0.0)
    peak = torque = 0.0
    while servo.step < steps(1.0):
        servo.run_to(servo.step + 4)
        peak, torque = max(peak, servo.speed_rad_s), max(torque, abs(servo.torque_nm))
    assert peak < settings.speed_limit_rad_s * 1.06, "anti-windup: the speed loop does not shoot over far"
    assert servo.speed_rad_s == pytest.approx(settings.speed_limit_rad_s, rel=1e-3)
    assert torque <= settings.torque_limit_nm


@pytest.mark.parametrize("pieces", [1, 3, 5, 16, 17, 64])
def test_how_the_steps_are_cut_changes_nothing_bit_for_bit(pieces: int) -> None:
    settings = ServoSettings(gravity_nm=1.0, torque_noise_nm=0.1)

    def play(cut: int) -> list[float]:
        servo = Servo(settings)
        servo.open_brake()
        servo.hold()
        servo.follow(5000.0, 20_000, P5, 0.0)
        while servo.step < 3200:
            servo.run_to(min(servo.step + cut, 3200))
        servo.off()
        while servo.step < 9600:
            servo.run_to(min(servo.step + cut, 9600))
        return servo._state

    assert play(pieces) == play(9600)


def test_working_ahead_changes_nothing_and_is_forgotten_when_the_axis_is_touched() -> None:
    plain, ahead = Servo(ServoSettings()), Servo(ServoSettings())
    for servo in (plain, ahead):
        servo.open_brake()
        servo.hold()
    ahead.prepare(60)
    ahead.follow(3000.0, 0, P5, 0.0)
    plain.follow(3000.0, 0, P5, 0.0)
    for servo in (plain, ahead):
        servo.run_to(64)
    ahead.prepare(124)
    ahead.run_to(100)  # SYNC came early
    plain.run_to(100)
    assert plain._state == ahead._state and ahead.step == 100
    ahead.prepare(160)
    ahead.run_to(164)
    plain.run_to(164)
    assert plain._state == ahead._state and plain.position_rad > 0.0
