"""Our master starts up a CANopen device we did not write (`durand`), and refuses the ones it must not start."""

import pathlib
import time
from collections.abc import Iterator

import pytest

from drivers.drives.cia402_boot import Identity, NodePlan, default_pdos
from gateway.links.canopen.direct_link import DirectLink
from gateway.links.canopen.master import CanopenMaster, Health, Node
from hil_tests.lab.partners.durand_drive import DurandDrive
from hil_tests.lab.running.bus_running import Bus, running_bus

NODE = 5
ANYBODY = Identity()


@pytest.fixture
def bus(tmp_path: pathlib.Path) -> Iterator[Bus]:
    with running_bus(tmp_path, name="durand", log=False) as running:
        yield running


class Started:
    """A master on the bus, no cycle: only the start-up is under test."""

    def __init__(self, bus: Bus, plan: NodePlan) -> None:
        self.said: list[str] = []
        self.link = DirectLink(bus.port())
        self.master = CanopenMaster("durand", self.link, [("A1", plan)], lambda kind, words, facts: self.said.append(words))

    def until(self, *healths: Health, seconds: float = 8.0) -> Node:
        node = self.master.nodes[NODE]
        end = time.monotonic() + seconds
        while node.health not in healths and time.monotonic() < end:
            time.sleep(0.01)
        return node


def started(bus: Bus, plan: NodePlan, *healths: Health) -> Started:
    run = Started(bus, plan)
    run.master.start()
    try:
        run.until(*healths)
    finally:
        run.master.stop()
        run.link.port.close()
    return run


def plan(identity: Identity = ANYBODY) -> NodePlan:
    return NodePlan(NODE, default_pdos(NODE, torque=True), identity)


def test_durand_is_started_up_and_its_pdos_are_ours(bus: Bus) -> None:
    device = DurandDrive(bus.name, NODE)
    try:
        run = started(bus, plan(Identity(vendor=0x1234)), Health.READY, Health.REFUSED)
        node = run.master.nodes[NODE]
        assert node.health is Health.READY, run.said
        assert run.link.released == {NODE: 8}
        assert device.node.nmt.state.value == 5
        assert device.object(0x1016, 1) == 127 << 16 | 150 and device.object(0x1017) == 50
        assert [device.object(0x1600, sub) for sub in (0, 1, 2)] == [2, 0x60400010, 0x607A0020]
        assert [device.object(0x1A00, sub) for sub in (0, 1, 2)] == [2, 0x60410010, 0x60640020]
        assert [device.object(0x1A02, sub) for sub in (0, 1, 2)] == [2, 0x60FD0020, 0x60610008]
        assert (device.object(0x1400, 1), device.object(0x1400, 2)) == (0x205, 1)
        assert device.object(0x6007) == 3 and device.object(0x6060) == 8
        assert int(str(device.object(0x1402, 1))) >> 31, "a PDO that is not ours is switched off"
    finally:
        device.stop()


def test_another_device_than_the_pinned_one_is_refused_and_stays_off(bus: Bus) -> None:
    device = DurandDrive(bus.name, NODE, vendor=0x9999)
    try:
        run = started(bus, plan(Identity(vendor=0x1234)), Health.READY, Health.REFUSED)
        node = run.master.nodes[NODE]
        assert node.health is Health.REFUSED
        assert "1018h:01" in node.why and "0x00009999" in node.why
        assert device.node.nmt.state.value != 5 and not run.link.released
    finally:
        device.stop()


def test_a_drive_that_cannot_watch_the_gateway_is_refused(bus: Bus) -> None:
    device = DurandDrive(bus.name, NODE, watches=False)
    try:
        run = started(bus, plan(), Health.READY, Health.REFUSED)
        node = run.master.nodes[NODE]
        assert node.health is Health.REFUSED and "1016h:01 heartbeat consumer" in node.why
        assert not run.link.released
    finally:
        device.stop()


def test_a_node_that_is_not_there_is_dead_and_is_tried_again(bus: Bus) -> None:
    run = Started(bus, plan())
    run.master.start()
    device: DurandDrive | None = None
    try:
        node = run.until(Health.DEAD)
        assert node.health is Health.DEAD
        device = DurandDrive(bus.name, NODE)  # its boot-up message brings the next attempt at once
        assert run.until(Health.READY).health is Health.READY
    finally:
        run.master.stop()
        run.link.port.close()
        if device is not None:
            device.stop()


def test_a_storm_of_emergencies_is_counted_and_reported_a_few_times_only(bus: Bus) -> None:
    device = DurandDrive(bus.name, NODE)
    run = Started(bus, plan())
    run.master.start()
    try:
        assert run.until(Health.READY).health is Health.READY
        node, before = run.master.nodes[NODE], len(run.said)
        for n in range(500):
            device.node.emcy.set(0x8611 if n % 2 else 0x3220, 0x21)
            time.sleep(0.001)
        end = time.monotonic() + 3.0
        while node.emergencies < 500 and time.monotonic() < end:
            time.sleep(0.02)
        assert node.emergencies == 500 and node.health is Health.READY
        told = run.said[before:]
        assert 1 <= len(told) <= 4 and "DC link under-voltage (3220h)" in told[0], told
        with node.lock:
            assert run.master.upload(NODE, 0x1018, 2) == (0x402).to_bytes(4, "little"), "SDO goes on beside it"
    finally:
        run.master.stop()
        run.link.port.close()
        device.stop()
