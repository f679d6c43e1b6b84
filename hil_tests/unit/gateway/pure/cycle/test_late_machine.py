"""AX-681: what stopped the drives of a simulation."""

import pytest

from gateway.pure.image.records.cell import AxisFlag, AxisState, CellState
from gateway.pure.reports.late_machine import LateMachine
from protocols.base.machine import ms

SYNC_LOST = 1


def state(*flags: int, skipped: int = 0, late: int = 0, code: int = SYNC_LOST) -> CellState:
    axes = [AxisState(flags=AxisFlag(flag), fault_code=code if flag & AxisFlag.FAULT else 0) for flag in flags]
    return CellState(axes=axes, skipped=skipped, late=late)


WELL, LOST, FAULT = 0, int(AxisFlag.LOST), int(AxisFlag.FAULT)


def blamed(*steps: tuple[int, CellState], simulated: bool = True) -> bool:
    machine = LateMachine(simulated=simulated)
    for now_ms, each in steps:
        machine.observe(each, ms(now_ms))
    return machine.blamed


def test_drives_that_stop_right_after_the_machine_was_late_are_its_doing() -> None:
    assert blamed((0, state(WELL)), (100, state(WELL, skipped=3)), (200, state(LOST, skipped=3)))
    assert blamed((0, state(WELL)), (200, state(FAULT, late=1)))
    assert blamed((0, state(WELL, late=1)), (2_999, state(LOST, late=1)), (60_000, state(LOST, late=1))), "as long as they are stopped"


def test_answers_that_come_right_behind_the_stop_explain_it_as_well() -> None:
    """Drives that are kept back are lost first; what they had said comes when they run again."""
    steps = (0, state(WELL)), (8, state(LOST)), (12, state(LOST))
    assert blamed(*steps, (40, state(LOST, late=12)), (5_000, state(LOST, late=12)))
    assert not blamed(*steps), "a drive that never answers is lost"
    assert not blamed(*steps, (300, state(LOST, late=12))), "long after it is another story"
    assert not blamed(*steps, (40, state(LOST, late=12)), simulated=False)
    assert not blamed(*steps, (40, state(FAULT, late=12, code=0x3210))), "it names its fault itself"


def test_a_drive_that_stops_on_a_machine_in_time_is_looked_after_itself() -> None:
    assert not blamed((0, state(WELL)), (200, state(LOST)))
    assert not blamed((0, state(WELL, skipped=3)), (3_001, state(LOST, skipped=3)))
    assert not blamed((0, state(LOST)), (100, state(LOST, skipped=3))), "it stopped before"
    assert not blamed((0, state(WELL, skipped=3)), (10, state(LOST, skipped=3)), (20, state(WELL, skipped=3)))


def test_on_a_real_bus_nobody_else_is_blamed() -> None:
    assert not blamed((0, state(WELL)), (100, state(LOST, skipped=9)), simulated=False)


@pytest.mark.parametrize("code", [SYNC_LOST, 2, 0x8130, 0x8700])
def test_supervision_of_sync_and_life_is_what_lateness_trips(code: int) -> None:
    assert blamed((0, state(WELL, late=1)), (10, state(FAULT, late=1, code=code)))


@pytest.mark.parametrize("code", [0, 3, 4, 99, 0x8611, 0x3210, 0x8110])
def test_a_fault_that_lateness_cannot_cause_stays_the_drives_own(code: int) -> None:
    assert not blamed((0, state(WELL, late=1)), (10, state(FAULT, late=1, code=code)))
    assert not blamed((0, state(WELL, late=1)), (10, state(LOST, late=1)), (20, state(FAULT | LOST, late=1, code=code))), "named later"


def test_each_axis_is_judged_by_itself() -> None:
    machine = LateMachine(simulated=True)
    machine.observe(state(WELL, WELL, WELL, late=1), 0)
    machine.observe(state(LOST, WELL, WELL, late=1), ms(10))
    assert machine.axes == {0}
    machine.observe(state(LOST, FAULT, WELL, late=1), ms(4_000))
    assert machine.axes == {0}, "A2 stopped when the machine was in time for long"
    machine.observe(state(WELL, FAULT, FAULT, late=2), ms(4_010))
    assert machine.axes == {2}
