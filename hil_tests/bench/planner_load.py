"""The cycle next to a fully loaded planner: a program of hundreds of short segments, ordered again as soon as it ends.

Judged as bench drives, against the cycle's twin in C under the same Modbus load, which has no planner (motion.md E, goal 2).
"""

import contextlib
import json
import math
import pathlib
import re
import statistics
import tempfile
import threading
import time
from dataclasses import dataclass, field

from pymodbus.exceptions import ConnectionException, ModbusIOException

from gateway.files.find import find_config
from gateway.runtime.supervisor_client import ask
from hil_tests.bench.cycle_bench import SWITCH_ON_S, Bench, Figure, Side, alternate, running
from hil_tests.bench.drives_bench import compared
from hil_tests.bench.emulated_drives import cpu_seconds
from hil_tests.lab.partners import plc2 as modbus

PROGRAM, BLEND_MM = 13, 0.25
SEGMENTS, ROUND, RADIUS_MM = 3760, 1880, 150.0  # two rounds by chords of half a millimetre, hundreds of blocks a second
STIFF = "accel = 20000.0, jerk = 4e6"  # the demo's axes would take these chords at 50 mm/s, which is no load for a planner
PLANNER_GOAL = 50.0  # % of a core: below, the planner was no load to speak of
P5_MS = 4
ROBOT = """
[robot]
kinematics = "portal"
model      = "portal"

[[program]]
number = 1
file   = "short-segments"
"""


@dataclass(slots=True)
class Loaded(Bench):
    """What moves the axes is the program; the planner's share of a core is taken of each block."""

    planner: list[float] = field(default_factory=list)

    def _keep_moving(self, stop: threading.Event) -> None:
        spent, begun = -self._planner_seconds(), time.monotonic()
        while not stop.is_set():
            with contextlib.suppress(TimeoutError, ConnectionException, ModbusIOException):
                self.plc.send(PROGRAM, 1)
                ended = self.plc.wait(lambda s: s.state in (modbus.DONE, modbus.REFUSED, modbus.ABORTED) or stop.is_set(), 120).state
                self.moves += ended in (modbus.DONE, modbus.RUNNING)
                if ended in (modbus.REFUSED, modbus.ABORTED) and not stop.is_set():
                    self.switch_on(time.monotonic() + SWITCH_ON_S, stop)
        self.planner.append((spent + self._planner_seconds()) / (time.monotonic() - begun))

    def _planner_seconds(self) -> float:
        with ask(self.name, "status") as connection:
            processes = json.loads(connection.makefile().readline())["processes"]
        return cpu_seconds(int(next(process["pid"] for process in processes if process["name"] == "planner")))


def figures(blocks: int = 6, seconds: float = 10.0) -> list[Figure]:
    """planner.skipped, planner.incomplete, planner.load: with six blocks of 10 s a minute of ours."""
    ours, theirs = Side(), Side()
    with tempfile.TemporaryDirectory(prefix="axisgate-bench-") as folder:
        cell = pathlib.Path(folder) / "planned.toml"
        cell.write_text(planned(find_config("demo", "cells").read_text()))
        (cell.parent / "short-segments.txt").write_text(short_segments())
        with running(cell.parent, str(cell), P5_MS, "bench-planner", kind=Loaded) as bench:
            assert isinstance(bench, Loaded)
            repeated = alternate(bench, ours, theirs, blocks, seconds)
            load = 100 * statistics.median(bench.planner) if bench.planner else float("nan")
            moves = bench.moves
    rows = compared(ours, theirs, repeated, moves, "planner.{}")
    beside = f"the goal; {moves} programs of {SEGMENTS} segments begun"
    return [*rows, {"figure": "planner.load", "value": round(load, 1), "unit": "% of a core", "reference": beside,
                    "reference_value": PLANNER_GOAL, "ratio": round(load / PLANNER_GOAL, 3), "goal": f">= {PLANNER_GOAL:g}",
                    "met": load >= PLANNER_GOAL}]  # fmt: skip


def planned(text: str) -> str:
    """The demo's cell with a portal on its axes A1 .. A4, stiffer than there, and its program."""
    head, mark, rest = text.partition("[[bus]]")
    return head + ROBOT + mark + re.sub(r"accel *= *[\d.]+, *jerk *= *[\d.]+", STIFF, rest)


def short_segments() -> str:
    """Chords, each rounded: what a contour of a drawing program looks like."""
    points = (2 * math.pi * n / ROUND for n in range(SEGMENTS))
    lines = [f"linear pose {400 + RADIUS_MM * math.cos(a):.4f} {400 + RADIUS_MM * math.sin(a):.4f} 100 0 0 0" for a in points]
    head = ["program short-segments", "robot portal", "angles rho3", "axes mm mm mm deg", "start 550 400 100 0"]
    return "\n".join([*head, "ptp joints 550 400 100 0", f"set path=600 radius={BLEND_MM}", *lines[1:], ""])
