"""`Desk`: a program's view of sio in virtual time, with a network operated by the test."""

from collections.abc import Callable
from typing import TypeVar

from gateway.pure.controllers.val3.sio.calls import AnyCall
from gateway.pure.controllers.val3.sio.channel import Channel
from gateway.pure.controllers.val3.sio.control import Value
from gateway.pure.controllers.val3.sio.core import SioCore
from gateway.pure.controllers.val3.sio.errors import Val3Error
from gateway.pure.controllers.val3.sio.orders import Close, Configure, Listen, Open, Order, StopListening
from gateway.pure.controllers.val3.sio.variable import Sio
from protocols.base.machine import Ns

R = TypeVar("R")
C = TypeVar("C", bound=AnyCall)
WAITS = "waits"


def error(code: int) -> str:
    """Return `outcome` of a run-time error."""
    return f"run-time error {code}"


class SioBench:
    """`network`: "open" answers every attempt at once, "refuse" refuses it, "silent" never answers.  `capacity`: bytes it takes in all."""

    def __init__(self, *channels: Channel, network: str = "open", capacity: int = 1_000_000) -> None:
        self.now: Ns = 0
        self.network, self.capacity = network, capacity
        self.sent: dict[int, bytearray] = {}  # by connection
        self.datagrams: list[bytes] = []  # every piece given away, as it was given
        self.numbers: list[int] = []  # connections ordered so far
        self.opened: list[int] = []  # open now
        self.closed: list[int] = []
        self.configured: list[Channel] = []
        self.listening: list[str] = []
        self.core = SioCore(channels)
        self.settle()

    def begin(self, start: Callable[[Ns], C]) -> C:
        """Starts an instruction as an interpreter does: orders are carried out, output leaves, then the clock is looked at."""
        call = start(self.now)
        assert call is not None
        self.settle()
        self.core.wake(self.now)
        self.settle()
        return call

    def get(self, sio: Sio, data: list[float], start: int = 0) -> AnyCall:
        return self.begin(lambda now: self.core.get(sio, data, now, start))

    def set(self, sio: Sio, data: list[float], count: float | None = None, start: int = 0) -> AnyCall:
        return self.begin(lambda now: self.core.set(sio, data, now, count, start))

    def read_text(self, sio: Sio) -> AnyCall:
        return self.begin(lambda now: self.core.read_text(sio, now))

    def read_num(self, sio: Sio) -> AnyCall:
        return self.begin(lambda now: self.core.read_num(sio, now))

    def write_text(self, sio: Sio, text: str) -> AnyCall:
        return self.begin(lambda now: self.core.write_text(sio, text, now))

    def write_num(self, sio: Sio, value: float) -> AnyCall:
        return self.begin(lambda now: self.core.write_num(sio, value, now))

    def clear(self, sio: Sio) -> int:
        answer = self.core.clear_buffer(sio)
        assert answer
        self.settle()
        return answer[0]

    def control(self, sio: Sio, name: str, value: Value) -> int:
        code = self.core.control(sio, name, value)
        self.settle()
        assert code is not None
        return int(code)

    def variable(self, link: str | None = None) -> Sio:
        sio = self.core.variable(link)
        assert isinstance(sio, Sio)
        return sio

    def code(self, action: Callable[[], object]) -> int:
        """The run-time error an instruction ends its task with; 0: none."""
        try:
            action()
        except Val3Error as failure:
            return int(failure.code)
        return 0

    def outcome(self, call: AnyCall) -> object:
        """WAITS, what it returned, or `error(code)`."""
        if not call.done:
            return WAITS
        results: list[object] = []
        code = self.code(lambda: results.append(call.result()))
        return error(code) if code else results[0]

    def hears(self, number: int, data: bytes, sender: str = "") -> None:
        self.core.received(number, data, self.now, sender)
        self.settle()

    def damaged(self, number: int) -> None:
        self.core.damaged(number, self.now)
        self.settle()

    def partner_closes(self, number: int) -> None:
        self.core.ended(number, self.now)
        self.settle()

    def breaks(self, number: int) -> None:
        self.core.lost(number, self.now)
        self.settle()

    def client_comes(self, name: str, peer: str = "127.0.0.1") -> int | None:
        answer = self.core.accepted(name, peer, self.now)
        assert answer
        if answer[0] is not None:
            self.opened.append(answer[0])
        self.settle()
        return answer[0]

    def answer(self, number: int) -> None:
        """Establish the connection that was ordered."""
        self.opened.append(number)
        self.core.opened(number, self.now)
        self.settle()

    def at(self, now: Ns) -> "SioBench":
        """Advance the time; wake the core at each of its deadlines."""
        while (due := self.core.deadline()) is not None and due <= now:
            assert due > self.now or self.now == 0, "a deadline that does not move"
            self.now = due
            self.core.wake(self.now)
            self.settle()
        self.now = now
        return self

    def settle(self) -> None:
        """Carries out what is ordered and takes what wants to leave."""
        while orders := self.core.take_orders():
            for order in orders:
                self._carry_out(order)
        for number in list(self.opened):
            self._take_output(number)

    def _take_output(self, number: int) -> None:
        while self.capacity and (output := self.core.output(number)):
            taken = output[: self.capacity]
            self.capacity -= len(taken)
            self.sent.setdefault(number, bytearray()).extend(taken)
            self.datagrams.append(taken)
            self.core.taken(number, len(taken), self.now)

    def _carry_out(self, order: Order) -> None:
        match order:
            case Open(number, _):
                self.numbers.append(number)
                if self.network == "open":
                    self.answer(number)
                elif self.network == "refuse":
                    self.core.refused(number, self.now)
            case Close(number):
                self.closed.append(number)
                self.opened = [one for one in self.opened if one != number]
            case Listen(channel):
                self.listening.append(channel.name)
            case StopListening(name):
                self.listening.remove(name)
            case Configure(_, channel):
                self.configured.append(channel)
