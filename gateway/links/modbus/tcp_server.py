"""Modbus TCP server inside asyncio: connections, limits and counters; framing and answers are protocols.modbus.

A faulty partner can lose its connection, nothing else.  Per client at most Limits.held_bytes stay in this process: a chunk is read, all its
requests are answered, and nothing more is read until the partner has read the answers (the kernel's buffers then stop it).  One timer
sweeps all connections for half frames, silence and answers that are not read.
"""

import asyncio
import errno
import ipaddress
import socket
import ssl
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from drivers.ports.base import PortError
from gateway.links.modbus.responder import Client, Counters, ModbusResponder, OnRequest
from protocols.base.machine import Ns, ms
from protocols.modbus.mbap import MAX_LENGTH, RECEIVE_LIMIT, Closing, Event, Foreign, Framing, Request, Why
from protocols.modbus.rights import Rights
from protocols.modbus.rtu import RtuTcpFraming
from protocols.modbus.station import Identity, Station
from protocols.modbus.view import View

__all__ = ["Client", "Counters", "Limits", "ModbusServer", "OnRequest", "RightsFor"]

DEFAULT_PORT = 1502  # 502 needs a permission on most systems (AX-012)
CHUNK_BYTES = 256  # read at once: one client's turn, 21 short requests; with all of them flooding the loop comes round within 50 ms
READ_REQUEST, LONGEST_ANSWER = 12, 260  # bytes on the wire of the request with the longest answer, and of that answer
CHUNK_ANSWERS = (CHUNK_BYTES + MAX_LENGTH) // READ_REQUEST * LONGEST_ANSWER  # all answers to one chunk fit into this
KERNEL_BYTES = 64 * 1024  # of each direction of a connection
KEEPALIVE = ((socket.TCP_KEEPIDLE, 5), (socket.TCP_KEEPINTVL, 2), (socket.TCP_KEEPCNT, 3))  # a dead partner's place is free after 11 s
STALL_LIMIT = ms(10_000)
SWEEP_S = 0.1
TLS_HANDSHAKE_S = 5.0
RightsFor = Callable[[asyncio.Transport], "tuple[Rights, str] | None"]


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of one server and of each of its clients (AX-073)."""

    clients: int = 32  # at once; the next one is closed at once
    per_address: int | None = None  # of them from one address; None: no separate limit
    held_bytes: int = 64 * 1024  # per client, in this process
    receive_limit_ns: Ns = RECEIVE_LIMIT  # a frame's first byte to its last
    stall_limit_ns: Ns = STALL_LIMIT  # answers waiting without being read
    idle_limit_ns: Ns | None = None  # no byte at all; None: idle clients stay
    allow: Sequence[str] | None = None  # addresses or networks that may write; None: all; the others only read, 01 for a write (AX-070)


class ModbusServer:
    """Listens on one address and answers every request from the view of its unit.

    view_for(unit) returns the tables or None (answered 0Bh; with rtu in silence); units 0 and 255 arrive there as `unit` (AX-012).
    rtu: RTU frames in the stream instead of the Modbus TCP header.
    on_request("host:port", function code) is called after each request answered without an exception.
    Set before start(): rights_for(transport), instead of Limits.allow: rights and role of a partner, None closes the connection;
    tls: a server context, with the handshake first.
    """

    def __init__(
        self,
        view_for: Callable[[int], View | None],
        host: str = "127.0.0.1",
        port: int = DEFAULT_PORT,
        *,
        unit: int = 1,
        limits: Limits | None = None,
        on_request: OnRequest | None = None,
        rtu: bool = False,
        identity: Identity | None = None,
    ) -> None:
        self.limits = limits or Limits()
        if self.limits.held_bytes < 2 * CHUNK_ANSWERS:
            raise ValueError(f"held_bytes: {self.limits.held_bytes}; at least {2 * CHUNK_ANSWERS} bytes")
        self.responder = ModbusResponder(view_for, unit, on_request, Station(identity, unit), line=rtu)
        self.rtu = rtu
        self.tls: ssl.SSLContext | None = None
        self.on_refused: Callable[[str, str], None] | None = None  # a partner's address, and why its TLS handshake failed
        self.rights_for: RightsFor | None = None
        allow = self.limits.allow
        self._allow = None if allow is None else [ipaddress.ip_network(text, strict=False) for text in allow]
        self._host, self._port = host, port
        self._connections: set[_Connection] = set()
        self._addresses: Counter[str] = Counter()
        self._server: asyncio.Server | None = None
        self._sweeper: asyncio.TimerHandle | None = None

    @property
    def counters(self) -> Counters:
        return self.responder.counters

    @property
    def last_request_ns(self) -> Ns | None:
        return self.responder.last_request_ns

    @property
    def address(self) -> tuple[str, int]:
        """Host and port of the server (the real port if 0 was given)."""
        return self._host, self._port

    @property
    def clients(self) -> list[Client]:
        return [connection.client for connection in self._connections]

    def unsent_bytes(self) -> int:
        """Answers in this process that partners have not read yet."""
        return sum(connection.unsent_bytes() for connection in self._connections)

    async def start(self) -> None:
        """Listen; PortError names the port and the remedy."""
        listener = _listen(self._host, self._port)
        self._port = listener.getsockname()[1]
        self._server = await asyncio.get_running_loop().create_server(self._partner, sock=listener)
        self._sweep_later()

    def _partner(self) -> "_Connection | _Handshake":
        return _Connection(self) if self.tls is None else _Handshake(self, self.tls)

    async def close(self) -> None:
        """Ends listening and all connections; afterwards nothing of this server is left in the loop."""
        if self._sweeper is not None:
            self._sweeper.cancel()
        if self._server is not None:
            self._server.close()
        for connection in list(self._connections):
            connection.drop()
        while self._connections:  # each leaves by its connection_lost, which the loop has queued already
            await asyncio.sleep(0)

    def may_write(self, host: str) -> bool:
        """Whether `allow` lets this address write."""
        if self._allow is None:
            return True
        partner = ipaddress.ip_address(host.partition("%")[0])
        if isinstance(partner, ipaddress.IPv6Address) and partner.ipv4_mapped is not None:
            partner = partner.ipv4_mapped
        return any(partner in network for network in self._allow)

    def rights_of(self, host: str, transport: asyncio.Transport) -> tuple[Rights, str] | None:
        """Rights and role of a new partner; None: no access."""
        if self.rights_for is not None:
            return self.rights_for(transport)
        return Rights(write=self.may_write(host)), ""

    def enter(self, connection: "_Connection", host: str) -> bool:
        """Whether there is a place for this new connection."""
        self.counters.connections += 1
        most = self.limits.per_address
        if len(self._connections) >= self.limits.clients or (most is not None and self._addresses[host] >= most):
            self.counters.refused_connections += 1
            return False
        self._connections.add(connection)
        self._addresses[host] += 1
        return True

    def leave(self, connection: "_Connection", host: str) -> None:
        self._connections.discard(connection)
        self._addresses[host] -= 1
        if self._addresses[host] <= 0:
            del self._addresses[host]

    def _sweep_later(self) -> None:
        self._sweeper = asyncio.get_running_loop().call_later(SWEEP_S, self._sweep)

    def _sweep(self) -> None:
        now = time.monotonic_ns()
        for connection in list(self._connections):
            connection.sweep(now)
        self._sweep_later()


class _Handshake(asyncio.Protocol):
    """A partner during its TLS handshake: a failure is reported here, because asyncio reports nothing."""

    def __init__(self, server: ModbusServer, context: ssl.SSLContext) -> None:
        self._server, self._context = server, context

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        transport.pause_reading()  # its first bytes are the handshake's
        self._task = asyncio.get_running_loop().create_task(self._secured(transport))

    async def _secured(self, transport: asyncio.Transport) -> None:
        peer = transport.get_extra_info("peername")
        connection = _Connection(self._server)
        loop = asyncio.get_running_loop()
        try:
            secured = await loop.start_tls(transport, connection, self._context, server_side=True, ssl_handshake_timeout=TLS_HANDSHAKE_S)
        except OSError as error:  # ssl.SSLError, a time-out, a connection closed
            transport.abort()
            if peer is not None and self._server.on_refused is not None:
                self._server.on_refused(str(peer[0]), _reason(error))
            return
        if secured is not None:
            connection.connection_made(secured)


def _reason(error: OSError) -> str:
    if isinstance(error, ssl.SSLError) and error.reason:
        return error.reason.lower().replace("_", " ")
    return str(error) or type(error).__name__


class _Connection(asyncio.BufferedProtocol):
    """One client's connection: bytes between the transport and its framing machine."""

    def __init__(self, server: ModbusServer) -> None:
        self._server = server
        self._buffer = bytearray(CHUNK_BYTES)
        limit = server.limits.receive_limit_ns
        self._framing: Framing | RtuTcpFraming = RtuTcpFraming(limit) if server.rtu else Framing(limit)
        self._serve = server.responder.serve
        self._transport: asyncio.Transport | None = None
        self._stalled_ns: Ns | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        peer, now = transport.get_extra_info("peername"), time.monotonic_ns()
        known = None if peer is None else self._server.rights_of(peer[0], transport)
        if peer is None or known is None or not self._server.enter(self, peer[0]):  # no name: it has gone already
            transport.abort()
            return
        self._host = str(peer[0])
        self.client = Client(f"{peer[0]}:{peer[1]}", known[0], now, now, role=known[1])
        self._transport = transport
        transport.set_write_buffer_limits(high=self._server.limits.held_bytes - CHUNK_ANSWERS)

    def connection_lost(self, exc: Exception | None) -> None:
        if self._transport is None:
            return
        self._server.leave(self, self._host)
        self._take(self._framing.lost(time.monotonic_ns()), 0)

    def get_buffer(self, sizehint: int) -> bytearray:
        return self._buffer

    def buffer_updated(self, nbytes: int) -> None:
        now = time.monotonic_ns()
        self.client.last_byte_ns = now
        self._take(self._framing.receive(bytes(self._buffer[:nbytes]), now), now)

    def pause_writing(self) -> None:
        self._stalled_ns = time.monotonic_ns()
        if self._transport is not None:
            self._transport.pause_reading()

    def resume_writing(self) -> None:
        self._stalled_ns = None
        self._framing.reading_again(time.monotonic_ns())
        if self._transport is not None:
            self._transport.resume_reading()

    def unsent_bytes(self) -> int:
        return 0 if self._transport is None else self._transport.get_write_buffer_size()

    def drop(self) -> None:
        """End the connection without waiting until answers are read."""
        if self._transport is not None:
            self._transport.abort()

    def sweep(self, now: Ns) -> None:
        """Check time-outs: a half frame, a stalled or an idle partner."""
        limits, counters = self._server.limits, self._server.counters
        if self._stalled_ns is not None:
            if now - self._stalled_ns >= limits.stall_limit_ns:
                counters.stalled += 1
                self.drop()
        elif limits.idle_limit_ns is not None and now - self.client.last_byte_ns >= limits.idle_limit_ns:
            counters.idle += 1
            self.drop()
        else:
            self._take(self._framing.wake(now), now)

    def _take(self, events: Sequence[Event], now: Ns) -> None:
        for event in events:
            if isinstance(event, Request):
                pdu = self._serve(event, self.client, now)
                if pdu:
                    self._framing.reply(event, pdu)
            elif isinstance(event, Foreign):
                self.client.foreign += 1
                self._server.counters.foreign += 1
            else:
                self._end(event)
        output = self._framing.take_output()
        if output and self._transport is not None:
            self._transport.write(output)

    def _end(self, event: Closing) -> None:
        self._server.counters.closed[event.why] += 1
        if self._transport is not None and event.why is not Why.LOST:
            self._transport.write(self._framing.take_output())  # requests received before the fault are answered
            self._transport.close()


def _listen(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        listener = socket.create_server((host, port), family=family, backlog=64)
    except OSError as error:
        raise PortError(_advice(host, port, error)) from error
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)  # accepted connections inherit all of these
    for option in (socket.SO_SNDBUF, socket.SO_RCVBUF):  # fixed: the kernel would let each grow to megabytes
        listener.setsockopt(socket.SOL_SOCKET, option, KERNEL_BYTES)
    for option, seconds in KEEPALIVE:
        listener.setsockopt(socket.IPPROTO_TCP, option, seconds)
    return listener


def _advice(host: str, port: int, error: OSError) -> str:
    match error.errno:
        case errno.EADDRINUSE:
            advice = f"in use by another program; stop that one (`ss -ltnp 'sport = :{port}'` names it) or set another port in `bind`"
        case errno.EACCES:
            advice = f"no permission for a port below 1024; use {DEFAULT_PORT}, or `sysctl net.ipv4.ip_unprivileged_port_start={port}`"
        case errno.EADDRNOTAVAIL:
            advice = f"no interface of this machine has the address {host}; set `bind` to one that exists (`ip address` lists them)"
        case _:
            advice = f"cannot listen: {error.strerror or error}; correct `bind`"
    return f"Modbus server {host}:{port}: {advice}"
