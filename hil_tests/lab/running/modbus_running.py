"""A Modbus server running in its own loop and thread, and a raw client that counts nothing and forgives nothing."""

import asyncio
import socket
import ssl
import struct
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Self

from gateway.links.modbus.tcp_server import Limits, ModbusServer, OnRequest, RightsFor
from hil_tests.lab.virtual.modbus_view import MemoryView
from protocols.modbus.view import View


class RawClient:
    """A plain socket with the few words of a client; bytes are the test's business."""

    def __init__(self, port: int, buffers: int | None = None) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        if buffers is not None:  # a small kernel on the client's side, so that the server's limits are met soon
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffers)
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, buffers)
        self.socket.settimeout(10)
        self.socket.connect(("127.0.0.1", port))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def send(self, data: bytes) -> None:
        self.socket.sendall(data)

    def take(self, count: int) -> bytes:
        """Exactly this many bytes; fewer only when the server closes."""
        data = bytearray()
        while len(data) < count and (more := self._some(count - len(data))):
            data += more
        return bytes(data)

    def ask(self, pdu: str, transaction: int = 1, unit: int = 1) -> str:
        """One request PDU and its answer PDU, in hex; the header is checked."""
        body = bytes.fromhex(pdu)
        self.send(struct.pack(">HHHB", transaction, 0, len(body) + 1, unit) + body)
        header = self.take(7)
        assert len(header) == 7, "the server closed instead of answering"
        got_transaction, protocol, length, got_unit = struct.unpack(">HHHB", header)
        assert (got_transaction, protocol, got_unit) == (transaction, 0, unit)
        return self.take(length - 1).hex(" ").upper()

    def closed_after_s(self) -> float:
        """Waits for the server's end of this connection; seconds it took (bytes on the way are thrown away)."""
        start = time.monotonic()
        while self._some(65536):
            pass
        return time.monotonic() - start

    def _some(self, count: int) -> bytes:
        try:
            return self.socket.recv(count)
        except ConnectionError:  # closed with our bytes unread: an end like any other
            return b""


class Running:
    """`with Running() as running:` a server over a MemoryView on a free port, or on `port`; nothing may reach the loop's handler."""

    def __init__(
        self,
        view: MemoryView | None = None,
        limits: Limits | None = None,
        allow: list[str] | None = None,
        on_request: OnRequest | None = None,
        view_for: Callable[[int], View | None] | None = None,
        rtu: bool = False,
        rights_for: RightsFor | None = None,
        tls: ssl.SSLContext | None = None,
        port: int = 0,
    ) -> None:
        self.view = view or MemoryView()
        chosen = view_for or (lambda unit: self.view if unit == 1 else None)
        bounds = replace(limits or Limits(), allow=allow)
        self.server = ModbusServer(chosen, port=port, limits=bounds, on_request=on_request, rtu=rtu)
        self.server.rights_for, self.server.tls = rights_for, tls
        self.loop = asyncio.new_event_loop()
        self.complaints: list[str] = []
        self.loop.set_exception_handler(lambda _, context: self.complaints.append(str(context)))
        self._thread = threading.Thread(target=self.loop.run_forever, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        asyncio.run_coroutine_threadsafe(self.server.start(), self.loop).result(10)
        return self

    def __exit__(self, *_: object) -> None:
        asyncio.run_coroutine_threadsafe(self.server.close(), self.loop).result(10)
        self.loop.call_soon_threadsafe(self.loop.stop)
        self._thread.join(10)
        self.loop.close()
        assert self.complaints == []

    @property
    def port(self) -> int:
        return self.server.address[1]

    def client(self, buffers: int | None = None) -> RawClient:
        return RawClient(self.port, buffers)

    def until(self, holds: Callable[[], bool], what: str, limit_s: float = 10.0) -> None:
        """Waits for something the server's loop will do; fails by name after the limit."""
        end = time.monotonic() + limit_s
        while not holds():
            assert time.monotonic() < end, f"{what}: not within {limit_s} s"
            time.sleep(0.005)
