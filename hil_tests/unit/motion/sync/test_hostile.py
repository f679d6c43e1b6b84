"""Belts and alter under whatever comes: random belts, programs and alterations, and what must hold all the same."""

import math
import random

from hypothesis import given, settings
from hypothesis import strategies as st

from hil_tests.lab.cells.arms import at
from hil_tests.unit.motion.sync.alter_lab import Altered, P
from hil_tests.unit.motion.sync.belt_lab import CYCLE, MM, Conveyor
from motion.program.blocks import Frame, Interpolation, Tool
from motion.sync.alter import Mode
from motion.sync.cam import LEAST, cam
from motion.sync.errors import BeltError
from motion.sync.pace import Pace
from motion.sync.synchronous_part import BeltBlock, Phase, SynchronPart
from motion.val3.errors import RuntimeFault
from motion.val3.mdesc import BlendKind, Mdesc
from motion.val3.trsf import Trsf

positive = st.floats(1e-6, 1e3)


@given(positive, st.floats(0.0, 1e6), st.floats(0.0, 1e6))
def test_every_cam_rises_smoothly_from_0_to_1_with_sections_of_1_percent(length: float, first: float, third: float) -> None:
    curve = cam(length, first, third)
    rest = length - curve.first - curve.third
    for part in (curve.first, curve.third, rest):
        assert part >= LEAST * length * (1 - 1e-9)
    steepest = 1.0 / (length - 0.5 * (curve.first + curve.third))
    before = 0.0
    for k in range(101):
        share, slope = curve.at(length * k / 100)
        assert before - 1e-12 <= share <= 1.0 + 1e-12 and 0.0 <= slope <= steepest * (1 + 1e-9)
        before = share
    assert before == 1.0


@given(st.floats(0.0, 1.0), st.floats(1e-4, 5.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.1, 10.0))
def test_the_speed_of_type_2_never_leaves_its_acceleration_nor_turns_back(
    way: float, time: float, now: float, end: float, accel: float
) -> None:
    speed = Pace(2.0, accel, accel).next_speed(way, time, now, end, CYCLE)
    assert 0.0 <= speed <= 2.0
    assert abs(speed - now) <= accel * CYCLE + 1e-12 or speed == 0.0


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from((2, 3, 12, 13)))
def test_a_part_ends_in_a_point_or_in_an_error_of_the_manual_and_never_jumps(seed: int, kind: int) -> None:
    dice = random.Random(seed)
    conveyor = Conveyor()
    conveyor.belts.belt_type(1, kind)
    conveyor.belts.belt_parameters(1, dice.uniform(0, 30), dice.uniform(0, 60), dice.choice((0, 100, 1000)))
    part = SynchronPart(conveyor.belts.belt(1), 1, (0.0, 0.0), dice.uniform(0, 50) * MM)
    belt, pace = 50.0, Pace(accel=5.0, decel=5.0)
    error, before = 0, part.position
    most = 0.03 if kind % 10 == 2 else 0.15  # a cam may be late by its tolerance: 10 mm of a block of 20 mm at least
    for _ in range(60):
        try:
            if dice.random() < 0.3 and belt < 800:
                belt += dice.uniform(20, 200)
                target = (dice.uniform(-0.1, 0.1), dice.uniform(-0.1, 0.1))
                kind_of = dice.choice((Interpolation.LINEAR,) * 12 + (Interpolation.PTP,))
                part.add(BeltBlock(target, belt * MM, kind_of, pace=pace, first=0.02, third=0.02))
            for _ in range(dice.randint(1, 30)):
                conveyor.run(dice.choice((200.0, 200.0, 180.0, 0.0, -1.0)) if dice.random() < 0.1 else 200.0)
                now = part.step()
                assert all(map(math.isfinite, now)) and math.dist(before, now) <= most
                before = now
        except BeltError as fault:
            error = fault.code
            break
    assert error in (0, 23, 89, 928, 944)
    if error:
        assert part.phase is Phase.FAILED
        conveyor.run(200.0, periods=5)
        assert part.step() == before


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10_000))
def test_alter_answers_with_its_numbers_and_the_arm_never_steps_faster_than_alter_begin_allows(seed: int) -> None:
    dice, rig = random.Random(seed), Altered()
    off, world = Mdesc(blend=BlendKind.OFF, tvel=300.0), Frame("world")
    answers, codes, at_most = set(), set(), Mdesc(tvel=800.0)
    value = 0.0
    for _ in range(60):
        match dice.randint(0, 9):
            case 0 | 1:
                answers.add(rig.moves.alter_begin(world, at_most))
            case 2:
                answers.add(rig.alter.end())
            case 3:
                try:
                    move = rig.moves.alter_movel if dice.random() < 0.6 else rig.stack.movel
                    move(at(dice.uniform(-200, 200), dice.uniform(-200, 200)), Tool(), off)
                except RuntimeFault as fault:
                    codes.add(fault.code)
            case 4:
                rig.stack.stop_move()
            case 5:
                rig.stack.restart_move()
            case 6 if rig.alter.mode is Mode.ERROR or dice.random() < 0.1:
                rig.stack.reset_motion()
            case _:
                value += dice.choice((0.2, -0.2, 0.5, 40.0 if dice.random() < 0.1 else 0.0))
                answers.add(rig.alter.alter(Trsf(z=value)))
        rig.run(dice.randint(1, 30))
    assert answers <= {1, 0, -1, -3} and codes <= {150, 154, 530, 531}
    assert float(rig.steps().max()) <= 2.0 * P + 1e-9, "an axis of the portal does 2 m/s at most"
