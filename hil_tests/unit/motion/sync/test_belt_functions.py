"""rho 3 Releases part 1: TO01 section 5 (SF 28, simulation), TO04 sections 14 and 15.2 (SF 21, SF 15)."""

import functools

import pytest

from hil_tests.unit.motion.sync.belt_lab import CYCLE, MM, Conveyor, code
from motion.errors import MotionError
from motion.sync.belt_state import Motion, Watch
from motion.sync.belts import BeltData, Belts, Condition, Sync, Type


@pytest.mark.requirement("RHO-MOT-20", by="motion.sync.belts:Belts.set_belt_counter")
@pytest.mark.requirement("RHO-MOT-20", by="motion.sync.belts:Belts.inputs")
def test_sf_28_2_minus_2000_and_bit_377_set_counter_2_and_a_restart_sets_0() -> None:
    conveyor = Conveyor(2)
    conveyor.run(100.0, 50.0, periods=100)
    conveyor.belts.set_belt_counter(2, -2000)
    assert conveyor.counter(2) == pytest.approx(50.0), "the function alone moves nothing"
    conveyor.belts.inputs({377})
    assert conveyor.counter(2) == pytest.approx(-2000.0)
    assert conveyor.counter(1) == pytest.approx(100.0), "belt 1 has bit 376"
    conveyor.run(100.0, 50.0, periods=100)
    conveyor.belts.inputs({377})
    assert conveyor.counter(2) == pytest.approx(-1950.0), "a signal that stays 1 sets once"
    conveyor.belts.inputs(())
    conveyor.belts.inputs({377})
    assert conveyor.counter(2) == pytest.approx(-2000.0), "the value stays until the next call"
    conveyor.belts.inputs({376})
    assert conveyor.counter(1) == 0.0, "default 0"
    again = Conveyor(2)
    again.run(0.0, 30.0, periods=10)
    again.belts.inputs({377})
    assert again.counter(2) == 0.0, "after start-up the value is 0"


def test_sync_statements_load_the_reset_value_when_their_condition_holds() -> None:
    conveyor = Conveyor(3)
    for number, value in ((1, 7.0), (2, 8.0), (3, 9.0)):
        conveyor.belts.set_belt_counter(number, value)
    first, second, third = (conveyor.belts.belt(n) for n in (1, 2, 3))
    assert not Sync(first, Condition.INPUT).met(signal=False)
    assert Sync(first, Condition.INPUT).met(signal=True)
    assert conveyor.counter(1) == pytest.approx(7.0)
    second.set_counter(101 * MM)
    waits = Sync(second, Condition.AT_MOST, 100 * MM)
    assert not waits.met()
    conveyor.run(0.0, -200.0, 0.0, periods=1)
    assert waits.met() and conveyor.counter(2) == pytest.approx(8.0)
    at_least = Sync(third, Condition.AT_LEAST, 200 * MM)
    third.set_counter(199 * MM)
    assert not at_least.met()
    conveyor.run(0.0, 0.0, 200.0, periods=1)
    assert at_least.met() and conveyor.counter(3) == pytest.approx(9.0)


@pytest.mark.requirement("RHO-MOT-21", by="motion.sync.belts:Belts.inputs")
@pytest.mark.requirement("RHO-MOT-21", by="motion.sync.belts:Belts.update")
def test_bit_399_lets_every_belt_run_at_p508_while_it_is_set() -> None:
    conveyor = Conveyor(2)
    conveyor.run(0.0, 0.0, periods=10)
    assert conveyor.belts.belt(1).watch.motion is Motion.STOPPED
    conveyor.belts.inputs({399})
    conveyor.run(0.0, 0.0, periods=100)
    for number in (1, 2):
        assert conveyor.belts.belt(number).watch.speed == pytest.approx(0.25), "P508 = 250 mm/s"
        assert conveyor.counter(number) == pytest.approx(250.0)
    conveyor.belts.inputs(())
    conveyor.run(0.0, 0.0, periods=10)
    assert conveyor.belts.belt(1).watch.speed == 0.0
    assert conveyor.counter(1) == pytest.approx(250.0)


@pytest.mark.requirement("RHO-MOT-22", by="motion.sync.belts:Belt.check_type")
@pytest.mark.requirement("RHO-MOT-22", by="motion.sync.belts:Belts.belt")
def test_type_72_is_type_2_tolerance_7_and_what_is_not_allowed_gives_92_and_93() -> None:
    belts = Conveyor(2).belts
    belt = belts.belt(1)
    assert (belt.kind, belt.tolerance) == (Type.PARALLEL, 5), "after start-up"
    belts.belt_type(1, 72)
    assert (belt.kind, belt.tolerance) == (Type.ALONE, 7)
    assert belts.belt(2).kind is Type.PARALLEL
    belts.belt_type(1, 3)
    assert (belt.kind, belt.tolerance) == (Type.CAM, 5)
    good = [1, *(10 * n + 2 for n in range(13)), *(10 * n + 3 for n in range(13))]
    for value in range(-20, 300):
        assert code(functools.partial(belts.belt_type, 1, value)) == (0 if value in good else 92), value
    assert code(lambda: belts.belt_type(1, 131)) == 92
    assert code(lambda: belts.belt_type(3, 2)) == 93, "P501 = 2"
    assert code(lambda: belts.belt_type(0, 2)) == 93
    assert code(lambda: belts.belt_parameters(9, 1.0, 1.0, 0)) == 93
    assert code(lambda: belts.set_belt_counter(3, 0.0)) == 93


def test_thresholds_after_start_up_are_5_um_a_cycle_and_the_time_is_rounded_to_cycles() -> None:
    conveyor = Conveyor()
    watch = conveyor.belts.belt(1).watch
    assert watch.stop * CYCLE == pytest.approx(5e-6) and watch.run * CYCLE == pytest.approx(5e-6)
    assert watch.patience == 0
    conveyor.belts.belt_parameters(1, 10.0, 50.0, 26)
    assert (watch.stop, watch.run) == pytest.approx((0.01, 0.05)) and watch.patience == 3
    with pytest.raises(MotionError):
        conveyor.belts.belt_parameters(1, float("nan"), 50.0, 0)


def test_speed_is_averaged_over_ten_cycles_only_above_running() -> None:
    watch = Watch(0.01)
    watch.parametrise(0.01, 0.05, 0.03)
    for _ in range(20):
        watch.update(0.10)
    for k in range(1, 11):
        watch.update(0.20)
        assert watch.speed == pytest.approx(0.10 + 0.01 * k)
    assert after(watch, 0.04) is Motion.SLOW and watch.speed == pytest.approx(0.04), "averaging ends at once"
    assert [watch.judges_tolerance, *judged(watch, 0.04, 3)] == [False, False, False, True]
    assert after(watch, 0.005) is Motion.STOPPED and watch.speed == 0.0
    assert not watch.judges_tolerance and not watch.judges_direction
    assert judged(watch, 0.04, 4) == [False, False, False, True]


def after(watch: Watch, speed: float) -> Motion:
    watch.update(speed)
    return watch.motion


def judged(watch: Watch, speed: float, cycles: int) -> list[bool]:
    found = []
    for _ in range(cycles):
        watch.update(speed)
        found.append(watch.judges_tolerance)
    return found


def test_increments_wrap_and_cycles_are_made_of_periods() -> None:
    belts = Belts([BeltData(1e-4)], 1e-3, 4e-3)
    belts.update([(1 << 32) - 10])
    for k in range(1, 9):
        belts.update([(5 * k - 10) % (1 << 32)])
    assert belts.belt(1).way == pytest.approx(40e-4)
    assert belts.belt(1).watch.raw == pytest.approx(0.5)
    with pytest.raises(MotionError):
        Belts([BeltData(1e-4)], 3e-3, 4e-3)
    with pytest.raises(MotionError):
        Belts([BeltData(1e-4)] * 9, 1e-3, 4e-3)
    with pytest.raises(MotionError):
        belts.update([1, 2])
    with pytest.raises(MotionError):
        BeltData(0.0)
