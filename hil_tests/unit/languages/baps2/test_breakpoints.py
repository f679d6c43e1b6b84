"""Breakpoints and steps of watched programs: a line where nothing holds costs no call, and is asked again as soon as something may hold."""

import pytest

from gateway.pure.languages.baps2.debugging import DebugRun
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.base.debug import Debugger, Step
from gateway.pure.languages.base.process import Process
from hil_tests.bench.program_bench import words

COUNT, FIRST, LAST = 7, 5, 9
SOURCE = """PROGRAM P
INTEGER : I
BEGIN
AGAIN:
I = I + 1
WAIT 0.1
I = I + 1
WAIT 0.1
JUMP AGAIN
PROGRAM_END
"""


class Counting(Debugger):
    """Counts what it is asked."""

    asked = 0

    def stops(self, process: Process, program: str, line: int, depth: int) -> bool:
        Counting.asked += 1
        return super().stops(process, program, line, depth)


def begun() -> DebugRun:
    """The program has gone round for 2 s."""
    watched = DebugRun(words(), Memory({"P.QLL": SOURCE.encode()}), Feed())
    watched.debugger = watched.run.scheduler.debugger = Counting()
    watched.run.begin("P")
    goes_on(watched, 2.0)
    return watched


def goes_on(watched: DebugRun, seconds: float) -> list[int]:
    """Lines at which processes are held when the time is over."""
    end = watched.run.now + seconds * 1e9
    while watched.run.now < end and not watched.held():
        watched.run.go_on()
    return [task.process.line for task in watched.held()]


def test_a_loop_without_breakpoints_asks_at_each_line_once() -> None:
    watched = begun()
    Counting.asked = 0
    assert goes_on(watched, 2.0) == []
    assert Counting.asked == 0


@pytest.mark.parametrize("line", [FIRST, COUNT, LAST])
def test_a_breakpoint_set_while_the_program_runs_holds_at_its_line(line: int) -> None:
    watched = begun()
    watched.debugger.set_breakpoints("P", [line])
    assert goes_on(watched, 2.0) == [line]
    watched.debugger.set_breakpoints("P", [])
    watched.resume(watched.held()[0].process.number, Step.RUN)
    assert goes_on(watched, 2.0) == []


def test_a_step_holds_at_the_next_line_though_its_flag_was_cleared() -> None:
    watched = begun()
    watched.pause()
    (line,) = goes_on(watched, 1.0)
    lines = [line]
    for _ in range(4):
        watched.resume(watched.held()[0].process.number, Step.INTO)
        lines += goes_on(watched, 1.0)
    ring = [5, 6, 7, 8, 9]
    at = ring.index(line)
    assert lines == (ring[at:] + ring)[:5]


def test_a_process_that_ends_with_a_step_open_leaves_the_others_quick() -> None:
    watched = begun()
    watched.pause()
    (task,) = watched.tasks()
    watched.run.scheduler.stop(task.process, watched.run.now)
    watched.run.begin("P")
    goes_on(watched, 1.0)
    Counting.asked = 0
    goes_on(watched, 1.0)
    assert watched.tasks() and Counting.asked == 0
