"""`axisgate conformance` at a pty: a station written by hand, in real time, that shares nothing with our protocols; servers on TCP."""

import contextlib
import json
import os
import pathlib
import pty
import socket
import subprocess
import sys
import threading
from typing import Any

import pytest

from hil_tests.lab.partners.foreign_station import ForeignStation

LIMIT = 200


def run(*argv: str) -> tuple[int, dict[str, Any]]:
    program = "import sys; from gateway.commands.conformance import main; sys.exit(main(sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, "-c", program, "run", *argv, "--json"], capture_output=True, text=True, timeout=LIMIT, check=False
    )
    assert done.stdout, done.stderr
    return done.returncode, json.loads(done.stdout)


def verdicts(found: dict[str, Any]) -> dict[str, str]:
    return {case["id"]: case["verdict"] for case in found["cases"]}


def test_a_foreign_station_gets_its_verdicts(tmp_path: pathlib.Path) -> None:
    """It takes a DLE that is not doubled, and knows no DLE ETB; FF comes plainly over this pty."""
    with ForeignStation() as station:
        bench = tmp_path / "bench.toml"
        bench.write_text(f'[port]\nurl = "pty:{station.path}"\n[link]\nprofile = "rho3"\npriority = "high"\n[touch]\ndb = [10]\n')
        only = "3964R_RCV_BV_*", "3964R_RCV_TI_01", "3964R_RCV_BI_06", "3964R_RCV_BI_01", "3964R_SND_BV_*", "3964R_SND_TI_01"
        chosen = [option for name in only for option in ("--only", name)]
        code, found = run("3964r", "--bench", str(bench), *chosen)
    got = verdicts(found)
    assert code == 1 and [name for name, verdict in got.items() if verdict == "FAIL"] == ["3964R_RCV_BI_06"]
    assert got["3964R_RCV_TI_01"] == "PASS" and got["3964R_SND_TI_01"] == "PASS"
    case = next(case for case in found["cases"] if case["id"] == "3964R_RCV_TI_01")
    measure = next(measure for measure in case["measures"] if measure["min_ms"])
    assert 200 < measure["ms"] < 241.2 and measure["uncertainty_ms"] > 0 and measure["clock"] != "virtual"
    assert found["self_check"]["echo"] is False


def test_a_foreign_station_talks_to_the_stations_of_the_makers(tmp_path: pathlib.Path) -> None:
    """In real time, both ways: blocks, a lost acknowledgement, a FETCH in the maker's dialect."""
    with ForeignStation() as station:
        bench = tmp_path / "bench.toml"
        bench.write_text(f'[port]\nurl = "pty:{station.path}"\n[link]\nprofile = "rho3"\npriority = "high"\n[touch]\ndb = [10]\n')
        only = [f"INTEROP_SIEMENSCP341_{row}" for row in ("BV_01", "BV_02", "BI_01", "BI_03", "BV_11", "BV_12")]
        code, found = run("interop", "--bench", str(bench), *(option for name in only for option in ("--only", name)))
    assert (code, verdicts(found)) == (0, dict.fromkeys(only, "PASS"))


def test_a_silent_pty_is_one_fail_within_half_a_minute(tmp_path: pathlib.Path) -> None:
    with ForeignStation(answers=False) as station:
        code, found = run("3964r", "--port", f"pty:{station.path}")
    got = verdicts(found)
    assert code == 1 and [name for name, verdict in got.items() if verdict == "FAIL"] == ["3964R_RCV_BV_01"]
    assert sum(case["took_ms"] for case in found["cases"]) < 30_000


DEVICE = """
import os, pty, subprocess, sys, tty
master, slave = pty.openpty()
tty.setraw(slave)
child = subprocess.Popen(["sleep", "600"])
open("pids", "w").write(f"{os.getpid()} {child.pid}")
os.symlink(os.ttyname(slave), "line")
while True:
    os.read(master, 100)
"""


def test_ctrl_c_at_a_terminal_ends_the_device_and_leaves_a_report(tmp_path: pathlib.Path) -> None:
    """The key goes to all of the terminal's group; the device, which is not of it, is ended by the run with what it started."""
    (tmp_path / "device.py").write_text(DEVICE)
    (tmp_path / "bench.toml").write_text(
        f'[device]\nstart = ["{sys.executable}", "device.py"]\n[port]\nurl = "pty:{tmp_path}/line"\n[link]\nprofile = "rho3"\n'
    )
    program = "import sys; from gateway.commands.conformance import main; sys.exit(main(sys.argv[1:]))"
    command = ["setsid", "-c", sys.executable, "-c", program, "run", "3964r", "--bench", str(tmp_path / "bench.toml"), "--report", "out"]
    master, slave = pty.openpty()
    with subprocess.Popen(command, cwd=tmp_path, stdin=slave, stdout=slave, stderr=slave) as run_itself:
        os.close(slave)
        drain = threading.Thread(target=_drained, args=(master,), daemon=True)
        drain.start()
        for _ in range(600):
            if (tmp_path / "line").is_symlink():
                break
            threading.Event().wait(0.05)
        threading.Event().wait(1.0)  # the first case is under way
        os.write(master, b"\x03")
        assert run_itself.wait(60) == 3
    drain.join(10)
    os.close(master)
    found = json.loads((tmp_path / "out" / "report.json").read_text())
    assert "interrupted" in found["cases"][0]["reason"] and (tmp_path / "out" / "report.html").exists()
    for pid in (tmp_path / "pids").read_text().split():
        assert not _alive(int(pid))


def _alive(pid: int) -> bool:
    """Runs; one that only waits to be reaped does not."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def _drained(master: int) -> None:
    """What is printed must not fill the terminal."""
    with contextlib.suppress(OSError):
        while os.read(master, 4096):
            pass


def test_a_port_that_is_not_there_is_said(tmp_path: pathlib.Path) -> None:
    program = "import sys; from gateway.commands.conformance import main; sys.exit(main(sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, "-c", program, "run", "3964r", "--port", "pty:/nowhere"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 3 and "/nowhere" in done.stderr and "Traceback" not in done.stderr


def test_pymodbus_as_a_server(tmp_path: pathlib.Path) -> None:
    """An independent server: it answers, keeps its tables apart, and what it does otherwise is named."""
    port = _free_port()
    server = subprocess.Popen([sys.executable, "-c", PYMODBUS, str(port)], stderr=subprocess.DEVNULL)
    try:
        _wait_for(port)
        bench = tmp_path / "bench.toml"
        bench.write_text(f'[port]\nurl = "tcp://127.0.0.1:{port}"\n[touch]\nholding = ["10..20"]\ncoils = ["0..15"]\n')
        _, found = run("modbus-tcp", "--bench", str(bench), "--only", "MBTCP_FUN_BV_*", "--only", "MBTCP_CON_*")
    finally:
        server.kill()
        server.wait()
    got = verdicts(found)
    assert got["MBTCP_FUN_BV_01"] == "PASS" and got["MBTCP_CON_BV_06"] == "PASS" and got["MBTCP_CON_BV_15"] == "PASS"
    assert "FAIL" not in {verdict for name, verdict in got.items() if "_CON_" in name}


def test_a_server_that_closes_at_once_is_no_traceback() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]

        def close_all() -> None:
            while True:
                try:
                    server.accept()[0].close()
                except OSError:
                    return

        thread = threading.Thread(target=close_all, daemon=True)
        thread.start()
        code, found = run("modbus-tcp", "--port", f"tcp://127.0.0.1:{port}", "--only", "MBTCP_FUN_*")
        server.shutdown(socket.SHUT_RDWR)
        thread.join(5)
    assert code == 1 and verdicts(found)["MBTCP_FUN_BV_01"] == "FAIL"


PYMODBUS = """
import sys
from pymodbus.datastore import ModbusDeviceContext, ModbusSequentialDataBlock, ModbusServerContext
from pymodbus.server import StartTcpServer
block = lambda: ModbusSequentialDataBlock(1, [0] * 200)
device = ModbusDeviceContext(di=block(), co=block(), hr=block(), ir=block())
StartTcpServer(ModbusServerContext(devices=device, single=True), address=("127.0.0.1", int(sys.argv[1])))
"""


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as probe:
        return int(probe.getsockname()[1])


def _wait_for(port: int) -> None:
    for _ in range(200):
        try:
            socket.create_connection(("127.0.0.1", port), 0.1).close()
            return
        except OSError:
            threading.Event().wait(0.05)
    pytest.fail("pymodbus did not start")
