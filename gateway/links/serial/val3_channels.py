"""Plays the sio channels of VAL 3 on real ports and sockets, inside asyncio.  gateway.pure.controllers.val3.sio decides their meaning.

    runner = await SioRunner.start([Channel("Socket\\\\plc", Kind.TCP_CLIENT, address="127.0.0.1", port=4000, timeout_s=2)])
    plc = runner.variable("Socket\\\\plc")
    await runner.write_text(plc, "hello")

Each instruction that can wait is a coroutine; a task that is killed cancels it.  Instructions yield to others even when they need not wait
(manual, asynchronous tasks: sio read and write yield).
"""

import asyncio
import contextlib
import socket
import time
from collections.abc import Iterable, Sequence
from typing import TypeVar

from gateway.links.serial.val3_wires import SerialWire, TcpWire, UdpWire, Wire, listening_socket
from gateway.pure.controllers.val3.sio.calls import AnyCall, Call
from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from gateway.pure.controllers.val3.sio.control import Code, Value
from gateway.pure.controllers.val3.sio.core import SioCore
from gateway.pure.controllers.val3.sio.orders import Close, Configure, Listen, Open, Order
from gateway.pure.controllers.val3.sio.variable import Sio
from protocols.base.machine import Damage

T = TypeVar("T")
ATTEMPT_S = 5.0  # one attempt to connect; a longer time-out makes several


class SioRunner:
    """Create it with `start` inside a running loop; `close` releases everything."""

    def __init__(self, channels: Iterable[Channel]) -> None:
        self.core = SioCore(channels, time.monotonic_ns())
        self._loop = asyncio.get_running_loop()
        self._wires: dict[int, Wire] = {}
        self._servers: dict[str, socket.socket] = {}
        self._openers: dict[int, asyncio.Task[None]] = {}
        self._waiting: dict[object, asyncio.Future[None]] = {}
        self._changing = asyncio.Lock()  # one sioCtrl after the other: a frame is set while others go on
        self._timer: asyncio.TimerHandle | None = None
        self._watched: dict[int, tuple[int, bool, bool]] = {}  # connection -> descriptor, reads, writes
        self._deaf: set[int] = set()  # connections whose partner has ended

    @classmethod
    async def start(cls, channels: Iterable[Channel]) -> "SioRunner":
        """Serial lines are on when it returns, as far as they are there.  Raises ValueError for a faulty declaration."""
        runner = cls(channels)
        runner._settle([])
        if runner._openers:
            await asyncio.wait(runner._openers.values())
        return runner

    # ------------------------------------------------------------------------------------------------- variables

    def variable(self, link: str | None = None) -> Sio:
        """A new sio variable."""
        return self.core.variable(link)

    def link(self, target: Sio, source: Sio) -> None:
        """sioLink."""
        self._settle(self.core.link(target, source))

    def delete(self, sio: Sio) -> None:
        """The variable goes."""
        self._settle(self.core.delete(sio))

    def status(self, sio: Sio) -> tuple[int, str, str]:
        """ioStatus: state, description, physical path."""
        return self.core.status(sio)

    def descriptors(self, sio: Sio) -> list[int]:
        """Descriptors of the open connections of its channel, to show the sockets outside."""
        return [wire.fileno() for wire in self._wires.values() if wire.channel.name == sio.link]

    def end_application(self) -> None:
        """Closes every socket and deletes every variable."""
        self._settle(self.core.end_application())

    # ---------------------------------------------------------------------------------------------- instructions

    async def get(self, sio: Sio, data: list[float], start: int = 0) -> int:
        """sioGet into data[start:]."""
        self._pump_channel(sio)
        return await self._run(self.core.get(sio, data, time.monotonic_ns(), start))

    async def set(self, sio: Sio, data: Sequence[float], count: float | None = None, start: int = 0) -> int:
        """sioSet of data[start:start + count]."""
        self._pump_channel(sio)
        return await self._run(self.core.set(sio, data, time.monotonic_ns(), count, start))

    async def read_text(self, sio: Sio) -> str:
        """`string = sio`."""
        self._pump_channel(sio)
        return await self._run(self.core.read_text(sio, time.monotonic_ns()))

    async def read_num(self, sio: Sio) -> float:
        """`num = sio`."""
        self._pump_channel(sio)
        return await self._run(self.core.read_num(sio, time.monotonic_ns()))

    async def write_text(self, sio: Sio, text: str) -> str:
        """`sio = string`."""
        self._pump_channel(sio)
        return await self._run(self.core.write_text(sio, text, time.monotonic_ns()))

    async def write_num(self, sio: Sio, value: float) -> float:
        """`sio = num`."""
        self._pump_channel(sio)
        return await self._run(self.core.write_num(sio, value, time.monotonic_ns()))

    def clear_buffer(self, sio: Sio) -> int:
        """clearBuffer."""
        self._pump_channel(sio)
        dropped, done = self.core.clear_buffer(sio)
        self._settle(done)
        return dropped

    async def control(self, sio: Sio, name: str, value: Value) -> Code:
        """sioCtrl; a setting that the hardware refuses is unsupported and changes nothing."""
        async with self._changing:
            mine = [number for number, wire in self._wires.items() if wire.channel.name == sio.link]
            before = None if sio.link is None or not mine else self._wires[mine[0]].channel
            code = self.core.control(sio, name, value, unsent=any(self._wires[number].unsent() > 0 for number in mine))
            if code is Code.CHANGED and before is not None and before.kind is Kind.SERIAL:
                code = await self._reopen(mine[0], before, self.core.channel(before.name))
            self._settle([])
            return code

    def close(self) -> None:
        """Release everything; a second call is harmless."""
        self.end_application()
        for opener in self._openers.values():
            opener.cancel()
        for number in list(self._wires):
            self._drop(number)
        if self._timer is not None:
            self._timer.cancel()

    # --------------------------------------------------------------------------------------------------- helpers

    async def _run(self, call: Call[T]) -> T:
        self._settle([])  # opens the required ports
        self._pump_channel(call.sio)
        self._settle(self.core.wake(time.monotonic_ns()))  # with time-out -1 this ends it
        if call.done:
            await asyncio.sleep(0)
            return call.result()
        waiter = self._loop.create_future()
        self._waiting[call] = waiter
        try:
            await waiter
        except asyncio.CancelledError:
            self._settle(self.core.cancel(call))
            raise
        finally:
            self._waiting.pop(call, None)
        return call.result()

    def _settle(self, done: list[AnyCall]) -> None:
        """Wake finished callers, carry out orders, update the watched descriptors."""
        for call in done:
            waiter = self._waiting.get(call)
            if waiter is not None and not waiter.done():
                waiter.set_result(None)
        while orders := self.core.take_orders():
            for order in orders:
                self._carry_out(order)
        for number in self._wires:
            self._watch(number)
        self._arm()

    def _carry_out(self, order: Order) -> None:
        match order:
            case Open(number, channel):
                self._openers[number] = self._loop.create_task(self._open(number, channel))
            case Close(number):
                if number in self._openers:
                    self._openers.pop(number).cancel()
                self._drop(number)
            case Configure(number, channel):
                if number in self._wires and channel.kind is not Kind.SERIAL:
                    self._wires[number].configure(channel)
            case Listen(channel):
                self._listen(channel)
            case _:
                if (server := self._servers.pop(order.name, None)) is not None:
                    self._loop.remove_reader(server.fileno())
                    server.close()

    async def _open(self, number: int, channel: Channel) -> None:
        try:
            wire = await asyncio.wait_for(self._make(channel), ATTEMPT_S)
            self._expect_same_frame(wire)
        except (OSError, ValueError):  # ValueError: a fault that only the hardware could detect
            self._openers.pop(number, None)
            self._settle(self.core.refused(number, time.monotonic_ns()))
            return
        self._openers.pop(number, None)
        self._wires[number] = wire
        self._settle(self.core.opened(number, time.monotonic_ns()))
        self._pump(number)

    def _expect_same_frame(self, wire: Wire) -> None:
        """Raises ValueError when sioCtrl has changed the frame while the line was being opened."""
        now = self.core.channel(wire.channel.name)
        if now.kind is Kind.SERIAL and (now.frame, now.flow_control) != (wire.channel.frame, wire.channel.flow_control):
            wire.close()
            raise ValueError(f"{now.name}: {now.frame} is wanted by now")

    async def _make(self, channel: Channel) -> Wire:
        if channel.kind is Kind.SERIAL:
            return await self._make_serial(channel)
        if channel.kind is Kind.UDP:
            return UdpWire(channel)
        sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            sock.setblocking(False)
            await self._loop.sock_connect(sock, (channel.address, channel.port))
            return TcpWire(channel, sock)
        except BaseException:
            sock.close()
            raise

    async def _make_serial(self, channel: Channel) -> Wire:
        """In a thread, which cannot be stopped: a wire that is no longer needed is closed."""
        making = asyncio.ensure_future(asyncio.to_thread(SerialWire, channel))
        try:
            return await asyncio.shield(making)
        except asyncio.CancelledError:
            making.add_done_callback(lambda made: None if made.cancelled() or made.exception() else made.result().close())
            raise

    async def _reopen(self, number: int, before: Channel, after: Channel) -> Code:
        """Frames are set by reopening, also without a waiting call; the old frame is restored if the new one is refused."""
        if (before.frame, before.flow_control) == (after.frame, after.flow_control):
            return Code.CHANGED
        self._drop(number)
        for code, channel in ((Code.CHANGED, after), (Code.UNSUPPORTED, before)):
            try:
                self._wires[number] = await self._make_serial(channel)
            except (OSError, ValueError):
                continue
            self.core.change(channel)
            return code
        self.core.change(before)
        self._settle(self.core.lost(number, time.monotonic_ns()))
        return Code.UNSUPPORTED

    def _listen(self, channel: Channel) -> None:
        try:
            server = listening_socket(channel)
        except OSError:
            self.core.not_listening(channel.name, time.monotonic_ns())
            return
        self._servers[channel.name] = server
        self._loop.add_reader(server.fileno(), self._accept, channel.name)

    def _accept(self, name: str) -> None:
        while name in self._servers:
            try:
                sock, (host, _port) = self._servers[name].accept()
            except OSError:  # no further one, or lost again
                return
            number, done = self.core.accepted(name, host, time.monotonic_ns())
            if number is None:
                sock.close()
                continue
            self._wires[number] = TcpWire(self.core.channel(name), sock)
            self._settle(done)
            self._pump(number)

    def _pump_channel(self, sio: Sio) -> None:
        for number in [number for number, wire in self._wires.items() if wire.channel.name == sio.link]:
            self._pump(number)

    def _pump(self, number: int) -> None:
        """Read available data and send waiting data."""
        try:
            self._read(number)
            self._write(number)
        except OSError:
            self._drop(number)
            self._settle(self.core.lost(number, time.monotonic_ns()))

    def _read(self, number: int) -> None:
        wire = self._wires.get(number)
        room = self.core.room(number)
        if wire is None or number in self._deaf or (room == 0 and isinstance(wire, TcpWire)):
            return
        for heard in wire.read(room):
            now = time.monotonic_ns()
            if isinstance(heard.what, bytes):
                self._settle(self.core.received(number, heard.what, now, heard.sender))
            elif isinstance(heard.what, Damage):
                self._settle(self.core.damaged(number, now))
            elif number in self._wires:
                self._deaf.add(number)
                self._settle(self.core.ended(number, now))

    def _write(self, number: int) -> None:
        while (output := self.core.output(number)) and (wire := self._wires.get(number)) is not None:
            count = wire.write(output)
            self._settle(self.core.taken(number, count, time.monotonic_ns()) if count else [])
            if not count:
                return

    def _watch(self, number: int) -> None:
        """The loop listens while there is room, and waits to send while there is something to send."""
        wire = self._wires[number]
        reads = number not in self._deaf and (self.core.room(number) > 0 or not isinstance(wire, TcpWire))
        wanted = (wire.fileno(), reads, bool(self.core.output(number)))
        if self._watched.get(number) == wanted:
            return
        self._unwatch(number)
        self._watched[number] = wanted
        if wanted[1]:
            self._loop.add_reader(wanted[0], self._pump, number)
        if wanted[2]:
            self._loop.add_writer(wanted[0], self._pump, number)

    def _unwatch(self, number: int) -> None:
        descriptor, _reads, _writes = self._watched.pop(number, (-1, False, False))
        if descriptor >= 0:
            self._loop.remove_reader(descriptor)
            self._loop.remove_writer(descriptor)

    def _drop(self, number: int) -> None:
        self._unwatch(number)
        self._deaf.discard(number)
        if (wire := self._wires.pop(number, None)) is not None:
            with contextlib.suppress(OSError):
                wire.close()

    def _arm(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        due = self.core.deadline()
        delay = None if due is None else max(0.0, (due - time.monotonic_ns()) / 1e9)
        self._timer = None if delay is None else self._loop.call_later(delay, self._on_time)

    def _on_time(self) -> None:
        self._settle(self.core.wake(time.monotonic_ns()))
