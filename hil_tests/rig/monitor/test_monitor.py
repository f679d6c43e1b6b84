"""The monitor and its pendant at a really running cell: through Textual's own hands, in a real pty, and through a pipe."""

import asyncio
import contextlib
import fcntl
import json
import os
import pathlib
import pty
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Coroutine, Iterator
from typing import Any

import pytest
from pymodbus.client import ModbusTcpClient

from drivers.ports.base import runtime_dir
from gateway.commands.monitor import main
from gateway.runtime.supervisor_client import ask
from gateway.tools.monitor.app import Monitor
from gateway.tools.monitor.look import Look
from gateway.tools.monitor.pendant import Pendant
from gateway.tools.monitor.widgets import Help
from hil_tests.lab.partners.signal_plc import signal_cell
from hil_tests.lab.running.cell_running import P5_MS, CellRun, running_cell

PATIENCE_S = 60.0
CONTROL = """
kind = "rho3"
[[controller.process]]
name = "PICK"
steps = [ { wait_ms = 1 }, { input = 5 } ]
"""
SHOWN_IN = '  { at = "DD 2", type = "DH", from = "MD 40" },\n'
BLOCK_ENTRIES = """
  { at = "DD 4", type = "REAL", from = "phg.33289.1.2" },
  { at = "DW 6", type = "KF", from = "phg.33297" },
"""
BESIDE = 'bind = "127.0.0.1:1502"\nmax_silence_ms = 8000\n'
REGISTERS = """
[[modbus.registers]]
at = 2000
from = "phg.33289.1.2"
[[modbus.registers]]
at = 2002
from = "phg.33793"
[[modbus.registers]]
at = 2004
from = "phg.33297"
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[CellRun]:
    """Two axes, a rho 3 control, two command sources nobody speaks to: EMERGENCY STOP stands."""
    path = pathlib.Path(signal_cell(tmp_path_factory.mktemp("see"), "net", CONTROL))
    text = path.read_text()
    assert text.count(SHOWN_IN) == text.count(BESIDE) == 1
    path.write_text(text.replace(SHOWN_IN, SHOWN_IN + BLOCK_ENTRIES).replace(BESIDE, BESIDE + REGISTERS))
    with running_cell(str(path), "see", plc=False, p5_ms=max(10, P5_MS)) as run:
        yield run


async def until(pilot: Any, holds: Callable[[], object], what: str) -> None:
    """Waits for a condition; the app goes on meanwhile."""
    end = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end, f"not within {PATIENCE_S:.0f} s: {what}"
        await asyncio.sleep(0.05)


def played(look: Look, play: Callable[[Monitor, Any], Coroutine[Any, Any, None]]) -> None:
    """The monitor attached to the run, and somebody's hands."""

    async def play_it() -> None:
        await look.attach()
        app = Monitor(look)
        async with app.run_test(size=(160, 44)) as pilot:
            await play(app, pilot)
        look.close()

    asyncio.run(play_it())


def held(run: CellRun, op: str) -> None:
    """The emulated drives are taken out of the run, or put back."""
    process = next(name for name in run.processes() if name.startswith("emulator"))
    with ask(run.name, op, process=process) as connection:
        assert json.loads(connection.makefile().readline()) == {"ok": True}


def cells(app: Monitor, table: str) -> list[list[str]]:
    """Rows of a table as they stand on the screen."""
    shown = app.sources if table == "lines-sources" else app.tables[table.removeprefix("table-")]
    return [[str(cell) for cell in shown.get_row_at(row)] for row in range(shown.row_count)]


def test_tabs_show_axes_signals_lines_and_errors_live(run: CellRun) -> None:
    async def play(app: Monitor, pilot: Any) -> None:
        await until(pilot, lambda: [row[0] for row in cells(app, "table-axes")] == ["A1", "A2"], "both axes")
        looks = app.looks
        await until(pilot, lambda: app.looks > looks + 3, "it goes on looking")
        head = str(app.line.content)
        assert head.startswith("see (simulated) | ") and "drives 0/2" in head and "control: not in use" in head
        await pilot.press("4")
        await until(pilot, lambda: cells(app, "table-errors")[0][0] == "no error pending", "no error")
        held(run, "hold")
        await until(pilot, lambda: any("A2" in row[2] for row in cells(app, "table-errors")), "the drives are lost")
        row = next(row for row in cells(app, "table-errors") if "A2" in row[2])
        assert row[0] == "axisgate" and row[3] and row[4], "cause and what to do"
        await pilot.press("1")
        await until(pilot, lambda: [row[8] for row in cells(app, "table-axes") if "no telegram" in row[8]], "it stands at the axes")
        held(run, "release")
        await pilot.press("3")
        await until(pilot, lambda: [row[1] for row in cells(app, "lines-sources")] == ["rack", "net"], "both command sources")
        assert [row[3] for row in cells(app, "lines-sources")] == ["DOWN", "DOWN"]

    played(Look("see"), play)


def test_signals_are_searched_filtered_and_held(run: CellRun) -> None:
    async def play(app: Monitor, pilot: Any) -> None:
        await pilot.press("slash")
        assert app.tabs.active == "signals" and app.box.has_focus
        await pilot.press(*"A1.actual")
        await until(pilot, lambda: [row[0] for row in cells(app, "table-signals")] == ["axis.A1.actual"], "the one that fits")
        await until(pilot, lambda: cells(app, "table-signals")[0][3] == "good", "its quality")
        await pilot.press("enter", "escape")
        await until(pilot, lambda: len(cells(app, "table-signals")) == 200, "the first of all")
        await pilot.press("f", "f")
        assert app.look.filter == "forced"
        await until(pilot, lambda: cells(app, "table-signals")[0][0] == "nothing fits search and filter", "nothing is forced")
        await pilot.press("space")
        looks = app.looks
        await asyncio.sleep(0.5)
        assert app.held and app.looks == looks
        await pilot.press("space", "question_mark")
        assert isinstance(app.screen, Help)
        looks = app.looks
        await until(pilot, lambda: app.looks > looks + 2, "it goes on looking behind the keys")
        await pilot.press("escape", "q")

    played(Look("see"), play)


def test_requests_to_a_modbus_server_are_among_what_was_said_on_the_lines(run: CellRun) -> None:
    client: Any = ModbusTcpClient("127.0.0.1", port=run.port, timeout=10)
    assert client.connect() and client.read_holding_registers(2000, count=2).isError() is False
    assert client.read_holding_registers(9999, count=1).exception_code == 2
    client.close()
    done = axisgate("monitor", "see", "--once", "--tab", "lines")
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    rows = [line.split() for line in done.stdout.splitlines() if "FC 3" in line]
    assert any("2000..2001:" in row for row in rows) and any(row[-3:] == ["illegal", "data", "address"] for row in rows), done.stdout


def test_a_search_over_the_services_death_goes_on_by_itself(run: CellRun) -> None:
    async def play(app: Monitor, pilot: Any) -> None:
        await pilot.press("3")
        await until(pilot, lambda: len(cells(app, "lines-sources")) == 2, "the command sources")
        dead = run.pid("services")
        run.hold("services")  # killed, they would be back before anybody saw that they were gone
        await until(pilot, lambda: "SERVICES SILENT" in str(app.line.content), "their silence is told")
        run.forgive("services")
        await until(pilot, lambda: "SERVICES SILENT" not in str(app.line.content), "they are back")
        assert run.processes()["services"]["pid"] != dead

    played(Look("see"), play)


def axisgate(*words: str, **environment: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-m", "gateway", *words],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        env={**os.environ, **environment},
        check=False,
    )


def test_the_pendant_shows_and_takes_keys(run: CellRun) -> None:
    async def play_it() -> None:
        app = Pendant("see")
        async with app.run_test(size=(80, 34)) as pilot:

            def line(number: int) -> str:
                text: str = app.shown["screen"][number - 1]
                return text.rstrip()

            async def shows(number: int, words: str) -> None:
                await until(pilot, lambda: line(number) == words, f"line {number}: {words!r}, not {app.shown['screen']}")

            await pilot.press("m", "0", "enter")
            await shows(1, "Basic level")
            await shows(2, "Manual")
            await pilot.press("m", *"7", "full_stop", "3", "full_stop", "2")
            await shows(4, "Mode=7.3.2")
            await pilot.press("enter")
            await shows(1, "7.3.2 Process condit")
            await pilot.press("m", *"0", "full_stop", "1", "0", "full_stop", "1", "enter", "enter")
            await shows(3, "started")
            await pilot.press("m", *"0", "full_stop", "1", "0", "full_stop", "2", "enter")
            await shows(2, "PICK")
            await pilot.press("enter")
            await shows(3, "stopped")
            await pilot.press("m", *"0", "full_stop", "7", "enter", "1")
            await pilot.click("#key-19")
            await shows(1, "7.1 Axis display")
            assert line(2).startswith("A1") and line(2).endswith("mm")
            await pilot.press("m", *"01", "backspace", "full_stop", "1", "enter", "i")
            await shows(1, "INFO")
            assert line(2) in ("no reference points", "notINPOS of all axis", "CONTRL.ALLOW n.avail", "FEED HOLD", "FEED ALLOW n.avail.")
            await pilot.press("left", "m", "0", "enter")
            await shows(1, "Basic level")
            await pilot.press("m", "1", "1", "full_stop", "1", "enter")
            await until(pilot, lambda: app.shown["screen"][2].strip() != "", "the reset is refused without control")
            assert app.shown["mode"] == "0"
            await pilot.press("f2")
            await until(pilot, lambda: app.holds, "control")
            await pilot.press("m", "1", "1", "full_stop", "1", "enter")
            await until(pilot, lambda: app.shown["mode"] == "11.1", "the reset")
            await pilot.press("m", "0", "enter", "f2")
            await until(pilot, lambda: not app.holds, "control given back")
        app.link.close()

    asyncio.run(play_it())


def test_through_a_pipe_it_is_plain_text_without_colours_or_one_object(run: CellRun, capsys: pytest.CaptureFixture[str]) -> None:
    done = axisgate("monitor", "see", FORCE_COLOR="1", COLORTERM="truecolor")
    assert (done.returncode, done.stderr) == (0, "") and "\033" not in done.stdout
    assert (
        all(title in done.stdout for title in ("Axes\n", "Command sources", "Errors, first one first\n")) and "Signals" not in done.stdout
    )

    def said(*words: str, code: int = 0) -> tuple[str, str]:
        assert main(["see", *words]) == code
        return capsys.readouterr()

    told = json.loads(said("--json", "--tab", "signals", "--search", "RCI 24")[0])
    assert told["signals"][0]["name"] == "EMSTOP_OK_RCI" and told["head"]["run"] == "see"
    assert json.loads(said("--press", "MODE 0.7.3.3 ENTER", "--json")[0])["screen"][0] == "7.3.3 Operating mode"
    assert "│Basic level         │" in said("--press", "MODE 0 ENTER")[0]
    assert "'+'" in said("--press", "7+", code=2)[1]
    assert main(["nobody"]) == 3
    assert "active: see" in capsys.readouterr().err


def screen_of(keys: str, run: str, *options: str) -> Iterator[str]:
    """The command in a pty of its own: all it has drawn so far, without control sequences; a key of `keys` after each word asked for."""
    pid, fd = pty.fork()
    if pid == 0:
        os.environ.update(TERM="xterm-256color", COLUMNS="140", LINES="40")
        os.execv(sys.executable, [sys.executable, "-m", "gateway", "monitor", run, *options])
    fcntl.ioctl(fd, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 140, 0, 0))
    try:
        yield from drawn(fd, keys)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        os.close(fd)


def drawn(fd: int, keys: str) -> Iterator[str]:
    raw, waiting, end = b"", list(keys), time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        if select.select([fd], [], [], 0.1)[0]:
            try:
                raw += os.read(fd, 65536)
            except OSError:  # its end is closed: it has ended
                return
        text = re.sub(
            r"\x1b(\[[0-9;?<>=]*[ -/]*[@-~]|[()][A-Z0-9]|\][^\x07]*\x07|P[^\x1b]*\x1b\\|[=>78c])", " ", raw.decode(errors="replace")
        )
        if (yield text) and waiting:
            os.write(fd, waiting.pop(0).encode())
            raw = b""
    raise AssertionError(f"not within {PATIENCE_S:.0f} s; on the screen: {text[-2000:]}")


def dialogue(screens: Iterator[str], *words: str) -> None:
    """Each word comes to stand on the screen, then the next key goes out; the command ends after the last."""
    generator: Any = screens
    text = next(generator)
    for word in words:
        while word not in text:
            text = generator.send(False)
        text = generator.send(True)
    with contextlib.suppress(StopIteration):
        while True:
            generator.send(False)


@pytest.mark.parametrize("end", ["\x11", "\x03"], ids=["ctrl-q", "ctrl-c"])
def test_the_pendant_in_a_real_terminal(run: CellRun, end: str) -> None:
    """Its display, a mode chosen by direct selection, and its end."""
    assert main(["see", "--press", "MODE 0 ENTER"]) == 0, "from the basic level: the panel keeps its mode between two terminals"
    dialogue(screen_of(f"m7.1\r{end}", "see", "--pendant"), "Basic level", *["Mode="] * 4, "7.1 Axis display")


def test_variables_of_the_phg_are_in_registers_blocks_and_var(run: CellRun) -> None:
    with ModbusTcpClient("127.0.0.1", port=run.port) as client:

        def real(at: int) -> float:
            words = client.read_holding_registers(at, count=2).registers
            found: float = struct.unpack(">f", struct.pack(">HH", *words))[0]
            return found

        assert (real(2000), client.read_holding_registers(2004, count=1).registers) == (2000.0, [2])
        assert told(run, op="set", address="phg.33793", value="0.25")["value"] == 0.25
        assert real(2002) == 0.25, "VFACTOR, written by one and read by the other"
    assert told(run, op="get", address="DB31.DD4")["REAL"] == 2000.0 and told(run, op="get", address="DB31.DW6")["KF"] == 2
    assert told(run, op="get", address="phg.33291.1.2") == {
        "address": "phg.33291.1.2",
        "place": "phg.33291.1.2 (Axis names)",
        "value": "A2",
    }
    assert "is only read" in told(run, op="set", address="phg.33028.0", value="1")["error"]
    assert "this control has none" in told(run, op="get", address="phg.33285.1")["error"]
    assert told(run, op="set", address="phg.33793", value="1")["value"] == 1.0


def told(run: CellRun, **request: str) -> dict[str, Any]:
    """One question of a tool."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as link:
        link.connect(str(runtime_dir() / f"{run.name}-services.sock"))
        link.sendall(json.dumps(request).encode() + b"\n")
        found: dict[str, Any] = json.loads(link.makefile().readline())
        return found


def test_looking_gave_no_command_and_no_life(run: CellRun) -> None:
    assert [entry["text"] for entry in run.journal() if entry.get("source") == 91] == []
