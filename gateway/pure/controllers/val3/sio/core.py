"""The sio part of one controller: variables, channels, connections and instructions under way.  Source: VAL 3 manual, 3.7.

The interpreter starts instructions (`get`, `set`, ...) and waits until their call is done; the adapter carries out `take_orders()`,
brings bytes and news, sends `output()` and calls `wake` at `deadline()`.  Every method that can finish calls returns those it finished.
"""

from collections.abc import Iterable, Sequence
from typing import TypeVar

from gateway.pure.controllers.val3.sio.calls import AnyCall, Call, Get, ReadNum, ReadText, Set, WriteNum, WriteText
from gateway.pure.controllers.val3.sio.channel import ANY, Channel, Kind, deadline_of
from gateway.pure.controllers.val3.sio.connection import Connection
from gateway.pure.controllers.val3.sio.control import Code, Value, judge
from gateway.pure.controllers.val3.sio.errors import Rte, Val3Error
from gateway.pure.controllers.val3.sio.inbox import Mark
from gateway.pure.controllers.val3.sio.line import Line
from gateway.pure.controllers.val3.sio.orders import Order
from gateway.pure.controllers.val3.sio.variable import Sio
from protocols.base.machine import Ns

T = TypeVar("T")
C = TypeVar("C", Get, Set, ReadNum, ReadText, WriteNum, WriteText)


def _check_index(data: Sequence[float], start: int) -> None:
    if start < 0:
        raise Val3Error(Rte.INDEX_LOW, f"index {start}")
    if start >= len(data):
        raise Val3Error(Rte.INDEX_HIGH, f"index {start} of {len(data)} elements")


class SioCore:
    """`channels`: what the controller declares.  Raises ValueError listing every fault of the declaration."""

    def __init__(self, channels: Iterable[Channel], now: Ns = 0) -> None:
        declared = list(channels)
        faults = [fault for channel in declared for fault in channel.faults()]
        names = [channel.name for channel in declared]
        faults += [f"sio channel {name}: declared twice" for name in sorted(set(names)) if names.count(name) > 1]
        if faults:
            raise ValueError("; ".join(faults))
        self._numbers = iter(range(1, 1 << 62))
        self._lines = {channel.name: Line(channel, self._next_number) for channel in declared}
        for line in self._lines.values():
            if line.channel.kind is Kind.SERIAL:  # always on (3.7.1)
                line.want(now)
        self._also: list[AnyCall] = []  # finished while another instruction began; reported with the next wake

    def declare(self, channel: Channel, now: Ns) -> None:
        """A channel that comes later.  Raises ValueError listing its faults."""
        if faults := [*channel.faults(), *([f"sio channel {channel.name}: declared twice"] if channel.name in self._lines else [])]:
            raise ValueError("; ".join(faults))
        line = self._lines[channel.name] = Line(channel, self._next_number)
        if channel.kind is Kind.SERIAL:
            line.want(now)

    # ------------------------------------------------------------------------------------------------- variables

    def variable(self, link: str | None = None) -> Sio:
        """A new sio variable; not linked unless a name is given."""
        sio = Sio(link)
        self._refer(sio)
        return sio

    def link(self, target: Sio, source: Sio) -> list[AnyCall]:
        """sioLink.  Raises Val3Error 123 when the source has no link (AX-188)."""
        if source.link is None or source.deleted or target.deleted:
            raise Val3Error(Rte.NOT_LINKED, f"sioLink from {source}")
        if target.link == source.link:
            return []
        done = self._release(target)
        target.link = source.link
        self._refer(target)
        return done

    def delete(self, sio: Sio) -> list[AnyCall]:
        """The variable goes: a local one with its program, a global one with its library."""
        done = self._release(sio)
        sio.deleted = True
        return done

    def status(self, sio: Sio) -> tuple[int, str, str]:
        """ioStatus: 0, -1 no link, -2 a link to nothing; description and physical path."""
        if sio.link is None or sio.deleted:
            return -1, "", ""
        line = self._lines.get(sio.link)
        return (-2, "", sio.link) if line is None else (0, line.channel.description, sio.link)

    def end_application(self) -> list[AnyCall]:
        """Closes every socket and deletes every variable; the serial lines stay on."""
        done: list[AnyCall] = []
        for line in self._lines.values():
            for sio in line.variables:
                sio.deleted = True
            done += line.shut("the application has ended")
            line.variables.clear()
        return done

    # ---------------------------------------------------------------------------------------------- instructions

    def get(self, sio: Sio, data: list[float], now: Ns, start: int = 0) -> Get:
        """sioGet into data[start:].  Raises Val3Error 123, 20, 21."""
        line = self._line(sio)
        _check_index(data, start)
        return self._begin(line, Get(sio, deadline_of(line.channel.timeout_s, now), data, start), now)

    def set(self, sio: Sio, data: Sequence[float], now: Ns, count: float | None = None, start: int = 0) -> Set:
        """sioSet of data[start:start + count].  Raise Val3Error 123, 20, 21, 122; 70 for an invalid count."""
        line = self._writable(sio)
        _check_index(data, start)
        size = len(data) - start if count is None else count
        if not (size >= 0 and float(size).is_integer()):
            raise Val3Error(Rte.BAD_VALUE, f"sioSet: {size} elements")
        if size > len(data) - start:
            raise Val3Error(Rte.INDEX_HIGH, f"sioSet: {size:g} elements of {len(data) - start}")
        return self._begin(line, Set(sio, deadline_of(line.channel.timeout_s, now), data[start : start + int(size)]), now)

    def read_text(self, sio: Sio, now: Ns) -> ReadText:
        """`string = sio`.  Raises Val3Error 123."""
        line = self._line(sio)
        return self._begin(line, ReadText(sio, deadline_of(line.channel.timeout_s, now), line.channel.end_of_string), now)

    def read_num(self, sio: Sio, now: Ns) -> ReadNum:
        """`num = sio`.  Raises Val3Error 123."""
        line = self._line(sio)
        return self._begin(line, ReadNum(sio, deadline_of(line.channel.timeout_s, now)), now)

    def write_text(self, sio: Sio, text: str, now: Ns) -> WriteText:
        """`sio = string`.  Raises Val3Error 123, 122; 70 for what no VAL 3 string holds."""
        line = self._writable(sio)
        return self._begin(line, WriteText(sio, deadline_of(line.channel.timeout_s, now), text, line.channel.end_of_string), now)

    def write_num(self, sio: Sio, value: float, now: Ns) -> WriteNum:
        """`sio = num`.  Raises Val3Error 123, 122; 70 for NaN and infinity."""
        line = self._writable(sio)
        return self._begin(line, WriteNum(sio, deadline_of(line.channel.timeout_s, now), value), now)

    def clear_buffer(self, sio: Sio) -> tuple[int, list[AnyCall]]:
        """clearBuffer: characters dropped, -1 for a closed socket; and the calls that ended by it.  Raises Val3Error 123."""
        return self._line(sio).clear(sio)

    def control(self, sio: Sio, name: str, value: Value, unsent: bool = False) -> Code:
        """sioCtrl; `unsent`: the serial interface still holds characters to send.  Raises Val3Error 123."""
        line = self._line(sio)
        code, channel = judge(line.channel, name, value, unsent or line.busy)
        if code is Code.CHANGED:
            self.change(channel)
        return code

    def cancel(self, call: AnyCall | Call[T]) -> list[AnyCall]:
        """Cancel the call of a killed task; bytes already written are gone, bytes it would have read stay."""
        line = self._lines.get(call.sio.link or "")
        return [] if line is None or call.done else line.cancel(call)

    # --------------------------------------------------------------------------------------------------- adapter

    def channel(self, name: str) -> Channel:
        """The channel as it is now.  Raises KeyError."""
        return self._lines[name].channel

    def change(self, channel: Channel) -> None:
        """Parameters of an existing channel; also the way back when the hardware refuses them."""
        self._lines[channel.name].change(channel)

    def ordered(self) -> bool:
        """Whether take_orders() would return any."""
        return any(line.orders for line in self._lines.values())

    def take_orders(self) -> list[Order]:
        """Carry these out in this order, once."""
        orders = [order for line in self._lines.values() for order in line.orders]
        for line in self._lines.values():
            line.orders = []
        return orders

    def opened(self, number: int, now: Ns) -> list[AnyCall]:
        """An ordered connection is established."""
        line, connection = self._find(number)
        return [] if line is None or connection is None else line.opened(connection)

    def refused(self, number: int, now: Ns) -> list[AnyCall]:
        """An ordered connection could not be made; tried again while a call waits for it (a serial line: always)."""
        line, connection = self._find(number)
        return [] if line is None or connection is None else line.refused(connection, now)

    def accepted(self, name: str, peer: str, now: Ns) -> tuple[int | None, list[AnyCall]]:
        """A client from address `peer` came to a server: number of its connection, None: turn it away."""
        return self._lines[name].accepted(peer)

    def not_listening(self, name: str, now: Ns) -> None:
        """The server's port cannot be had; tried again while a call waits."""
        self._lines[name].not_listening(now)

    def room(self, number: int) -> int:
        """Return how many bytes a connection's buffer accepts now."""
        connection = self._find(number)[1]
        return 0 if connection is None else connection.inbox.room

    def received(self, number: int, data: bytes, now: Ns, sender: str = "") -> list[AnyCall]:
        """Bytes came; on UDP one datagram with its sender's address."""
        line, connection = self._find(number)
        if line is None or connection is None:
            return []
        kind = line.channel.kind
        if kind is Kind.UDP and (not line.hears(sender) or len(data) > connection.inbox.room):
            line.ignored += 1
            return []
        if connection.inbox.put(data) < len(data):
            connection.inbox.mark(Mark.DAMAGED)
        return line.serve(connection)

    def damaged(self, number: int, now: Ns) -> list[AnyCall]:
        """A spoiled character, in line order with the bytes."""
        return self._marked(number, Mark.DAMAGED)

    def ended(self, number: int, now: Ns) -> list[AnyCall]:
        """The partner sends nothing more; it may still listen."""
        return self._marked(number, Mark.ENDED)

    def lost(self, number: int, now: Ns) -> list[AnyCall]:
        """The connection broke or the port is gone."""
        line, connection = self._find(number)
        return [] if line is None or connection is None else line.lost(connection, now)

    def output(self, number: int) -> bytes:
        """What this connection has to send; on UDP one datagram."""
        connection = self._find(number)[1]
        return b"" if connection is None else connection.output()

    def taken(self, number: int, count: int, now: Ns) -> list[AnyCall]:
        """The channel took the first `count` bytes of `output()`."""
        line, connection = self._find(number)
        return [] if line is None or connection is None else connection.took(count) + line.serve(connection)

    def deadline(self) -> Ns | None:
        """Call wake then."""
        return min((due for line in self._lines.values() for due in line.deadlines()), default=None)

    def wake(self, now: Ns) -> list[AnyCall]:
        """Ends what has waited long enough; with time-out -1 that is now."""
        also, self._also = self._also, []
        return also + [call for line in self._lines.values() for call in line.wake(now)]

    # --------------------------------------------------------------------------------------------------- helpers

    def _begin(self, line: Line, call: C, now: Ns) -> C:
        self._also += [other for other in line.begin(call, now) if other is not call]
        return call

    def _next_number(self) -> int:
        return next(self._numbers)

    def _refer(self, sio: Sio) -> None:
        if sio.link in self._lines:
            self._lines[sio.link].variables.append(sio)

    def _release(self, sio: Sio) -> list[AnyCall]:
        line = self._lines.get(sio.link or "")
        return [] if line is None or sio.deleted else line.release(sio)

    def _line(self, sio: Sio) -> Line:
        line = None if sio.deleted else self._lines.get(sio.link or "")
        if line is None:
            raise Val3Error(Rte.NOT_LINKED, f"{sio} is not linked to a system I/O")
        return line

    def _writable(self, sio: Sio) -> Line:
        line = self._line(sio)
        if line.channel.kind is Kind.UDP and line.channel.address == ANY:
            raise Val3Error(Rte.WRITE_TO_INPUT, f"{sio}: address {ANY} only receives")
        return line

    def _find(self, number: int) -> tuple[Line | None, Connection | None]:
        for line in self._lines.values():
            for connection in line.connections():
                if connection.number == number:
                    return line, connection
        return None, None

    def _marked(self, number: int, mark: Mark) -> list[AnyCall]:
        line, connection = self._find(number)
        if line is None or connection is None:
            return []
        connection.inbox.mark(mark)
        return line.serve(connection)
