"""rho 3 Releases part 1 (TO05), section 9 (L5185-5460): reference path recording, SF 29, 30, 31."""

import pytest

from motion.errors import MotionError
from motion.measure.errors import ProgramFault
from motion.measure.record import BY_CYCLES, ReferencePaths

SYSTEMS = 8


def driven(paths: ReferencePaths, cycles: int, per_cycle: float = 0.5, kinematic: int = 2, begin: float = 0.0) -> None:
    """Measuring system 8 (a belt) runs; A21 .. A23 and the belt are recorded with it, so an entry tells where it was taken."""
    for k in range(cycles):
        belt = begin + k * per_cycle
        joints = (belt * 2, 10.0, 20.0, belt)
        paths.step(kinematic, (0.0,) * 7 + (belt,), joints, (belt * 3, 1.0, 2.0, belt))


def code(paths: ReferencePaths, kinematic: int, index: int) -> int:
    try:
        paths.read(kinematic, index)
    except ProgramFault as fault:
        return fault.code
    return 0


@pytest.mark.requirement("RHO-MOT-38", by="motion.measure.record:ReferencePaths.on")
@pytest.mark.requirement("RHO-MOT-38", by="motion.measure.record:ReferencePaths.step")
@pytest.mark.requirement("RHO-MOT-38", by="motion.measure.record:ReferencePaths.off")
def test_sf_29_takes_a_point_each_13_mm_and_sf_30_reports_how_many() -> None:
    paths = ReferencePaths(SYSTEMS)
    paths.on(2, 8, 13.0)
    driven(paths, 201)  # 100 mm
    assert paths.off(2) == 7
    entries = [paths.read(2, n) for n in range(1, 8)]
    assert [entry.joints[3] for entry in entries] == [91.0, 78.0, 65.0, 52.0, 39.0, 26.0, 13.0], "the latest is 1; belts are recorded"
    assert entries[1].joints == (156.0, 10.0, 20.0, 78.0) and entries[1].world == (234.0, 1.0, 2.0, 78.0)
    driven(paths, 50, begin=100.0)
    assert paths.off(2) == 7, "switched off, the data stay"


@pytest.mark.requirement("RHO-MOT-38", by="motion.measure.record:ReferencePaths.off")
def test_the_ring_holds_50_points() -> None:
    paths = ReferencePaths(SYSTEMS)
    paths.on(2, 8, 1.0)
    driven(paths, 141)
    assert paths.off(2) == 50
    assert paths.read(2, 1).joints[3] == 70.0 and paths.read(2, 50).joints[3] == 21.0
    assert code(paths, 2, 51) == 90


@pytest.mark.requirement("RHO-MOT-38", by="motion.measure.record:ReferencePaths.read")
def test_sf_31_of_an_entry_that_is_not_stored_is_error_90() -> None:
    paths = ReferencePaths(SYSTEMS)
    assert code(paths, 2, 1) == 90, "never recorded"
    paths.on(2, 8, 13.0)
    driven(paths, 60)
    assert paths.off(2) == 2
    assert [code(paths, 2, n) for n in (0, 1, 2, 3, -1)] == [90, 0, 0, 90, 90]
    assert code(paths, 1, 1) == 90, "another kinematic"
    paths.on(2, 8, 13.0)
    assert code(paths, 2, 1) == 90, "SF 29 begins anew"


@pytest.mark.requirement("RHO-MOT-38", by="motion.measure.record:ReferencePaths.on")
def test_a_bad_measuring_system_is_error_91_also_where_cycles_count() -> None:
    for option in (0, BY_CYCLES):
        for system in (0, 9, -1):
            with pytest.raises(ProgramFault, match=r"Inadmiss\. meas\. sys\.") as caught:
                ReferencePaths(SYSTEMS, option).on(2, system, 10.0)
            assert caught.value.code == 91


def test_option_1_takes_a_point_each_10_cycles() -> None:
    paths = ReferencePaths(SYSTEMS, BY_CYCLES)
    paths.on(1, 4, 10.0)
    driven(paths, 36, kinematic=1)
    assert paths.off(1) == 3
    assert [paths.read(1, n).joints[3] for n in (1, 2, 3)] == [15.0, 10.0, 5.0]


def test_both_directions_count_and_the_grid_stays_where_cycles_overshoot_it() -> None:
    paths = ReferencePaths(SYSTEMS)
    paths.on(2, 8, 1.0)
    driven(paths, 11, 0.7)  # to 7 mm: marks near 1, 2, 3 ..
    assert paths.off(2) == 7
    paths.on(2, 8, 1.0)
    driven(paths, 11, -0.7)
    assert paths.off(2) == 7 and paths.read(2, 1).joints[3] == pytest.approx(-7.0)


@pytest.mark.parametrize("distance", [0.0, -1.0, float("nan"), float("inf")])
def test_distances_that_are_none_are_refused(distance: float) -> None:
    with pytest.raises(MotionError, match="DISTANCE"):
        ReferencePaths(SYSTEMS).on(1, 1, distance)


def test_less_than_a_cycle_is_refused_and_nothing_is_recorded_unasked() -> None:
    paths = ReferencePaths(SYSTEMS, BY_CYCLES)
    with pytest.raises(MotionError, match="1 is the least"):
        paths.on(1, 1, 0.3)
    driven(paths, 5)
    assert paths.off(2) == 0
