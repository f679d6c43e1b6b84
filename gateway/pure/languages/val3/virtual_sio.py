"""Serial lines and sockets of a virtual run: the core is the real one, the other end never answers."""

from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from gateway.pure.controllers.val3.sio.core import SioCore
from gateway.pure.controllers.val3.sio.orders import Listen, Open
from gateway.pure.controllers.val3.sio.variable import Sio
from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.values import SioV


class VirtualSio:
    """All channels that the applications name are declared when they are first used."""

    def __init__(self) -> None:
        self.core = SioCore([])
        self.now: Ns = 0
        self._declared: dict[str, Channel] = {}
        self.sent: dict[str, bytes] = {}

    def declare(self, link: str) -> None:
        """A channel of that name: serial by its path, else a client that gets no answer."""
        if link in self._declared:
            return
        serial = "serial" in link.lower() or "com" in link.lower().split("\\")[0]
        kind = Kind.SERIAL if serial else Kind.TCP_CLIENT
        channel = Channel(link, kind, address="127.0.0.1", port=1, device="virtual")
        self._declared[link] = channel
        self.core.declare(channel, self.now)
        self.settle()

    def of(self, variable: SioV) -> Sio:
        """What the core knows the variable as; 123 without a link."""
        if not variable.link:
            raise Rte(123)
        self.declare(variable.link)
        if not isinstance(variable.made, Sio) or variable.made.link != variable.link:
            variable.made = self.core.variable(variable.link)
        return variable.made

    def link(self, variable: SioV, source: SioV) -> None:
        """sioLink."""
        if not source.link:
            raise Rte(123)
        variable.link = source.link

    def status(self, variable: SioV) -> tuple[int, str, str]:
        """ioStatus."""
        if not variable.link:
            return -1, "", ""
        return self.core.status(self.of(variable))

    def clear(self, variable: SioV) -> int:
        """clearBuffer."""
        return self.core.clear_buffer(self.of(variable))[0]

    def control(self, variable: SioV, name: str, value: float | str | bool) -> int:
        """sioCtrl."""
        return int(self.core.control(self.of(variable), name, value))

    def settle(self) -> None:
        """Carries out what the core orders: serial lines open, connections are refused; what is sent is noted."""
        for order in self.core.take_orders():
            if isinstance(order, Open):
                if order.channel.kind in (Kind.SERIAL, Kind.UDP):
                    self.core.opened(order.number, self.now)
                    self._drain(order.number, order.channel.name)
                else:
                    self.core.refused(order.number, self.now)
            elif isinstance(order, Listen):
                pass
        for number in list(range(1, 200)):
            self._drain(number, str(number))
        self.core.wake(self.now)

    def _drain(self, number: int, name: str) -> None:
        data = self.core.output(number)
        if data:
            self.sent[name] = self.sent.get(name, b"") + data
            self.core.taken(number, len(data), self.now)
