"""What a mirror port and tcpdump give: a proxy between a PLC and its Modbus server that writes each segment, as pcap, into a FIFO."""

import contextlib
import os
import pathlib
import select
import socket
import struct
import threading
import time
from dataclasses import dataclass, field

HEAD = struct.pack("<IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, 65535, 1)  # nanoseconds, Ethernet
LOOPBACK = bytes((127, 0, 0, 1))
ACK, PUSH = 0x10, 0x08


def record(packet: bytes, stamp_ns: int) -> bytes:
    """One packet of the capture."""
    return struct.pack("<IIII", stamp_ns // 1_000_000_000, stamp_ns % 1_000_000_000, len(packet), len(packet)) + packet


def segment(source: tuple[bytes, int], target: tuple[bytes, int], sequence: int, data: bytes, flags: int = ACK | PUSH) -> bytes:
    """Ethernet, IPv4, TCP; sums are left at 0, as with offloading cards."""
    tcp = struct.pack(">HHIIBBHHH", source[1], target[1], sequence % (1 << 32), 0, 5 << 4, flags, 8192, 0, 0) + data
    ip = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(tcp), 0, 0x4000, 64, 6, 0) + source[0] + target[0]
    return bytes(12) + b"\x08\x00" + ip + tcp


@dataclass
class CapturedWire:
    """Listens on `port`; every connection is forwarded to `server`."""

    server: int
    fifo: pathlib.Path
    port: int = 0
    lost: int = 0
    _stop: threading.Event = field(default_factory=threading.Event)
    _fd: int = -1

    def __post_init__(self) -> None:
        os.mkfifo(self.fifo)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        self._thread.join(5)
        self._listener.close()
        if self._fd >= 0:
            os.close(self._fd)

    def _run(self) -> None:
        while not self._stop.is_set():
            if not select.select([self._listener], [], [], 0.05)[0]:
                continue
            plc, peer = self._listener.accept()
            with contextlib.suppress(OSError), plc, socket.create_connection(("127.0.0.1", self.server)) as control:
                self._pass(plc, control, (LOOPBACK, peer[1]))

    def _pass(self, plc: socket.socket, control: socket.socket, client: tuple[bytes, int]) -> None:
        server = (LOOPBACK, self.server)
        ways = {plc: (control, client, server), control: (plc, server, client)}
        at = {plc: 1000, control: (1 << 32) - 100}  # one of them comes round
        for end in ways:
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        while not self._stop.is_set():
            for source in select.select(list(ways), [], [], 0.05)[0]:
                data = source.recv(4096)
                if not data:
                    return
                target, sender, receiver = ways[source]
                self._keep(segment(sender, receiver, at[source], data))
                at[source] += len(data)
                target.sendall(data)

    def _keep(self, packet: bytes) -> None:
        """Only while somebody reads."""
        try:
            if self._fd < 0:
                self._fd = os.open(self.fifo, os.O_WRONLY | os.O_NONBLOCK)
                os.write(self._fd, HEAD)
            os.write(self._fd, record(packet, time.time_ns()))
        except BlockingIOError:
            self.lost += 1
        except OSError:
            if self._fd >= 0:
                os.close(self._fd)
            self._fd = -1
