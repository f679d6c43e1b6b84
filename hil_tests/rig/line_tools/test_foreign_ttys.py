"""Every tool at a terminal that is not ours: a pty opened under its own name, a station written by hand behind it; and at a real UART."""

import asyncio
import contextlib
import io
import json
import os
import pathlib
import select
import termios
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest

from drivers.ports.base import PortError
from drivers.ports.open import open_bytes
from drivers.ports.serial.device import SerialPort
from drivers.ports.serial.line_format import parse_format
from gateway.commands import doctor, line
from gateway.pure.lines.decoder import LineReport
from gateway.pure.lines.rk512_link import Rk512Link
from gateway.shadow.taps import TapPair
from gateway.tools.line.ports import open_port, open_wire
from hil_tests.lab.partners.foreign_station import ForeignStation
from hil_tests.lab.partners.sync_line import SyncLine
from hil_tests.lab.virtual.rk512_blocks import Blocks
from protocols.base.machine import ms
from protocols.p3964r.profiles import RHO3, Priority
from protocols.rk512.active import Done

UART = "/dev/ttyS0"
COMMAND = b"\x02\x00\x00ED\x0a\x00\x00\x02\xff\xff\x10\x03\x1a"
REACTION = b"\x02" + bytes(4) + b"\xff\xff\x10\x10\xff\xff\x10\x03\x13"


def has_uart() -> bool:
    try:
        fd = os.open(UART, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError:
        return False
    try:
        termios.tcgetattr(fd)
    except termios.error:
        return False
    finally:
        os.close(fd)
    return True


PLACES = ["", "pty:"]


@dataclass(frozen=True)
class Ran:
    """A command as a user types it, in this process: what it printed, and its exit code."""

    returncode: int
    stdout: str
    stderr: str


def axisgate(command: str, *words: str, folder: pathlib.Path | None = None) -> Ran:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), contextlib.chdir(folder or pathlib.Path.cwd()):
        code = {"line": line.main, "doctor": doctor.main}[command](list(words))
    return Ran(code, out.getvalue(), err.getvalue())


@pytest.fixture
def station() -> Iterator[ForeignStation]:
    with ForeignStation() as running:
        yield running


@pytest.mark.parametrize("kind", PLACES)
@pytest.mark.parametrize("line_format", ["9600 8E1", "9600 8N1"])
def test_fetch_and_send(station: ForeignStation, kind: str, line_format: str) -> None:
    port = f"{kind}{station.path}"
    brought = axisgate("line", "fetch", port, "DB10.DW0", "--count", "2", "--format", line_format, "--json")
    assert brought.returncode == 0, brought.stderr
    assert [one["bytes"] for one in json.loads(brought.stdout)] == ["ffff", "10ff"], "FF is FF, both of two"
    sent = axisgate("line", "send", port, "DB10.DW3", "--type", "KH", "FFFF", "00FF", "FF00", "--format", line_format)
    assert sent.returncode == 0, sent.stderr
    assert bytes(station.block[6:12]) == b"\xff\xff\x00\xff\xff\x00"


@pytest.mark.parametrize("kind", PLACES)
def test_the_probe_runs_to_its_end(station: ForeignStation, kind: str, tmp_path: pathlib.Path) -> None:
    only = [word for name in ("idle.nak", "idle.break", "receive.gap-in-data", "receive.parity-in-data", "rk512.fetch", "rk512.send")
            for word in ("--only", name)]  # fmt: skip
    done = axisgate("line", "probe", f"{kind}{station.path}", *only, "--write", "--report", "r", folder=tmp_path)
    verdicts = {test["name"]: test["verdict"] for test in json.loads((tmp_path / "r.json").read_text())["tests"]}
    assert done.returncode == 0, done.stdout + done.stderr
    assert verdicts["rk512.fetch"] == verdicts["rk512.send"] == "PASS", done.stdout
    assert verdicts["receive.parity-in-data"] == verdicts["idle.break"] == "NOT RUN", "a pty has neither parity nor BREAK"


@pytest.mark.parametrize("kind", PLACES)
def test_diagnose_finds_nothing_wrong(station: ForeignStation, kind: str) -> None:
    done = axisgate("line", "diagnose", f"{kind}{station.path}", "--json")
    found = {one["name"]: one["level"] for one in json.loads(done.stdout)}
    assert done.returncode == 0 and "fault" not in found.values(), done.stdout + done.stderr


def heard(text: str) -> int:
    return text.count("FETCH")


def play(*stations: ForeignStation, what: tuple[bytes, ...], after: float) -> threading.Thread:
    """The stations say something, later: the tool is there by then."""

    def later() -> None:
        time.sleep(after)
        for _ in range(3):
            for station, data in zip(stations, what, strict=True):
                for byte in data:
                    station.say(bytes((byte,)))
                    time.sleep(0.002)
            time.sleep(0.3)

    thread = threading.Thread(target=later, daemon=True)
    thread.start()
    return thread


@pytest.mark.parametrize("kind", PLACES)
def test_monitor_of_one_port_and_of_two_taps(kind: str, tmp_path: pathlib.Path) -> None:
    with ForeignStation(answers=False) as near, ForeignStation(answers=False) as far:
        playing = play(near, far, what=(COMMAND, b"\x10"), after=0.5)
        one = axisgate("line", "monitor", f"{kind}{near.path}", "--seconds", "3", "--json")
        playing.join()
        assert one.returncode == 0 and heard(one.stdout) >= 1, one.stdout + one.stderr
        playing = play(near, far, what=(b"\x10" + COMMAND, b"\x02" + b"\x10"), after=0.5)
        taps = f"{kind}{near.path},{kind}{far.path}"
        two = axisgate("line", "monitor", "--tap", taps, "--seconds", "3", "--json", "--save", "l.rec", folder=tmp_path)
        playing.join()
        assert two.returncode == 0, two.stderr
        assert {json.loads(line)["side"] for line in two.stdout.splitlines()} == {"A", "B"}
        assert (tmp_path / "l.rec").read_text().count(" A ") == 3 * len(b"\x10" + COMMAND)


@pytest.mark.parametrize("kind", PLACES)
def test_learn_from_living_taps(kind: str, tmp_path: pathlib.Path) -> None:
    with ForeignStation(answers=False) as near, ForeignStation(answers=False) as far:
        steps = [(near, COMMAND[:1]), (far, b"\x10"), (near, COMMAND[1:]), (far, b"\x10" + REACTION[:1]), (near, b"\x10"),
                 (far, REACTION[1:]), (near, b"\x10")]  # fmt: skip

        def later() -> None:
            time.sleep(0.5)
            for _ in range(4):
                for side, data in steps:
                    side.say(data)
                    time.sleep(0.03)
                time.sleep(0.3)

        thread = threading.Thread(target=later, daemon=True)
        thread.start()
        taps = f"{kind}{near.path},{kind}{far.path}"
        done = axisgate("line", "learn", "--tap", taps, "--seconds", "3", "-o", "cell.toml", folder=tmp_path)
        thread.join()
    assert done.returncode == 0, done.stderr
    assert "number = 10" in " ".join((tmp_path / "cell.toml").read_text().split())


def test_doctor_measures_an_echo() -> None:
    master, slave = os.openpty()
    over = threading.Event()

    def echo() -> None:
        while not over.is_set():
            if select.select([master], [], [], 0.05)[0]:
                os.write(master, os.read(master, 64))

    thread = threading.Thread(target=echo, daemon=True)
    thread.start()
    done = axisgate("doctor", "serial", os.ttyname(slave), "--count", "50", "--seconds", "0.2", "--json")
    over.set()
    thread.join()
    assert done.returncode in (0, 1) and "adapter echo" in json.loads(done.stdout)["figures"], done.stdout + done.stderr
    os.close(master)
    os.close(slave)


def test_taps_of_a_shadow_hear_both_sides() -> None:
    tolds: list[LineReport] = []

    async def listen(near: ForeignStation, far: ForeignStation) -> str:
        taps = TapPair((near.path, far.path), "9600 8E1", time.monotonic_ns, tolds.append)
        assert taps.connected, taps.why
        for data in (COMMAND[:1], COMMAND[1:]):
            near.say(data)
            await asyncio.sleep(0.05)
            far.say(b"\x10")
            for _ in range(20):
                await asyncio.sleep(0.02)
                taps.turn()
        why = taps.why
        taps.close()
        return why

    with ForeignStation(answers=False) as near, ForeignStation(answers=False) as far:
        assert asyncio.run(listen(near, far)) == ""
    assert any(told.kind == "BLOCK" and told.side == "A" for told in tolds), tolds


@pytest.mark.parametrize("kind", PLACES)
def test_a_far_end_that_goes_away_is_reported_at_once(kind: str) -> None:
    master, slave = os.openpty()
    port = open_port(f"{kind}{os.ttyname(slave)}")
    os.close(slave)
    assert port.read() == []
    os.close(master)
    with pytest.raises(PortError, match="lost"):
        port.read()
    port.close()


@pytest.mark.parametrize("kind", PLACES)
def test_settings_somebody_else_changes_do_not_hang_the_port_up(kind: str) -> None:
    """`stty` at an open port sets VMIN 0: an empty read is not a hang-up."""
    master, slave = os.openpty()
    port = open_bytes(f"{kind}{os.ttyname(slave)}", "9600 8E1")
    settings = termios.tcgetattr(slave)
    settings[6][termios.VMIN] = 0
    termios.tcsetattr(slave, termios.TCSANOW, settings)
    assert port.read() == []
    os.write(master, b"\xff\x00U")
    assert port.read() == [b"\xff\x00U"]
    port.close()
    os.close(master)
    os.close(slave)


@pytest.mark.skipif(not has_uart(), reason=f"no UART at {UART}")
def test_a_real_uart_is_silent_and_not_gone() -> None:
    try:
        port = SerialPort(UART, parse_format("9600 8E1"))
    except PortError as error:
        pytest.skip(str(error))
    try:
        for _ in range(20):
            assert all(isinstance(item, bytes) for item in port.read())
            time.sleep(0.01)
    finally:
        port.close()
    wire = open_wire(UART, "9600 8E1")
    wire.hear(wire.now() + ms(200))
    wire.close()


@pytest.mark.skipif(not has_uart(), reason=f"no UART at {UART}")
def test_the_tools_at_a_real_uart_do_not_call_it_gone() -> None:
    for words in (("monitor", UART, "--seconds", "0.3"), ("fetch", UART, "DB10.DW0"), ("diagnose", UART, "--no-scan")):
        done = axisgate("line", *words)
        assert "lost (" not in done.stderr + done.stdout and done.returncode != 3, done.stderr


@pytest.mark.parametrize("kind", PLACES)
def test_a_cell_with_a_paced_format_takes_the_early_acknowledgement(station: ForeignStation, kind: str) -> None:
    """AX-652: 74 characters at 300 baud would take 2.7 s; the far end has them at once and says so."""
    machine = Rk512Link(RHO3, Priority.LOW, Blocks({}))
    with SyncLine[Any](open_bytes(f"{kind}{station.path}", "300 8E1"), machine) as running:
        job = machine.active.send(4, bytes(range(64)), 10)
        machine.start(time.monotonic_ns())
        assert running.run_until(lambda: bool(running.events), 10)
    assert [event for _, event in running.events] == [Done(job, b"")] and len(station.heard) == 1
