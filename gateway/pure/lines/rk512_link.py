"""RK512 on 3964R: one byte machine out of a link and a station, which know nothing of each other."""

from collections.abc import Callable, Sequence

from protocols.base.machine import Damage, Ns
from protocols.p3964r.events import BlockReceived, BlockSent, SendFailed
from protocols.p3964r.events import Event as LinkEvent
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import Priority, Profile
from protocols.rk512.active import Active
from protocols.rk512.dialects import STANDARD, Dialect
from protocols.rk512.header import FOLLOW_ON, is_reaction
from protocols.rk512.passive import Areas, DataBlocks, Passive
from protocols.rk512.station import Event as StationEvent
from protocols.rk512.station import Station

Event = LinkEvent | StationEvent


class Rk512Link:
    """Jobs go to `active` (then `start`), the partner's are served from the store.  Events of the link are passed on, save blocks."""

    def __init__(
        self,
        profile: Profile,
        priority: Priority,
        store: DataBlocks,
        dialect: Dialect = STANDARD,
        baud: int = 9600,
        areas: Areas | None = None,
        tap: Callable[[LinkEvent, Ns], None] | None = None,
    ) -> None:
        """`tap` receives every event of the link, blocks too, before they are handled: for monitors and judges."""
        self._tap = tap
        self.link = Link(profile, priority)
        self.active, self.passive = Active(dialect, baud), Passive(store, dialect, areas)
        self._station = Station(self.passive, self.active, dialect)
        self._command = self._reaction = 0  # the link's job number of the last of each

    def start(self, now: Ns) -> None:
        """Call after giving `active` a job: it leaves as soon as the line is free."""
        while (block := self._station.take_block()) is not None:
            follow_on, reaction = block[0] == FOLLOW_ON, is_reaction(block)
            if reaction and self._station.reactions > 1 and self.link.replace(self._reaction, block, follow_on):
                self._station.replaced()  # a new command withdraws the reaction its partner has not taken (AX-650)
            elif reaction:
                self._reaction = self.link.send(block, now, follow_on)
            else:
                self._command = self.link.send(block, now, follow_on)

    # ---- the machine
    def receive(self, data: bytes, now: Ns) -> Sequence[Event]:
        return self._handle(self.link.receive(data, now), now)

    def damaged(self, kind: Damage, now: Ns) -> Sequence[Event]:
        return self._handle(self.link.damaged(kind, now), now)

    def sent(self, now: Ns) -> Sequence[Event]:
        return self._handle(self.link.sent(now), now)

    def wake(self, now: Ns) -> Sequence[Event]:
        events = [*self._handle(self.link.wake(now), now), *self.active.wake(now)]
        self.start(now)
        return events

    def deadline(self) -> Ns | None:
        dues = [due for due in (self.link.deadline(), self.active.deadline()) if due is not None]
        return min(dues, default=None)

    def take_output(self) -> bytes:
        return self.link.take_output()

    def lost(self, now: Ns) -> Sequence[Event]:
        events = [event for event in self.link.lost(now) if not isinstance(event, SendFailed | BlockSent | BlockReceived)]
        return [*events, *self._station.lost()]

    def _handle(self, link_events: list[LinkEvent], now: Ns) -> list[Event]:
        events: list[Event] = []
        for event in link_events:
            if self._tap is not None:
                self._tap(event, now)
            match event:
                case BlockReceived(data):
                    events += self._station.block(data, now, 0 < self.link.overtaken_by <= self._command)
                case BlockSent():
                    events += self._station.block_sent(now)
                case SendFailed():
                    events += [event, *self._station.block_failed(now)]
                case _:
                    events.append(event)
            self.start(now)
        return events
