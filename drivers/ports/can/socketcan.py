"""A CAN interface of the Linux kernel: raw AF_CAN, never blocking.

Source: Documentation/networking/can.rst; linux/can/raw.h, linux/can/error.h; AX-096 (stamps).

Stamps are the kernel's receive times (SO_TIMESTAMPNS, wall clock), moved to the monotonic clock by the distance of the two clocks at
the moment of reading.  A wall clock set between the frame and its reading would shift the stamp: it is then kept between the last stamp
and now.
"""

import errno
import os
import socket
import struct
import time
from collections.abc import Sequence
from pathlib import Path

from drivers.ports.base import PortError
from drivers.ports.can.restart import restart
from drivers.ports.can.wire import CAN_FRAME, CONTROL, EFF_FLAG, ERR_FLAG, CanCounters, check_frame, fault_of
from protocols.base.machine import Frame, FrameFault, Ns

SO_TIMESTAMPNS = 35  # asm-generic/socket.h; the control message that carries the stamp has the same number
CAN_RAW_ERR_FILTER = 2  # linux/can/raw.h
CAN_ERR_MASK = 0x1FFFFFFF
TIMESPEC = struct.Struct("=qq") if struct.calcsize("@l") == 8 else struct.Struct("=ll")
ANCILLARY_BYTES = socket.CMSG_SPACE(TIMESPEC.size)
BURST = 512
NET = Path("/sys/class/net")


class SocketCanPort:
    """CanPort of one interface.  Own frames are not received (other programs on this computer receive them); error frames come by
    take_faults().
    """

    not_data = CONTROL  # flags of frames that receive() leaves out; see drivers.ports.can.remote_frames

    def __init__(self, interface: str) -> None:
        self.name = f"socketcan:{interface}"
        self.counters = CanCounters()
        self._faults: list[tuple[FrameFault, Ns]] = []
        self._last_ns = 0
        self._socket = self._open(interface)

    def _open(self, interface: str) -> socket.socket:
        try:
            link = socket.socket(socket.AF_CAN, socket.SOCK_RAW | socket.SOCK_NONBLOCK, socket.CAN_RAW)
        except (OSError, AttributeError) as error:
            raise PortError(f"{self.name}: this kernel has no CAN (AF_CAN): modprobe can-raw, or use broker:NAME") from error
        try:
            link.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
            link.setsockopt(socket.SOL_CAN_RAW, CAN_RAW_ERR_FILTER, CAN_ERR_MASK)
            link.bind((interface,))
        except OSError as error:
            link.close()
            raise PortError(_advice(self.name, interface, error)) from error
        if not _is_up(interface):
            link.close()
            raise PortError(f"{self.name}: the interface is down: sudo ip link set {interface} up")
        restart(interface)  # one that is at bus-off; refused everywhere else
        return link

    def fileno(self) -> int:
        return self._socket.fileno()

    def send(self, frames: Sequence[Frame]) -> int:
        """Number of frames accepted, in order; the others are counted as refused (ENOBUFS: the interface's queue is full;
        EAGAIN: its own).
        """
        for frame in frames:
            check_frame(frame)
        for taken, frame in enumerate(frames):
            try:
                self._socket.send(CAN_FRAME.pack(frame.identifier, len(frame.data), frame.data))
            except OSError as error:
                if error.errno not in (errno.ENOBUFS, errno.EAGAIN):
                    raise PortError(_advice(self.name, self.name.partition(":")[2], error)) from error
                self.counters.sent += taken
                self.counters.refused += len(frames) - taken
                return taken
        self.counters.sent += len(frames)
        return len(frames)

    def receive(self) -> list[Frame]:
        """Everything that waits, with kernel stamps on the monotonic clock."""
        raw = self._drain()
        now = time.monotonic_ns()
        offset = time.time_ns() - now
        frames: list[Frame] = []
        for octets, wall_ns in raw:
            can_id, length, data = CAN_FRAME.unpack(octets)
            self._last_ns = min(max(self._last_ns, wall_ns - offset if wall_ns else now), now)
            if not can_id & self.not_data:
                frames.append(Frame(can_id, data[:length], self._last_ns))
            elif can_id & ERR_FLAG:
                self.counters.faults += 1
                self._faults.append((fault_of(can_id & ~EFF_FLAG, data[:length]), self._last_ns))
            else:
                self.counters.ignored += 1
        self.counters.received += len(frames)
        return frames

    def _drain(self) -> list[tuple[bytes, Ns]]:
        raw: list[tuple[bytes, Ns]] = []
        for _ in range(BURST):
            try:
                octets, ancillary, _, _ = self._socket.recvmsg(CAN_FRAME.size, ANCILLARY_BYTES)
            except BlockingIOError:
                break
            except OSError as error:
                if raw:
                    break  # return what came before first; the next call reports the fault
                raise PortError(_advice(self.name, self.name.partition(":")[2], error)) from error
            raw.append((octets, _wall_ns(ancillary)))
        return raw

    def receive_next(self) -> list[Frame]:
        """Everything: to leave some of it would be no cheaper here."""
        return self.receive()

    def take_faults(self) -> list[tuple[FrameFault, Ns]]:
        """Error frames since the last call, with their stamps; call it after receive()."""
        faults, self._faults = self._faults, []
        return faults

    def close(self) -> None:
        self._socket.close()


def _wall_ns(ancillary: list[tuple[int, int, bytes]]) -> Ns:
    for level, kind, data in ancillary:
        if level == socket.SOL_SOCKET and kind == SO_TIMESTAMPNS and len(data) == TIMESPEC.size:
            seconds, nanoseconds = TIMESPEC.unpack(data)
            return int(seconds) * 1_000_000_000 + int(nanoseconds)
    return 0


def _is_up(interface: str) -> bool:
    try:
        return bool(int((NET / interface / "flags").read_text(), 16) & 1)  # IFF_UP
    except OSError:
        return True  # no sysfs here: the first send shows it


def _advice(name: str, interface: str, error: OSError) -> str:
    """One line: the fault and the remedy."""
    match error.errno:
        case errno.ENODEV | errno.ENXIO:
            make = f"sudo ip link add dev {interface} type vcan && " if interface.startswith("vcan") else ""
            return f"{name}: no such interface ('ip link' lists them); {make}sudo ip link set {interface} up"
        case errno.ENETDOWN:
            return f"{name}: the interface is down: sudo ip link set {interface} up"
        case errno.EPERM | errno.EACCES:
            return f"{name}: not permitted; a container needs --cap-add=NET_RAW"
        case _:
            return f"{name}: {error.strerror or os.strerror(error.errno or 0)}"
