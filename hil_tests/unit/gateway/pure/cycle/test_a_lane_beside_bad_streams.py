"""What is wrong with the stream of one lane: the other lane's record is the same, cycle by cycle, as without it (AX-920, AX-1788)."""

from collections.abc import Callable

import pytest

from gateway.pure.arbitration.jobs import Job
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.planner import BLOCKS, BlockRecord, PlannerState, Say
from gateway.pure.planning.ahead import KEPT, StatementsAhead
from gateway.services.tool_streams import ToolStreams
from hil_tests.lab.cells.arm_and_scara import CELL
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.lanes_bench import Lanes

ARM, SCARA = 0b111111, 0b1111 << 6
AXES = "axes deg deg mm deg"
OF_ARM = ("ptp joints 90 30 90 0 60 0", "ptp joints -60 30 90 0 60 0", "ptp joints 0 30 90 0 60 0")
AWAY, FURTHER = "ptp joints 30 90 -200 0", "ptp joints -60 90 -200 0"
MOST = BLOCKS // 2 - KEPT


class Tools:
    """A stream of the arm that is always the same, and one of the SCARA; statements go through a ring of so many records."""

    def __init__(self, *lines: str) -> None:
        self.lanes = Lanes(Cell402Bench(8, cell=CELL), {1: "robot tx60-like\nstart 0 30 90 0 60 0\n" + OF_ARM[0]}, {1: "arm"})
        self.lanes.taken = 64
        self.lanes.ready(1, ARM)
        self.lanes.ready(2, SCARA)
        self.statements: list[BlockRecord] = []
        self.streams = ToolStreams(self.lanes.dispatcher, self.statements)
        self.arm, self.scara = self._begin(1, ARM, *OF_ARM), self._begin(2, SCARA, AXES, *lines)

    def _begin(self, robot: int, mask: int, *lines: str) -> Job:
        job = self.lanes.dispatcher.order_stream(robot, robot, mask)
        self.lanes.bench._hand_over()
        self.streams.begin(job)
        self.say(job, *lines)
        return job

    def say(self, job: Job, *lines: str, then: str = "finish") -> None:
        self.streams.say(job, lines, then)
        self.lanes.lines.extend(self.statements)
        self.statements.clear()
        assert len(self.lanes.lines) <= BLOCKS, "the ring has come round"

    def record(self, cycles: int = 350, at: Callable[["Tools"], None] | None = None) -> list[list[float]]:
        """Of the arm; `at`: what happens in the middle of its way."""
        rows = []
        for n in range(cycles):
            if n == 60 and at is not None:
                at(self)
            self.lanes.bench.cycle()
            rows.append(self.lanes.sets()[:6])
        return rows


@pytest.fixture(scope="module")
def alone() -> list[list[float]]:
    """The arm beside a SCARA that has nothing to do."""
    return Tools().record()


def flood(tools: Tools) -> None:
    tools.say(tools.scara, *["set path=100"] * MOST)


def in_small_parts(tools: Tools) -> None:
    for _ in range(20):
        tools.say(tools.scara, *["set path=100"] * 100, then="")


def as_an_interpreter(tools: Tools) -> None:
    """It writes statements one by one, and does not ask how many wait."""
    ahead, job = StatementsAhead(), tools.scara.id
    for _ in range(3 * MOST):
        record = ahead.passed(BlockRecord(Say.LINE, job, "set path=100"), tools.lanes.dispatcher.planner or PlannerState())
        tools.lanes.lines.extend([] if record is None else [record])
    assert len(tools.lanes.lines) <= BLOCKS // 2


def die(tools: Tools) -> None:
    tools.lanes.dispatcher.stop_move(tools.scara)
    tools.lanes.bench._hand_over()


TOO_MANY = f"lost: more than {MOST} arrived before the planner used them"
FLOODED = f"statements of the stream are {TOO_MANY}"
CASES: dict[str, tuple[tuple[str, ...], Callable[[Tools], None] | None, str]] = {
    "floods": ((AWAY,), flood, f"scara: block 2: {MOST + 1} {FLOODED}"),
    "floods in small parts": ((AWAY, FURTHER), in_small_parts, f"scara: block 3: 100 {FLOODED}"),
    "floods from a program": ((AWAY,), as_an_interpreter, f"scara: block 2: a statement of the stream is {TOO_MANY}"),
    "starves": ((AWAY,), None, ""),
    "dies in the middle": ((AWAY, FURTHER), die, ""),
    "out of range": ((AWAY, "ptp joints 400 90 -200 0"), None, "scara: block 2, axis S1: target 400 deg is outside"),
    "unreachable": ((AWAY, "linear pose 2000 0 100 180 0 0"), None, "scara: block 2: point not reachable"),
    "singular": ((AWAY, "linear pose 600 0 100 180 0 0 path=60", "linear pose 0 0 100 180 0 0 path=60"), None, "scara: block "),
    "no number": ((AWAY, "ptp joints nan 90 -200 0"), None, "scara: block 2: joints: nan deg is outside"),
}


@pytest.mark.parametrize("case", CASES)
def test_the_record_of_the_other_lane_is_the_same(alone: list[list[float]], case: str) -> None:
    lines, at, words = CASES[case]
    tools = Tools(*lines)
    assert tools.record(at=at) == alone
    if words:
        assert tools.scara.reason is Reason.PROGRAM_FAULT and tools.scara.detail.startswith(words), tools.scara.detail
    tools.say(tools.arm, then="end")
    assert tools.lanes.bench.settle(tools.arm).state is CommandState.DONE


def test_a_lane_asked_for_twice_leaves_both_records_as_they_are(alone: list[list[float]]) -> None:
    def again(tools: Tools) -> None:
        refused = tools.lanes.dispatcher.order_stream(1, 1, ARM)
        assert refused.reason is Reason.BUSY and refused.detail.endswith("a stream of robot 1 of command source 1 is under way")

    assert Tools().record(at=again) == alone


def test_what_was_said_of_one_stream_is_not_forgotten_when_another_lane_begins_one() -> None:
    tools = Tools(AWAY, FURTHER)
    assert (tools.streams.answer(tools.arm)["said"], tools.streams.answer(tools.scara)["said"]) == (3, 2)


def test_a_stream_may_say_as_much_as_it_likes_when_the_planner_has_read_it() -> None:
    tools = Tools(AWAY)
    for _ in range(6):
        tools.say(tools.scara, *["set path=100"] * (MOST - 200))
        tools.lanes.bench.run(0.2)
    tools.say(tools.scara, then="end")
    assert tools.lanes.bench.settle(tools.scara).state is CommandState.DONE, tools.scara
