"""Conformance suites: how long they take at a correct device, how many faulty ones they find, and whether their order matters."""

import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import cast

from gateway.conformance.framework.result import Result
from gateway.conformance.peers.score import fails, peers, play, score
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.verdict import Verdict
from hil_tests.bench.figure_row import EMPTY_LOOP, Figure, loop_turns, row

SHUFFLED = 20
LINE, CAN = ("3964r", "rk512"), ("canopen-301", "cia402")
SERVER = """
import sys
from pymodbus.datastore import ModbusDeviceContext, ModbusSequentialDataBlock, ModbusServerContext
from pymodbus.server import StartTcpServer
block = lambda: ModbusSequentialDataBlock(1, [0] * 200)
device = ModbusDeviceContext(di=block(), co=block(), hr=block(), ir=block())
StartTcpServer(ModbusServerContext(devices=device, single=True), address=("127.0.0.1", int(sys.argv[1])))
"""
BENCH = '[port]\nurl = "tcp://127.0.0.1:{}"\n[touch]\nholding = ["10..140"]\ncoils = ["0..40"]\n'


def run(shuffled: int = SHUFFLED, names: Sequence[str] = tuple(SUITES)) -> list[Figure]:
    """All figures; --blocks is the number of shuffled runs, where it is stated."""
    anchor = loop_turns()
    found = [
        row("conformance.3964r_rk512_s", _time(LINE), "s in virtual time", 30, EMPTY_LOOP, anchor),
        row("conformance.canopen_402_s", _time(CAN), "s in virtual time", 300, EMPTY_LOOP, anchor),
        row("conformance.modbus_tcp_s", _over_tcp(), "s, pymodbus on a socket", 180, EMPTY_LOOP, anchor),
    ]
    for name in names:
        found += _scored(name)
        found.append(_most(f"{name}_order", _differing(name, shuffled), "verdicts", f"{shuffled} shuffled runs", 0))
    return found


def _most(name: str, value: float, unit: str, reference: str, goal: float) -> Figure:
    return row(f"conformance.{name}", value, unit, goal, reference)


def _variant_run(name: str, seed: int | None = None) -> list[Result]:
    return play(SUITES[name], peers(SUITES[name])[1][0], seed=seed)


def _time(names: Sequence[str]) -> float:
    begin = time.perf_counter()
    for name in names:
        assert not fails(_variant_run(name)), f"{name}: a correct device FAILs"
    return round(time.perf_counter() - begin, 1)


def _scored(name: str) -> list[Figure]:
    found = score(SUITES[name])
    counts = cast(dict[str, float], found["fails_per_mutant"])
    mutants = len(cast(list[object], found["mutants"]))
    share = round(100.0 * cast(int, found["killed"]) / mutants, 1)
    return [
        row(f"conformance.{name}_mutants", share, "%", 95.0, f"{mutants} faulty devices", at_least=True),
        _most(f"{name}_fails_median", counts["median"], "FAILs", "of one faulty device", 3),
        _most(f"{name}_fails_most", counts["most"], "FAILs", "of one faulty device", 12),
    ]


def _differing(name: str, runs: int) -> int:
    """Verdicts that another order changed."""
    plain = _verdicts(_variant_run(name))
    return sum(verdict is not plain[case] for seed in range(1, runs + 1) for case, verdict in _verdicts(_variant_run(name, seed)).items())


def _verdicts(results: Sequence[Result]) -> dict[str, Verdict]:
    return {result.purpose.id: result.verdict for result in results}


def _over_tcp() -> float:
    """The whole suite at a server of somebody else's, in real time."""
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = int(probe.getsockname()[1])
    with tempfile.TemporaryDirectory() as folder:
        bench = Path(folder) / "bench.toml"
        bench.write_text(BENCH.format(port))
        server = subprocess.Popen([sys.executable, "-c", SERVER, str(port)], stderr=subprocess.DEVNULL)
        try:
            while not _open(port):
                assert server.poll() is None, "pymodbus did not start"
                time.sleep(0.05)
            begin = time.perf_counter()
            command = [sys.executable, "-m", "gateway", "conformance", "run", "modbus-tcp", "--bench", str(bench), "--json"]
            done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
            assert done.returncode in (0, 1, 3), f"exit code {done.returncode}"
            return round(time.perf_counter() - begin, 1)
        finally:
            server.kill()
            server.wait()


def _open(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), 0.1).close()
    except OSError:
        return False
    return True
