"""Serial lines and sockets of a virtual run: the real core, with events as its partners; without events there is no answer."""

from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from gateway.pure.controllers.val3.sio.core import SioCore
from gateway.pure.controllers.val3.sio.orders import Close, Listen, Open, StopListening
from gateway.pure.controllers.val3.sio.variable import Sio
from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.values import SioV

PEER = "127.0.0.1"


def kind_of(link: str) -> Kind:
    """A serial line, a server, UDP or a client, depending on the path of the link."""
    text = link.lower()
    if "serial" in text or text.split("\\", maxsplit=1)[0].startswith("com"):
        return Kind.SERIAL
    if "udp" in text:
        return Kind.UDP
    return Kind.TCP_SERVER if "server" in text or "srv" in text else Kind.TCP_CLIENT


class VirtualSio:
    """All channels that the applications name are declared when they are first used."""

    def __init__(self) -> None:
        self.core = SioCore([])
        self.now: Ns = 0
        self.sent: dict[str, bytes] = {}
        self.open: dict[int, str] = {}  # connection -> its channel, in the order they were made
        self._declared: dict[str, Channel] = {}
        self._there: set[str] = set()  # channels with a partner
        self._early: dict[str, int] = {}  # clients that came before their server listened

    # ---- what the run's events do ------------------------------------------------------------------------------------------
    def name_of(self, text: str) -> str:
        """The channel of that path or last name; the text itself where none is declared yet."""
        wanted = text.lower()
        found = (name for name in self._declared if wanted in (name.lower(), name.lower().rpartition("\\")[2]))
        return next(found, text)

    def knows(self, text: str) -> bool:
        """Whether a channel of that path or last name is declared."""
        return self.name_of(text) in self._declared

    def connect(self, text: str) -> None:
        """Connect a partner: it answers a client, or connects to a server."""
        name = self.name_of(text)
        self.declare(name)
        self._there.add(name)
        if self._declared[name].kind is Kind.TCP_SERVER:
            self._early[name] = self._early.get(name, 0) + 1
        self.settle()

    def disconnect(self, text: str) -> None:
        """The partner closes and is gone."""
        name = self.name_of(text)
        self._there.discard(name)
        for number in self._numbers(name):
            self.core.ended(number, self.now)
        self.settle()

    def hear(self, text: str, data: bytes, which: int = 0) -> bool:
        """Bytes come in; False: no connection is open.  which: 1 the first one, 0 the last."""
        numbers = self._numbers(self.name_of(text))
        if not numbers or which > len(numbers):
            return False
        self.core.received(numbers[which - 1], data, self.now, PEER)
        self.settle()
        return True

    def _numbers(self, name: str) -> list[int]:
        return [number for number, own in self.open.items() if own == name]

    # ---- what instructions ask -----------------------------------------------------------------------------------------------
    def declare(self, link: str, channel: Channel | None = None) -> None:
        """A channel of that name; `channel` where its parameters are known."""
        if link in self._declared:
            return
        made = channel or Channel(link, kind_of(link), address=PEER, port=1, device="virtual")
        self._declared[link] = made
        self.core.declare(made, self.now)
        self.settle()

    def of(self, variable: SioV) -> Sio:
        """What the core knows the variable as; 123 without a link."""
        if not variable.link:
            raise Rte(123)
        self.declare(variable.link)
        return self._made(variable, variable.link)

    def _made(self, variable: SioV, name: str) -> Sio:
        """As a variable of this channel; what it was of another one ends (AX-188)."""
        if not isinstance(variable.made, Sio) or variable.made.link != name or variable.made.deleted:
            self.forget(variable)
            variable.made = self.core.variable(name)
        return variable.made

    def register(self, variable: SioV) -> None:
        """A variable is there: a client stays open while one refers to it, used or not (L2648)."""
        try:
            self.of(variable)
        except Rte:  # no link, or one to nothing, which is legal as a link (AX-188)
            return

    def forget(self, variable: SioV) -> None:
        """The variable ends with its program or library: its connection to a server closes (L2646)."""
        if isinstance(variable.made, Sio):
            self.core.delete(variable.made)
            variable.made = None
            self.settle()

    def end_application(self) -> None:
        """Sockets close (L2644)."""
        self.core.end_application()
        self.settle()

    def link(self, variable: SioV, source: SioV) -> None:
        """sioLink."""
        if not source.link:
            raise Rte(123)
        self.register(source)
        variable.link = source.link
        self.register(variable)

    def status(self, variable: SioV) -> tuple[int, str, str]:
        """ioStatus."""
        if not variable.link:
            return -1, "", ""
        return self.core.status(self.of(variable))

    def clear(self, variable: SioV) -> int:
        """clearBuffer."""
        count = self.core.clear_buffer(self.of(variable))[0]
        self.settle()
        return count

    def control(self, variable: SioV, name: str, value: float | str | bool) -> int:
        """sioCtrl."""
        return int(self.core.control(self.of(variable), name, value))

    # ---- the network ---------------------------------------------------------------------------------------------------------
    def settle(self) -> None:
        """Execute the core's orders; accept the sent data."""
        while orders := self.core.take_orders():
            for order in orders:
                match order:
                    case Open(number, channel):
                        self._opens(number, channel)
                    case Close(number):
                        self.open.pop(number, None)
                    case Listen(channel):
                        self._early.setdefault(channel.name, 0)
                        self._arrive(channel.name)
                    case StopListening(name):
                        self._early[name] = 0
        for name in [name for name, count in self._early.items() if count]:
            self._arrive(name)
        for number in list(self.open):
            self._drain(number)
        self.core.wake(self.now)

    def _opens(self, number: int, channel: Channel) -> None:
        if channel.kind in (Kind.SERIAL, Kind.UDP) or channel.name in self._there:
            self.open[number] = channel.name
            self.core.opened(number, self.now)
            self._drain(number)
        else:
            self.core.refused(number, self.now)

    def _arrive(self, name: str) -> None:
        while self._early.get(name, 0):
            number, _ = self.core.accepted(name, PEER, self.now)
            if number is None:  # no server listens yet, or all places are taken
                return
            self._early[name] -= 1
            self.open[number] = name

    def _drain(self, number: int) -> None:
        while data := self.core.output(number):
            name = self.open.get(number, str(number))
            self.sent[name] = self.sent.get(name, b"") + data
            self.core.taken(number, len(data), self.now)
