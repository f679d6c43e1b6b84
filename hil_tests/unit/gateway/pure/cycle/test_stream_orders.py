"""Orders to a stream under way: hold, go, retrace, flush, cut after a block, single step.  AX-1080."""

import math
from collections.abc import Iterator

import pytest

from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from gateway.pure.image.records.planner import Say
from hil_tests.lab.virtual.stream_bench import PART, SEEN, StreamBench

HOME = "ptp joints 100 100 50 0"
SLOW = "path=50"
SQUARE = (
    f"linear pose 130 100 50 0 0 0 {SLOW} radius=5",
    f"linear pose 130 130 50 0 0 0 {SLOW} radius=5",
    f"linear pose 100 130 50 0 0 0 {SLOW} radius=5",
    f"linear pose 100 100 50 0 0 0 {SLOW} radius=5",
)


@pytest.fixture(scope="module")
def cell() -> StreamBench:
    return StreamBench()


@pytest.fixture
def bench(cell: StreamBench) -> Iterator[StreamBench]:
    """A stream of its own; the axes are where tests begin."""
    cell.permit(SEEN, PART, value=False)
    if cell.job.open:
        assert cell.end().state is CommandState.DONE
    cell.begin()
    cell.say(HOME)
    cell.passed(1)
    if cell.end().state is not CommandState.DONE:
        raise AssertionError(cell.job)
    cell.begin()
    yield cell
    if cell.job.open:
        cell.order_of(Say.SINGLE, "off")
        cell.go()
        cell.end()


def at(bench: StreamBench, x: float, y: float) -> None:
    """Until the set values are near a place; mm."""
    bench.until(lambda s: math.hypot(s.axes[0].set * 1e3 - x, s.axes[1].set * 1e3 - y) < 1.0)


def rests(bench: StreamBench) -> tuple[float, float]:
    """Where the axes have come to rest."""
    for _ in range(500):
        before = bench.set()
        bench.run(0.1)
        if bench.set() == before:
            return bench.at()[0], bench.at()[1]
    raise AssertionError("never at rest")


def way(bench: StreamBench) -> list[tuple[float, float]]:
    return [(s.axes[0].set * 1e3, s.axes[1].set * 1e3) for s in bench.seen]


def beside(bench: StreamBench) -> float:
    """The most the axes were beside the square and its corners of 5 mm; mm."""
    worst = 0.0
    for x, y in way(bench):
        inside = all(100.0 - 1e-3 < value < 130.0 + 1e-3 for value in (x, y))
        edge = min(abs(x - 100.0), abs(x - 130.0), abs(y - 100.0), abs(y - 130.0))
        corner = min(math.hypot(x - a, y - b) for a in (100.0, 130.0) for b in (100.0, 130.0))
        worst = max(worst, 0.0 if inside and edge < 1e-3 else 0.0 if inside and corner < 5.01 and edge < 3.6 else edge if inside else 99.0)
    return worst


def test_a_held_stream_rests_on_its_path_and_what_is_said_meanwhile_waits(bench: StreamBench) -> None:
    bench.say(*SQUARE[:2])
    at(bench, 115, 100)
    bench.hold()
    x, y = rests(bench)
    assert bench.core.state.motion is Motion.STOPPED and 115 < x < 130 and y == 100.0
    bench.say(*SQUARE[2:])
    bench.run(1.0)
    assert bench.at()[:2] == (x, y)
    bench.go()
    bench.passed(4)
    assert bench.at()[:2] == (100.0, 100.0) and beside(bench) < 1e-3


def test_a_stream_that_is_held_while_it_is_empty_does_not_begin_by_itself(bench: StreamBench) -> None:
    bench.hold()
    bench.say(SQUARE[0])
    bench.run(1.0)
    assert bench.at()[:2] == (100.0, 100.0) and bench.job.open
    bench.go()
    bench.passed(1)
    assert bench.at()[:2] == (130.0, 100.0)


def test_retrace_goes_back_to_where_the_stream_began_and_go_forward_again(bench: StreamBench) -> None:
    bench.say(*SQUARE)
    at(bench, 115, 130)
    bench.retrace()
    assert rests(bench) == pytest.approx((100.0, 100.0), abs=1e-3)
    assert bench.state().back and bench.state().block == 1
    assert bench.core.state.motion is Motion.STOPPED
    bench.go()
    bench.passed(4)
    assert bench.at()[:2] == (100.0, 100.0) and beside(bench) < 1e-3 and not bench.state().back


def test_retrace_is_held_on_its_way_and_takes_parts_that_are_over_too(bench: StreamBench) -> None:
    bench.say(SQUARE[0])
    bench.passed(1)
    bench.say(f"linear pose 130 130 50 0 0 0 {SLOW} wait={PART}")
    bench.run(0.5)
    bench.permit(PART)
    at(bench, 130, 120)
    bench.retrace()
    at(bench, 115, 100)
    bench.hold()
    x, y = rests(bench)
    assert 100.0 < x < 115.0 and y == pytest.approx(100.0, abs=1e-3)
    assert bench.state().back and bench.state().block == 1
    bench.go()
    bench.passed(2)
    assert bench.at()[:2] == (130.0, 130.0) and beside(bench) < 1e-3


def test_retrace_never_leads_back_over_what_another_program_has_run(bench: StreamBench) -> None:
    bench.retrace()
    bench.run(1.0)
    assert bench.at()[:2] == (100.0, 100.0)
    bench.say(SQUARE[0])
    bench.run(0.5)
    assert bench.at()[:2] == (100.0, 100.0), "it is held until it is said to go"
    bench.go()
    bench.passed(1)
    bench.retrace()
    assert rests(bench) == pytest.approx((100.0, 100.0), abs=1e-3)


def test_a_flushed_stream_rests_on_its_path_drops_what_waits_and_goes_on_with_what_comes(bench: StreamBench) -> None:
    bench.say(*SQUARE)
    at(bench, 130, 115)
    bench.flush()
    x, y = rests(bench)
    assert x == 130.0 and 115 < y < 130 and bench.job.open
    assert bench.core.state.motion is not Motion.STOPPED and bench.state().passed == 4, "what is dropped is over"
    bench.say(f"linear rel pose 5 0 0 0 0 0 {SLOW}")
    bench.passed(5)
    assert bench.at()[:2] == pytest.approx((135.0, y), abs=1e-6)
    assert bench.end().state is CommandState.DONE


def test_a_stream_is_flushed_while_it_waits_for_an_input_and_while_it_is_empty(bench: StreamBench) -> None:
    bench.order_of(Say.FLUSH)
    bench.say(f"linear pose 130 100 50 0 0 0 wait={PART}", "linear pose 130 130 50 0 0 0")
    bench.run(0.5)
    bench.flush()
    bench.run(0.3)
    bench.permit(PART)
    bench.run(0.5)
    assert bench.at()[:2] == (100.0, 100.0) and bench.state().passed == 2
    bench.say(f"linear pose 110 100 50 0 0 0 until={SEEN}", f"linear pose 110 140 50 0 0 0 {SLOW} until={SEEN}")
    at(bench, 110, 110)
    bench.flush()
    x, y = rests(bench)
    assert x == 110.0 and 110 < y < 125
    assert not bench.state().answers[-1].met
    bench.say(HOME)
    bench.passed(5)


def test_a_stream_that_is_ended_in_place_is_done_where_the_axes_rest(bench: StreamBench) -> None:
    bench.say(*SQUARE)
    at(bench, 130, 115)
    bench.flush()
    job = bench.end()
    assert job.state is CommandState.DONE
    x, y = bench.at()[:2]
    assert x == 130.0 and 115 < y < 130


@pytest.mark.parametrize("finish", [True, False])
@pytest.mark.parametrize("where", [(115, 100, 2), (115, 100, 1), (129.5, 100.5, 2)])
def test_a_stream_is_cut_behind_a_block_and_ends_at_its_target(bench: StreamBench, where: tuple[float, float, int], finish: bool) -> None:
    x, y, behind = where
    bench.say(*SQUARE, finish=finish)
    bench.until(lambda s: math.hypot(s.axes[0].set * 1e3 - x, s.axes[1].set * 1e3 - y) < 3.0)
    bench.order_of(Say.CUT, str(behind))
    targets = {1: (130.0, 100.0), 2: (130.0, 130.0), 3: (100.0, 130.0)}
    bench.passed(4)  # what is dropped is over
    assert bench.at()[:2] == targets[behind], bench.state()
    assert beside(bench) < 1e-3 and bench.job.open
    bench.say(f"linear rel pose 0 0 5 0 0 0 {SLOW}")
    bench.passed(5)
    assert bench.at()[:2] == targets[behind]
    assert bench.end().state is CommandState.DONE


def test_what_is_not_handed_on_yet_is_cut_without_a_stop(bench: StreamBench) -> None:
    lines = [f"linear pose {100 + 10 * n} 100 50 0 0 0 {SLOW} radius=1" for n in range(1, 21)]
    bench.say(*lines[:10], finish=False)
    at(bench, 130, 100)
    bench.say(*lines[10:], finish=False)
    bench.order_of(Say.CUT, "15")
    bench.seen.clear()
    at(bench, 245, 100)
    assert min(b - a for (a, _), (b, _) in zip(way(bench), way(bench)[1:], strict=False)) > 0.15, "mm in 4 ms, of 0.2"
    assert bench.state().block >= 15
    bench.passed(20)
    assert bench.at()[:2] == (250.0, 100.0)


def test_arcs_are_cut_too_and_keep_to_their_circle(bench: StreamBench) -> None:
    arc = f"circular via pose 120 120 50 0 0 0 to pose 100 140 50 0 0 0 {SLOW}"
    bench.say(arc, f"linear pose 100 170 50 0 0 0 {SLOW}")
    bench.until(lambda s: s.axes[1].set > 0.115)
    bench.order_of(Say.CUT, "1")
    bench.passed(2)
    assert bench.at()[:2] == (100.0, 140.0)
    assert max(abs(math.hypot(x - 100.0, y - 120.0) - 20.0) for x, y in way(bench)) < 1e-3


def test_parts_to_come_are_cut_where_they_are(bench: StreamBench) -> None:
    bench.say(
        f"linear pose 130 100 50 0 0 0 {SLOW} until={SEEN}",
        f"linear pose 130 130 50 0 0 0 {SLOW} until={SEEN}",
        f"linear pose 100 130 50 0 0 0 {SLOW}",
        f"linear pose 100 150 50 0 0 0 {SLOW}",
    )
    at(bench, 115, 100)
    bench.order_of(Say.CUT, "3")
    bench.passed(4)
    assert bench.at()[:2] == (100.0, 130.0)
    bench.say(f"linear pose 100 100 50 0 0 0 {SLOW}")
    bench.passed(5)
    assert [(each.block, each.met) for each in bench.state().answers] == [(1, False), (2, False)]


def test_single_step_ends_each_block_at_its_target_and_waits_for_the_next_step(bench: StreamBench) -> None:
    bench.say(*SQUARE)
    at(bench, 115, 100)
    bench.order_of(Say.SINGLE, "on")
    bench.passed(1)
    bench.run(0.3)
    assert bench.at()[:2] == (130.0, 100.0)
    assert bench.state().withheld == 3
    bench.say(f"linear pose 120 100 50 0 0 0 {SLOW}")
    for block, target in ((2, (130.0, 130.0)), (3, (100.0, 130.0))):
        bench.order_of(Say.STEP)
        bench.passed(block)
        bench.run(0.3)
        assert bench.at()[:2] == target
    assert bench.state().withheld == 2 and bench.state().passed == 3
    bench.order_of(Say.SINGLE, "off")
    bench.passed(5)
    assert bench.at()[:2] == (120.0, 100.0) and beside(bench) < 1e-3
    assert bench.end().state is CommandState.DONE


def test_the_end_of_a_stream_in_single_step_comes_behind_its_last_step(bench: StreamBench) -> None:
    bench.order_of(Say.SINGLE, "on")
    bench.say(*SQUARE[:2])
    bench.order_of(Say.END)
    bench.run(0.5)
    assert bench.job.open and bench.at()[:2] == (100.0, 100.0)
    bench.order_of(Say.STEP)
    bench.passed(1)
    assert bench.at()[:2] == (130.0, 100.0)
    bench.order_of(Say.STEP)
    assert bench.finished(bench.job).state is CommandState.DONE
    assert bench.at()[:2] == (130.0, 130.0)


@pytest.mark.parametrize(
    ("say", "text", "words"),
    [(Say.STEP, "", "not in single step"), (Say.CUT, "0", "the axes are in block 2")],
)
def test_an_order_that_cannot_be_done_is_answered_in_words_and_the_stream_goes_on(
    bench: StreamBench, say: Say, text: str, words: str
) -> None:
    bench.say(*SQUARE)
    at(bench, 130, 115)
    bench.order_of(say, text)
    bench.passed(4)
    assert words in bench.state().order_fault, bench.state()
    assert bench.at()[:2] == (100.0, 100.0)


def test_a_stream_on_a_belt_can_only_be_ended(bench: StreamBench) -> None:
    bench.started(1)
    bench.say("synchron B1 at=60mm", "linear pose 150 150 50 0 0 0 belt=60mm")
    bench.until(lambda _: bench.state().bound != "")
    bench.run(0.3)
    bench.order_of(Say.FLUSH)
    bench.run(0.1)
    assert "a belt" in bench.state().order_fault and bench.job.open
    bench.passed(1)
    bench.say("synchron_end", HOME)
    bench.passed(2)
    bench.drive(1, 0.0)
