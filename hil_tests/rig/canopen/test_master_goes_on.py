"""A failing look at the ring must not end the master's receiving thread: all nodes are started up all the same (AX-309)."""

import time
from collections.abc import Callable, Iterator

import pytest

from gateway.assembly.canopen_nodes import node_plans
from gateway.cell_file.load import load_cell
from gateway.links.canopen.master import CanopenMaster, Health
from hil_tests.lab.running.canopen_link import DrivesLink

LIMIT_S = 40.0
SENTENCE = "release unlocked lock"


class Bus:
    """A master with six drives; `said`: what it told."""

    def __init__(self) -> None:
        cell = load_cell("demo-402")
        plans = node_plans(cell, cell.bus[0], cell.cycle_ms, simulated=True)
        self.said: list[str] = []
        self.link = DrivesLink([plan.node for _, plan in plans])
        self.master = CanopenMaster("goes-on", self.link, plans, lambda kind, words, facts: self.said.append(f"{kind}: {words}"))

    def wait(self, condition: Callable[[], bool]) -> bool:
        end = time.monotonic() + LIMIT_S
        while not condition() and time.monotonic() < end:
            time.sleep(0.01)
        return condition()

    def all_ready(self) -> bool:
        return all(node.health is Health.READY for node in self.master.nodes.values())

    def stop(self) -> None:
        self.master.stop()
        self.link.stop()


@pytest.fixture
def bus() -> Iterator[Bus]:
    made = Bus()
    yield made
    made.stop()


def test_an_error_in_the_receiving_thread_is_reported_with_its_place_and_every_node_is_started_up(bus: Bus) -> None:
    bus.master.start()
    assert bus.wait(lambda: any(node.health is Health.BOOTING for node in bus.master.nodes.values()) and bus.link.answered > 20)
    bus.link.fail = RuntimeError(SENTENCE)
    assert bus.wait(bus.all_ready), [(node.name, node.health, node.why) for node in bus.master.nodes.values()]
    told = [words for words in bus.said if SENTENCE in words]
    assert told and told[0].startswith(f"alarm: goes-on: receiving failed and continues: RuntimeError: {SENTENCE} (canopen_link.py:")
    assert bus.link.released == set(bus.master.nodes)
