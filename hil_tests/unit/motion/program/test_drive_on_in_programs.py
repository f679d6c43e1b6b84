"""Drive-on of single axes while a program runs: a portal with SERVODYN drives in virtual time, judged by the emulator's own record.

rho 3 Releases part 1, L1290-1345 and L1500-1524 (interruptible axes), L7918-7945 (disabled axes); AX-393.
"""

import numpy as np
import pytest

from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.assembly.axis_scaling import window_of
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.jobs import Job
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import AxisFlag, CellState, Motion
from gateway.pure.planning import chain as programchain
from hil_tests.lab.virtual.belt_bench import CELL
from hil_tests.lab.virtual.planned_bench import Driven, Planned, ServodynRobot

HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n"
X, Y, Z, ALL = 1, 2, 4, 15
PROBE = 464
THERE, NEAR = 2e-5, 5e-4  # m: two increments; Z sinks a little until its brake holds


class Judged(ServodynRobot):
    """What goes wrong inside a cycle is a failure of the test."""

    def cycle(self, count: int = 1) -> None:
        for _ in range(count):
            super().cycle()


class Portal(Planned):
    """X, Y, Z, C; somebody may move Z by hand while its drive is off."""

    def __init__(self) -> None:
        super().__init__(Judged(cell=CELL))
        self.bench.permit(PROBE, value=False)
        self.programs.cell.windows = [window_of(axis) for axis in CELL.axis]
        assert self.finished(self.run("ptp joints 100 100 50 0")).state is CommandState.DONE
        self.driven()

    def run(self, *lines: str) -> Job:
        return self.order(HEAD + "\n".join(lines))

    def give(self, code: Code, mask: int) -> Job:
        return self.bench.settle(self.bench.give(code, mask))

    def finished(self, job: Job) -> Job:
        self.bench.settle(job)
        self.until(lambda s: s.motion is Motion.IDLE)
        return job

    def pushed(self, mm: float) -> None:
        """Z is moved from outside, slowly, brake or no brake."""
        self.until(lambda s: not s.axes[2].flags & AxisFlag.ENABLED)
        slave, steps = self.bench.slave, 50
        assert isinstance(slave, ServodynSlave)
        servo = slave._seats[2].axis.servo
        axis = self.bench.core._axes[2]
        for _ in range(steps):
            servo.jump(round(mm * 1e-3 * axis.scaling.inc_per_unit / steps))
            self.bench.cycle()
        self.bench.cycle(3)

    def z(self) -> tuple[float, float]:
        """Set and actual; m."""
        return self.state.axes[2].set, self.state.axes[2].actual


@pytest.fixture
def portal() -> Portal:
    return Portal()


def far(state: CellState) -> bool:
    return state.axes[0].set > 0.15


def quiet(portal: Portal) -> Driven:
    """Nothing of X and Y was harder than the path allows; Z counts only by its place."""
    driven = portal.driven()
    accel = np.diff(driven.sets[:, :2], 2, axis=0) / driven.period**2
    limits = [axis.accel for axis in portal.machine.limits[:2]]
    rounded = 4.0 * 1e-6 / driven.period**2  # of increments
    assert np.all(np.max(np.abs(accel), axis=0) < 1.05 * np.array(limits) + rounded)
    return driven


AWAY = "linear pose 300 100 50 0 0 0 path=250"
BACK = "linear pose 200 150 50 0 0 0"


@pytest.mark.requirement("RHO-MOT-46", by="gateway.pure.cycle.path_mover:PathMover.leave")
def test_an_axis_that_takes_no_part_may_go_and_the_others_go_on_as_if_it_had_not(portal: Portal) -> None:
    undisturbed = Portal()
    undisturbed.finished(undisturbed.run(AWAY, BACK))
    whole = undisturbed.driven().sets
    job = portal.run(AWAY, BACK)
    portal.until(far)
    assert portal.give(Code.DISABLE, Z).state is CommandState.DONE
    portal.pushed(8.0)
    assert portal.z()[0] == pytest.approx(0.058, abs=NEAR) and portal.z()[0] == pytest.approx(portal.z()[1], abs=THERE), "slaved"
    assert portal.finished(job).state is CommandState.DONE
    driven = portal.driven().sets
    count = min(len(whole), len(driven))
    assert count > 100 and np.max(np.abs(driven[:count, :2] - whole[:count, :2])) < 1e-9, "X and Y have not noticed"
    assert portal.z()[0] == pytest.approx(0.058, abs=NEAR) and not portal.state.axes[2].finding
    assert portal.give(Code.ENABLE, Z).state is CommandState.DONE
    assert portal.z()[0] == pytest.approx(0.058, abs=NEAR), "on again from where it is"
    assert portal.finished(portal.run("linear pose 200 150 50 0 0 0")).state is CommandState.DONE, "no program ran: nothing to accept"


@pytest.mark.requirement("RHO-MOT-46", by="gateway.pure.cycle.path_mover:PathMover._held_up")
def test_an_axis_that_takes_part_ends_the_program_and_the_others_stop_on_the_path(portal: Portal) -> None:
    job = portal.run("linear pose 300 200 90 0 0 0 path=200")
    portal.until(far)
    portal.give(Code.DISABLE, Z)
    portal.finished(job)
    assert (job.state, job.reason, job.detail) == (CommandState.ABORTED, Reason.DRIVE_ON_NOT_AVAILABLE, "axis Z")
    driven = quiet(portal)
    way = (driven.sets[:, :2] - 0.1) / np.array([0.2, 0.1])
    assert np.max(np.abs(way[:, 0] - way[:, 1])) < 2e-4 and 0.3 < way[-1, 0] < 0.9, "on the line, to a rest"
    before = portal.state.axes[0].set
    portal.bench.run(0.5)
    assert portal.state.axes[0].set == before and portal.give(Code.RESUME, ALL).reason is Reason.NOTHING_TO_RESUME


@pytest.mark.requirement("RHO-MOT-46", by="gateway.pure.cycle.drive_on:DriveOnGate.join")
def test_nobody_comes_back_while_the_axes_move(portal: Portal) -> None:
    job = portal.run(AWAY, BACK)
    portal.until(far)
    portal.give(Code.DISABLE, Z)
    back = portal.give(Code.ENABLE, Z)
    assert (back.state, back.reason) == (CommandState.ABORTED, Reason.DRIVE_ON_NOT_ALLOWED)
    portal.finished(job)
    assert (job.state, job.reason, job.detail) == (CommandState.ABORTED, Reason.DRIVE_ON_NOT_ALLOWED, "axis Z")
    portal.bench.run(0.3)
    assert not portal.state.axes[2].flags & AxisFlag.ENABLED
    quiet(portal)


def interrupted(portal: Portal, *lines: str) -> Job:
    """Z leaves in the first block, is moved, and is back while the others stand; then the program goes on."""
    job = portal.run(*lines)
    portal.until(far)
    portal.give(Code.DISABLE, Z)
    portal.pushed(5.0)
    assert portal.give(Code.STOP, ALL).state is CommandState.DONE
    portal.until(lambda s: s.motion is Motion.STOPPED)
    assert portal.give(Code.ENABLE, Z).state is CommandState.DONE
    assert portal.z()[0] == pytest.approx(0.055, abs=NEAR), "set := actual, though the path says 50 mm"
    portal.bench.run(0.2)
    assert portal.state.motion is Motion.STOPPED, "it waits for a resume"
    portal.bench.give(Code.RESUME, ALL)
    return job


@pytest.fixture
def hand_to_mouth(monkeypatch: pytest.MonkeyPatch) -> None:
    """So little is handed on at once that the next block is not prepared while the first one runs."""
    monkeypatch.setattr(programchain, "AHEAD", 4)


@pytest.mark.usefixtures("hand_to_mouth")
@pytest.mark.requirement("RHO-MOT-46", by="gateway.pure.cycle.drive_on:DriveOnGate.check")
def test_without_move_until_the_next_block_is_refused(portal: Portal) -> None:
    job = portal.finished(interrupted(portal, AWAY, "linear pose 100 100 50 0 0 0"))
    assert (job.state, job.reason, job.detail) == (CommandState.ABORTED, Reason.DRIVE_ON_NOT_AVAILABLE, "axis Z")
    assert portal.state.axes[0].set == pytest.approx(0.3, abs=1e-9), "the block under way was run to its end"
    portal.bench.run(0.3)
    assert portal.z()[0] == pytest.approx(0.055, abs=NEAR), "and stays, now that nothing keeps it"
    quiet(portal)
    assert portal.finished(portal.run("linear pose 300 100 60 0 0 0")).state is CommandState.DONE


@pytest.mark.usefixtures("hand_to_mouth")
@pytest.mark.requirement("RHO-MOT-46", by="gateway.pure.cycle.drive_on:DriveOnGate.accepted")
def test_move_until_accepts_the_position_and_the_axis_goes_on_from_there(portal: Portal) -> None:
    wait = f"linear pose 300 110 55 0 0 0 path=30 until={PROBE}"
    job = interrupted(portal, AWAY, wait, "linear pose 300 100 60 0 0 0")
    portal.until(lambda s: s.axes[1].set > 0.103 or not job.open)
    assert job.open, job
    portal.bench.permit(PROBE)
    assert portal.finished(job).state is CommandState.DONE
    sets = quiet(portal).sets
    assert sets[-1, :3] == pytest.approx((0.3, 0.1, 0.06), abs=THERE)
    assert np.max(np.abs(np.diff(sets[:, 2]))) < 0.5 * 0.004, "no jump: where it stood, not where the program had left it"


@pytest.mark.requirement("RHO-MOT-47", by="gateway.pure.arbitration.dispatcher:CommandDispatcher.bar")
def test_a_disabled_axis_keeps_its_place_programs_move_the_others_and_those_that_need_it_say_so(portal: Portal) -> None:
    job = portal.run(AWAY)
    portal.until(far)
    portal.bench.dispatcher.bar(Z)
    portal.bench._hand_over()
    portal.pushed(-3.0)
    assert portal.finished(job).state is CommandState.DONE
    refused = portal.give(Code.ENABLE, Z)
    assert (refused.state, refused.reason) == (CommandState.REFUSED, Reason.DRIVES_OFF)
    assert portal.finished(portal.run("ptp joints 100 100 45 0")).state is CommandState.REFUSED
    z = portal.z()[0]
    assert z == pytest.approx(0.047, abs=NEAR)
    near = 1e3 * (z + 0.5 * window_of(CELL.axis[2]))
    again = portal.finished(portal.run(f"linear pose 150 150 {near!r} 0 0 0", f"linear pose 100 100 {near!r} 0 0 0"))
    assert again.state is CommandState.DONE and portal.z()[0] == z, "as near as an axis in position is: it does not take part"
    portal.driven()
    needs = portal.bench.settle(portal.run(f"linear pose 150 150 {1e3 * z!r} 0 0 0", "linear pose 150 150 60 0 0 0"))
    assert (needs.state, needs.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT)
    assert needs.detail == "line 6: block 2, axis Z: DRIVE ON not avail."
    assert np.ptp(portal.driven().sets[:, 0]) < 1e-9, "before anything moved"


def test_without_any_drive_or_with_a_broken_one_no_program_begins(portal: Portal) -> None:
    portal.give(Code.DISABLE, ALL)
    job = portal.run(AWAY)
    assert (job.state, job.reason) == (CommandState.REFUSED, Reason.DRIVES_OFF)
    portal.give(Code.ENABLE, ALL)
    portal.bench.silent.add(3)
    portal.bench.run(0.3)
    job = portal.run(AWAY)
    assert (job.state, job.reason, job.detail) == (CommandState.REFUSED, Reason.DRIVES_OFF, "X, Y, Z, C")
