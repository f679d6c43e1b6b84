"""The cycle's core with the emulated drives in virtual time: what the axes do for which command, and what they never do by themselves."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from drivers.drives.family import Actual, Demand, SetRecord
from drivers.drives.servodyn import Drive
from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.cell import FollowingError
from gateway.pure.cycle.core_watch import SERVICES_LIMIT
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import AxisFlag, Motion, Permit, Quality
from hil_tests.lab.virtual.cell_bench import ALL, DEMO, CellBench
from protocols.servodyn.codec import ActualValue

FAR = (1200.0, 800.0, 500.0, 120.0, -80.0, 250.0)
MIDDLE = (400.0, 300.0, 200.0, 30.0, -20.0, 90.0)


def test_on_reference_and_a_move_end_at_the_target() -> None:
    cell = CellBench().ready()
    assert all(axis.flags & AxisFlag.REFERENCED for axis in cell.core.state.axes[:6])
    job = cell.settle(cell.give(Code.PTP_ABSOLUTE, targets=MIDDLE))
    assert job.state is CommandState.DONE
    cell.run(0.4)
    assert cell.actual()[:6] == pytest.approx(MIDDLE, abs=0.003)


def test_all_axes_of_a_move_end_in_the_same_cycle() -> None:
    cell = CellBench().ready()
    last_change = [0] * 6
    before = cell.set()[:6]

    def note() -> None:
        for n, (old, new) in enumerate(zip(before, cell.set()[:6], strict=True)):
            if old != new:
                last_change[n] = cell.core.state.cycle
        before[:] = cell.set()[:6]

    cell.each = note
    cell.settle(cell.give(Code.PTP_ABSOLUTE, targets=MIDDLE))
    assert len(set(last_change)) == 1


def test_stop_leaves_a_rest_and_resume_ends_the_move_on_the_same_line() -> None:
    cell = CellBench().ready()
    start = cell.set()[:6]
    off_line = 0.0

    def watch() -> None:
        nonlocal off_line
        now = cell.set()
        progress = (now[0] - start[0]) / (FAR[0] - start[0])
        off_line = max(off_line, *(abs(now[n] - start[n] - progress * (FAR[n] - start[n])) for n in range(6)))

    cell.each = watch
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.7)
    assert cell.settle(cell.give(Code.STOP)).state is CommandState.DONE
    assert cell.core.state.motion is Motion.STOPPED
    rest = cell.set()
    cell.run(0.5)
    assert cell.set() == rest
    assert move.open
    resume = cell.settle(cell.give(Code.RESUME))
    assert (resume.state, move.state) == (CommandState.DONE, CommandState.DONE)
    assert off_line < 1e-6


def test_abandoned_rest_cannot_be_resumed() -> None:
    cell = CellBench().ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    cell.settle(cell.give(Code.STOP))
    cell.settle(cell.give(Code.ABANDON))
    assert (move.state, move.reason) == (CommandState.ABORTED, Reason.ABANDONED)
    assert cell.give(Code.RESUME).reason is Reason.NOTHING_TO_RESUME


def test_an_opened_emergency_chain_latches_and_drops_the_drives() -> None:
    cell = CellBench().ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    cell.permit(24, value=False)
    cell.run(0.1)
    assert cell.core.state.emergency
    assert (move.state, move.reason) == (CommandState.ABORTED, Reason.EMERGENCY_STOP)
    cell.permit(24)
    cell.run(0.5)
    assert cell.core.state.emergency, "a chain that closes again does not reset the latch"
    assert cell.give(Code.ENABLE).reason is Reason.EMERGENCY_STOP
    assert cell.settle(cell.give(Code.FAULT_RESET)).state is CommandState.DONE
    assert cell.settle(cell.give(Code.ENABLE)).state is CommandState.DONE
    cell.run(1.0)
    assert cell.core.state.motion is Motion.IDLE, "nothing goes on by itself"


def test_feed_hold_holds_on_the_path_and_lets_go_on() -> None:
    cell = CellBench().ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    cell.permit(27, value=False)
    cell.run(1.0)
    held = cell.set()
    cell.run(0.5)
    assert cell.set() == held
    cell.permit(27)
    assert cell.settle(move).state is CommandState.DONE


def test_a_lost_enabling_input_stops_and_its_return_starts_nothing() -> None:
    cell = CellBench().ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    cell.core._permissions.inputs.assume(
        Permit.CHAIN | Permit.CONTROL | Permit.TRAVEL
    )  # wired elsewhere: feed allow and feed hold are lost
    cell.inputs.quality[3] = Quality.BAD
    cell.run(1.0)
    assert cell.core.state.motion is Motion.STOPPED
    cell.inputs.quality[3] = Quality.GOOD
    rest = cell.set()
    cell.run(1.0)
    assert cell.set() == rest
    assert move.open


def test_a_lost_chain_stops_on_the_path_and_then_drops_the_drives_without_a_latch() -> None:
    cell = CellBench().ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    cell.inputs.quality[3] = Quality.BAD
    cell.cycle(5)
    assert cell.core.state.motion is Motion.STOPPING
    assert all(axis.flags & AxisFlag.ENABLED for axis in cell.core.state.axes[:6]), "first to rest, then off"
    cell.run(1.0)
    assert not any(axis.flags & AxisFlag.ENABLED for axis in cell.core.state.axes[:6])
    assert (move.state, move.reason, cell.core.state.emergency) == (CommandState.ABORTED, Reason.INPUT_LOST, False)
    cell.inputs.quality[3] = Quality.GOOD
    cell.run(0.5)
    assert not any(axis.flags & AxisFlag.ENABLED for axis in cell.core.state.axes[:6]), "nothing comes back by itself"
    assert cell.settle(cell.give(Code.ENABLE)).state is CommandState.DONE


def test_a_refused_set_value_takes_the_drives_off() -> None:
    cell = CellBench().ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.3)
    drive = cell.core._axes[0].drive
    assert isinstance(drive, Drive)
    drive._held.step = 1
    cell.run(0.1)
    assert (move.state, move.reason) == (CommandState.ABORTED, Reason.SET_VALUE)


def test_dead_services_stop_the_axes_on_the_path() -> None:
    cell = CellBench().ready()
    cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    cell.services_alive = False
    cell.run(SERVICES_LIMIT / 1e9 + 0.6)
    assert cell.core.state.motion is Motion.STOPPED
    assert cell.core.state.stop_cause == Reason.SERVICES_LOST


def test_dead_services_let_the_move_end_where_the_cell_says_so() -> None:
    cell = CellBench(finish_without_services=True).ready()
    cell.give(Code.PTP_ABSOLUTE, targets=MIDDLE)
    cell.run(0.5)
    cell.services_alive = False
    cell.run(3.0)
    assert cell.set()[:6] == pytest.approx(MIDDLE, abs=1e-6)


def test_a_new_cycle_starts_off_unreferenced_with_override_0_and_moves_nothing() -> None:
    cell = CellBench().ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    cell.now += 300_000_000  # nobody sends SYNC meanwhile
    cell.slave.wake(cell.now)
    cell.restart_cycle()
    cell.cycle(2)
    assert (move.state, move.reason) == (CommandState.ABORTED, Reason.CYCLE_RESTARTED)
    cell.run(0.5)
    standing = cell.actual()
    cell.run(1.0)
    assert cell.actual() == pytest.approx(standing, abs=1e-3)
    state = cell.core.state
    assert state.override == 0.0
    assert not any(axis.flags & (AxisFlag.ENABLED | AxisFlag.REFERENCED) for axis in state.axes[:6])


def test_a_silent_drive_takes_all_off_and_only_a_fresh_command_brings_them_back() -> None:
    cell = CellBench().ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    cell.silent = {3}
    cell.run(0.2)
    assert (move.state, move.reason) == (CommandState.ABORTED, Reason.DRIVE_LOST)
    assert not cell.core.state.ready
    cell.silent = set()
    cell.run(1.0)
    assert not any(axis.flags & AxisFlag.ENABLED for axis in cell.core.state.axes[:6])
    assert not cell.core.state.axes[2].flags & AxisFlag.REFERENCED, "a lost drive may have lost its counts"


def test_a_move_needs_referenced_axes_feed_and_travel() -> None:
    cell = CellBench()
    cell.run(0.3)
    for code in (Code.REQUEST_CONTROL, Code.OVERRIDE):
        cell.settle(cell.give(code))
    assert cell.give(Code.PTP_ABSOLUTE, targets=MIDDLE).reason is Reason.DRIVES_OFF
    cell.settle(cell.give(Code.ENABLE))
    assert cell.give(Code.PTP_ABSOLUTE, targets=MIDDLE).reason is Reason.NOT_REFERENCED
    cell.settle(cell.give(Code.REFERENCE))
    for bit, reason in ((26, Reason.FEED_NOT_ALLOWED), (28, Reason.TRAVEL_NOT_ALLOWED)):
        cell.permit(bit, value=False)
        cell.cycle(3)
        assert cell.give(Code.PTP_ABSOLUTE, targets=MIDDLE).reason is reason
        cell.permit(bit)
        cell.cycle(3)
    assert cell.give(Code.PTP_ABSOLUTE, ALL, targets=MIDDLE).state is CommandState.ACCEPTED


def test_a_missing_enabling_input_reads_0() -> None:
    cell = CellBench()
    cell.inputs.quality[3] = Quality.BAD
    cell.run(0.3)
    cell.settle(cell.give(Code.REQUEST_CONTROL))
    assert cell.give(Code.ENABLE).reason is Reason.EMERGENCY_STOP


def test_too_many_skipped_syncs_in_a_row_stop_on_the_path() -> None:
    cell = CellBench().ready()
    cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    cell.core.skipped(1)
    cell.cycle()
    assert cell.core.state.motion is Motion.RUNNING
    cell.core.skipped(3)
    cell.run(0.6)
    assert (cell.core.state.motion, cell.core.state.stop_cause) == (Motion.STOPPED, Reason.OVERRUN)


def test_following_error_beyond_the_limit_takes_the_drives_off() -> None:
    cell = CellBench().ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.4)
    cell.core._axes[1].tracking.lag._trip = 1e-4
    cell.run(0.1)
    assert (move.state, move.reason) == (CommandState.ABORTED, Reason.FOLLOWING_ERROR)
    assert move.detail == cell.dispatcher.strayed() == "A2 647 tracking distance too long"
    assert cell.dispatcher.strayed("de") == "A2 647 Schleppabstand zu gross"


def test_an_answer_that_comes_a_cycle_late_is_no_following_error() -> None:
    """AX-560: at full speed it seems to lag by the travel of a cycle more."""
    cell = CellBench(p5_ms=20).ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    axis = cell.core._axes[0]
    axis.tracking.lag._trip = abs(axis.behind) * 1.2
    travel = axis.speed * 0.02
    assert travel > abs(axis.behind) * 0.5, "so it would count"
    cell.late = {1}
    cell.cycle()
    cell.late = set()
    cell.cycle(3)
    assert (move.state, cell.core.state.stop_cause) == (CommandState.RUNNING, 0)
    axis.tracking.lag._trip = abs(axis.behind) * 0.8
    cell.cycle()
    assert cell.core.state.stop_cause == Reason.FOLLOWING_ERROR, "and it is judged again"


def test_an_axis_pushed_out_of_its_standstill_takes_the_drives_off_with_648() -> None:
    axes = [replace(axis, following_error=FollowingError(16.0, 20.0, standstill=0.5)) for axis in DEMO.axis]
    cell = CellBench(cell=replace(DEMO, axis=tuple(axes))).ready()
    cell.settle(cell.give(Code.PTP_ABSOLUTE, targets=MIDDLE))
    cell.run(1.0)
    assert cell.core.state.stop_cause == 0 and cell.dispatcher.strayed() == ""
    assert isinstance(cell.slave, ServodynSlave)
    cell.slave.load_torque(3, 25.0)  # more than the motor has
    cell.run(0.3)
    assert [axis.finding for axis in cell.core.state.axes[:4]] == [0, 0, 648, 0]
    assert cell.core.state.stop_cause == Reason.FOLLOWING_ERROR and not cell.core.state.axes[0].flags & AxisFlag.ENABLED
    assert cell.dispatcher.strayed() == "A3 648 axis left its standstill position"
    cell.settle(cell.give(Code.FAULT_RESET))
    assert cell.dispatcher.strayed() == "" and cell.core.state.stop_cause == 0


def test_a_drive_that_leaves_control_by_itself_takes_all_off_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    cell = CellBench().ready()
    move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.2)
    drive = cell.core._axes[1].drive
    assert isinstance(drive, Drive)
    step = Drive.step

    def dropped(self: Drive, actual: Actual | None, demand: Demand) -> SetRecord:
        assert isinstance(actual, ActualValue)
        return step(self, actual._replace(enabled=False) if self is drive else actual, demand)

    monkeypatch.setattr(Drive, "step", dropped)
    cell.cycle()
    monkeypatch.undo()
    assert (move.reason, cell.core.state.stop_cause) == (Reason.DRIVE_FAULT, Reason.DRIVE_FAULT)
    cell.run(1.0)
    assert not any(axis.flags & AxisFlag.ENABLED for axis in cell.core.state.axes[:6])


def lose(cell: CellBench) -> None:
    """The command source of the enabling inputs is gone."""
    cell.inputs.quality[3] = Quality.BAD


@pytest.mark.parametrize(
    "take, reason",
    [(lambda cell: cell.permit(25, value=False), Reason.CONTROL_NOT_ALLOWED), (lose, Reason.INPUT_LOST)],
    ids=["taken", "lost"],
)
def test_drives_that_go_off_at_rest_say_why(take: Callable[[CellBench], None], reason: Reason) -> None:
    cell = CellBench().ready()
    take(cell)
    cell.run(1.0)
    assert not any(axis.flags & AxisFlag.ENABLED for axis in cell.core.state.axes[:6])
    assert cell.core.state.stop_cause == reason
    cell.permit(25)
    cell.run(0.1)
    assert cell.settle(cell.give(Code.ENABLE)).state is CommandState.DONE and cell.core.state.stop_cause == 0
