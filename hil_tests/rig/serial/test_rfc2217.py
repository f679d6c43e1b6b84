"""rfc2217:// against pyserial's own server side (serial.rfc2217.PortManager) on the loopback, a pty with our passive partner behind."""

import os
import pty
import socket
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest
import serial
from serial import rfc2217

from drivers.ports.base import BytePort, PortError
from drivers.ports.open import open_bytes
from hil_tests.lab.partners.sync_line import SyncLine
from protocols.p3964r.events import BlockReceived, BlockSent, Event
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority, profile_named


class PtySerial(serial.Serial):
    """A pty has no modem lines; the server asks for them."""

    cts = dsr = cd = property(lambda self: True)
    ri = property(lambda self: False)

    def _update_rts_state(self) -> None: ...
    def _update_dtr_state(self) -> None: ...


@dataclass
class Server:
    """One connection at a time, as pyserial's example does it; `far` is the other end of the serial line."""

    far: int
    near: serial.Serial
    listener: socket.socket = field(default_factory=lambda: socket.create_server(("127.0.0.1", 0)))
    connection: socket.socket | None = None

    def serve(self) -> None:
        self.connection, _ = self.listener.accept()
        connection = self.connection
        make: Any = rfc2217.PortManager  # typed for its own port class
        manager = make(self.near, self)

        def out() -> None:
            while True:
                try:
                    data = self.near.read(self.near.in_waiting or 1)
                    if data:
                        self.write(b"".join(manager.escape(data)))
                except (OSError, serial.SerialException, TypeError, AttributeError, ValueError):
                    return

        threading.Thread(target=out, daemon=True).start()
        while True:
            try:
                data = connection.recv(1024)
                if not data:
                    return
                self.near.write(b"".join(manager.filter(data)))
            except (OSError, serial.SerialException):
                return

    def write(self, data: bytes) -> None:
        """PortManager answers through this."""
        if self.connection is not None:
            self.connection.sendall(data)

    @property
    def url(self) -> str:
        return f"rfc2217://127.0.0.1:{self.listener.getsockname()[1]}"


@pytest.fixture
def server() -> Iterator[Server]:
    far, near = pty.openpty()
    found = Server(far, PtySerial(os.ttyname(near), 9600, timeout=0.02))
    threading.Thread(target=found.serve, daemon=True).start()
    yield found
    for closing in (found.connection, found.listener):
        if closing is not None:
            closing.close()
    found.near.close()
    os.close(far)
    os.close(near)


def read_all(port: BytePort, count: int) -> bytes:
    data, until = b"", time.monotonic() + 3
    while len(data) < count and time.monotonic() < until:
        for item in port.read():
            assert isinstance(item, bytes)
            data += item
        time.sleep(0.01)
    return data


def test_bytes_go_both_ways_ffh_too_and_the_server_takes_the_frame(server: Server) -> None:
    port = open_bytes(server.url, "4800 8N1")
    every = bytes(range(256))
    assert port.write(every) == 256
    found = b""
    while len(found) < 256:
        found += os.read(server.far, 512)
    assert found == every and server.near.baudrate == 4800
    os.write(server.far, every)
    assert read_all(port, 256) == every and port.read() == []
    port.close()
    port.close()


def test_a_block_goes_through(server: Server) -> None:
    link = Link(profile_named("rho3-tcp"), Priority.LOW)
    line = SyncLine[Event](open_bytes(server.url, "9600 8N1"), link)
    partner = Link(RHO3, Priority.HIGH)
    threading.Thread(target=_partner, args=(partner, server.far), daemon=True).start()
    link.send(b"hello\x10", time.monotonic_ns())
    assert line.run_until(lambda: any(isinstance(event, BlockSent) for _, event in line.events), 5)
    line.close()


def _read_for(port: BytePort, seconds: float) -> None:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        port.read()
        time.sleep(0.01)


def _partner(link: Link, far: int) -> None:
    while True:
        try:
            events = link.receive(os.read(far, 64), time.monotonic_ns())
        except OSError:
            return
        os.write(far, link.take_output())
        link.sent(time.monotonic_ns())
        if any(isinstance(event, BlockReceived) for event in events):
            return


def test_nobody_there_and_a_connection_that_ends(server: Server) -> None:
    with pytest.raises(PortError, match="no connection"):
        open_bytes("rfc2217://127.0.0.1:1", "9600 8N1")
    port = open_bytes(server.url, "9600 8N1")
    assert server.connection is not None
    server.connection.shutdown(socket.SHUT_RDWR)
    with pytest.raises(PortError, match="lost"):
        _read_for(port, 3.0)
    port.close()
