"""The guest's vcan0, judged by Debian's candump and by python-can: both see what raw AF_CAN sends, byte for byte."""

import pathlib
import socket
import struct

import can
import pytest

from hil_tests.rig.vcan.candump import candump, read

pytestmark = pytest.mark.vcan

FRAME = struct.Struct("=IB3x8s")  # struct can_frame: identifier, length, padding, data
SENT = [(100, b""), (210, bytes(range(8))), (660, b"\xff\x00\x10")]


def send_raw() -> None:
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as line:
        line.bind(("vcan0",))
        for identifier, data in SENT:
            line.send(FRAME.pack(identifier, len(data), data.ljust(8, b"\0")))


def test_candump_sees_raw_frames_byte_for_byte_and_in_order(tmp_path: pathlib.Path) -> None:
    log = tmp_path / "candump.log"
    with candump(log):
        send_raw()
    frames = read(log)
    assert [(frame.identifier, frame.data) for frame in frames] == SENT
    assert sorted(frame.stamp_us for frame in frames) == [frame.stamp_us for frame in frames]


def test_python_can_sees_raw_frames_byte_for_byte_and_in_order() -> None:
    with can.Bus(interface="socketcan", channel="vcan0") as bus:
        send_raw()
        received = [bus.recv(timeout=5.0) for _ in SENT]
    assert [(message.arbitration_id, bytes(message.data)) for message in received if message] == SENT


def test_candump_sees_what_python_can_sends(tmp_path: pathlib.Path) -> None:
    log = tmp_path / "candump.log"
    with candump(log), can.Bus(interface="socketcan", channel="vcan0") as bus:
        for identifier, data in SENT:
            bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))
    assert [(frame.identifier, frame.data) for frame in read(log)] == SENT
