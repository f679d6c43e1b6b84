"""Four arms of six axes in a running cell, 24 axes on four buses at 4 ms: what the cycle costs, and how often it is late, against its twin
in C on each bus.

Judged as bench cycle: by the brokers' logs and their stamps, in blocks that alternate with the reference under the same Modbus load.
"""

import contextlib
import pathlib
import re
import statistics
import tempfile
import threading
import time

from gateway.files.find import find_config
from gateway.tools.client import ToolClient, ToolError
from hil_tests.bench.cycle_bench import Bench, Figure, Side, alternate, running
from hil_tests.bench.drives_bench import compared, tables

ROBOTS, AXES, P5_MS, CPU_GOAL = 4, 6, 4, 35.0  # goal: % of a core
BUSES = ("drives", *(f"drives{n}" for n in range(2, ROBOTS + 1)))
WAYS = (20.0, 10.0, 10.0, 20.0, 20.0, 20.0)  # deg from where the emulated arm begins
SPEED = 0.5


class FourArms(Bench):
    """Commanded over the tools' socket: the command block of a PLC holds twelve targets."""

    _commands: ToolClient | None = None  # has control until it is closed

    def switch_on(self, until: float, stop: threading.Event | None = None) -> bool:
        """Control and drives on; again from the start while one is refused."""
        while time.monotonic() < until and not (stop and stop.is_set()):
            with contextlib.suppress(ToolError, OSError):
                if self._commands is not None:
                    self._commands.close()
                self._commands = ToolClient(self.name)
                self._commands.take_over()
                self._commands.command("enable", self.mask, timeout_s=5.0)
                return True
            time.sleep(0.05)
        return False

    def _watch_drives(self, stop: threading.Event, seen: list[int]) -> None:
        with contextlib.closing(ToolClient(self.name)) as client:
            while not stop.wait(0.2):
                seen[0] += any(row["words"] for row in client.axes())

    def _keep_moving(self, stop: threading.Event) -> None:
        """To and fro, all axes of all arms."""
        sign = 1.0
        while not stop.is_set():
            targets = [sign * way for way in WAYS] * ROBOTS
            try:
                assert self._commands is not None
                self._commands.command("ptp_relative", self.mask, velocity=SPEED, targets=targets, timeout_s=10.0)
            except (ToolError, OSError):
                self.switch_on(time.monotonic() + 10.0, stop)
                continue
            self.moves += 1
            sign = -sign


def four_arms(text: str) -> str:
    """The shipped Reis arm four times, without its controller."""
    head = re.sub(r"^\[controller.*?(?=^\[rc_inputs\])", "", text[: text.index("[robot]")], flags=re.MULTILINE | re.DOTALL)
    own = "\n".join(part for name in (r"\[robot\]", r"\[\[bus\]\]", r"\[\[axis\]\]") for part in tables(text, name))
    own = own.replace("[robot]", "[[robot]]", 1)
    plant = tables(text, r"\[plant\.axis\.A\d\]")
    robots, machines = list[str](), list[str]()
    for number, bus in enumerate(BUSES):
        arm = own.replace('"ROBOT"', f'"ROBOT{number + 1}"').replace('"drives"', f'"{bus}"')
        robots.append(_renamed(arm, r'(?<="A)\d(?=")', number))
        machines += [_renamed(each, r"(?<=axis\.A)\d", number) for each in plant]
    between = "\n".join([*tables(text, r"\[defaults\.axis\]"), *tables(text, r"\[plant\]")])
    return "\n".join([head.replace('"7" = "plc", "88" = "plc"', '"7" = "plc"'), *robots, between, *machines])


def _renamed(text: str, axis: str, robot: int) -> str:
    """With the axes of another arm."""
    return re.sub(axis, lambda found: str(int(found[0]) + robot * AXES), text)


def figures(blocks: int = 6, seconds: float = 5.0) -> list[Figure]:
    """lanes.cycle_cpu, lanes.skipped_24, lanes.incomplete_24."""
    ours, theirs = Side(), Side()
    with tempfile.TemporaryDirectory(prefix="axisgate-bench-") as folder:
        cell = pathlib.Path(folder) / "four-arms.toml"
        cell.write_text(four_arms(find_config("reis-palletiser", "cells").read_text()))
        with running(pathlib.Path(folder), str(cell), P5_MS, "bench-lanes", BUSES, FourArms) as bench:
            repeated = alternate(bench, ours, theirs, blocks, seconds)
            cpu, moves = statistics.median(bench.cpu) * 100.0 if bench.cpu else float("nan"), bench.moves
    row = {"figure": "lanes.cycle_cpu", "value": round(cpu, 2), "unit": f"% of a core, {ROBOTS * AXES} axes on {ROBOTS} buses",
           "reference": f"the goal; {moves} moves of all axes meanwhile", "reference_value": CPU_GOAL, "ratio": round(cpu / CPU_GOAL, 3),
           "goal": f"<= {CPU_GOAL:g}", "met": moves > 0 and cpu <= CPU_GOAL}  # fmt: skip
    return [row, *compared(ours, theirs, repeated, moves, "lanes.{}_24")]
