"""Emergency messages by the thousand: counted, told once a second, nothing kept for ever, the services live on (AX-622)."""

import gc
import json
import os
import socket
import threading
import time
import tracemalloc
from collections.abc import Iterator

import pytest

from drivers.ports.can.broker import BrokerPort
from gateway.assembly.canopen_nodes import node_plans
from gateway.cell_file.load import load_cell
from gateway.links.canopen.master import CanopenMaster
from gateway.links.canopen.ring_link import Rings
from gateway.pure.image.records.aside import ACYCLIC_RECORDS, ASIDE_BYTES, ASIDE_LAYOUT, HEARD_RECORDS, Aside, AsideRecord, pack_aside
from gateway.runtime.regions import RingWriter, create_ring
from hil_tests.lab.running.cell_running import P5_MS, running_cell
from protocols.base.machine import Frame

NODE = 1
STORM = int(os.environ.get("AXISGATE_STORM", "14000"))  # 60,000 in `make soak`
FLOOD_S = 8.0 if STORM > 14_000 else 3.0


@pytest.fixture
def heard() -> Iterator[tuple[CanopenMaster, RingWriter, list[str]]]:
    """A master on the services' end of real rings, the cycle's end, and what the master told."""
    out = create_ring("acyclic", ASIDE_BYTES, ACYCLIC_RECORDS, ASIDE_LAYOUT)
    back = create_ring("heard", ASIDE_BYTES, HEARD_RECORDS, ASIDE_LAYOUT)
    cell = load_cell("demo-402")
    told: list[str] = []
    plans = node_plans(cell, cell.bus[0], cell.cycle_ms, simulated=True)
    master = CanopenMaster("storm", Rings(out, back, 1).links[0], plans, lambda kind, words, facts: told.append(f"{kind}: {words}"))
    master.start([NODE])
    yield master, RingWriter(back, "heard"), told
    master.stop()
    os.close(out)
    os.close(back)


def storm(ring: RingWriter, identifier: int, size: int, count: int) -> None:
    """7,000 a second and more, as a cycle hands them on: some in each period."""
    for n in range(count):
        data = bytes((0x10 + n % 2, 0x43, 1, 0, 0, 0, 0, 0))[:size]
        ring.put(pack_aside(AsideRecord(Aside.FRAME, 0, identifier, data, time.monotonic_ns())))
        if n % 50 == 49:
            time.sleep(0.006)


def test_nothing_is_kept_of_a_storm_and_every_message_is_counted(heard: tuple[CanopenMaster, RingWriter, list[str]]) -> None:
    master, ring, told = heard
    time.sleep(1.5)  # data sheets are read
    storm(ring, 0x080 + NODE, 8, 2000)
    gc.collect()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    storm(ring, 0x080 + NODE, 8, STORM)
    storm(ring, 0x580 + NODE, 8, 5000)  # answers nobody asked for
    storm(ring, 0x080 + NODE, 3, 1000)  # and what is too short for an emergency message
    time.sleep(0.1)
    gc.collect()
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert grown < 600_000, f"{grown} bytes: 0.5 KB of each would be 7 MB and more"
    row = next(row for row in master.status() if row["node"] == NODE)
    assert row["emergencies"] == 2000 + STORM + 1000
    assert not [words for words in told if "receiving failed" in words]
    assert 2 <= sum("more emergency messages before" in words for words in told) <= 2 + STORM // 5_000, told


def flood(name: str, stop: threading.Event, each: int, pause_s: float) -> None:
    port, n = BrokerPort(name), 0
    while not stop.is_set():
        n += 1
        port.send([Frame(0x080 + node, bytes((0x10 + n % 2, 0x43, 1, 0, 0, 0, 0, 0))) for node in range(1, 1 + each)])
        port.receive()
        time.sleep(pause_s)
    port.close()


def test_a_storm_on_the_bus_of_a_running_cell_ends_no_process() -> None:
    with running_cell("demo-402", name="storm", plc=False, p5_ms=max(P5_MS, 10)) as run:
        time.sleep(2.0)
        before = {name: process["pid"] for name, process in run.processes().items()}
        stop = threading.Event()
        thread = threading.Thread(target=flood, args=("storm-drives", stop, 6, 0.001))
        thread.start()
        time.sleep(FLOOD_S)
        stop.set()
        thread.join()
        assert {name: process["pid"] for name, process in run.processes().items()} == before, run.words()
        assert len([entry for entry in run.journal("drive") if "more emergency messages" in entry["text"]]) <= 6 * (FLOOD_S + 3)
        with socket.socket(socket.AF_UNIX) as tool:
            tool.settimeout(5)
            tool.connect(str(run.folder / "run" / "storm-services.sock"))
            tool.sendall(b'{"op": "status"}\n')
            assert "nodes" in json.loads(tool.makefile().readline())
