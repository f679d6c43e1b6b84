"""Tools at a run: what they ask, what they get wrong, and that none of them disturbs the processes (one run for all)."""

import contextlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import pytest

from drivers.emulator.servo.record import read
from drivers.ports.base import PortError, runtime_dir
from gateway.runtime.supervisor_client import ask
from hil_tests.lab.running.bus_running import running_bus
from hil_tests.lab.running.cell_running import P5_MS, CellRun, gone, left_over, running_cell, runtime_folder, special_files

LIMIT_S = 60
P5_TOOLS_MS = max(P5_MS, 20)  # tools look at it: no cycle here needs to be short, and a long one leaves them the processor


@pytest.fixture(scope="module")
def run() -> Iterator[CellRun]:
    with running_cell(name="tools", p5_ms=P5_TOOLS_MS) as running:
        yield running


def axisgate(*arguments: str) -> tuple[int, str, str]:
    """Exit code, standard output, standard error."""
    command = [sys.executable, "-m", "gateway", *arguments]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=LIMIT_S, check=False)
    return done.returncode, done.stdout.strip(), done.stderr.strip()


READ = [
    ("DB11.DW2", "DB11.DW2 = "),
    ("axis.A1.actual", "axis.A1.actual = "),
    ("cell.ready", "cell.ready = 1"),
    ("E 8.0", "RC output 64 (I8.0, READY_RCO) = 1"),
    ("RC out 1.1", "RC output 64 (I8.0, READY_RCO) = 1"),
    ("A 8.0", "RC input 64 (O8.0) = 0"),
    ("10065", "discrete 64 = 1"),
    ("00025", "coil 24 = 1"),
    ("30001", "input 0 = "),
    ("40001", "holding 0 = "),
    ("K01_A_MN_RCI", "RC input 38 (O4.6, K01_A_MN_RCI) = 0"),
    ("DB12.DD0", "DB12.DD0 = 0 mm   (DH 0, KH 00000000, KG 0.0, REAL 0.0)"),
]
WRONG = [
    (("nonsense",), "'nonsense': expected DB10.DW2"),
    (("axis.A9.actual",), "axis.A9.actual: no such name, did you mean"),
    (("DB99.DW0",), "DB 99: no line of this cell serves it"),
    (("DB10.DW200",), "DB10.DW200: the block has 32 words"),
    (("49999",), "49999: holding 9998 does not exist"),
    (("E 200.0",), "RC output 1600: bit numbers are 0..1023"),
    (("DB10.DW2", "--set", "70000"), "DB10.DW2 = 70000: a DW takes -32768..65535"),
    (("DB10.DW2", "--set", "far"), "DB10.DW2 = 'far': a whole number is expected"),
    (("DB10.D0.8", "--set", "2"), "DB10.D0.8 = 2: a DW takes"),
    (("DB11.DW2", "--set", "1"), "DB 11 DW 2: refused with RK512 error 0Ah"),
    (("axis.A1.actual", "--set", "1"), "axis.A1.actual: a data word or bit a PLC writes is expected"),
]


@pytest.mark.parametrize("address, says", READ)
def test_var_reads_every_kind_of_address(run: CellRun, address: str, says: str) -> None:
    code, out, err = axisgate("var", address)
    assert (code, err) == (0, "") and out.startswith(says), out


@pytest.mark.parametrize("arguments, says", WRONG)
def test_var_says_what_is_wrong_in_one_line(run: CellRun, arguments: tuple[str, ...], says: str) -> None:
    code, out, err = axisgate("var", *arguments)
    assert (code, out) == (2, "") and err.startswith(f"axisgate var: {says}") and "\n" not in err, err


def test_var_writes_as_the_plc_would_and_speaks_json(run: CellRun) -> None:
    code, out, _ = axisgate("var", "DB10.DW2", "--set", "-1200")
    assert (code, out) == (0, "DB10.DW2 = -1200 x 0.1 mm   (KF -1200, KH FB50, KM 1111101101010000)")
    code, out, _ = axisgate("var", "DB10.DW2", "--json")
    found = json.loads(out)
    assert (code, found["value"], found["KH"], found["source"]) == (0, -1200, "FB50", "plc1")
    assert "axis.A6.in_position" in axisgate("var")[1].splitlines()


def test_var_knows_which_runs_are_up(run: CellRun) -> None:
    code, out, err = axisgate("var", "cell.ready", "--name", "other")
    assert (code, out) == (3, "") and err == "axisgate var: no run 'other' is active; active: tools; choose one: --name NAME"
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind(str(runtime_dir() / "crashed-services.sock"))
    assert axisgate("var", "cell.ready") == (0, "cell.ready = 1", ""), "a socket without a listener is not a run"
    os.unlink(runtime_dir() / "crashed-services.sock")


def test_a_second_run_of_that_name_is_refused_in_one_line(run: CellRun) -> None:
    code, _, err = axisgate("run", "demo", "--sim", "--name", "tools")
    assert code == 3 and err.count("\n") == 0
    assert err.endswith("tools.sock: a run of cell 'tools' is already up; stop it first (Ctrl-C there)")


@pytest.mark.parametrize(
    "arguments, code, says",
    [
        (("no-such-cell",), 2, "no-such-cell: no such file; looked for"),
        (("demo", "--sim", "--p5", "99"), 2, "--p5 99: the cycle is 2..32 ms"),
        (("demo", "--sim", "--p5", "1"), 2, "--p5 1: the cycle is 2..32 ms"),
    ],
)
def test_run_refuses_in_words(arguments: tuple[str, ...], code: int, says: str) -> None:
    found, out, err = axisgate("run", *arguments)
    assert (found, out) == (code, "") and says in err and err.count("\n") == 0, err


# ---- the supervisor's own socket --------------------------------------------------------------------------------------
def talk(octets: bytes) -> bytes:
    """What the supervisor answers until it hangs up."""
    with socket.socket(socket.AF_UNIX) as tool:
        tool.settimeout(5)
        tool.connect(str(runtime_dir() / "tools.sock"))
        tool.sendall(octets)
        tool.shutdown(socket.SHUT_WR)
        return b"".join(iter(lambda: tool.recv(4096), b""))


@pytest.mark.parametrize("octets", [b"{", b"[1]", b"\xff\xfe", b"\n", b'"op"', b"x" * 4096, b'{"op": "status"'])
def test_junk_is_told_apart_and_ends_nothing(run: CellRun, octets: bytes) -> None:
    before = {name: process["pid"] for name, process in run.processes().items()}
    assert b"error" in talk(octets)
    assert b"op 'dance'" in talk(b'{"op": "dance"}')
    assert talk(b'{"op": "hold", "process": "nobody"}') == b'{"ok": false}\n'
    assert talk(b"") == b""
    assert {name: process["pid"] for name, process in run.processes().items()} == before


def test_tools_that_say_nothing_delay_neither_tools_nor_the_watch(run: CellRun) -> None:
    mute = [socket.socket(socket.AF_UNIX) for _ in range(10)]
    try:
        for tool in mute:
            tool.connect(str(runtime_dir() / "tools.sock"))
        mute[0].sendall(b'{"op": ')  # half a request
        start = time.monotonic()
        with ask("tools", "status") as connection:
            assert connection.recv(4096)
        assert time.monotonic() - start < 0.25, "one of ten mute tools would have cost 50 ms"
        dead, at = run.kill("line-plc1")
        run.back("line-plc1", dead)
        buried = next(entry for entry in run.journal("process") if entry["ns"] > at)
        assert (buried["ns"] - at) / 1e6 < 50 + 50, "seen within one turn; the rest is the machine"
        mute[1].settimeout(5)
        assert mute[1].recv(1) == b"", "sent away after a while"
    finally:
        for tool in mute:
            tool.close()


def test_a_tool_waits_behind_tools_that_were_not_accepted_yet() -> None:
    with runtime_folder(), socket.socket(socket.AF_UNIX) as late, contextlib.ExitStack() as tools:
        late.bind(str(runtime_dir() / "late.sock"))
        late.listen(1)
        for _ in range(2):  # the queue is full
            tools.enter_context(ask("late", "status"))
        with pytest.raises(PortError, match="no run 'late' answers"):
            ask("late", "status", timeout_s=0.1)
        accepting = threading.Timer(0.1, lambda: tools.enter_context(late.accept()[0]))
        accepting.start()
        tools.enter_context(ask("late", "status", timeout_s=5.0))
        accepting.join()


# ---- the end ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_run_in_order(number: signal.Signals) -> None:
    with runtime_folder() as folder:
        running = CellRun(folder, "demo", "ending")
        assert left_over(folder) and special_files(folder)
        assert running.stop(number) == 0
        gone(folder, 0.5)
        assert special_files(folder) == []


def test_emulate_plays_the_drives_of_a_cell_on_a_bus_of_its_own(tmp_path: pathlib.Path) -> None:
    record = tmp_path / "plant.rec"
    with running_bus(tmp_path, log=False, name="own"):
        command = [sys.executable, "-m", "gateway", "emulate", "demo", "--bus", "broker:own", "--record", str(record)]
        emulating = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert emulating.stdout is not None
        said = [emulating.stdout.readline() for _ in range(5)]
        assert said[0].startswith("axisgate is not a safety device") and said[4] == "ready\n", said
        emulating.send_signal(signal.SIGINT)
        assert emulating.wait(10) == 0
        emulating.stdout.close()
    assert read(record.read_bytes()).axes == (1, 2, 3, 4, 5, 6)
