"""Recordings of a CAN bus: read and written through python-can (candump, ASC, BLF, TRC, CSV), and our own pcapng writer.

A recording is frames with stamps; an extended frame carries bit 31 in its identifier, as struct can_frame does.
"""

import pathlib
import struct
from collections.abc import Iterator

import can

from drivers.ports.canwire import EFF_FLAG
from gateway.pure.candump import frames_of
from gateway.pure.pcapng import can_pcapng
from protocols.base.machine import Frame

READABLE = (".log", ".asc", ".blf", ".trc", ".csv")
WRITABLE = (*READABLE, ".pcapng")


class BadLog(ValueError):
    """The file is no recording we can read; the message names it and says which are."""


def read_log(path: pathlib.Path) -> Iterator[Frame]:
    """Frames in the order of the file; raises BadLog, OSError."""
    if path.suffix not in READABLE:
        raise BadLog(f"{path}: a recording ends in {', '.join(READABLE)}; convert others with Wireshark or canlogs")
    if path.suffix == ".log" and _ours(path):
        with path.open() as lines:
            yield from frames_of(lines)
        return
    count = 0
    try:
        for message in can.LogReader(path):
            count += 1
            if not message.is_error_frame and not message.is_remote_frame:
                yield frame_of(message)
    except (ValueError, struct.error, IndexError, EOFError) as error:
        raise BadLog(f"{path}: after {count} frames: {error}") from error


def _ours(path: pathlib.Path) -> bool:
    """The broker's own log: remarks, or three more numbers behind each frame, which python-can does not know."""
    with path.open(errors="replace") as lines:
        return any(line.startswith("#") or len(line.split()) > 4 for line, _ in zip(lines, range(50), strict=False))


def frame_of(message: can.Message) -> Frame:
    """python-can's message as ours; stamp in ns of the recording's clock."""
    flag = EFF_FLAG if message.is_extended_id else 0
    return Frame(message.arbitration_id | flag, bytes(message.data), round(message.timestamp * 1e9))


def message_of(frame: Frame) -> can.Message:
    """Ours as python-can's."""
    return can.Message(
        timestamp=frame.stamp_ns / 1e9,
        arbitration_id=frame.identifier & ~EFF_FLAG,
        is_extended_id=bool(frame.identifier & EFF_FLAG),
        data=frame.data,
        is_rx=True,
    )


class LogWriter:
    """One file; the ending decides the form."""

    def __init__(self, path: pathlib.Path, channel: str) -> None:
        if path.suffix not in WRITABLE:
            raise BadLog(f"{path}: a recording ends in {', '.join(WRITABLE)}")
        self._path, self._channel = path, channel
        self._frames: list[Frame] = []
        self._writer = None if path.suffix == ".pcapng" else can.Logger(str(path))

    def put(self, frame: Frame) -> None:
        if self._writer is None:
            self._frames.append(frame)
            return
        message = message_of(frame)
        message.channel = self._channel
        self._writer.on_message_received(message)

    def close(self) -> None:
        if self._writer is not None:
            self._writer.stop()
        else:
            self._path.write_bytes(can_pcapng(self._frames, self._channel))
