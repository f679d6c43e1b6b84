"""A device that sends segments for ever does not hold its client: against one on python-can that never says "last"."""

import pathlib
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import can
import canopen
import pytest
from canopen.sdo.exceptions import SdoAbortedError

from gateway.links.canopen.sdo_client import bounded_upload
from hil_tests.lab.running.bus_running import running_bus

NODE = 9


class Endless(can.Listener):
    """Answers 1008h with an upload that does not end; `size`: what it announces."""

    def __init__(self, size: int | None = None) -> None:
        self._bus, self._size = can.Bus(interface="broker", channel="endless"), size
        self.aborted = threading.Event()
        self._notifier = can.Notifier(self._bus, [self], timeout=0.05)

    def on_message_received(self, msg: can.Message) -> None:
        if msg.arbitration_id != 0x600 + NODE:
            return
        command = msg.data[0]
        if command == 0x80:
            self.aborted.set()
        elif command == 0x40:
            sized = self._size is not None
            self._say(bytes((0x41 if sized else 0x40, *msg.data[1:4])) + (self._size or 0).to_bytes(4, "little"))
        else:
            self._say(bytes((command & 0x10,)) + b"endless")

    def _say(self, data: bytes) -> None:
        self._bus.send(can.Message(arbitration_id=0x580 + NODE, data=data, is_extended_id=False))

    def close(self) -> None:
        self._notifier.stop()
        self._bus.shutdown()


@pytest.fixture
def network(tmp_path: pathlib.Path) -> Iterator[canopen.Network]:
    with running_bus(tmp_path, name="endless", log=False):
        network = canopen.Network(can.Bus(interface="broker", channel="endless"))
        network.connect()
        yield network
        network.disconnect()


@pytest.mark.parametrize(("size", "most", "most_s"), [(None, 700, 20.0), (20, 65_536, 20.0), (None, 1 << 30, 0.5)])
def test_an_upload_that_does_not_end_is_aborted(network: canopen.Network, size: int | None, most: int, most_s: float) -> None:
    device = Endless(size)
    try:
        start = time.monotonic()
        with pytest.raises(SdoAbortedError):
            bounded_upload(network.add_node(NODE).sdo, 0x1008, 0, most, most_s)
        assert time.monotonic() - start < 5 and device.aborted.wait(2), "and the device is told"
    finally:
        device.close()


def test_bus_send_read_ends_with_a_sentence(network: canopen.Network) -> None:
    device = Endless(20)
    try:
        command = [sys.executable, "-m", "gateway", "bus", "send", "broker:endless", "--node", str(NODE), "--read", "1008:0"]
        told = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    finally:
        device.close()
    assert told.returncode == 1 and "Out of memory" in told.stderr and "Traceback" not in told.stderr, told
