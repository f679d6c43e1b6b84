"""Contacts on a Modbus coupler (another server of ours in a thread) and on gpiochips; `axisgate io` on the first."""

import asyncio
import dataclasses
import json
import os
import pathlib
import subprocess
import sys
import time
from collections.abc import Mapping

import pytest

from gateway.assembly.run import make_regions, plan_run
from gateway.cell_file.load import load_cell
from gateway.processes.gpio import Chip, Chips
from gateway.pure.buses.contacts import Said, unpack_said
from gateway.pure.cell.cell import Io, IoDevice
from gateway.pure.image.records.cell import CellState, Quality, cell_state_packer
from gateway.runtime.regions import RegionReader, RegionWriter
from hil_tests.lab.running.cell_running import runtime_folder
from hil_tests.lab.running.joined_running import JoinedRun, cell_copy, running_joined
from hil_tests.lab.running.modbus_running import Running
from hil_tests.lab.virtual.modbus_view import MemoryView
from protocols.base.machine import Ns
from protocols.modbus.view import Kind

CONTACTS = """
[[io]]
name   = "ready"
device = {{ type = "modbus", url = "tcp://127.0.0.1:{port}", output = 2 }}
signal = "cell.ready"
[[io]]
name   = "dog"
device = {{ type = "modbus", url = "tcp://127.0.0.1:{port}", output = 3 }}
signal = "cell.watchdog"
toggle_ms = 100
[[io]]
name   = "lamp"
device = {{ type = "modbus", url = "tcp://127.0.0.1:{port}", output = 4 }}
signal = "io.lamp"
[[io]]
name   = "button"
device = {{ type = "modbus", url = "tcp://127.0.0.1:{port}", input = 7 }}
signal = "io.button"
[[route]]
name = "button_to_lamp"
from = "io.button"
to   = "io.lamp"
on_loss = "zero"
[[modbus]]
name = "coupler"
role = "client"
port = "tcp://127.0.0.1:{port}"
[[modbus.device]]
name  = "tank"
order = "CDAB"
probe_ms = 200
[[route]]
name  = "level"
from  = "tank:30011"
type  = "REAL"
to    = "coupler.tank:40021"
to_type = "s16"
scale = 10.0
every_ms = 20
on_loss = "value"
loss_value = -1
[[route]]
name  = "pump"
from  = "tank:10006"
to    = "tank:00006"
edge  = "level"
every_ms = 20
"""


def test_a_modbus_coupler_shows_outputs_gives_inputs_and_is_bad_while_it_is_away() -> None:
    coupler = MemoryView()
    with Running(coupler) as server:
        more = CONTACTS.format(port=server.port)
        with running_joined(lambda folder: cell_copy("cl300-bits", folder, more=more), "coils") as run:

            def said(name: str) -> dict[str, object]:
                return next(row for row in run.ask(op="contacts")["contacts"] if row["name"] == name)

            run.until(lambda: said("button")["quality"] == "GOOD" and said("ready")["quality"] == "GOOD", "the coupler answers")
            coupler.bits[Kind.DISCRETE_INPUTS][7] = True
            run.until(lambda: coupler.bits[Kind.COILS][4], "the button lights the lamp")
            coupler.bits[Kind.DISCRETE_INPUTS][7] = False
            run.until(lambda: not coupler.bits[Kind.COILS][4], "and puts it out")
            run.until(lambda: coupler.bits[Kind.COILS][3], "the watchdog toggles")
            run.until(lambda: not coupler.bits[Kind.COILS][3], "the watchdog toggles back")
            _registers_of_a_device(run, coupler)
            command = [sys.executable, "-m", "gateway", "io", "test", str(run.folder / "cl300-bits.toml"), "--name", "coils"]
            told = subprocess.run([*command, "--yes", "--json"], capture_output=True, text=True, timeout=60, check=False)
            results = {row["name"]: row for row in json.loads(told.stdout)["results"]}
            assert told.returncode == 0 and all(row["ok"] for row in results.values()), told
            assert results["dog"]["result"] == "toggles by itself" and results["ready"]["result"] == "switched to 1 and 0"
            asked = subprocess.run(
                [*command, "--only", "lamp"], input="yes\ny\nn\n", capture_output=True, text=True, timeout=60, check=False
            )
            assert asked.returncode == 1 and "not seen at 0" in asked.stdout and "clear of people" in asked.stderr
            asyncio.run_coroutine_threadsafe(server.server.close(), server.loop).result(10)
            run.until(lambda: said("button")["quality"] == "BAD" and said("ready")["quality"] == "BAD", "a coupler that is away is told")


def _registers_of_a_device(run: JoinedRun, coupler: MemoryView) -> None:
    """AX-407: registers and coils of a client's device at both ends of a route; a route that is lost still gives its loss value."""
    holding, level = coupler.words[Kind.HOLDING_REGISTERS], coupler.words[Kind.INPUT_REGISTERS]
    run.until(lambda: holding[20] == 0, "0.0 has come over")
    level[10:12] = [0x0000, 0xC049]  # -3.140625, low word first
    run.until(lambda: holding[20] == 0x10000 - 31, "ten times as a whole number")
    coupler.bits[Kind.DISCRETE_INPUTS][5] = True
    run.until(lambda: coupler.bits[Kind.COILS][5], "a coil follows a discrete input")
    level[10:12] = [0x0000, 0x7FC0]  # not a number
    run.until(lambda: holding[20] == 0xFFFF, "lost: -1")
    assert run.ask(op="get", address="route.level")["valid"] is False
    level[10:12] = [0x0000, 0x3FC0]
    run.until(lambda: holding[20] == 15, "and back")


class Watched(Chip):
    """Stands where the chip would stand: what it was to show, and one contact it confirms."""

    def __init__(self, path: str, contacts: Mapping[int, Io]) -> None:
        super().__init__(path, contacts)
        self.shown: list[dict[int, bool]] = []

    def turn(self, shown: Mapping[int, bool], now: Ns) -> dict[int, Said]:
        self.shown.append(dict(shown))
        return {0: Said(True, Quality.GOOD)}


def test_a_gpiochip_that_is_not_there_is_reported_with_what_to_do_and_its_contacts_are_bad(capfd: pytest.CaptureFixture[str]) -> None:
    chip = Chip("/dev/gpiochip99", {0: Io("lamp", IoDevice("gpiochip", output=4, chip="/dev/gpiochip99"), "cell.ready")})
    assert chip.turn({0: True}, 10**9) == {} == chip.turn({0: True}, 10**9 + 1)
    assert capfd.readouterr().out == "/dev/gpiochip99: no such gpiochip; gpiodetect lists those that exist; contacts lamp are out\n"


def test_chips_show_the_last_completed_cycle_and_fall_when_there_is_no_new_one(tmp_path: pathlib.Path) -> None:
    """Real regions; the chip itself is the one thing this machine does not have."""
    more = """
[[io]]
name = "ready"
device = { type = "gpiochip", chip = "none", output = 1 }
signal = "cell.ready"
[[io]]
name = "lamp"
device = { type = "gpiochip", chip = "none", output = 2 }
signal = "cell.ready"
on_loss = 1
[[io]]
name = "dog"
device = { type = "gpiochip", chip = "none", output = 3 }
signal = "cell.watchdog"
"""
    with runtime_folder():
        plan = plan_run(load_cell(str(cell_copy("cl300-bits", tmp_path, more=more))), simulated=False, slug="chips")
        assert [child.name for child in plan.children][-1] == "chips"
        fds = make_regions(plan)
        try:
            axes, pack = RegionWriter(fds["axes"], "axes"), cell_state_packer(len(plan.cell.axis))
            chips = Chips(plan, fds)
            chip = Watched(chips.chips[0].path, chips.chips[0].contacts)
            chips.chips[0] = chip
            shown = chip.shown
            for cycle in (2, 3, 4, 5, 6):
                axes.write(pack(CellState(cycle=cycle, ready=True)), time.monotonic_ns())
                axes.beat(time.monotonic_ns())
                chips.turn(time.monotonic_ns())
            assert [each[2] for each in shown] == [bool(cycle // 2 & 1) for cycle in (2, 3, 4, 5, 6)] and all(each[0] for each in shown)
            chips.turn(time.monotonic_ns() + 10**9)
            assert shown[-1] == {0: False, 1: True, 2: shown[-2][2]}
            heard = RegionReader(fds["io_chip"], "io_chip").read()
            assert heard is not None and unpack_said(heard)[:2] == [Said(True, Quality.GOOD), Said()]
        finally:
            for fd in fds.values():
                os.close(fd)


def test_a_simulated_run_touches_no_chip() -> None:
    cell = load_cell("cl300-bits")
    device = IoDevice("gpiochip", output=1, chip="/dev/gpiochip0")
    with runtime_folder():
        plan = plan_run(dataclasses.replace(cell, io=(Io("lamp", device, "cell.ready"),)), simulated=True, slug="sim")
        assert "chips" not in [child.name for child in plan.children]
