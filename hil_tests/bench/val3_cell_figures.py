"""A VAL 3 application in a cell: synchronous tasks against the 4 ms grid, and how long a move, an alteration and an input take.

`val3.sync_p99_us`, `val3.sync_p999_us`, `val3.sync_lost`: the interpreter's turns by its timer, in real time, with SCHED_FIFO where this
user may have it; two tasks that only compute run next to the synchronous one.  The others: the cell in virtual time, cycles plus the time
that all its processes calculated meanwhile, 99 of 100.
"""

import functools
import os
import select
import time
from collections.abc import Callable
from dataclasses import replace

from gateway.pure.languages.val3.cell_run import CellRun
from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.tasks import Task
from gateway.runtime.realtime import Timerfd, go_ahead
from hil_tests.bench.figure_row import Figure, row
from hil_tests.lab.virtual.baps2_bench import VirtualPort
from hil_tests.lab.virtual.val3_cell_bench import DONE, PART, SETUP, Val3Cell
from hil_tests.unit.languages.val3.apps import App, datum, value
from motion.geometry.units import to_si
from motion.val3.trsf import Trsf

PERIOD, WORKING_NS = 4_000_000, 2_000_000
SYNC_S, TIMES = 60.0, 30
PRIORITY = 5
LATE_P99, LATE_P999, MOVE_MS, ALTER_MS, IO_MS = 500.0, 1000.0, 60.0, 8.0, 4.0 + 2 * 4.0
SYNC = App(
    "sync",
    datum("n", "num", "4") + datum("bLate", "bool"),
    {
        "start": 'taskCreateSync "s",0.004,bLate,often()\ntaskCreate "a",10,busy(1)\ntaskCreate "b",10,busy(2)\nwait(false)',
        "often": "while true\nn[0]=n[0]+1\ndelay(0)\nendWhile",
        "busy(num x_n)": "while true\nn[x_n]=n[x_n]+1\nendWhile",
    },
)
DATA = (
    datum("jA", "joint", "2", value("0", j1=5, j2=30, j3=90, j5=60) + value("1", j1=8, j2=30, j3=90, j5=60))
    + datum("mFast", "mdesc", "1", value(vel=100, accel=100, decel=100, blend="off"))
    + datum("mSlow", "mdesc", "1", value(vel=1, accel=40, decel=40, blend="off"))
    + datum("mA", "mdesc", "1", value(vel=100, accel=100, decel=100, tmax=400, rmax=400, blend="off"))
    + datum("diPart", "dio", "1", value(link="UserIO\\part"))
    + datum("doDone", "dio", "1", value(link="UserIO\\done"))
    + datum("f", "frame", "1", value(fatherId="world[0]"))
    + datum("p", "point", "2", value(fatherId="world[0]"))
    + datum("tr", "trsf")
    + datum("n", "num", "2")
)
HOME = "enablePower()\nwait(isPowered())\nmovej(jA[0],flange,mFast)\nwaitEndMove()\nn[0]=1\n"
FOLLOW = "while true\nwait(diPart)\ndoDone=true\nwait(diPart==false)\ndoDone=false\nendWhile"
LOOP = "while true\nwait(diPart)\nn[1]=n[1]+1\nmovej(jA[n[1]%2],flange,mFast)\nwaitEndMove()\nn[0]=n[0]+1\nwait(diPart==false)\nendWhile"
MOVES = HOME + LOOP
ALTERS = (
    HOME
    + """p[0]=here(flange,world)
p[1]=appro(p[0],{0,0,-60,0,0,0})
alterBegin(f,mA)
alterMovel(p[1],flange,mSlow)
delay(0.5)
n[0]=2
while true
wait(diPart)
tr.x=tr.x+0.2
n[1]=alter(tr)
wait(diPart==false)
endWhile"""
)


def sync(seconds: float = SYNC_S) -> tuple[float, float, float]:
    """How late it begins, us: 99 of 100 and 999 of 1000; how many periods are missing."""
    port, began = VirtualPort(1), time.monotonic_ns() + 10 * PERIOD
    run = CellRun(replace(SETUP, name="sync", folder="sync"), port, lambda: Disk(SYNC.files()))
    run.read()
    before = os.sched_getscheduler(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except PermissionError:
        go_ahead()
    try:
        starts = _turns(run, port, began, round(seconds * 1e9) // PERIOD)
    finally:
        os.sched_setscheduler(0, before, os.sched_param(0))
    late = sorted((start - began) % PERIOD / 1e3 for start in starts)
    wanted = seconds * 1e9 // PERIOD
    return _share(late, 0.99), _share(late, 0.999), max(wanted - len(starts), 0.0)


def _turns(run: CellRun, port: VirtualPort, began: int, count: int) -> list[int]:
    """As the process of the interpreter: moments at which the synchronous task began."""
    timer, starts = Timerfd(), list[int]()
    timer.set(began, PERIOD)
    run.start_run("sync", 1, began)
    machine = run.machine
    assert machine is not None
    cycle: Callable[[Task], None] = machine._cycle

    def watched(task: Task) -> None:
        starts.append(time.monotonic_ns())
        cycle(task)

    setattr(machine, "_cycle", watched)  # noqa: B010
    end = began + (count + 1) * PERIOD
    while (wall := time.monotonic_ns()) < end:
        select.select([timer], (), ())
        if not timer.expired():
            continue
        wall = time.monotonic_ns()
        now = wall - (wall - began) % PERIOD
        while run.turn(now) and time.monotonic_ns() - wall < WORKING_NS:
            pass
        port.said.clear()
    timer.close()
    return starts


def _share(values: list[float], share: float) -> float:
    return values[min(round(share * len(values)), len(values) - 1)]


def _switched(cell: Val3Cell, level: bool) -> bool:
    return bool(cell.outputs) and cell.outputs[-1][1:] == (DONE, level)


def _answered(cell: Val3Cell, act: Callable[[], None], test: Callable[[], bool]) -> float:
    """ms from an order to its effect: cycles, and what all processes calculated in them."""
    first, began = len(cell.places), time.perf_counter()
    act()
    cell.until(test)
    return (len(cell.places) - first) * 4.0 + (time.perf_counter() - began) * 1e3


def _cell(code: str) -> Val3Cell:
    cell = Val3Cell(App(data=DATA, programs={"start": code}).files(), "demo")
    cell.start()
    cell.bench.run(0.2)
    return cell


def _number(cell: Val3Cell, at: int) -> float:
    assert cell.language.own is not None
    found = cell.language.own.data["n"]
    assert isinstance(found, list)
    return float(str(found[at]))


def io_ms() -> float:
    """From an input of the PLC to the output that a task sets after its wait()."""
    cell, found = _cell(FOLLOW), list[float]()
    for edge in range(2 * TIMES):
        level = edge % 2 == 0
        found.append(_answered(cell, functools.partial(cell.put, PART, level), functools.partial(_switched, cell, level)))
        cell.bench.run(0.02)
    return _share(sorted(found), 0.99)


def _moved(cell: Val3Cell, rest: tuple[float, ...]) -> bool:
    return cell.places[-1] != rest


def _counted(cell: Val3Cell, count: int) -> bool:
    return _number(cell, 0) == count


def move_ms() -> float:
    """From an input, at rest, through wait() and movej to the first set value that differs."""
    cell, found = _cell(MOVES), list[float]()
    cell.until(lambda: _number(cell, 0) == 1)
    for move in range(TIMES):
        cell.bench.run(0.05)
        rest = cell.places[-1]
        found.append(_answered(cell, functools.partial(cell.put, PART, True), functools.partial(_moved, cell, rest)))
        cell.until(functools.partial(_counted, cell, move + 2))
        cell.put(PART, False)
    return _share(sorted(found), 0.99)


def alter_ms() -> tuple[float, float]:
    """From the call of alter() to the set value that has it; from the input that the application waits for before it calls."""
    cell, called, found = _cell(ALTERS), list[float](), list[float]()
    cell.until(lambda: _number(cell, 0) == 2)
    calls = _calls(cell)
    for count in range(1, TIMES + 1):
        cell.bench.run(0.05)
        before = _x(cell)
        found.append(_answered(cell, functools.partial(cell.put, PART, True), functools.partial(_stepped, cell, before)))
        (first, began), now = calls[-1], time.perf_counter()
        assert len(calls) == count and _number(cell, 1) == 1
        called.append((len(cell.places) - first) * 4.0 + (now - began) * 1e3)
        cell.put(PART, False)
    return _share(sorted(called), 0.99), _share(sorted(found), 0.99)


def _calls(cell: Val3Cell) -> list[tuple[int, float]]:
    """Of each call of alter() to come: how many set values there were before it, and the moment."""
    moves, found = cell.language._moves, list[tuple[int, float]]()
    assert moves is not None
    own = moves.alter

    def alter(change: Trsf) -> int:
        found.append((len(cell.places), time.perf_counter()))
        return own(change)

    setattr(moves, "alter", alter)  # noqa: B010
    return found


def _x(cell: Val3Cell) -> float:
    return 1e3 * cell.setup.machine.forward([to_si(each, "deg") for each in cell.places[-1]]).position[0]


def _stepped(cell: Val3Cell, before: float) -> bool:
    return _x(cell) - before > 0.1


def run(beside: str, anchor: float, seconds: float = SYNC_S) -> list[Figure]:
    """beside, anchor: of the other figures of the run."""
    (p99, p999, lost), (called, answered) = sync(seconds), alter_ms()
    return [
        row("val3.sync_p99_us", p99, "us", LATE_P99, beside, anchor),
        row("val3.sync_p999_us", p999, "us", LATE_P999, beside, anchor),
        row("val3.sync_lost", lost, "periods", 0.0, beside, anchor),
        row("val3.move_ms", move_ms(), "ms", MOVE_MS, beside, anchor),
        row("val3.alter_ms", answered, "ms", ALTER_MS, beside, anchor),
        row("val3.alter_call_ms", called, "ms", ALTER_MS, beside, anchor),
        row("val3.io_ms", io_ms(), "ms", IO_MS, beside, anchor),
    ]
