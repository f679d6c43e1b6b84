"""A station of a maker at the tester's end of the line: axisgate's link with that maker's times, attempts and RK512 dialect."""

import itertools
from collections.abc import Callable

from gateway.conformance.suites.line import LineTester
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.events import BlockReceived, BlockRefused, BlockSent, Event, SendFailed, SendRepeated
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import Priority, Profile
from protocols.rk512.active import Active
from protocols.rk512.active import Event as JobEvent
from protocols.rk512.dialects import dialect_of
from protocols.rk512.header import ErrorNumber
from protocols.rk512.passive import Passive
from protocols.rk512.station import Station

Change = Callable[[bytes], bytes]
Done = Callable[[], bool]
START = ms(60)


def joined(words: list[str]) -> str:
    """Equal ones in a row once, with their number."""
    groups = [(word, len(list(same))) for word, same in itertools.groupby(words)]
    return ", ".join(word if count == 1 else f"{word} ({count} times)" for word, count in groups)


class Shelf:
    """All data blocks; written values stay."""

    def __init__(self) -> None:
        self.content: dict[tuple[int, int], bytes] = {}

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        return b"".join(self.content.get((db, at), bytes((db, at & 0xFF))) for at in range(word, word + words))

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        for at in range(0, len(data), 2):
            self.content[db, word + at // 2] = data[at : at + 2]
        return None


class Partner:
    """One station, from the beginning of a case to its end."""

    def __init__(self, t: LineTester, profile: Profile, priority: Priority) -> None:
        self._t = t
        self.profile = profile
        self.link = Link(profile, priority)
        dialect = dialect_of(profile.name)
        self.active = Active(dialect)
        self.roles: Station | None = None
        self._dialect = dialect
        self.received: list[bytes] = []
        self.jobs: list[JobEvent] = []
        self.heard = bytearray()
        self.sent = 0  # blocks of ours that were acknowledged
        self.failed: list[str] = []
        self.repeats: list[str] = []
        self.refused: list[str] = []
        self.says: Change | None = None  # damage on the way, once
        self.hears: Change | None = None
        self.swallows = False  # the acknowledgement of the first block gets lost on the way
        self._leaves: Ns | None = None

    def with_rk512(self) -> "Partner":
        """Both roles of RK512 on the link."""
        self.roles = Station(Passive(Shelf(), self._dialect), self.active, self._dialect)
        return self

    # ---- time
    def play(self, done: Done, limit: Ns) -> bool:
        """Both stations exchange data until the condition holds; False: the time is over."""
        wire = self._t.wire
        end = wire.now() + limit
        while not done():
            self._speak()
            moments = [moment for moment in (self.link.deadline(), self._leaves, self._wait()) if moment is not None]
            heard = self._t.char(min((end, *moments)))
            now = wire.now()
            if self._leaves is not None and min(self._leaves, wire.drained()) <= now:  # a port without a serial line is quicker
                self._leaves = None
                self._take(self.link.sent(now), now)
            if heard is not None:
                self._take(self._hear(heard, now), now)
                continue
            if now >= end:
                return done()
            self._take(self.link.wake(now), now)
            self._jobs(self.active.wake(now), now)
        self._speak()
        return True

    def quiet(self, limit: Ns) -> None:
        """Wait for quiet, with nothing left to do; accept what still arrives."""
        self.play(lambda: False, limit)

    def meets(self, block: bytes, limit: Ns) -> int | Damage | None:
        """The device's STX is received only once the partner's has left: both request the line.  Returns the received characters."""
        heard = self._t.char(self._t.wire.now() + limit)
        now = self._t.wire.now()
        self.link.receive(b"", now)
        self.link.send(block, now)
        self._speak()
        if heard is not None:
            self._take(self._hear(heard, now), now)
        return heard

    def _wait(self) -> Ns | None:
        return self.active.deadline() if self.roles is not None else None

    def restart(self, profile: Profile) -> None:
        """Its supply failed; it ignores the rest of what is on the line, and some makers send NAK when the interface is ready."""
        while self._t.char(self._t.wire.now() + START) is not None:
            pass
        self.link = Link(profile if self.profile.block_check else profile.plain(), self.link.priority)
        self._leaves = None

    # ---- the line
    def send(self, block: bytes) -> None:
        self.link.send(block, self._t.wire.now())

    def hand_over(self) -> None:
        """Telegrams of RK512 to the link."""
        while self.roles is not None and (block := self.roles.take_block()) is not None:
            self.link.send(block, self._t.wire.now())

    def _speak(self) -> None:
        data = self.link.take_output()
        if not data:
            return
        if self.says is not None and len(data) > 1:
            data, self.says = self.says(data), None
        if self.swallows and self.received:
            self.swallows = False
        else:
            self._t.say(data)
        self._leaves = self._t.wire.drained()

    def _hear(self, heard: int | Damage, now: Ns) -> list[Event]:
        if isinstance(heard, Damage):
            return self.link.damaged(heard, now)
        data = bytes((heard,))
        self.heard += data
        if self.hears is not None:
            changed = self.hears(data)
            if changed != data:
                self.hears = None
            data = changed
        return self.link.receive(data, now)

    def _take(self, events: list[Event], now: Ns) -> None:
        for event in events:
            if isinstance(event, BlockReceived):
                self.received.append(event.data)
                if self.roles is not None:
                    self._jobs(self.roles.block(event.data, now), now)
            elif isinstance(event, BlockSent):
                self.sent += 1
                if self.roles is not None:
                    self._jobs(self.roles.block_sent(now), now)
            elif isinstance(event, SendFailed):
                self.failed.append(event.why.name)
                if self.roles is not None:
                    self._jobs(self.roles.block_failed(now), now)
            elif isinstance(event, SendRepeated):
                self.repeats.append(f"{event.stage.name}: {event.why.name}")
            elif isinstance(event, BlockRefused):
                self.refused.append(event.why.name)

    def _jobs(self, events: object, now: Ns) -> None:
        assert isinstance(events, list)
        self.jobs += events
        self.hand_over()
