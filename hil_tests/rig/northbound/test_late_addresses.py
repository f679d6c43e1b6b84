"""Page, metrics and OPC UA whose address or port comes late: they wait alive, say so once, and listen when it is there."""

import asyncio
import errno
import json
import pathlib
import shutil
import socket
import subprocess
import sys
import urllib.request
from typing import Any

import pytest
import uvicorn

from gateway.files.find import find_config
from gateway.processes.web import LivingServer
from gateway.runtime.journal import Journal
from gateway.runtime.late_address import listening, patiently
from hil_tests.lab.running.cell_running import running_cell
from hil_tests.lab.running.web_running import until

LATE = """
import asyncio, subprocess, sys
from gateway.runtime.late_address import listening, patiently
async def main():
    async def start(): return listening("192.0.2.77", 0)
    asyncio.get_running_loop().call_later(1.5, subprocess.run, ["ip", "address", "add", "192.0.2.77/32", "dev", "lo"])
    found = await patiently("page", start, print)
    print("bound", found.getsockname()[0])
asyncio.run(main())
"""


ABSENT = """
import socket
try:
    socket.socket().bind(("192.0.2.77", 0))
except OSError:
    print("absent")
"""


def own_network() -> bool:
    """A network namespace can be made here, and its kernel refuses an address that no interface has."""
    if not shutil.which("unshare") or not shutil.which("ip"):
        return False
    done = subprocess.run(["unshare", "-rn", sys.executable, "-c", ABSENT], check=False, capture_output=True, text=True)
    return done.stdout == "absent\n"


@pytest.mark.skipif(not own_network(), reason="no network namespace of one's own here, or a kernel that binds any address")
def test_an_interface_that_comes_up_late_is_taken() -> None:
    done = subprocess.run(["unshare", "-rn", sys.executable, "-c", LATE], check=True, capture_output=True, text=True, timeout=60)
    assert done.stdout.splitlines() == [
        "page: no interface of this machine has this address yet; tried again every second until it exists",
        "page: listens now",
        "bound 192.0.2.77",
    ]


def test_an_address_that_comes_later_is_taken_and_said_once() -> None:
    said: list[str] = []
    refusals = iter((errno.EADDRNOTAVAIL, errno.EADDRNOTAVAIL, 0))
    beats: list[int] = []

    async def start() -> str:
        if number := next(refusals):
            raise OSError(number, "refused")
        return "listens"

    assert asyncio.run(patiently("page", start, said.append, lambda: beats.append(1))) == "listens"
    assert len(said) == 2 and "no interface of this machine has this address yet" in said[0] and said[1] == "page: listens now"
    assert len(beats) >= 20, "alive while it waits"


def test_what_cannot_come_is_raised_and_waiting_ends_when_asked() -> None:
    said: list[str] = []

    async def refused() -> socket.socket:
        raise PermissionError(errno.EACCES, "no")

    async def taken() -> socket.socket:
        return listening(*held.getsockname())

    with pytest.raises(PermissionError):
        asyncio.run(patiently("page", refused, said.append))
    with listening("127.0.0.1", 0) as held:
        turns = iter((False, False, True))
        assert asyncio.run(patiently("page", taken, said.append, ended=lambda: next(turns))) is None
    assert said == ["page: another program has this port; tried again every second until it exists"]


def test_the_page_waits_for_its_port_and_shows_life(tmp_path: pathlib.Path) -> None:
    journal = tmp_path / "journal.jsonl"

    async def app(scope: dict[str, Any], receive: Any, send: Any) -> None:
        if scope["type"] == "http":
            await send({"type": "http.response.start", "status": 204, "headers": []})
            await send({"type": "http.response.body"})

    async def whole() -> int:
        held = listening("127.0.0.1", 0)
        port = held.getsockname()[1]
        server = LivingServer(uvicorn.Config(app, host="127.0.0.1", port=port, lifespan="off"), Journal(journal, "web"))
        serving = asyncio.create_task(server.serve())
        await asyncio.sleep(1.5)
        assert not server.started and not serving.done()
        held.close()
        async with asyncio.timeout(10):
            while not server.started:
                await asyncio.sleep(0.05)
        status = await asyncio.to_thread(lambda: urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=5).status)
        server.should_exit = True
        await serving
        return int(status)

    assert asyncio.run(whole()) == 204
    said = [json.loads(line)["text"] for line in journal.read_text().splitlines()]
    assert len(said) == 2 and "another program has this port" in said[0] and said[1].endswith("listens now")


@pytest.mark.slow
def test_metrics_and_opc_ua_of_a_run_wait_for_their_ports_without_dying(tmp_path: pathlib.Path) -> None:
    first, second = listening("127.0.0.1", 0), listening("127.0.0.1", 0)
    metrics, opcua = first.getsockname()[1], second.getsockname()[1]
    cell = tmp_path / "cell.toml"
    north = f'\n[northbound.metrics]\nbind = "127.0.0.1:{metrics}"\n[northbound.opcua]\nbind = "127.0.0.1:{opcua}"\n'
    cell.write_text(find_config("demo", "cells").read_text() + north)
    with running_cell(str(cell), "late", plc=False) as run:

        def told(words: str) -> bool:
            return sum(words in row["text"] for row in run.journal("alarm")) == 2

        until(lambda: told("another program has this port"), "both wait")
        first.close()
        second.close()
        until(lambda: told("listens now"), "both listen")
        with urllib.request.urlopen(f"http://127.0.0.1:{metrics}/metrics", timeout=10) as answer:
            assert b"axisgate_ready" in answer.read()
        with socket.create_connection(("127.0.0.1", opcua), timeout=10):
            pass
        restarts = {each["name"]: each.get("restarts") for each in run.status()["processes"]}
        assert not restarts["northbound"], restarts
