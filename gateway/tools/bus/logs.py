"""Recordings of a CAN bus: read and written through python-can (candump, ASC, BLF, TRC, CSV), and our own pcapng writer.

A recording is frames with stamps; an extended frame carries bit 31 in its identifier and a remote frame bit 30, as in struct can_frame. The
data of a remote frame are as many zeros as it requests.
"""

import pathlib
from collections.abc import Iterator
from dataclasses import dataclass

import can

from drivers.ports.can.wire import EFF_FLAG, ID_BITS, RTR_FLAG
from gateway.pure.buses.candump import is_fd, marked_frames_of
from gateway.pure.lines.pcapng import can_pcapng
from protocols.base.machine import Frame, Ns

LINES = 50  # of a text, in which its form has to show
READABLE = (".log", ".asc", ".blf", ".trc", ".csv")
WRITABLE = (*READABLE, ".pcapng")


class BadLog(ValueError):
    """The file is not a readable recording; the message names it and the readable kinds."""


def read_log(path: pathlib.Path) -> Iterator[Frame]:
    """Frames in the order of the file; raises BadLog, OSError."""
    if path.suffix not in READABLE:
        raise BadLog(f"{path}: a recording ends in {', '.join(READABLE)}; convert others with Wireshark or canlogs")
    if path.suffix == ".log" and _ours(path):
        yield from _text(path)
        return
    if path.suffix == ".asc" and _relative(path):
        raise BadLog(f"{path}: its timestamps are relative, and events other than frames are lost: export it with absolute timestamps")
    count = 0
    try:
        for message in can.LogReader(path):
            count += 1
            if message.is_fd:
                raise BadLog(f"{path}: frame {count} is CAN FD; the buses here are classic CAN: export it without FD frames")
            if not message.is_error_frame:
                yield frame_of(message)
    except (BadLog, OSError, GeneratorExit):
        raise
    except Exception as error:  # whatever a torn or foreign file makes the library raise
        words = str(error) or type(error).__name__
        raise BadLog(f"{path}: after {count} frames: {words}; the file is torn or no {path.suffix} recording") from error
    if not count:
        raise BadLog(f"{path}: no frame in it; the file is torn, empty or no {path.suffix} recording")


def _text(path: pathlib.Path) -> Iterator[Frame]:
    """Candump text, also of the local bus; a file without one frame among its lines is another thing."""
    count = others = 0
    with path.open(encoding="utf-8", errors="replace") as lines:
        for number, line in enumerate(lines, 1):
            others += bool(line.strip()) and not line.startswith("#")
            if is_fd(line):
                raise BadLog(f"{path}: line {number} is CAN FD; the buses here are classic CAN: record it without FD frames")
            for frame in marked_frames_of((line,)):
                count += 1
                yield frame
            if number == LINES and not count and not line.startswith("#"):
                raise BadLog(f"{path}: none of its first {LINES} lines is a frame of candump, e.g. (1.000000) can0 201#0600")
    if others and not count:
        raise BadLog(f"{path}: none of its lines is a frame of candump, e.g. (1.000000) can0 201#0600")


def _relative(path: pathlib.Path) -> bool:
    """The header reports it in its first lines."""
    with path.open(encoding="utf-8", errors="replace") as lines:
        return any("timestamps relative" in line.lower() for line, _ in zip(lines, range(20), strict=False))


def _ours(path: pathlib.Path) -> bool:
    """The broker's own log: remarks, or three more numbers after each frame, which python-can does not read."""
    with path.open(encoding="utf-8", errors="replace") as lines:
        return any(line.startswith("#") or len(line.split()) > 4 for line, _ in zip(lines, range(LINES), strict=False))


def frame_of(message: can.Message) -> Frame:
    """python-can's message as a frame; stamp in ns of the recording's clock."""
    flag = (EFF_FLAG if message.is_extended_id else 0) | (RTR_FLAG if message.is_remote_frame else 0)
    data = bytes(message.dlc) if message.is_remote_frame else bytes(message.data)
    return Frame(message.arbitration_id | flag, data, round(message.timestamp * 1e9))


@dataclass(frozen=True, slots=True)
class FdFrame:
    """A CAN FD frame: shown and counted, but not decoded."""

    identifier: int
    data: bytes  # up to 64
    stamp_ns: Ns
    fast: bool  # its data at the second bit rate (BRS)


def fd_frame_of(message: can.Message) -> FdFrame:
    flag = EFF_FLAG if message.is_extended_id else 0
    return FdFrame(message.arbitration_id | flag, bytes(message.data), round(message.timestamp * 1e9), message.bitrate_switch)


def message_of(frame: Frame) -> can.Message:
    """A frame as python-can's message."""
    remote = bool(frame.identifier & RTR_FLAG)
    return can.Message(
        timestamp=frame.stamp_ns / 1e9,
        arbitration_id=frame.identifier & ID_BITS,
        is_extended_id=bool(frame.identifier & EFF_FLAG),
        is_remote_frame=remote,
        dlc=len(frame.data),
        data=None if remote else frame.data,
        is_rx=True,
    )


class Candump(can.CanutilsLogWriter):
    """Format of candump -L: python-can's own leaves out how many bytes a remote frame requests."""

    def on_message_received(self, msg: can.Message) -> None:
        if not msg.is_remote_frame or not msg.dlc:
            super().on_message_received(msg)
            return
        self.last_timestamp = max(self.last_timestamp or 0.0, msg.timestamp)
        width = 8 if msg.is_extended_id else 3
        self.file.write(f"({self.last_timestamp:f}) {msg.channel or self.channel} {msg.arbitration_id:0{width}X}#R{msg.dlc} R\n")


class LogWriter:
    """One file; the ending decides the form."""

    def __init__(self, path: pathlib.Path, channel: str) -> None:
        if path.suffix not in WRITABLE:
            raise BadLog(f"{path}: a recording ends in {', '.join(WRITABLE)}")
        self._path, self._channel = path, channel
        self._frames: list[Frame] = []
        self._writer = None if path.suffix == ".pcapng" else Candump(path) if path.suffix == ".log" else can.Logger(str(path))

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
