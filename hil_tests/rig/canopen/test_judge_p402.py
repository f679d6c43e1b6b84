"""The canopen package (master and its p402 profile), which we did not write, commissions and moves the emulated drive over the local bus.

Nothing is done for our drive that p402 would not do for any: EDS loaded by canopen, `state = ...`, homing, profile position, CSP by SYNC.
"""

import contextlib
import json
import pathlib
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402

from drivers.emulator.servo import record
from drivers.emulator.servo.settings import BusSettings, DriveSettings, ServoSettings, to_dict
from gateway.files.find import find_config
from gateway.simulation.drives.control import EmulatorControl
from hil_tests.lab.running.bus_running import Bus, running_bus

NODE = 5
CYCLE_S = 0.020
SERVO = ServoSettings(start_rad=-3.0, reference_switch_from_rad=4.0, reference_switch_to_rad=9.0, boot_s=0.05)


class Rig:
    """Broker, emulator process, canopen network with one node."""

    def __init__(self, bus: Bus, folder: pathlib.Path) -> None:
        settings = folder / "drives.json"
        self.record_file = folder / "drives.rec"
        settings.write_text(json.dumps(to_dict(BusSettings(CYCLE_S * 1000, 5, {}, {NODE: DriveSettings(SERVO)}))))
        self.network: Any = canopen.Network()  # half of the package has no types
        self.network.connect(interface="broker", channel=bus.name)
        profile: Any = BaseNode402
        self.node: Any = profile(NODE, str(find_config("axisgate_402.eds", "drives")))
        self.network.add_node(self.node)
        command = [sys.executable, "-m", "gateway.simulation.drives.process", "--settings", str(settings), "--bus", f"broker:{bus.name}"]
        self.process = subprocess.Popen(
            [*command, "--record", str(self.record_file)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self.node.nmt.wait_for_bootup(10)
        self.control = EmulatorControl(bus.name)

    def commission(self) -> None:
        self.node.setup_402_state_machine()
        self.node.nmt.state = "OPERATIONAL"
        self.node.tpdo[1].wait_for_reception(5)  # the node tells how it stands

    def until(self, key: int, wanted: int, limit_s: float = 10.0, near: int = 0) -> int:
        """An object by SDO until it is as wanted."""
        end = time.monotonic() + limit_s
        while abs((value := int(self.node.sdo[key].raw)) - wanted) > near:
            assert time.monotonic() < end, f"{key:04X}h is {value}, wanted {wanted}"
            time.sleep(0.01)
        return value

    def in_state(self, wanted: str, limit_s: float = 10.0) -> None:
        """Its status word comes by TPDO."""
        end = time.monotonic() + limit_s
        while self.node.state != wanted:
            assert time.monotonic() < end, f"{self.node.state}, wanted {wanted}"
            time.sleep(0.01)

    def close(self) -> None:
        self.control.close()
        self.network.disconnect()
        self.process.terminate()
        self.process.communicate(timeout=10)


@pytest.fixture
def rig(tmp_path: pathlib.Path) -> Iterator[Rig]:
    with running_bus(tmp_path, log=False) as bus, contextlib.closing(Rig(bus, tmp_path)) as running:
        yield running


def test_p402_commissions_homes_and_positions_the_drive(rig: Rig) -> None:
    node = rig.node
    assert node.sdo[0x1008].raw == "axisgate emulated CiA 402 servo drive"
    assert node.sdo[0x1018][2].raw == 0x402
    rig.commission()
    rig.in_state("SWITCH ON DISABLED")
    node.op_mode = "HOMING"
    assert node.op_mode == "HOMING"
    node.sdo[0x6098].raw = 24  # home switch, rising edge from the left
    node.sdo[0x607C].raw = 1000
    node.state = "OPERATION ENABLED"
    assert node.state == "OPERATION ENABLED"
    assert node.homing(timeout=10) and node.is_homed()
    shaft = rig.control.state()["nodes"][str(NODE)]["position_rad"]
    place = int(node.sdo[0x6064].raw)
    assert abs(place - 1000 - (shaft - 4.0) * 16384 / 6.283185307) < 3  # the edge at 4 rad is position 1000
    node.op_mode = "PROFILED POSITION"
    assert node.op_mode == "PROFILED POSITION"
    node.controlword = 0x0F  # homing left bit 4 standing; a set-point wants its rising edge
    for target in (30000, -20000):
        node.sdo[0x607A].raw = target
        node.rpdo[1][0x607A].raw = target
        node.controlword = 0x1F
        assert node.sdo[0x6041].raw & 0x1000, "set-point not acknowledged"
        node.controlword = 0x0F
        rig.until(0x6064, target, near=20)
        deadline = time.monotonic() + 2
        while not node.statusword & 0x400 and time.monotonic() < deadline:
            time.sleep(0.01)
        assert node.statusword & 0x400, "target reached came by event-driven TPDO1"
    node.state = "SWITCHED ON"
    assert node.state == "SWITCHED ON"
    assert rig.control.state()["nodes"][str(NODE)]["brake_open"] is False


def test_p402_moves_the_drive_in_csp_by_sync_and_the_record_shows_the_path(rig: Rig) -> None:
    node = rig.node
    rig.commission()
    node.nmt.state = "PRE-OPERATIONAL"
    for pdo in (node.rpdo[1], node.tpdo[1]):
        pdo.trans_type = 1
        pdo.save()
    node.sdo[0x60C2][1].raw, node.sdo[0x60C2][2].raw = round(CYCLE_S * 1000), -3
    node.nmt.state = "OPERATIONAL"
    node.rpdo[1][0x607A].raw = node.sdo[0x6064].raw
    node.rpdo[1].start(CYCLE_S / 2)
    rig.network.sync.start(CYCLE_S)
    node.sdo[0x6060].raw = 8
    node.state = "OPERATION ENABLED"
    start = int(node.sdo[0x6064].raw)
    for step in range(1, 51):
        node.rpdo[1][0x607A].raw = start + 200 * step
        node.rpdo[1].update()
        time.sleep(CYCLE_S)
    assert rig.until(0x6064, start + 10000, near=30)
    node.state = "SWITCH ON DISABLED"
    node.rpdo[1].stop()
    rig.network.sync.stop()
    rig.control.ask("flush")
    rows = record.read(rig.record_file.read_bytes()).rows
    moved = [row.axes[0] for row in rows if row.axes[0].flags & record.Flag.ENABLED and not row.axes[0].flags & record.Flag.NO_SYNC]
    sets = [row.set_inc - start for row in moved]
    assert abs(sets[0]) <= 1 and abs(sets[-1] - 10000) <= 1 and sets == sorted(sets), "the set values were taken in order, one a SYNC"
    assert all(later - earlier <= 600 for earlier, later in pairwise(sets))
    assert max(abs(row.set_inc - row.position_inc) for row in moved) < 400  # lag = 200 inc / 20 ms / 80 per second


def test_p402_sees_a_fault_reads_the_emergency_and_resets_it(rig: Rig) -> None:
    node = rig.node
    rig.commission()
    node.op_mode = "PROFILED POSITION"
    node.state = "OPERATION ENABLED"
    rig.control.ask("undervoltage", node=NODE, on=True)
    deadline = time.monotonic() + 5  # its log, not wait(): that misses what came before it began to wait
    while not (told := [entry for entry in node.emcy.log if entry.code == 0x3220]) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert told and told[0].register & 0x04
    assert node.sdo[0x603F].raw == 0x3220
    assert node.is_faulted()
    rig.control.ask("undervoltage", node=NODE, on=False)
    node.reset_from_fault()
    assert node.state == "OPERATION ENABLED" and node.sdo[0x603F].raw == 0


def test_canopen_reads_and_writes_long_objects_by_segments_and_blocks(rig: Rig) -> None:
    node, text = rig.node, bytes(range(256)) * 9
    with node.sdo.open(0x2F00, 0, "wb", size=len(text), block_transfer=True) as stream:
        stream.write(text)
    with node.sdo.open(0x2F00, 0, "rb", block_transfer=True) as stream:
        assert stream.read() == text
    assert node.sdo.upload(0x2F00, 0) == text
    node.sdo.download(0x2F00, 0, text[:100], force_segment=True)
    assert node.sdo.upload(0x2F00, 0) == text[:100]
    with pytest.raises(canopen.SdoAbortedError) as caught:
        node.sdo.download(0x6041, 0, struct.pack("<H", 1))
    assert caught.value.code == 0x06010002


def test_canopen_finds_and_renumbers_the_drive_by_lss(rig: Rig) -> None:
    lss = rig.network.lss
    assert lss.send_switch_state_selective(0, 0x402, 0x00010000, 1)
    assert lss.inquire_node_id() == NODE
    assert lss.inquire_lss_address(0x5D) == 1
    lss.configure_node_id(9)
    lss.store_configuration()
    lss.send_switch_state_global(lss.WAITING_STATE)
    moved = rig.network.add_node(9, str(find_config("axisgate_402.eds", "drives")))
    rig.node.nmt.send_command(0x82)  # reset communication: the number counts
    moved.nmt.wait_for_bootup(5)
    assert moved.sdo[0x1018][4].raw == 1


def test_canopen_asks_by_remote_frames_and_guards_the_node(rig: Rig) -> None:
    node = rig.node
    tpdo = node.tpdo[1]
    node.tpdo.read()
    tpdo.rtr_allowed, tpdo.trans_type = True, 253
    tpdo.save()
    node.nmt.state = "OPERATIONAL"
    assert tpdo.wait_for_reception(0.3) is None, "it speaks only when it is asked"
    came = threading.Event()
    tpdo.add_callback(lambda _: came.set())  # before it is asked: the answer may be quicker than a wait for it
    tpdo.remote_request()
    assert came.wait(5) and tpdo[0x6041].raw & 0x4F == 0x40
    heard: list[int] = []
    rig.network.subscribe(0x700 + NODE, lambda can_id, data, stamp: heard.append(data[0]))
    node.nmt.start_node_guarding(0.05)
    end = time.monotonic() + 5
    while len(heard) < 4 and time.monotonic() < end:
        time.sleep(0.01)
    node.nmt.stop_node_guarding()
    assert heard[:4] == [0x05, 0x85, 0x05, 0x85]
