"""The sio channels of a cell as its application uses them: sockets and serial lines served once a turn, without a loop of their own.

gateway.pure.controllers.val3.sio decides their meaning; the interpreter calls `settle` in every turn and while an instruction waits.
"""

import contextlib
import select
import socket
from collections.abc import Iterable

from gateway.links.serial.val3_wires import SerialWire, TcpWire, UdpWire, Wire, listening_socket
from gateway.pure.controllers.val3.sio.channel import Channel, Kind, channel_named
from gateway.pure.controllers.val3.sio.control import Code
from gateway.pure.controllers.val3.sio.core import SioCore
from gateway.pure.controllers.val3.sio.orders import Close, Configure, Listen, Open, Order
from gateway.pure.controllers.val3.sio.variable import Sio
from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.values import SioV
from gateway.pure.languages.val3.virtual_sio import VirtualSio
from protocols.base.machine import Damage

ATTEMPT_NS = 5_000_000_000  # one attempt to connect; a longer time-out makes several


class CellSio(VirtualSio):
    """channels: those of the cell."""

    def __init__(self, channels: Iterable[Channel]) -> None:
        super().__init__()
        self._channels = tuple(channels)
        self.core = SioCore(self._channels)
        self._wires: dict[int, Wire] = {}
        self._servers: dict[str, socket.socket] = {}
        self._connecting: dict[int, tuple[Channel, socket.socket, Ns]] = {}
        self._deaf: set[int] = set()  # connections whose partner has ended

    # ---- requests of instructions
    def declare(self, link: str, channel: Channel | None = None) -> None:
        """Channels are those of the cell."""

    def of(self, variable: SioV) -> Sio:
        """The core's number of the variable; 123 without a link, or with one to nothing."""
        name = channel_named(self._channels, variable.link) if variable.link else None
        if name is None:
            raise Rte(123, variable.link or "")
        return self._made(variable, name)

    def status(self, variable: SioV) -> tuple[int, str, str]:
        """ioStatus."""
        if not variable.link:
            return -1, "", ""
        if channel_named(self._channels, variable.link) is None:
            return -2, "", variable.link
        return self.core.status(self.of(variable))

    def control(self, variable: SioV, name: str, value: float | str | bool) -> int:
        """sioCtrl; a serial line is reopened with its new frame, and keeps the old one if that is refused."""
        sio = self.of(variable)
        mine = [number for number, wire in self._wires.items() if wire.channel.name == sio.link]
        before = self._wires[mine[0]].channel if mine else None
        code = self.core.control(sio, name, value, unsent=any(self._wires[number].unsent() for number in mine))
        if code is Code.CHANGED and before is not None and before.kind is Kind.SERIAL:
            code = self._reopened(mine[0], before, self.core.channel(before.name))
        self.settle()
        return int(code)

    def _reopened(self, number: int, before: Channel, after: Channel) -> Code:
        if (before.frame, before.flow_control) == (after.frame, after.flow_control):
            return Code.CHANGED
        self._drop(number)
        for code, channel in ((Code.CHANGED, after), (Code.UNSUPPORTED, before)):
            with contextlib.suppress(OSError, ValueError):
                self._wires[number] = SerialWire(channel)
                self.core.change(channel)
                return code
        self.core.change(before)
        self.core.lost(number, self.now)
        return Code.UNSUPPORTED

    def end_application(self) -> None:
        """Everything closes: the next start has its own channels."""
        self.core.end_application()
        self.settle()
        for number in [*self._wires, *self._connecting]:
            self._drop(number)
        for server in self._servers.values():
            server.close()
        self._servers.clear()

    # ---- the network
    def settle(self) -> None:
        """Carry out the orders of the core; read and write what is available."""
        self._carry_out()
        for name in list(self._servers):
            self._accept(name)
        for number in list(self._connecting):
            self._connects(number)
        for number in list(self._wires):
            self._pump(number)
        self.core.wake(self.now)
        self._carry_out()

    def _carry_out(self) -> None:
        while orders := self.core.take_orders():
            for order in orders:
                self._order(order)

    def _order(self, order: Order) -> None:
        match order:
            case Open(number, channel):
                self._open(number, channel)
            case Close(number):
                self._drop(number)
            case Configure(number, channel):
                if number in self._wires and channel.kind is not Kind.SERIAL:
                    self._wires[number].configure(channel)
            case Listen(channel):
                try:
                    self._servers[channel.name] = listening_socket(channel)
                except OSError:
                    self.core.not_listening(channel.name, self.now)
            case _:
                if (server := self._servers.pop(order.name, None)) is not None:
                    server.close()

    def _open(self, number: int, channel: Channel) -> None:
        try:
            if channel.kind is Kind.TCP_CLIENT:
                made = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
                made.setblocking(False)
                made.connect_ex((channel.address, channel.port))
                self._connecting[number] = channel, made, self.now + ATTEMPT_NS
                return
            self._wires[number] = SerialWire(channel) if channel.kind is Kind.SERIAL else UdpWire(channel)
        except (OSError, ValueError):  # ValueError: a fault that only the hardware could detect
            self.core.refused(number, self.now)
            return
        self.core.opened(number, self.now)

    def _connects(self, number: int) -> None:
        channel, made, end = self._connecting[number]
        _, ready, _ = select.select((), (made,), (), 0)
        if not ready and self.now < end:
            return
        del self._connecting[number]
        if ready and not made.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR):
            self._wires[number] = TcpWire(channel, made)
            self.core.opened(number, self.now)
        else:
            made.close()
            self.core.refused(number, self.now)

    def _accept(self, name: str) -> None:
        while name in self._servers:
            try:
                made, (host, _port) = self._servers[name].accept()
            except OSError:  # no more
                return
            number, _ = self.core.accepted(name, host, self.now)
            if number is None:
                made.close()
                continue
            self._wires[number] = TcpWire(self.core.channel(name), made)

    def _pump(self, number: int) -> None:
        """Read available data and send waiting data."""
        try:
            self._read(number)
            while (output := self.core.output(number)) and (wire := self._wires.get(number)) is not None:
                count = wire.write(output)
                if not count:
                    break
                self.core.taken(number, count, self.now)
        except OSError:
            self._drop(number)
            self.core.lost(number, self.now)

    def _read(self, number: int) -> None:
        wire, room = self._wires[number], self.core.room(number)
        if number in self._deaf or (room == 0 and isinstance(wire, TcpWire)):
            return
        for heard in wire.read(room):
            if isinstance(heard.what, bytes):
                self.core.received(number, heard.what, self.now, heard.sender)
            elif isinstance(heard.what, Damage):
                self.core.damaged(number, self.now)
            else:
                self._deaf.add(number)
                self.core.ended(number, self.now)

    def _drop(self, number: int) -> None:
        self._deaf.discard(number)
        if (wire := self._wires.pop(number, None)) is not None:
            wire.close()
        if (waits := self._connecting.pop(number, None)) is not None:
            waits[1].close()
