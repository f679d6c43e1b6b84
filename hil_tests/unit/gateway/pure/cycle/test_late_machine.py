"""AX-681: what stopped the drives of a simulation."""

from gateway.pure.image.records.cell import AxisFlag, AxisState, CellState
from gateway.pure.reports.late_machine import LateMachine
from protocols.base.machine import ms


def state(*flags: int, skipped: int = 0, late: int = 0) -> CellState:
    return CellState(axes=[AxisState(flags=AxisFlag(flag)) for flag in flags], skipped=skipped, late=late)


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


def test_a_drive_that_stops_on_a_machine_in_time_is_looked_after_itself() -> None:
    assert not blamed((0, state(WELL)), (200, state(LOST)))
    assert not blamed((0, state(WELL, skipped=3)), (3_001, state(LOST, skipped=3)))
    assert not blamed((0, state(LOST)), (100, state(LOST, skipped=3))), "it stopped before"
    assert not blamed((0, state(WELL, skipped=3)), (10, state(LOST, skipped=3)), (20, state(WELL, skipped=3)))


def test_on_a_real_bus_nobody_else_is_blamed() -> None:
    assert not blamed((0, state(WELL)), (100, state(LOST, skipped=9)), simulated=False)
