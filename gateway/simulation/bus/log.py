"""The broker's log: lines as candump -L writes them, with bus stamps, written by a child process so that no disk ever stalls the bus.

    (12345.678901) drives 064# 3 4711 234
    stamp s.us     bus    frame  sender, sequence, ns within the microsecond

The three numbers at the end are axisgate's (AX-095); tools that read candump logs ignore them.  Lines that begin with # are remarks: who
connected, who was too slow, how many frames the log lost.  Between broker and child runs a pipe of records; when it and 65,536 more
records are full, frames are left out of the log, counted, and the log reports it.
"""

import collections
import contextlib
import fcntl
import os
import signal
import sys
import time

from drivers.ports.base import PortError
from drivers.ports.can.wire import CONTROL, COUNT, EFF_FLAG, ERR_FLAG, RECORD, RECORD_BYTES, RTR_FLAG, Control, control_record, text_record
from gateway.runtime.bounded_file import LIMIT, BoundedFile

PIPE_BYTES = 1 << 20
WAITING_RECORDS = 65_536
BATCH_BYTES = 128 * RECORD_BYTES
WRITE_BYTES = 1 << 16


class LogPipe:
    """The broker's end: accepts everything, never waits; `lost` counts frames missing from the log."""

    def __init__(self, path: str, name: str, limit: int = LIMIT) -> None:
        try:
            target = log_file(path, name, limit)  # inherited by the child
        except OSError as error:
            raise PortError(f"log {path}: {error.strerror}") from error
        inside, outside = os.pipe2(os.O_CLOEXEC)
        with contextlib.suppress(OSError):  # a smaller pipe only means an earlier gap
            fcntl.fcntl(outside, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        self._child = os.fork()
        if not self._child:
            os.close(outside)
            _child(inside, target, name)
        os.close(inside)
        target.close()
        os.set_blocking(outside, False)
        self._fd = outside
        self._waiting: collections.deque[bytes] = collections.deque()
        self._bytes = 0
        self.lost = 0
        self._untold = 0  # lost and not yet reported in the log
        self._gone = False

    def waiting(self) -> bool:
        """Some records have not reached the child."""
        return bool(self._waiting)

    def put(self, records: bytes) -> None:
        """Log these records, in batches."""
        if self._gone or self._bytes + len(records) > WAITING_RECORDS * RECORD_BYTES:
            self.lost += len(records) // RECORD_BYTES
            self._untold += len(records) // RECORD_BYTES
            return
        if self._untold:
            self._append(control_record(Control.GAP, COUNT.pack(self._untold), 0, time.monotonic_ns()))
            self._untold = 0
        self._append(records)
        if self._bytes >= BATCH_BYTES:
            self.flush()

    def note(self, text: str) -> None:
        """A remark line."""
        self._append(text_record(Control.TEXT, text.replace("\n", " ").encode(), time.monotonic_ns()))

    def _append(self, octets: bytes) -> None:
        self._waiting.append(octets)
        self._bytes += len(octets)

    def flush(self) -> None:
        """Write what the pipe accepts now."""
        parts: list[bytes] = []
        size = 0
        while self._waiting and size < WRITE_BYTES:  # not all of a long queue: joining it again and again would cost bus time
            parts.append(self._waiting.popleft())
            size += len(parts[-1])
        if not parts:
            return
        octets = b"".join(parts)
        try:
            taken = os.write(self._fd, octets)
        except BlockingIOError:
            taken = 0
        except OSError:
            self._gone, taken = True, size  # the child died; the bus continues
        self._bytes -= taken
        if taken < size:
            self._waiting.appendleft(octets[taken:])

    def close(self, limit_s: float = 5.0) -> None:
        """Everything to the file, then the child's end; a child that cannot write for `limit_s` is ended."""
        if self._untold:
            self._append(control_record(Control.GAP, COUNT.pack(self._untold), 0, time.monotonic_ns()))
        end = time.monotonic() + limit_s
        while self._waiting and not self._gone and time.monotonic() < end:
            self.flush()
            time.sleep(0.001)
        os.close(self._fd)
        while time.monotonic() < end:
            if os.waitpid(self._child, os.WNOHANG)[0]:
                return
            time.sleep(0.002)
        os.kill(self._child, signal.SIGKILL)
        os.waitpid(self._child, 0)


def _child(pipe: int, target: BoundedFile, name: str) -> None:
    """The child's life: ends when the broker closes the pipe or dies, after everything in it is written."""
    code = 1
    try:
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)  # the broker ends it by closing the pipe
        write_log(pipe, target, name)
        code = 0
    except Exception as error:
        print(f"broker:{name}: log ended: {error}", file=sys.stderr, flush=True)
    finally:
        os._exit(code)


def write_log(pipe: int, target: BoundedFile, name: str) -> None:
    """Records from the pipe to lines in the file until the pipe ends."""
    rest = b""
    while True:
        octets = rest + os.read(pipe, 65536)
        if len(octets) == len(rest):
            return
        lines, used = _lines(octets, name)
        rest = octets[used:]
        if lines:
            target.write("".join(lines).encode(), len(lines))


def log_file(path: str, name: str, limit: int) -> BoundedFile:
    """The file with its first line.  OSError."""
    head = f"# axisgate broker:{name}; stamps: CLOCK_MONOTONIC; after the frame: sender, sequence, ns within the microsecond\n"

    def lost(lines: int, reason: str) -> bytes:
        return f"# ({stamp_text(time.monotonic_ns())}) lost {lines} lines: {reason}\n".encode()

    return BoundedFile(path, head.encode(), lost, limit)


def _lines(octets: bytes, name: str) -> tuple[list[str], int]:
    """Lines of the complete records in there, and how many bytes they were."""
    lines: list[str] = []
    at = 0
    while at + RECORD_BYTES <= len(octets):
        can_id, length, sender, data, stamp, sequence = RECORD.unpack_from(octets, at)
        if can_id < CONTROL:
            lines.append(frame_line(name, can_id, data[:length], sender, stamp, sequence))
        elif can_id == CONTROL | Control.GAP:
            lines.append(f"# ({stamp_text(stamp)}) lost {COUNT.unpack(data)[0]} frames: the log could not be written in time\n")
        else:
            size = COUNT.unpack(data)[0]
            text_at = at + RECORD_BYTES
            if text_at + size + -size % RECORD_BYTES > len(octets):
                break
            lines.append(f"# ({stamp_text(stamp)}) {octets[text_at : text_at + size].decode(errors='replace')}\n")
            at += size + -size % RECORD_BYTES
        at += RECORD_BYTES
    return lines, at


def stamp_text(stamp_ns: int) -> str:
    """Seconds with six digits, as candump -L writes them."""
    return f"{stamp_ns // 1_000_000_000}.{stamp_ns // 1000 % 1_000_000:06d}"


def frame_line(name: str, can_id: int, data: bytes, sender: int, stamp_ns: int, sequence: int) -> str:
    """One line.  Source: candump of can-utils: 3 digits standard, 8 digits extended and error frames, #R remote."""
    if can_id & ERR_FLAG or can_id & EFF_FLAG:
        shown = f"{can_id & (0x1FFFFFFF | ERR_FLAG):08X}"
    else:
        shown = f"{can_id & 0x7FF:03X}"
    payload = f"R{len(data) or ''}" if can_id & RTR_FLAG else data.hex().upper()
    return f"({stamp_text(stamp_ns)}) {name} {shown}#{payload} {sender} {sequence} {stamp_ns % 1000:03d}\n"
