"""VAL 3 chapter 13.1 in a cell: planner, core and emulated drives in virtual time; what the robot did by the emulator's own record."""

import numpy as np
import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.virtual.alter_bench import P5_MS, WAIT, AlterBench
from motion.program.text.reader import read
from motion.program.text.writer import write

PART = ("alter frame - path=500", "linear pose 300 100 50 0 0 0 path=200", "alter_end")
LOCKED, RUNS, UNKNOWN, WRONG = 0, 1, -1, -3
OFF, PENDING, ACTIVE, FROZEN, ERROR = range(5)
P = P5_MS / 1e3


@pytest.fixture(scope="module")
def robot() -> AlterBench:
    return AlterBench()


@pytest.fixture
def bench(robot: AlterBench) -> AlterBench:
    return robot.home()


def ramp(bench: AlterBench, top: float, speed: float, axis: int = 2, after: float = 110.0) -> None:
    """From the moment X is beyond `after` mm: this coordinate goes to `top` at mm/s (deg/s), and stays."""
    made = [0.0]

    def correct() -> tuple[float, ...]:
        if made[0] or bench.bench.set()[0] > after:
            made[0] = min(made[0] + speed * P, top)
        return tuple(made[0] if n == axis else 0.0 for n in range(6))

    bench.correct = correct


def sets(bench: AlterBench) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """(cycles, 4) mm and deg since the order."""
    facts = bench.bench.dispatcher.axes
    return np.array([[axis.set / fact.si for axis, fact in zip(state.axes, facts, strict=False)] for state in bench.seen])


def smooth(bench: AlterBench) -> None:
    """No axis is faster than the path and the correction together."""
    rows = sets(bench)
    assert np.abs(np.diff(rows[:, :3], axis=0)).max() / P < 300.0


def test_a_correction_is_added_to_the_path_and_the_next_block_begins_where_the_axes_stand(bench: AlterBench) -> None:
    ramp(bench, 8.0, 40.0)
    job = bench.begin(*PART, "linear pose 300 130 50 0 0 0 path=200")
    assert bench.finished(job).state is CommandState.DONE
    rows = bench.driven().sets * 1e3
    there = rows[np.abs(rows[:, 1] - 100.0) < 1e-3]
    on = there[(there[:, 0] > 200.0) & (there[:, 0] < 299.0)]
    assert len(on) > 40 and np.abs(on[:, 2] - 58.0).max() < 2e-3, "path + correction, to an increment"
    assert np.abs(rows[rows[:, 0] < 299.0][:, 1] - 100.0).max() < 2e-3, "the rest of the path is as it was"
    rising = there[(there[:, 2] > 50.9) & (there[:, 2] < 57.5)]
    assert len(rising) > 15 and np.abs(np.diff(rising[:, 2], 2)).max() < 0.012, "from value to value in a straight line"
    assert bench.bench.set()[:3] == pytest.approx([300.0, 130.0, 50.0], abs=1e-6)
    smooth(bench)


def test_time_along_the_path_is_the_same_with_and_without_a_correction(bench: AlterBench) -> None:
    bench.finished(bench.begin(*PART))
    plain = sets(bench)[:, 0]
    bench.home()
    ramp(bench, 8.0, 40.0)
    bench.finished(bench.begin(*PART))
    altered = sets(bench)[:, 0]
    first = int(np.argmax(plain > 101.0)), int(np.argmax(altered > 101.0))
    assert altered[first[1] : first[1] + 120] == pytest.approx(plain[first[0] : first[0] + 120], abs=1e-6)


def test_a_correction_about_the_tool_turns_the_flange_round_its_tip(bench: AlterBench) -> None:
    ramp(bench, 5.0, 20.0, axis=5)
    lines = ("tool grip 50 0 0 0 0 0", "alter tool grip path=500 turn=90", "linear pose 350 100 50 0 0 0 path=200 tool=grip", "alter_end")
    assert bench.finished(bench.begin(*lines)).state is CommandState.DONE
    driven = bench.driven()
    tips = driven.places(
        driven.sets,
        tool=read("start 0 0 0 0\naxes mm mm mm deg\ntool grip 50 0 0 0 0 0\nlinear pose 0 0 0 0 0 0 tool=grip\n").blocks[0].tool.pose,
    )
    turned = driven.sets[:, 3] > np.radians(4.9)
    assert turned.sum() > 40 and np.abs(tips[turned][:, 1] - 0.1).max() < 5e-6, "the tip stays on its path"
    assert np.degrees(driven.sets[-1][3]) == pytest.approx(5.0, abs=0.01)


def test_the_source_reads_answer_mode_and_stop_time(bench: AlterBench) -> None:
    bench.bench.run(0.1)
    assert bench.answer() == (UNKNOWN, OFF, 0), "alter before alterBegin"
    job = bench.begin(*PART)
    bench.until(lambda s: s.axes[0].set > 0.15)
    assert bench.answer() == (RUNS, ACTIVE, -1)
    bench.done(Code.STOP)
    bench.bench.run(0.55)
    assert bench.answer() == (LOCKED, ACTIVE, 0) and bench.state.motion is Motion.STOPPED
    bench.bench.give(Code.RESUME)
    bench.bench.run(0.2)
    assert bench.answer() == (RUNS, ACTIVE, -1)
    assert bench.finished(job).state is CommandState.DONE and bench.answer() == (UNKNOWN, OFF, 0)


def test_after_a_stop_alter_acts_for_its_stop_time_and_is_locked_until_the_path_goes_on(bench: AlterBench) -> None:
    ramp(bench, 30.0, 10.0)
    job = bench.begin("alter frame - path=500 decel=60", *PART[1:])
    bench.until(lambda s: s.axes[0].set > 0.15)
    bench.bench.give(Code.STOP)
    bench.until(lambda s: s.motion is Motion.STOPPED)
    began = bench.bench.set()[2]
    left = bench.answer()[2]
    assert 0 < left < 500
    bench.bench.run(left / 1e3 + 0.02)
    locked = bench.bench.set()
    assert locked[2] == pytest.approx(began + 10.0 * left / 1e3, abs=0.2), "the correction goes on for alterStopTime"
    assert bench.still() and bench.bench.set() == pytest.approx(locked, abs=1e-9)
    bench.correct = lambda: (0.0, 0.0, round(locked[2] - 50.0, 2), 0.0, 0.0, 0.0)
    bench.bench.run(0.05)
    bench.bench.give(Code.RESUME)
    assert bench.finished(job).state is CommandState.DONE
    assert bench.bench.set()[0] == pytest.approx(300.0, abs=1e-6)


def ended(bench: AlterBench, *lines: str) -> str:
    """The program ends badly, with everything at rest; its words."""
    job = bench.finished(bench.begin(*lines))
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.ALTER_FAULT) and bench.still()
    return job.detail


def goes_on(bench: AlterBench) -> None:
    """The drives are on, and a fresh order runs from where the axes stand."""
    bench.correct, bench.speaks = lambda: (0.0,) * 6, True
    bench.bench.run(0.05)
    bench.seen.clear()
    assert bench.finished(bench.begin("linear pose 120 100 50 0 0 0", *PART)).state is CommandState.DONE
    smooth_from(bench)


def smooth_from(bench: AlterBench) -> None:
    assert np.abs(np.diff(sets(bench)[:, :3], axis=0)).max() / P < 1000.0


@pytest.mark.requirement("VAL-ALT-01", by=("gateway.pure.cycle.alter:CoreAlter._altered", "gateway.pure.cycle.alter:CoreAlter._halted"))
def test_too_fast_a_correction_halts_at_the_last_valid_position_and_is_minus_3_until_the_next_program(bench: AlterBench) -> None:
    bench.correct = lambda: (0.0, 0.0, 20.0 if bench.bench.set()[0] > 200.0 else 0.0, 0.0, 0.0, 0.0)
    assert ended(bench, *PART) == "block 1: the altered path is too fast for its alterBegin (VAL 3 alter -3)"
    assert 200.0 < bench.bench.set()[0] < 204.0 and bench.bench.set()[2] == pytest.approx(50.0, abs=1e-6)
    assert bench.answer() == (WRONG, ERROR, 0)
    goes_on(bench)


def test_a_correction_out_of_the_travel_names_the_axis(bench: AlterBench) -> None:
    ramp(bench, 320.0, 180.0, axis=1)
    words = ended(bench, "alter frame - path=500", "linear pose 300 700 50 0 0 0 path=200", "alter_end")
    assert words == "block 1, axis Y: the altered position cannot be reached (VAL 3 alter -3)"
    assert 996.0 < bench.bench.set()[1] <= 1000.0
    goes_on(bench)


@pytest.mark.parametrize("say", ["nothing", "bad"])
def test_a_silent_correction_stays_as_it_is_and_the_axes_come_to_rest_on_the_path(bench: AlterBench, say: str) -> None:
    ramp(bench, 6.0, 40.0)
    job = bench.begin(*PART)
    bench.until(lambda s: s.axes[0].set > 0.2)
    at = bench.bench.set()[0]
    bench.speaks = False
    bench.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.ALTER_FAULT) and job.detail.endswith("the correction is silent")
    x, y, z, _ = bench.bench.set()
    assert bench.still() and at + 18.0 < x < at + 60.0, "100 ms of silence, then the path brakes"
    assert (y, z) == pytest.approx((100.0, 56.0), abs=1e-6), "on the altered path"
    rows = sets(bench)
    assert np.abs(np.diff(rows[:, 0], 2)).max() < 1.05 * 3000.0 * P * P, "within the acceleration: no jump"
    goes_on(bench)


def test_without_a_living_correction_nothing_moves(bench: AlterBench) -> None:
    bench.speaks = False
    bench.bench.run(0.3)
    assert ended(bench, *PART) == "block 1: the correction is silent"
    assert bench.bench.set()[0] == pytest.approx(100.0, abs=1e-9)
    goes_on(bench)


@pytest.mark.requirement("VAL-ALT-03", by=("gateway.pure.cycle.alter:CoreAlter.may_end", "gateway.pure.cycle.alter:CoreAlter.step"))
def test_until_keeps_the_correction_acting_at_the_end_of_the_path(bench: AlterBench) -> None:
    job = bench.begin(f"alter frame - path=500 until={WAIT}", *PART[1:], "linear pose 300 120 50 0 0 0 path=200")
    bench.until(lambda s: s.axes[0].set > 0.3 - 1e-9)
    bench.bench.run(0.2)
    assert bench.answer() == (RUNS, ACTIVE, -1) and job.open
    ramp(bench, 3.0, 20.0)
    bench.bench.run(0.3)
    assert bench.bench.set()[2] == pytest.approx(53.0, abs=1e-6), "the arm still moves though the path is over"
    bench.bench.permit(WAIT)
    assert bench.finished(job).state is CommandState.DONE
    assert bench.bench.set()[:3] == pytest.approx([300.0, 120.0, 50.0], abs=1e-6)


def test_a_stop_at_the_end_of_the_path_ends_the_program(bench: AlterBench) -> None:
    job = bench.begin(f"alter frame - path=500 until={WAIT}", *PART[1:])
    bench.until(lambda s: s.axes[0].set > 0.3 - 1e-9)
    bench.bench.run(0.1)
    bench.done(Code.STOP)
    bench.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.STOPPED_BY_SOURCE) and bench.still()
    ramp(bench, 3.0, 10.0)
    assert bench.still(), "a correction moves nothing any more"


@pytest.mark.requirement("VAL-ALT-02", by="gateway.pure.cycle.alter:CoreAlter.freeze")
def test_freeze_keeps_the_correction_for_the_rest_of_the_path(bench: AlterBench) -> None:
    ramp(bench, 60.0, 20.0)
    lines = (
        "alter frame - path=500",
        "linear pose 200 100 50 0 0 0 path=100 freeze=yes",
        "linear pose 400 100 50 0 0 0 path=100",
        "alter_end",
    )
    assert bench.finished(bench.begin(*lines)).state is CommandState.DONE
    rows = sets(bench)
    rest = rows[(rows[:, 0] > 202.0) & (rows[:, 0] < 299.0)][:, 2]
    assert len(rest) > 40 and np.ptp(rest) < 1e-6 and 57.0 < rest[0] < 75.0
    assert bench.bench.set()[2] == pytest.approx(rest[0], abs=1e-6)


def test_an_abandoned_path_drops_its_correction_and_the_planners_death_ends_at_rest(bench: AlterBench) -> None:
    ramp(bench, 6.0, 40.0)
    job = bench.begin(*PART)
    bench.until(lambda s: s.axes[0].set > 0.2)
    bench.done(Code.STOP)
    bench.done(Code.ABANDON)
    assert bench.finished(job).reason in (Reason.ABANDONED, Reason.STOPPED_BY_SOURCE) and bench.still()
    assert bench.bench.set()[2] == pytest.approx(56.0, abs=1e-6)
    bench.home()
    job = bench.begin(f"alter frame - path=500 until={WAIT}", *PART[1:], "linear pose 300 130 50 0 0 0")
    bench.until(lambda s: s.axes[0].set > 0.2)
    bench.planner.alive = False
    bench.bench.core.planner_lost()
    bench.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.PLANNER_LOST) and bench.state.motion is Motion.IDLE


def test_drives_off_forget_the_part(bench: AlterBench) -> None:
    ramp(bench, 6.0, 40.0)
    job = bench.begin(*PART)
    bench.until(lambda s: s.axes[0].set > 0.2)
    assert bench.bench.settle(bench.bench.give(Code.DISABLE, 0xF)).state is CommandState.DONE
    bench.bench.run(0.5)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.DRIVES_OFF)
    bench.home()
    goes_on(bench)


SAYS: dict[str, list[str]] = {
    "line 6: alter: the alterable part before is not ended: alter_end (VAL 3 alterBegin -1)": ["alter frame -", "alter frame -"],
    "line 5: alter_end: ends no alterable part; `alter frame NAME` begins one (VAL 3 alterEnd -1)": ["alter_end"],
    "line 5: alter: VAL 3 error 103: mdesc tvel invalid": ["alter frame - path=0"],
    "line 5: alter: frame 'nowhere' is unknown; - are known": ["alter frame nowhere"],
    "line 5: freeze: is allowed in an alter section only": ["linear pose 400 100 50 0 0 0 freeze=yes"],
    "line 6: block 1: until= and labels have no place in an alterable part": ["alter frame -", "linear pose 400 100 50 0 0 0 until=464"],
    "the tool cannot change in an alterable part": [
        "tool grip 50 0 0 0 0 0",
        "alter frame -",
        "linear pose 400 100 50 0 0 0",
        "linear pose 300 100 50 0 0 0 tool=grip",
    ],
}


def test_rules_of_alterable_parts_are_reported_before_anything_moves(bench: AlterBench) -> None:
    before = bench.bench.set()
    for words, lines in SAYS.items():
        job = bench.bench.settle(bench.begin(*lines))
        assert (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT), words
        assert words in job.detail, job.detail
    bench.programs.cell.altered = ()
    job = bench.bench.settle(bench.begin(*PART))
    assert job.detail == "line 6: block 1: alterBegin: option not enabled; the cell has no [alter] for the robot (VAL 3 -2)"
    assert bench.bench.set() == before


def test_the_text_form_is_written_as_it_was_read() -> None:
    text = (
        "program it\nrobot portal\nangles val3\naxes mm mm mm deg\nstart 100 100 50 0\ntool grip 50 0 0 0 0 0\n"
        "alter tool grip speed=50 path=250 turn=90 accel=100 decel=80 until=!464\n"
        "linear pose 400 100 50 0 0 0 freeze=yes\nlinear pose 300 100 50 0 0 0\nalter_end\nlinear pose 200 100 50 0 0 0\n"
    )
    program = read(text)
    assert read(write(program)) == program
    part = program.blocks[0].alteration
    assert part is not None and part.speed == 0.5 and part.path == 0.25 and part.until is not None and not part.until.value
    assert [block.freeze for block in program.blocks] == [True, False, False] and program.blocks[2].alteration is None
