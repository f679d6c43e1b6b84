"""The steps of an emulated axis in C against their Python twin: the same state, steps and trip, bit for bit (AX-1020)."""

import random
import struct
from math import inf
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.emulator.servo import model
from drivers.emulator.servo.model import Servo, Steps, constants
from drivers.emulator.servo.settings import ServoSettings
from gateway.cycle.native.built import load
from gateway.cycle.native.servo import use_servo

pytestmark = pytest.mark.cref
AXES = (
    ServoSettings(),
    ServoSettings(gravity_nm=1.5, brake=True, torque_noise_nm=0.2, viscous_nms_per_rad=0.0),
    ServoSettings(gravity_arm_nm=2.0, gravity_arm_gear=3.0, gravity_arm_phase_rad=0.4, torque_noise_nm=0.05),
)
ANY = st.one_of(st.floats(allow_nan=False), st.floats(-1e3, 1e3), st.sampled_from([0.0, -0.0, 1.0, inf, -inf]))


@pytest.fixture(scope="module")
def quick() -> Steps:
    steps: Steps = load("servo").run
    return steps


def bits(state: list[float], told: tuple[int, int]) -> tuple[bytes, tuple[int, int]]:
    return struct.pack(f"{len(state)}d", *state), told


def teased(servo: Servo, draw: random.Random) -> None:
    """What a drive, a test or a person does to an axis."""
    match draw.randrange(10):
        case 0:
            servo.hold()
        case 1:
            servo.follow(
                servo.counter_inc + draw.uniform(-900, 900) * draw.choice((1, 100)),
                draw.randrange(62_500),
                4_000_000,
                draw.uniform(-40, 40),
            )
        case 2:
            servo.ramp()
        case 3:
            servo.off()
        case 4:
            servo.open_brake()
        case 5:
            servo.close_brake()
        case 6:
            servo.block(draw.choice((-1, 0, 1)))
        case 7:
            servo.arm(on=draw.random() < 0.5)
        case 8:
            servo.watch(servo.position_rad - draw.random(), servo.position_rad + draw.random())
        case _:
            servo.jump(draw.randrange(-300, 300))


@pytest.mark.parametrize("axis", range(len(AXES)))
@pytest.mark.parametrize("substeps", [1, 3])
def test_an_axis_that_is_teased_is_the_same(quick: Steps, axis: int, substeps: int) -> None:
    draw, servo = random.Random(axis), Servo(AXES[axis], 7, substeps)
    fixed, trips = constants(AXES[axis], substeps), 0
    for _ in range(1500):
        teased(servo, draw)
        steps = draw.choice((1, 2, 3, 15, 16, 17, 64, 200))
        ours, theirs = servo._state[:], servo._state[:]
        told = model.run(ours, fixed, servo.step, steps, substeps)
        assert bits(ours, told) == bits(theirs, quick(theirs, fixed, servo.step, steps, substeps))
        trips += told[1] > 0
        servo._state, servo.step = theirs, servo.step + steps - told[0]
    assert trips > 4, "trips are met, too"


@settings(max_examples=300)
@given(st.lists(ANY, min_size=15, max_size=15), st.sampled_from([0.0, 1.0, 2.0]), st.integers(0, 40), st.integers(1, 40))
def test_states_no_axis_has_are_the_same(quick: Steps, own: list[float], mode: float, step: int, steps: int) -> None:
    servo = Servo(AXES[2])
    fixed, state = constants(AXES[2]), [*own, mode, *servo._state[16:]]
    other = state[:]
    try:
        told = model.run(state, fixed, step, steps, 1)
    except ValueError:
        return  # math.sin of an infinite angle
    assert [*map(repr, (*quick(other, fixed, step, steps, 1), *other))] == [*map(repr, (*told, *state))]


def test_wrong_arguments_are_refused_and_change_nothing(quick: Any) -> None:
    state, fixed = [0.0] * 27, constants(AXES[0])
    bad: list[tuple[Any, ...]] = [
        (state[:26], fixed, 0, 1, 1),
        (state, fixed[:5], 0, 1, 1),
        (state, fixed, "0", 1, 1),
        (tuple(state), fixed, 0, 1, 1),
    ]
    for wrong in (*bad, ([0.0] * 26 + [None], fixed, 0, 1, 1), (state, fixed, 0, 1)):
        with pytest.raises(TypeError):
            quick(*wrong)
    assert state == [0.0] * 27


def test_a_process_takes_the_part_where_it_is_built_and_wanted() -> None:
    before = Servo.steps
    try:
        assert use_servo(python=False) and Servo.steps is not model.run
        assert not use_servo(python=True) and Servo.steps is model.run
    finally:
        Servo.steps = staticmethod(before)
