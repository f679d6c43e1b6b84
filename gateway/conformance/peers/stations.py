"""Axisgate's link with parts exchanged: stations with one fault each or with correct but different behaviour."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gateway.conformance.serial.partners import Late, Station
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority, Profile
from protocols.p3964r.receiver import Receiver
from protocols.p3964r.sender import Sender
from protocols.rk512.active import Active
from protocols.rk512.dialects import DIALECTS, STANDARD
from protocols.rk512.passive import Passive
from protocols.rk512.station import Station as Roles

OWN_BLOCK = b"U\x10\x02\x15V\x10\x10W"  # block sent by a station here: control characters among the data
DLE, NAK, STX = (bytes((char,)) for char in (Char.DLE, Char.NAK, Char.STX))


class Built(Station):
    """Axisgate's station with another receiver or sender, and with changed output or input."""

    def __init__(
        self,
        profile: Profile = RHO3,
        priority: Priority = Priority.LOW,
        layer: str = "rk512",
        receiver: type[Receiver] | None = None,
        sender: type[Sender] | None = None,
        says: Callable[[bytes], bytes] | None = None,
        hears: Callable[[int], bytes] | None = None,
        passive: Callable[["Built"], Passive] | None = None,
    ) -> None:
        super().__init__(profile, priority, layer)
        self._says, self._hears = says, hears
        if receiver is not None:
            self.link._receiver = receiver(profile, self.link._box, False)
        if sender is not None:
            self.link._sender = sender(profile, priority, self.link._box)
        if passive is not None:
            self.passive = passive(self)

    def stimulate(self, now: Ns, block: bytes = OWN_BLOCK) -> None:
        super().stimulate(now, block)

    def take_output(self) -> bytes:
        output = super().take_output()
        return self._says(output) if self._says is not None and output else output

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return super().receive(data if self._hears is None else b"".join(map(self._hears, data)), now)


class DeafToDamage(Built):
    """Takes a damaged character for one like any other; a break it receives."""

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        return super().damaged(kind, now) if kind is Damage.BREAK else Station.receive(self, b"U", now)


class AnswersLate(Late):
    """Correct, but slow: each DLE and each reaction is delayed."""

    def __init__(self, profile: Profile = RHO3, priority: Priority = Priority.LOW, layer: str = "rk512", late: Ns = ms(120)) -> None:
        super().__init__(profile, priority, layer, late)

    def stimulate(self, now: Ns, block: bytes = OWN_BLOCK) -> None:
        super().stimulate(now, block)

    def hold(self, held: bool, now: Ns) -> None:
        super().hold(held, now)
        self._collect(now)

    def _collect(self, now: Ns) -> None:
        output = self.link.take_output()
        if output:
            self._queue.append((now + (self._late if output == DLE else 0), output))


class Chatty(Built):
    """Correct; sends a block of its own every two seconds."""

    def __init__(self, profile: Profile = RHO3, priority: Priority = Priority.LOW, layer: str = "rk512", period: Ns = ms(2000)) -> None:
        super().__init__(profile, priority, layer)
        self._period, self._next = period, period

    def deadline(self) -> Ns | None:
        due = super().deadline()
        return self._next if due is None else min(due, self._next)

    def wake(self, now: Ns) -> Sequence[object]:
        if now >= self._next:
            self._next = now + self._period
            if self.link.pending < 2:
                self.link.send(OWN_BLOCK, now)
        due = self.link.deadline()
        return super().wake(now) if due is not None and due <= now else []


class ActiveStation(Built):
    """Both roles of RK512: `stimulate` makes it send a command of its own."""

    def __init__(
        self,
        profile: Profile = RHO3,
        priority: Priority = Priority.LOW,
        nesting: bool = True,
        roles: type[Roles] = Roles,
        active: type[Active] = Active,
    ) -> None:
        super().__init__(profile, priority)
        dialect = replace(DIALECTS.get(profile.name, STANDARD), nesting=nesting)
        assert self.passive is not None
        self.active = active(dialect)
        self.roles = roles(self.passive, self.active, dialect)
        self._jobs = 0

    def stimulate(self, now: Ns, block: bytes = b"") -> None:
        self._jobs += 1
        if self._jobs % 2:
            self.active.fetch(0, 2, block=5)
        else:
            self.active.send(0, b"\x01\x02\x10\x04", block=5)
        self._hand_over(now)

    def _hand_over(self, now: Ns) -> None:
        while (block := self.roles.take_block()) is not None:
            self.link.send(block, now)

    def _serve(self, data: bytes, now: Ns) -> None:
        self.roles.block(data, now)
        self._hand_over(now)

    def _handle(self, events: Sequence[object], now: Ns) -> Sequence[object]:
        for event in events:
            if type(event).__name__ == "BlockSent":
                self.roles.block_sent(now)
            elif type(event).__name__ == "SendFailed":
                self.roles.block_failed(now)
        handled = super()._handle(events, now)
        self._hand_over(now)
        return handled

    def wake(self, now: Ns) -> Sequence[object]:
        due = self.link.deadline()
        events = super().wake(now) if due is not None and due <= now else []
        self.active.wake(now)
        self._hand_over(now)
        return events

    def deadline(self) -> Ns | None:
        moments = [moment for moment in (self.link.deadline(), self.active.deadline()) if moment is not None]
        return min(moments, default=None)


Maker = Callable[[], object]


@dataclass(frozen=True, slots=True)
class Mutant:
    """A faulty device.  expects: purposes of which at least one must FAIL, and no other may be the only one."""

    id: str
    what: str
    expects: tuple[str, ...]
    make: Maker
    link: dict[str, object]
    pics: dict[str, object]


@dataclass(frozen=True, slots=True)
class Variant:
    """A correct device that is unlike the others: no FAIL."""

    id: str
    what: str
    make: Maker
    link: dict[str, object]
    pics: dict[str, object]
    touch: bool = True


def link_of(profile: Profile, priority: Priority) -> dict[str, object]:
    """The [link] table of a bench for such a station."""
    return {"profile": profile.name.removesuffix("-3964"), "priority": priority.name.lower(), "block_check": profile.block_check}


def fresh_link(station: Built, priority: Priority) -> None:
    """The station forgets all it had on the line."""
    station.link = Link(replace(station.profile, nak_at_start=False), priority)
