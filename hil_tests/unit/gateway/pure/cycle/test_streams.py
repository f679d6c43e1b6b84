"""Streams: blocks that come one by one and move as they become known, with everything programs may say.  AX-970."""

from collections.abc import Iterator
from itertools import pairwise

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.cells.arm_and_scara import CELL as PAIR
from hil_tests.lab.cells.arm_and_scara import HEAD as PAIR_HEAD
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned
from hil_tests.lab.virtual.stream_bench import FAST, IO, PART, PROBE, SEEN, SWITCHED, StreamBench
from motion.program.text import keys as textkeys
from motion.program.text.reader import STATEMENTS
from motion.program.text.team import STATEMENTS as OF_SEVERAL

HOME = "ptp joints 100 100 50 0"


@pytest.fixture(scope="module")
def cell() -> StreamBench:
    return StreamBench()


@pytest.fixture
def bench(cell: StreamBench) -> Iterator[StreamBench]:
    """A stream that has brought the axes to where tests begin."""
    cell.permit(PROBE, FAST, SEEN, PART, value=False)
    if not cell.job.open:
        cell.begin()
        cell.say(HOME)
        cell.passed(1)
    yield cell
    if cell.job.open:
        cell.end()


def fresh(bench: StreamBench) -> StreamBench:
    """The stream of a test: its blocks are counted from 1."""
    if bench.job.open:
        assert bench.end().state is CommandState.DONE
    bench.begin()
    return bench


def test_a_stream_that_is_open_and_empty_is_no_end_and_goes_on(bench: StreamBench) -> None:
    fresh(bench).say("linear pose 130 100 50 0 0 0")
    bench.passed(1)
    bench.run(2.0)
    assert bench.job.open and bench.at() == (130.0, 100.0, 50.0, 0.0)
    bench.say("linear rel pose 0 20 0 0 0 0")
    bench.passed(2)
    assert bench.at() == (130.0, 120.0, 50.0, 0.0)
    assert bench.end().state is CommandState.DONE


@pytest.mark.requirement("RHO-MOT-10", by="gateway.pure.planning.planner:Programs._answer")
def test_a_block_ends_with_its_input_or_without_it_and_the_answer_says_which_and_where(bench: StreamBench) -> None:
    fresh(bench).say("linear pose 200 100 50 0 0 0 path=60 until=ch611")
    bench.until(lambda s: s.axes[0].set > 0.13)
    bench.permit(FAST)
    bench.passed(1)
    (answer,) = bench.state().answers
    x = bench.at()[0]
    assert answer.block == 1 and answer.met and 130.0 < x < 150.0
    assert answer.places[0] == pytest.approx(x / 1e3, abs=5e-3) and answer.places[1] == pytest.approx(0.1, abs=1e-5)
    bench.permit(FAST, value=False)
    bench.say(f"linear pose {x + 30} 100 50 0 0 0 until={SEEN}", "linear mpos")
    bench.passed(3)
    assert [(each.block, each.met) for each in bench.state().answers] == [(1, True), (2, False)]


def test_what_follows_an_input_that_never_came_is_left_out_up_to_its_label_also_what_is_said_later(bench: StreamBench) -> None:
    fresh(bench).say(f"linear pose 130 100 50 0 0 0 until={SEEN} error=NONE", "linear pose 130 170 50 0 0 0")
    bench.passed(2)
    assert bench.at() == (130.0, 100.0, 50.0, 0.0), "left out, and over"
    bench.say("linear pose 150 150 50 0 0 0", "label NONE", "linear pose 130 110 50 0 0 0")
    bench.passed(4)
    assert bench.at() == (130.0, 110.0, 50.0, 0.0)
    assert max(state.axes[1].set for state in bench.seen) < 0.1101


def test_a_stream_whose_label_never_comes_ends_with_words(bench: StreamBench) -> None:
    fresh(bench).say(f"linear pose 130 100 50 0 0 0 until={SEEN} error=NONE")
    bench.passed(1)
    job = bench.end()
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.PROGRAM_FAULT) and "label NONE" in job.detail


def test_a_block_that_comes_in_time_is_joined_to_a_started_one_without_a_stop(bench: StreamBench) -> None:
    """Behind a part that ended with its input, where the path begins anew."""
    fresh(bench).say(f"linear pose 110 100 50 0 0 0 until={SEEN}")
    bench.passed(1)
    bench.seen.clear()
    bench.say("linear pose 200 100 50 0 0 0 radius=20 path=100", finish=False)
    bench.until(lambda s: s.axes[0].set > 0.125)
    bench.say("linear pose 200 190 50 0 0 0 path=100")
    bench.passed(3)
    rows = [(s.axes[0].set, s.axes[1].set) for s in bench.seen]
    steps = [max(abs(a[0] - b[0]), abs(a[1] - b[1])) for a, b in pairwise(rows)]
    under_way = [step for (x, y), step in zip(rows, steps, strict=False) if x > 0.13 and y < 0.185]
    assert min(under_way) > 0.25 * 0.1 * 0.004, "it never stood"
    assert (0.2, 0.1) not in [(round(x, 4), round(y, 4)) for x, y in rows], "the corner was rounded"


def test_a_start_waits_for_its_input_while_more_blocks_come(bench: StreamBench) -> None:
    fresh(bench).say(f"linear pose 130 100 50 0 0 0 wait={PART} radius=5", "linear pose 130 130 50 0 0 0")
    bench.run(1.0)
    assert bench.at()[:2] == (100.0, 100.0)
    bench.permit(PART)
    bench.passed(2)
    assert bench.at()[:2] == (130.0, 130.0)


@pytest.mark.requirement("RHO-MOT-23", by="gateway.pure.planning.planner:Programs._next")
def test_belts_of_all_types_are_ridden_as_their_blocks_come(bench: StreamBench) -> None:
    fresh(bench)
    bench.started(1)
    bench.say("synchron B1 at=60mm", "linear pose 150 150 50 0 0 0 belt=60mm")
    bench.passed(1)
    bench.run(0.3)
    a, belt = bench.at()[0], bench.core.state.belt
    bench.run(0.3)
    rode = bench.at()[0] - a
    assert rode == pytest.approx(1e3 * (bench.core.state.belt - belt), abs=1.0) and rode > 10.0, "nothing follows, and it rides along"
    bench.say("linear pose 150 150 70 0 0 0 belt=60mm", "synchron_end", HOME)
    bench.passed(3)
    assert bench.at() == pytest.approx((100.0, 100.0, 50.0, 0.0), abs=1e-3)
    bench.drive(1, 0.0)
    for kind, lines in (
        (2, "linear pose 150 150 50 0 0 0 belt=160mm"),
        (3, "linear pose 150 150 50 0 0 0 belt=160mm camin=30mm camout=50mm"),
    ):
        bench.started(kind)
        before = bench.state().passed
        bench.say(f"synchron B{kind} at=60mm", lines)
        bench.passed(before + 1)
        assert bench.at() == pytest.approx((150.0, 150.0, 50.0, 0.0), abs=1e-3)
        bench.say("synchron_end", HOME)
        bench.passed(before + 2)
        bench.drive(kind, 0.0)


def test_what_is_done_at_rest_behind_the_last_block_is_done_when_nothing_follows(bench: StreamBench) -> None:
    fresh(bench).say("linear pose 110 100 50 0 0 0", "mach_pos joints 10 20 30 0")
    bench.until(lambda s: abs(s.axes[1].set - 0.02) < 1e-9)
    assert bench.job.open
    bench.say("mach_pos joints 110 100 50 0")
    bench.until(lambda s: abs(s.axes[1].set - 0.1) < 1e-9)
    bench.say(HOME)
    bench.passed(2)
    assert bench.end().state is CommandState.DONE


FAULTS = {
    "block 2, axis X: point not reachable": "linear pose 90000 100 50 0 0 0",
    "input": "linear pose 120 100 50 0 0 0 until=9999",
    "speed: 1000 %": "ptp joints 100 100 50 0 speed=1000",
    "nan": "linear pose nan 100 50 0 0 0",
    "'jump' is not a statement": "jump 3",
    "synchron B9": "synchron B9",
}


@pytest.mark.parametrize("words", FAULTS)
def test_a_block_that_cannot_be_ends_the_stream_with_words_and_the_axes_rest_on_their_path(bench: StreamBench, words: str) -> None:
    fresh(bench).say("linear pose 120 100 50 0 0 0 path=50", FAULTS[words], "linear pose 150 100 50 0 0 0", finish=True)
    job = bench.finished(bench.job)
    if words == "synchron B9":
        words = "belt B9: Inadmiss. Belt-No"
    assert (job.state, job.reason) in ((CommandState.ABORTED, Reason.PROGRAM_FAULT), (CommandState.REFUSED, Reason.PROGRAM_FAULT))
    assert words in job.detail, job.detail
    y, z = bench.at()[1:3]
    assert (y, z) == (100.0, 50.0) and bench.at()[0] <= 120.0


def test_a_stream_of_which_statements_are_lost_ends_with_their_number_on_its_path(bench: StreamBench) -> None:
    fresh(bench).say("linear pose 200 100 50 0 0 0 path=60", finish=False)
    bench.until(lambda s: s.axes[0].set > 0.13)
    bench.programs.lost(7)
    bench.say("linear pose 200 300 50 0 0 0")
    job = bench.finished(bench.job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.PROGRAM_FAULT)
    assert "7 statements of the stream are lost" in job.detail
    assert bench.at()[1:] == (100.0, 50.0, 0.0) and bench.at()[0] <= 200.0


def test_a_stop_holds_a_stream_on_its_path_and_resume_goes_on(bench: StreamBench) -> None:
    fresh(bench).say("linear pose 200 100 50 0 0 0 path=60", "linear pose 200 150 50 0 0 0")
    bench.until(lambda s: s.axes[0].set > 0.13)
    assert bench.settle(bench.give(Code.STOP, bench.all)).state is CommandState.DONE
    bench.until(lambda s: s.motion is Motion.STOPPED)
    x = bench.at()[0]
    bench.run(0.5)
    assert bench.at()[0] == x and bench.job.open
    bench.give(Code.RESUME, bench.all)
    bench.passed(2)
    assert bench.at()[:2] == (200.0, 150.0)


# ---- every statement of the guide -----------------------------------------------------------------------------------------
SETS = (
    "program hand",
    "robot portal",
    "start 100 100 50 0",
    "tool gripper 0 0 0 0 0 0",
    "frame table 0 0 0 0 0 0",
    "point A pose 110 100 50 0 0 0",
    "point B pose 110 110 50 0 0 0",
    "point FAR joints 100 100 50 0",
    "set speed=60 accel=90 decel=80 path=150 turn=90 pathaccel=1500 pathdecel=1400 share=60 arcs=yes lead=no",
    "set limitmin=50,50,10 limitmax=400,400,200 mirror=- slope=program shape=jerk turning=least",
)
MOVES = (
    "linear A tool=gripper frame=table radius=3 out=400:1@2",
    "linear B leave=1 reach=1 flyby=50 weight=100",
    "ptp joints 100 110 50 0 blend=joint zone=1,1,1,1",
    "ptp FAR distance=0.5",
    "linear rel pose 5 0 0 0 0 0 time=1 ramp=20",
    "linear A",
    "circular via pose 120 110 50 0 0 0 to pose 110 120 50 0 0 0 viaweight=50",
    "circular via pose 100 110 50 0 0 0 to pose 110 100 50 0 0 0 angle=360 rise=2",
    "linear FAR",
    "spline A tension=80 oritension=90",
    "spline B tube=0.5",
    "linear FAR blend=off out=400:0",
    "wc_frame FIX 10 0 0 0 0 0",
    "wc_system FIX",
    "linear pose 90 100 50 0 0 0",
    "wc_system WC_UR",
    "block_search 5",
    "linear A",
    "block_search -",
    "linear FAR",
)
ASKS = (
    f"linear A path=20 until={SEEN} within=60 error=NEXT",
    "linear pose 200 200 50 0 0 0",
    "label NEXT",
    f"linear FAR wait={PART} delay=0.05",
    "iol 2 1 1 105 1 0",
    "linear A",
    "ppo 3 1 1 100 5 0",
    "linear FAR",
    "iol -2 1 1 0 0 0",
    "ppo -3 1 1 0 0 0",
    "measure_on ch610",
    "linear A",
    "measure_off ch610",
    "set_latch fIn0",
    "linear FAR",
    "linear mpos error=NOWHERE",
    "linear pose 200 200 50 0 0 0",
    "label NOWHERE",
    "linear FAR",
    "record_on 1 2mm",
    "linear A",
    "record_off",
    "linear FAR",
    "linear recorded 1",
    "linear FAR",
    "mach_pos joints 100 100 50 0",
    "linear A",
    "read_begin curve.bnr",
    "move_file curve.bnr modulo=0,0,0,0",
    "close curve.bnr",
    "linear FAR",
    "alter frame - path=100",
    "linear A freeze=yes",
    "linear FAR",
    "alter_end",
)
BELTS = (
    ("belt_type 2 2", "belt_param 2 5 10 500", "set_beltcnt 2 0", "sync B2 >= 20mm", "linear FAR"),
    ("synchron B1", "linear pose 130 130 50 0 0 0", "synchron_end", "linear FAR"),
    ("synchron B3 at=60mm", "linear pose 150 150 50 0 0 0 belt=160mm camin=30mm camout=50mm", "synchron_end", "linear FAR"),
)


def test_a_stream_written_by_hand_plays_every_statement_of_the_guide(bench: StreamBench) -> None:
    fresh(bench).permit(PART)
    bench.say(*SETS, *MOVES)
    bench.passed(sum(line.split()[0] in MOVING for line in MOVES), 60.0)
    assert bench.at() == pytest.approx((100.0, 100.0, 50.0, 0.0), abs=1e-3) and not bench.output(SWITCHED)
    bench.say(*ASKS)
    blocks = sum(line.split()[0] in MOVING for line in (*MOVES, *ASKS))
    bench.passed(blocks, 60.0)
    assert bench.at() == pytest.approx((100.0, 100.0, 50.0, 0.0), abs=1e-3) and not bench.output(IO)
    for kind, lines in zip((2, 1, 3), BELTS, strict=True):
        bench.started(kind)
        bench.say(*lines)
        blocks += sum(line.split()[0] in MOVING for line in lines)
        bench.passed(blocks, 60.0)
        bench.drive(kind, 0.0)
    assert bench.at() == pytest.approx((100.0, 100.0, 50.0, 0.0), abs=1e-3)
    assert bench.end().state is CommandState.DONE
    said = (*SETS, *MOVES, *ASKS, *(line for lines in BELTS for line in lines), "angles", "axes")
    assert set(STATEMENTS) <= {line.split()[0] for line in said}
    keys = {word.partition("=")[0] for line in said for word in line.split() if "=" in word}
    assert set(textkeys.NAMES) - keys <= {"config", "extra"}, "of arms, and of additional axes"


MOVING = ("ptp", "linear", "circular", "spline", "move_file", "move")
TEAM = (
    "move arm ptp joints 10 30 90 0 60 0 and scara ptp joints 10 90 -200 0",
    "kinematic arm",
    "point A joints 5 30 90 0 60 0",
    "tool T 0 0 10 0 0 0",
    "frame F 0 0 0 0 0 0",
    "set speed=60",
    "ptp A",
    "wc_frame W 0 0 0 0 0 0",
    "wc_system W",
    "linear rel pose 0 0 5 0 0 0",
    "wc_system WC_UR",
    f"move arm ptp joints 20 30 90 0 60 0 and scara ptp joints 20 90 -200 0 until={SEEN} error=NEXT",
    "label NEXT",
    "kinematic scara",
    "mach_pos joints 20 90 -200 0",
    "ptp joints 0 90 -200 0",
    "move arm ptp joints 0 30 90 0 60 0 and scara ptp joints 5 90 -200 0",
)


def test_a_stream_of_several_kinematics_moves_them_together_block_by_block() -> None:
    planned = Planned(Cell402Bench(8, cell=PAIR))
    planned.bench.permit(SEEN, value=False)
    planned.planner.streams = True
    job = planned.bench.settle(planned.order(PAIR_HEAD + "\n".join(TEAM)), 60.0)
    assert job.state is CommandState.DONE, job
    assert planned.bench.set() == pytest.approx([0, 30, 90, 0, 60, 0, 5, 90, -200, 0], abs=1e-6)
    (answer,) = planned.programs.state.answers
    assert not answer.met
    said = {line.split()[0] for line in (*PAIR_HEAD.splitlines(), *TEAM) if line.split()}
    assert said <= set(OF_SEVERAL)
