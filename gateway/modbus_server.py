"""Modbus TCP server inside asyncio: connections, limits and counters; framing and answers are protocols.modbus.

What a partner sends can cost it its connection and nothing else.  Per client at most Limits.held_bytes stay in this process: a chunk is
read, all its requests are answered, and while the partner does not take the answers nothing more is read (the kernel's buffers then
stop it).  One timer sweeps all connections for half frames, silence and answers nobody takes.
"""

import asyncio
import errno
import ipaddress
import socket
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from drivers.ports.base import PortError
from protocols.base.machine import Ns, ms
from protocols.modbus.answering import answer, exception
from protocols.modbus.mbap import MAX_LENGTH, RECEIVE_LIMIT, Closing, Event, Foreign, Framing, Request, Why
from protocols.modbus.view import ExceptionCode, View, home_unit

DEFAULT_PORT = 1502  # 502 needs a permission on most systems (AX-012)
CHUNK_BYTES = 1024  # read at once: also one client's turn before the next one's
EXCEPTION_BIT = 0x80
READ_REQUEST, LONGEST_ANSWER = 12, 260  # bytes on the wire of the request with the longest answer, and of that answer
CHUNK_ANSWERS = (CHUNK_BYTES + MAX_LENGTH) // READ_REQUEST * LONGEST_ANSWER  # all answers to one chunk fit into this
KERNEL_BYTES = 64 * 1024  # of each direction of a connection
KEEPALIVE = ((socket.TCP_KEEPIDLE, 5), (socket.TCP_KEEPINTVL, 2), (socket.TCP_KEEPCNT, 3))  # a dead partner's place is free after 11 s
STALL_LIMIT = ms(10_000)
SWEEP_S = 0.1

OnRequest = Callable[[str, int], None]


@dataclass(frozen=True, slots=True)
class Limits:
    """What one server and each of its clients may use (AX-073)."""

    clients: int = 32  # at once; the next one is closed at once
    held_bytes: int = 64 * 1024  # per client, in this process
    receive_limit_ns: Ns = RECEIVE_LIMIT  # a frame's first byte to its last
    stall_limit_ns: Ns = STALL_LIMIT  # answers waiting and nobody taking them
    idle_limit_ns: Ns | None = None  # no byte at all; None: idle clients stay


@dataclass(slots=True)
class Client:
    """One connected partner."""

    address: str  # "host:port"
    may_write: bool
    since_ns: Ns
    last_byte_ns: Ns
    last_request_ns: Ns | None = None  # the last one answered without exception
    requests: int = 0
    exceptions: int = 0
    foreign: int = 0


@dataclass(slots=True)
class Counters:
    """Since start, over all clients."""

    connections: int = 0
    refused_connections: int = 0
    requests: int = 0  # with those answered by an exception
    exceptions: Counter[ExceptionCode] = field(default_factory=Counter)
    foreign: int = 0  # frames of another protocol identifier
    closed: Counter[Why] = field(default_factory=Counter)
    stalled: int = 0  # closed because answers were not taken
    idle: int = 0
    view_faults: int = 0  # a view or the callback raised: our own mistake, answered with 04
    last_view_fault: str = ""


class ModbusServer:
    """Listens on one address and answers every request from the view of its unit.

    view_for(unit) gives the tables or None (answered 0Bh); units 0 and 255 arrive there as `unit` (AX-012).
    allow: addresses or networks that may write; None: everybody may; all others only read and get 01 for a write (AX-070).
    on_request("host:port", function code) is called after each request that was answered without exception.
    """

    def __init__(
        self,
        view_for: Callable[[int], View | None],
        host: str = "127.0.0.1",
        port: int = DEFAULT_PORT,
        *,
        unit: int = 1,
        allow: Sequence[str] | None = None,
        limits: Limits | None = None,
        on_request: OnRequest | None = None,
    ) -> None:
        self.limits = limits or Limits()
        if self.limits.held_bytes < 2 * CHUNK_ANSWERS:
            raise ValueError(f"held_bytes: {self.limits.held_bytes}; at least {2 * CHUNK_ANSWERS} bytes")
        self.counters = Counters()
        self.last_request_ns: Ns | None = None
        self._view_for, self._unit, self._on_request = view_for, unit, on_request
        self._allow = None if allow is None else [ipaddress.ip_network(text, strict=False) for text in allow]
        self._host, self._port = host, port
        self._connections: set[_Connection] = set()
        self._server: asyncio.Server | None = None
        self._sweeper: asyncio.TimerHandle | None = None

    @property
    def address(self) -> tuple[str, int]:
        """Host and port listened on (the real port where 0 was asked for)."""
        return self._host, self._port

    @property
    def clients(self) -> list[Client]:
        return [connection.client for connection in self._connections]

    def unsent_bytes(self) -> int:
        """Answers in this process that partners have not taken yet."""
        return sum(connection.unsent_bytes() for connection in self._connections)

    async def start(self) -> None:
        """Listens; PortError names the port and what to do when it cannot."""
        listener = _listen(self._host, self._port)
        self._port = listener.getsockname()[1]
        self._server = await asyncio.get_running_loop().create_server(lambda: _Connection(self), sock=listener)
        self._sweep_later()

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

    def enter(self, connection: "_Connection") -> bool:
        """Whether there is a place for this new connection."""
        self.counters.connections += 1
        if len(self._connections) >= self.limits.clients:
            self.counters.refused_connections += 1
            return False
        self._connections.add(connection)
        return True

    def leave(self, connection: "_Connection") -> None:
        self._connections.discard(connection)

    def serve(self, request: Request, client: Client, now: Ns) -> bytes:
        """The answer PDU to one request; a view that raises costs its request, never the connection or the loop."""
        self.counters.requests += 1
        client.requests += 1
        try:
            result = answer(request.pdu, self._view_for(home_unit(request.unit, self._unit)), client.may_write)
        except Exception as fault:  # a view is foreign code here: one broken entry must not stop the other partners
            self._blame(fault, request, client)
            result = exception(request.pdu[0], ExceptionCode.SERVER_DEVICE_FAILURE)
        if result[0] & EXCEPTION_BIT:
            client.exceptions += 1
            self.counters.exceptions[ExceptionCode(result[1])] += 1
        else:
            client.last_request_ns = self.last_request_ns = now
            self._tell(request, client)
        return result

    def _tell(self, request: Request, client: Client) -> None:
        if self._on_request is None:
            return
        try:
            self._on_request(client.address, request.pdu[0])
        except Exception as fault:  # the request is done and has its answer whatever happens to those who watch
            self._blame(fault, request, client)

    def _blame(self, fault: Exception, request: Request, client: Client) -> None:
        self.counters.view_faults += 1
        self.counters.last_view_fault = f"{client.address}: {request.pdu.hex(' ')}: {fault!r}"

    def _sweep_later(self) -> None:
        self._sweeper = asyncio.get_running_loop().call_later(SWEEP_S, self._sweep)

    def _sweep(self) -> None:
        now = time.monotonic_ns()
        for connection in list(self._connections):
            connection.sweep(now)
        self._sweep_later()


class _Connection(asyncio.BufferedProtocol):
    """One client's connection: bytes between the transport and its framing machine."""

    def __init__(self, server: ModbusServer) -> None:
        self._server = server
        self._buffer = bytearray(CHUNK_BYTES)
        self._framing = Framing(server.limits.receive_limit_ns)
        self._transport: asyncio.Transport | None = None
        self._stalled_ns: Ns | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        peer, now = transport.get_extra_info("peername"), time.monotonic_ns()
        if peer is None or not self._server.enter(self):  # no name: it has gone already
            transport.abort()
            return
        self.client = Client(f"{peer[0]}:{peer[1]}", self._server.may_write(peer[0]), now, now)
        self._transport = transport
        transport.set_write_buffer_limits(high=self._server.limits.held_bytes - CHUNK_ANSWERS)

    def connection_lost(self, exc: Exception | None) -> None:
        if self._transport is None:
            return
        self._server.leave(self)
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
        """Ends the connection without waiting for answers to be taken."""
        if self._transport is not None:
            self._transport.abort()

    def sweep(self, now: Ns) -> None:
        """Looks at what only time can tell: a half frame, a stalled or an idle partner."""
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
                self._framing.reply(event, self._server.serve(event, self.client, now))
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
            self._transport.write(self._framing.take_output())  # what was asked before the fault is answered
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
            advice = f"no interface of this machine has the address {host}; set `bind` to one that is there (`ip address` lists them)"
        case _:
            advice = f"cannot listen: {error.strerror or error}; correct `bind`"
    return f"Modbus server {host}:{port}: {advice}"
