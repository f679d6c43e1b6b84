"""The core with a planner: pieces of a program in, done when nothing more comes, and what follows a planner's death."""

from gateway.axes import limits_of
from gateway.pure.plannerrecords import BlockRecord, PieceRecord, Say, pack_piece, unpack_piece
from gateway.pure.programs import Programs
from gateway.pure.reasons import Reason
from gateway.pure.records import Motion
from hil_tests.lab.cellbench import ALL, DEMO, CellBench
from motion.kinematics.identity import Identity
from motion.planner.robot import Machine

LIMITS = tuple(limits_of(axis) for axis in DEMO.axis)
JOB = 700


class WithPlanner:
    """A cell in virtual time and the planner's inside beside it: one turn a cycle."""

    def __init__(self) -> None:
        self.cell = CellBench().ready()
        self.programs = Programs(lambda _: Machine(Identity(LIMITS), LIMITS), lambda _: ALL)
        self.said: list[BlockRecord] = []
        self.alive = True
        self.held: list[PieceRecord] = []
        self.cell.each = self.turn

    def turn(self) -> None:
        state = self.cell.core.state
        if self.alive:
            said, self.said = self.said, []
            standing = [axis.set for axis in state.axes[: len(LIMITS)]]
            moving = state.motion is not Motion.IDLE
            self.held += self.programs.turn(said, state.generation, state.piece, standing, moving=moving)
        for record in self.held[:2]:
            self.cell.core.feed(unpack_piece(pack_piece(record)))
        del self.held[:2]

    def finished(self, seconds: float = 20.0) -> None:
        """Runs until the job has an outcome and the axes rest."""
        for _ in range(round(seconds / 0.2)):
            self.cell.run(0.2)
            state = self.cell.core.state
            if JOB in (state.done_job, state.failed_job) and state.motion is Motion.IDLE:
                return
        raise AssertionError(f"no outcome: {self.cell.core.state}")

    def say(self, *lines: str, end: bool = True) -> None:
        units = " ".join(axis.unit for axis in DEMO.axis)
        self.said += [BlockRecord(Say.BEGIN, JOB, f"axes {units}"), *(BlockRecord(Say.LINE, JOB, line) for line in lines)]
        if end:
            self.said.append(BlockRecord(Say.END, JOB))

    def places(self) -> list[float]:
        return [axis.set / fact.si for axis, fact in zip(self.cell.core.state.axes, self.cell.office.axes, strict=False)]


def joints(step: float) -> str:
    """All axes a little further than where referencing left them."""
    return " ".join(f"{step:g}" for _ in LIMITS)


def test_a_program_runs_through_the_core_and_is_done_when_the_axes_are_there() -> None:
    both = WithPlanner()
    both.say(f"ptp joints {joints(5)} blend=joint leave=1 reach=1", f"ptp joints {joints(8)}")
    both.cell.run(0.2)
    assert both.cell.core.state.motion is Motion.RUNNING and both.cell.core.state.piece > 0
    both.finished()
    state = both.cell.core.state
    assert state.done_job == JOB and state.motion is Motion.IDLE and state.failed_job != JOB
    assert all(abs(place - 8.0) < 0.01 for place in both.places())


def test_a_planner_that_dies_leaves_the_axes_at_rest_and_the_job_failed() -> None:
    both = WithPlanner()
    both.say(f"ptp joints {joints(5)}", end=False)
    both.cell.run(0.3)
    assert both.cell.core.state.motion is Motion.RUNNING
    both.alive = False
    both.cell.core.planner_lost()
    both.finished()
    state = both.cell.core.state
    assert (state.failed_job, state.failed_reason) == (JOB, Reason.PLANNER_LOST)
    assert state.motion is Motion.IDLE and state.done_job != JOB
    assert all(abs(place - 5.0) < 0.01 for place in both.places()), "what was committed is run to its end, at rest"


def test_pieces_for_axes_that_are_off_are_refused_and_nothing_moves() -> None:
    both = WithPlanner()
    both.cell.core._off(Reason.DRIVES_OFF)
    before = both.places()
    both.say(f"ptp joints {joints(5)}")
    both.cell.run(1.0)
    assert (both.cell.core.state.failed_job, both.cell.core.state.failed_reason) == (JOB, Reason.NOT_READY)
    assert max(abs(a - b) for a, b in zip(both.places(), before, strict=True)) < 0.05


def test_pieces_of_an_older_cycle_are_dropped() -> None:
    both = WithPlanner()
    both.say(f"ptp joints {joints(5)}", end=False)
    both.turn()
    both.turn()
    kept = [PieceRecord(record.part, record.job, record.generation + 1, record.piece) for record in both.held]
    both.held, both.alive = kept, False
    before = both.places()
    both.cell.run(0.5)
    moved = max(abs(a - b) for a, b in zip(both.places(), before, strict=True))
    assert both.cell.core.state.failed_job != JOB and moved < 4.9


def test_a_fault_in_a_block_ends_the_job_with_its_number_and_nothing_moves() -> None:
    both = WithPlanner()
    both.say(f"ptp joints {joints(1e5)}")
    before = both.places()
    both.cell.run(0.5)
    state = both.programs.state
    assert state.failed_job == JOB and state.fault_block == 1 and state.fault_code == 520 and "axis" in state.fault
    assert both.places() == before
