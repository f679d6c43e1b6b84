"""Two streams of one cell, of an arm and of a SCARA: what is wrong with one is told with lane, block and number; its axes rest.

The other one goes on, and nothing moves afterwards without a fresh command (AX-920, AX-970)."""

import pytest

from gateway.pure.arbitration.jobs import Job
from gateway.pure.image.reasons import CommandState, Reason
from hil_tests.lab.cells.arm_and_scara import CELL
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.lanes_bench import Lanes

ARM, SCARA = 0b111111, 0b1111 << 6
AXES = "axes deg deg mm deg"
OF_ARM = ("ptp joints 90 30 90 0 60 0", "ptp joints -60 30 90 0 60 0", "ptp joints 0 30 90 0 60 0")
AWAY, AT = "ptp joints 30 90 -200 0", (30.0, 90.0, -200.0, 0.0)


@pytest.fixture
def lanes() -> Lanes:
    """Command source 1 has the arm, 2 the SCARA."""
    made = Lanes(Cell402Bench(8, cell=CELL), {1: "robot tx60-like\nstart 0 30 90 0 60 0\n" + OF_ARM[0]}, {1: "arm"})
    made.ready(1, ARM)
    made.ready(2, SCARA)
    return made


def both(lanes: Lanes, *lines: str) -> tuple[Job, Job]:
    """A stream on each lane; the SCARA's first block is a good one."""
    return lanes.stream(1, 1, ARM, *OF_ARM), lanes.stream(2, 2, SCARA, AXES, AWAY, *lines)


def rests(lanes: Lanes, job: Job) -> list[float]:
    """Where the SCARA is; nothing that is said to its old stream moves it any more."""
    lanes.bench.run(0.3)
    before = lanes.sets()[6:]
    lanes.say(job, "ptp joints 0 90 -200 0", end=True)
    lanes.bench.run(0.5)
    assert lanes.sets()[6:] == before
    return before


def goes_on(lanes: Lanes, arm: Job) -> None:
    """The arm ends where its stream does, and the SCARA takes a fresh stream."""
    lanes.say(arm, end=True)
    assert lanes.bench.settle(arm, 30.0).state is CommandState.DONE, arm
    assert lanes.sets()[:6] == pytest.approx([0, 30, 90, 0, 60, 0], abs=1e-6)
    fresh = lanes.stream(2, 2, SCARA, AXES, "ptp joints 0 90 -200 0")
    lanes.say(fresh, end=True)
    assert lanes.bench.settle(fresh, 30.0).state is CommandState.DONE, fresh
    assert lanes.sets()[6:] == pytest.approx([0, 90, -200, 0], abs=1e-6)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("ptp joints 400 90 -200 0", "scara: block 2, axis S1: target 400 deg is outside -132 .. 132 deg (VAL 3 520)"),
        ("ptp joints nan 90 -200 0", "scara: block 2: joints: nan deg is outside -1e+07 .. 1e+07 deg"),
        (
            "linear pose 2000 0 100 180 0 0",
            "scara: block 2: point not reachable: 600.001 mm from axis 1, possible are 100.000 .. 600.000 mm",
        ),
        ("linear pose 0 0 100 180 0 0 path=60", "scara: block 2, axis S2: point not reachable: axis S2 would leave its travel"),
        ("ptp joints 30 90 -200 0 speed=900", "scara: block 2: speed: 900 % is outside 0.01 .. 500 %"),
        ("jump 1 2 3", "scara: block 2: 'jump' is not a statement; "),
    ],
)
def test_a_wrong_statement_ends_its_stream_with_lane_block_and_number(lanes: Lanes, line: str, words: str) -> None:
    arm, scara = both(lanes, line)
    lanes.bench.settle(scara, 20.0)
    assert scara.state in (CommandState.ABORTED, CommandState.REFUSED) and scara.reason is Reason.PROGRAM_FAULT
    assert scara.detail.startswith(words), scara.detail
    assert rests(lanes, scara) == pytest.approx(AT, abs=1e-6) or rests(lanes, scara) == pytest.approx([0, 90, -200, 0], abs=1e-6)
    goes_on(lanes, arm)


def test_a_lane_that_is_asked_for_twice_is_refused_with_what_has_it(lanes: Lanes) -> None:
    arm, _ = both(lanes)
    again = lanes.stream(1, 1, ARM)
    assert (again.state, again.reason) == (CommandState.REFUSED, Reason.BUSY)
    assert again.detail == "J1, J2, J3, J4, J5, J6: a stream of robot 1 of command source 1 is under way"
    program = lanes.order(1, 1)
    assert (program.state, program.reason, program.detail) == (CommandState.REFUSED, Reason.BUSY, again.detail)
    goes_on_without(lanes, arm)


def goes_on_without(lanes: Lanes, arm: Job) -> None:
    lanes.say(arm, end=True)
    assert lanes.bench.settle(arm, 30.0).state is CommandState.DONE, arm


def test_a_stream_that_starves_rests_and_goes_on_when_more_comes(lanes: Lanes) -> None:
    arm, scara = both(lanes)
    lanes.bench.run(8.0)
    assert scara.open and lanes.sets()[6:] == pytest.approx(AT, abs=1e-6), "open and empty is not an end"
    assert lanes.sets()[:6] == pytest.approx([0, 30, 90, 0, 60, 0], abs=1e-6)
    lanes.say(scara, "ptp joints 0 90 -200 0", end=True)
    assert lanes.bench.settle(scara, 20.0).state is CommandState.DONE
    goes_on_without(lanes, arm)


def test_a_fault_of_the_other_lane_is_no_matter_to_a_stream(lanes: Lanes) -> None:
    arm, scara = both(lanes, "ptp joints -60 90 -200 0")
    lanes.bench.run(0.6)
    lanes.bench.core._axes[6].tracking.lag._trip = 1e-9
    lanes.bench.settle(scara)
    assert (scara.state, scara.reason) == (CommandState.ABORTED, Reason.FOLLOWING_ERROR)
    rests(lanes, scara)
    goes_on_without(lanes, arm)
    assert lanes.dispatcher.enabled_mask() == ARM


def test_a_stream_whose_sender_dies_stops_on_its_path_and_the_other_goes_on(lanes: Lanes) -> None:
    arm, scara = both(lanes, "ptp joints -60 90 -200 0")
    lanes.bench.run(0.4)
    lanes.dispatcher.stop_move(scara)
    lanes.bench._hand_over()
    lanes.bench.run(1.0)
    held = lanes.sets()[6:]
    assert -60.0 < held[0] < 30.0 and held[1:] == pytest.approx([90, -200, 0], abs=1e-6), "on its path"
    lanes.bench.run(1.0)
    assert lanes.sets()[6:] == held, "nothing goes on by itself"
    goes_on_without(lanes, arm)
