"""Requests of a tool about its stream: orders go to the cycle and the planner, answers come back by block.  AX-970, AX-1080."""

from collections.abc import Iterator

import pytest

from gateway.pure.image.reasons import CommandState, Reason, Refusal
from gateway.pure.image.records.cell import Motion
from gateway.pure.image.records.planner import BlockRecord
from gateway.services.tool_streams import ToolStreams
from hil_tests.lab.virtual.stream_bench import HEADING, SEEN, StreamBench

HOME = "ptp joints 100 100 50 0"
LINES = (
    "linear pose 130 100 50 0 0 0 path=50 radius=5",
    "linear pose 130 130 50 0 0 0 path=50 radius=5",
    "linear pose 100 130 50 0 0 0 path=50",
)


class Tool:
    """What a tool has of a stream, through the real requests."""

    def __init__(self, bench: StreamBench) -> None:
        self.bench = bench
        self.statements: list[BlockRecord] = []
        self.streams = ToolStreams(bench.dispatcher, self.statements)
        self.streams.begin(bench.job)

    def say(self, *lines: str, then: str = "") -> None:
        self.streams.say(self.bench.job, lines, then)
        self._on()

    def order(self, what: str, block: int | None = None, *, on: bool = True) -> None:
        self.streams.order(self.bench.job, what, block, on=on)
        self._on()

    def _on(self) -> None:
        self.bench.planner.lines.extend(self.statements)
        self.statements.clear()
        self.bench._hand_over()

    @property
    def answer(self) -> dict[str, object]:
        return self.streams.answer(self.bench.job)

    def until(self, name: str, value: object) -> None:
        for _ in range(5000):
            if self.answer[name] == value:
                return
            self.bench.cycle()
        raise AssertionError(self.answer)


@pytest.fixture(scope="module")
def cell() -> StreamBench:
    return StreamBench()


@pytest.fixture
def tool(cell: StreamBench) -> Iterator[Tool]:
    cell.permit(SEEN, value=False)
    if cell.job.open:
        assert cell.end().state is CommandState.DONE
    cell.begin()
    cell.say(HOME)
    cell.passed(1)
    assert cell.end().state is CommandState.DONE
    cell.begin()
    tool = Tool(cell)
    tool.say(*HEADING)
    yield tool
    if cell.job.open:
        tool.order("go")


@pytest.mark.requirement("RHO-MOT-10", by="gateway.services.tool_streams:ToolStreams.order")
def test_a_tool_holds_its_stream_goes_back_and_on_and_reads_where_the_axes_are(tool: Tool) -> None:
    tool.say(*LINES, then="finish")
    tool.until("block", 2)
    tool.order("hold")
    tool.until("motion", Motion.STOPPED.name)
    held = tool.answer
    assert held["position"] == pytest.approx(list(tool.bench.at()), abs=1e-3) and held["measured"] == [None] * 4
    tool.order("retrace")
    tool.until("back", True)
    with pytest.raises(ValueError, match=r"the axes have gone back to block [12]: continue first"):
        tool.order("cut", 2)
    tool.until("motion", Motion.STOPPED.name)
    assert tool.answer["block"] == 1 and tool.bench.at()[:2] == pytest.approx((100.0, 100.0), abs=1e-3)
    tool.order("go")
    tool.until("passed", 3)
    assert tool.bench.at()[:2] == (100.0, 130.0)


def test_a_tool_cuts_steps_and_flushes(tool: Tool) -> None:
    tool.say(*LINES, then="finish")
    tool.until("block", 1)
    tool.order("cut", 2)
    tool.until("passed", 3)
    assert tool.bench.at()[:2] == (130.0, 130.0)
    tool.order("single")
    tool.say("linear pose 120 130 50 0 0 0 path=50", "linear pose 120 100 50 0 0 0 path=50", "linear pose 100 100 50 0 0 0 path=50")
    tool.until("withheld", 3)
    tool.order("step")
    tool.until("passed", 4)
    assert tool.bench.at()[:2] == (120.0, 130.0) and tool.answer["withheld"] == 2
    tool.order("single", on=False)
    tool.bench.until(lambda s: s.axes[1].set < 0.12)
    tool.order("end_here")
    job = tool.bench.finished(tool.bench.job)
    x, y = tool.bench.at()[:2]
    assert job.state is CommandState.DONE and x == 120.0 and 100.0 < y < 120.0


@pytest.mark.parametrize(
    ("what", "block", "words"),
    [
        ("cut", 9, r"cut after block 9; the stream has blocks 1 \.\. 3"),
        ("cut", 1, "cut after block 1: the axes are in block 2; cut after that one, or flush"),
        ("cut", None, "cut after block None"),
        ("jump", None, "do 'jump'; begin, say, look, hold, go, retrace"),
    ],
)
def test_an_order_that_makes_no_sense_is_refused_in_words(tool: Tool, what: str, block: int | None, words: str) -> None:
    tool.say(*LINES, then="finish")
    tool.until("block", 2)
    with pytest.raises(ValueError, match=words):
        tool.order(what, block)
    tool.until("passed", 3)
    with pytest.raises(ValueError, match="step: no block waits"):
        tool.order("step")


def test_nothing_goes_on_without_its_enabling_inputs_and_an_ended_stream_takes_no_order(tool: Tool) -> None:
    tool.say(*LINES, then="finish")
    tool.until("block", 2)
    tool.order("hold")
    tool.until("motion", Motion.STOPPED.name)
    tool.bench.permit(26, value=False)
    tool.bench.run(0.1)
    with pytest.raises(Refusal):
        tool.order("go")
    tool.bench.permit(26)
    tool.bench.run(0.1)
    tool.order("go")
    tool.until("passed", 3)
    assert tool.bench.end().state is CommandState.DONE
    with pytest.raises(ValueError, match="the stream is over: done"):
        tool.order("hold")
    tool.bench.job.state, tool.bench.job.reason = CommandState.REFUSED, Reason.EMERGENCY_STOP
    with pytest.raises(ValueError, match="the stream is over: refused: emergency stop"):
        tool.order("hold")


def test_an_order_that_the_planner_cannot_execute_is_reported_until_the_next_one(tool: Tool) -> None:
    tool.say(*LINES)
    assert tool.answer["order_fault"] == ""
    tool.order("step")
    tool.until("order_fault", "the stream is not in single step")
    tool.order("single")
    tool.until("order_fault", "")
    tool.order("single", on=False)
    tool.say(then="finish")
    tool.until("passed", 3)


def test_a_stream_that_is_over_still_answers_for_its_last_block(tool: Tool) -> None:
    """A tool asks every 50 ms, and the stream is over 5 ms after its last block."""
    tool.bench.permit(SEEN)
    tool.say(LINES[0], f"linear pose 130 130 50 0 0 0 path=50 until={SEEN}", then="end")
    for _ in range(5000):
        if not tool.bench.job.open:
            break
        tool.bench.cycle()
    tool.bench.run(0.1)
    answer = tool.answer
    assert answer["fault"] == ""
    assert (tool.bench.job.state, answer["said"], answer["passed"]) == (CommandState.DONE, 2, 2)
    found = answer["answers"]
    assert isinstance(found, list) and [(each["block"], each["met"]) for each in found] == [(2, True)]
