"""Synchronous tasks of a cell whose interpreter is woken late: no cycle is lost that can be made up for (L3386-3397)."""

import itertools
from dataclasses import replace

import pytest

from gateway.pure.languages.val3.cell_run import CellRun
from gateway.pure.languages.val3.disk import Disk
from hil_tests.lab.virtual.baps2_bench import VirtualPort
from hil_tests.lab.virtual.val3_cell_bench import SETUP
from hil_tests.unit.languages.val3.apps import App, datum

CYCLE = 4_000_000
APP = App(
    "late",
    datum("n", "num", "3") + datum("bLate", "bool"),
    {
        "start": 'taskCreateSync "s",0.004,bLate,often()\ntaskCreate "a",10,busy()\n'
        "n[2]=clock()\ndelay(0.2)\nn[2]=clock()-n[2]\nwait(false)",
        "often": "while true\nn[0]=n[0]+1\ndelay(0)\nendWhile",
        "busy": "while true\nn[1]=n[1]+1\nendWhile",
    },
)


class Late:
    """The interpreter's inside, with turns at given moments."""

    def __init__(self) -> None:
        self.port = VirtualPort(1)
        self.run = CellRun(replace(SETUP, name="late", folder="late"), self.port, lambda: Disk(APP.files()))
        self.run.read()
        self.run.start_run("late", 1, 0)
        self.at = 0

    def turns(self, *cycles: int) -> None:
        """One turn behind each of these numbers of cycles."""
        for each in cycles:
            self.at += each * CYCLE
            while self.run.turn(self.at):
                pass
            self.port.said.clear()

    @property
    def numbers(self) -> list[float]:
        assert self.run.own is not None
        found = self.run.own.data["n"]
        assert isinstance(found, list)
        return [float(str(each)) for each in found]


def test_cycles_of_a_late_turn_are_made_up_for() -> None:
    late = Late()
    late.turns(1, 1, 1)
    before, lines = late.numbers[:2]
    late.turns(5)
    assert late.numbers[0] == before + 5
    assert late.numbers[1] - lines < 4000, "lines of other tasks are left out: the arm would wait for them"
    late.turns(1)
    assert late.numbers[0] == before + 6


def test_a_turn_that_is_much_too_late_leaves_cycles_out_and_keeps_the_clock() -> None:
    late = Late()
    late.turns(1, 1, 1)
    before = late.numbers[0]
    late.turns(30)
    assert before + 9 <= late.numbers[0] <= before + 11
    late.turns(*([1] * 21))
    assert late.numbers[2] == pytest.approx(0.2, abs=0.0041)


def test_each_turn_on_the_grid_has_one_cycle() -> None:
    late = Late()
    late.turns(*([1] * 4))
    counts = []
    for _ in range(20):
        late.turns(1)
        counts.append(late.numbers[0])
    assert [b - a for a, b in itertools.pairwise(counts)] == [1] * 19


def test_tasks_that_wait_are_not_asked_again_in_one_turn() -> None:
    """Inputs stay as they are in a turn: its time is over as soon as all tasks wait."""
    app = App("late", datum("b", "bool"), {"start": 'taskCreate "t",10,waits()\nwait(b)', "waits": "wait(b)"})
    run = CellRun(replace(SETUP, name="late", folder="late"), VirtualPort(1), lambda: Disk(app.files()))
    run.read()
    run.start_run("late", 1, 0)
    for cycle in range(1, 6):
        assert not run.turn(cycle * CYCLE), f"cycle {cycle}: there is time to make up"
        assert run.machine is not None
        assert run.machine.clock == cycle * CYCLE
