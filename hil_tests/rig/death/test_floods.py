"""Partners and tools that send as fast as they can take their share of a turn and no more: the services live on (AX-622)."""

import contextlib
import multiprocessing
import socket
import time
from collections.abc import Callable

from hil_tests.lab.running.cell_running import P5_MS, running_cell

FLOOD_S = 5.0
READ_125 = bytes.fromhex("00010000000601030000007d")


def pour(connect: Callable[[], socket.socket], octets: bytes) -> None:
    """One client: sends without ever waiting for an answer."""
    with contextlib.suppress(OSError), connect() as link:
        link.setblocking(False)
        until = time.monotonic() + FLOOD_S
        while time.monotonic() < until:
            with contextlib.suppress(BlockingIOError):
                link.send(octets)
            with contextlib.suppress(BlockingIOError):
                link.recv(1 << 20)
            time.sleep(0.001)


def unix(path: str) -> socket.socket:
    link = socket.socket(socket.AF_UNIX)
    link.connect(path)
    return link


def test_tools_and_modbus_clients_that_flood_end_nothing() -> None:
    with running_cell(name="floods", plc=False, p5_ms=max(P5_MS, 20)) as run:
        tools, port = str(run.folder / "run" / "floods-services.sock"), run.port
        before = {name: process["pid"] for name, process in run.processes().items()}
        fork = multiprocessing.get_context("fork")
        clients = [fork.Process(target=pour, args=(lambda: unix(tools), b'{"op":"status"}\n' * 200)) for _ in range(12)]
        clients += [
            fork.Process(target=pour, args=(lambda: socket.create_connection(("127.0.0.1", port)), READ_125 * 100)) for _ in range(8)
        ]
        for client in clients:
            client.start()
        for client in clients:
            client.join()
        assert {name: process["pid"] for name, process in run.processes().items()} == before, run.words()
        assert not [entry for entry in run.journal("process") if "showed no life" in entry["text"]]
