"""The raw AF_CAN port on a real vcan0, judged by Debian's candump and cansend: frames, stamps, error frames, what is refused."""

import errno
import os
import pathlib
import select
import socket
import struct
import subprocess
import time
from collections.abc import Iterator

import pytest

from drivers.ports.base import PortError
from drivers.ports.can.open import open_can
from drivers.ports.can.restart import restart
from drivers.ports.can.socketcan import SocketCanPort
from hil_tests.rig.vcan.candump import candump, read
from protocols.base.machine import Frame, FrameFault

pytestmark = pytest.mark.vcan

CYCLE = [Frame(100)] + [Frame(200 + 10 * axis, bytes(range(axis, axis + 8))) for axis in range(1, 7)]
LIMIT_S = 10.0


@pytest.fixture
def port() -> Iterator[SocketCanPort]:
    opened = open_can("socketcan:vcan0")
    assert isinstance(opened, SocketCanPort)
    yield opened
    opened.close()


def heard(port: SocketCanPort, count: int) -> list[Frame]:
    frames: list[Frame] = []
    end = time.monotonic() + LIMIT_S
    while len(frames) < count:
        assert time.monotonic() < end, f"{len(frames)} of {count} frames"
        select.select([port], [], [], 0.1)
        frames += port.receive()
    return frames


def cansend(*frames: str) -> None:
    for frame in frames:
        subprocess.run(["cansend", "vcan0", frame], check=True, timeout=LIMIT_S)


def test_candump_sees_what_the_port_sends_and_the_port_does_not_hear_itself(port: SocketCanPort, tmp_path: pathlib.Path) -> None:
    with candump(tmp_path / "log"):
        assert port.send(CYCLE) == 7
    assert [(frame.identifier, frame.data) for frame in read(tmp_path / "log")] == [(frame.identifier, frame.data) for frame in CYCLE]
    assert port.receive() == [] and (port.counters.sent, port.counters.received, port.counters.refused) == (7, 0, 0)


def test_the_port_hears_what_cansend_sends_with_stamps_of_the_monotonic_clock(port: SocketCanPort) -> None:
    before = time.monotonic_ns()
    cansend("064#", "262#0102030405060708", "12345678#01", "123#R", "263#FF")
    frames = heard(port, 3)
    after = time.monotonic_ns()
    assert [(frame.identifier, frame.data) for frame in frames] == [(0x64, b""), (0x262, bytes(range(1, 9))), (0x263, b"\xff")]
    stamps = [frame.stamp_ns for frame in frames]
    assert before < stamps[0] <= stamps[1] <= stamps[2] < after
    assert port.counters.ignored == 2, "extended and remote frames"


def test_a_stamp_is_the_moment_of_the_frame_not_of_its_reading(port: SocketCanPort) -> None:
    with candump_free_sender() as sender:
        sender.send(struct.pack("=IB3x8s", 5, 0, b""))
        sent = time.monotonic_ns()
        time.sleep(0.3)
        (frame,) = heard(port, 1)
    assert abs(frame.stamp_ns - sent) < 200_000_000


def candump_free_sender() -> socket.socket:
    sender = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    sender.bind(("vcan0",))
    return sender


def test_two_ports_hear_each_other(port: SocketCanPort) -> None:
    other = open_can("socketcan:vcan0")
    other.send(CYCLE)
    assert [frame.identifier for frame in heard(port, 7)] == [frame.identifier for frame in CYCLE]
    other.close()


def test_error_frames_are_reported_as_faults(port: SocketCanPort) -> None:
    with candump_free_sender() as sender:
        for can_id, data in ((0x20000040, bytes(8)), (0x20000004, b"\0\x10" + bytes(6)), (0x20000020, bytes(8)), (0x20000080, bytes(8))):
            sender.send(struct.pack("=IB3x8s", can_id, 8, data))
        sender.send(struct.pack("=IB3x8s", 5, 0, b""))
        assert [frame.identifier for frame in heard(port, 1)] == [5]
    kinds = [kind for kind, _ in port.take_faults()]
    assert kinds == [FrameFault.BUS_OFF, FrameFault.ERROR_PASSIVE, FrameFault.NO_ACK, FrameFault.OTHER]
    assert port.counters.faults == 4


def test_a_missing_or_downed_interface_says_what_to_do(port: SocketCanPort) -> None:
    with pytest.raises(PortError, match=r"no such interface.*ip link add dev vcan7 type vcan"):
        open_can("socketcan:vcan7")
    listener = open_can("socketcan:vcan0")
    subprocess.run(["ip", "link", "set", "vcan0", "down"], check=True)
    try:
        with pytest.raises(PortError, match="down: sudo ip link set vcan0 up"):
            open_can("socketcan:vcan0")
        with pytest.raises(PortError, match="down: sudo ip link set vcan0 up"):
            port.send([Frame(1)])
        with pytest.raises(PortError, match="down: sudo ip link set vcan0 up"):
            listener.receive()
    finally:
        subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True)
    fresh = open_can("socketcan:vcan0")
    assert fresh.send([Frame(1)]) == 1
    fresh.close()
    listener.close()


def test_a_controller_at_bus_off_is_restarted_with_the_words_ip_uses(port: SocketCanPort) -> None:
    """vcan has no controller: the kernel understands the request (ip gets the same answer) and refuses it there."""
    told = subprocess.run(
        ["ip", "link", "set", "vcan0", "type", "can", "restart"], capture_output=True, text=True, timeout=LIMIT_S, check=False
    )
    assert os.strerror(restart("vcan0")) in told.stderr and restart("vcan0") == errno.EOPNOTSUPP
    assert restart("nosuch") == errno.ENODEV
    assert port.send(CYCLE) == 7, "and nothing happened to it"
