"""3964R: stations on which something before has an effect later, with one fault each (used by peers.p3964r)."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from gateway.conformance.peers.powered import Powered
from gateway.conformance.peers.stations import NAK, STX, Built
from protocols.base.machine import Ns, ms
from protocols.p3964r.events import BlockRefused, BlockSent, Refusal
from protocols.p3964r.profiles import RHO3, Priority
from protocols.p3964r.receiver import Receiver
from protocols.p3964r.sender import Sender
from protocols.p3964r.sender import State as Saying


class LongCheck(Receiver):
    """The check of a block of more than 100 characters is not looked at."""

    def _judge(self, check: int) -> None:
        super()._judge(self._check if len(self._data) > 100 else check)


class HastyRepeats(Sender):
    """A repeated block waits 200 ms for its acknowledgement."""

    def sent(self, now: Ns) -> None:
        super().sent(now)
        if self.state is Saying.ANSWER and self._attempts.blocks:
            self.due = now + ms(200)


class PatientAtLast(Sender):
    """The last repeat of a block waits 2.5 s for its acknowledgement."""

    def sent(self, now: Ns) -> None:
        super().sent(now)
        if self.state is Saying.ANSWER and self._attempts.blocks == self._profile.block_attempts - 1:
            self.due = now + ms(2500)


class ShortAfterStx(Sender):
    """The first character of a block is lost where its STX was repeated."""

    def _transmit(self, now: Ns) -> None:
        job = self.jobs[0]
        if self._attempts.connects and not self._attempts.blocks:
            self.jobs[0] = replace(job, block=job.block[1:])
        super()._transmit(now)
        self.jobs[0] = job


class Prolongs(Sender):
    """With priority: the STX of the partner restarts the acknowledgement delay."""

    def hear(self, byte: int, now: Ns) -> bool:
        taken = super().hear(byte, now)
        if taken and byte == STX[0] and self.state is Saying.CONNECT:
            self.due = now + self._profile.ack_delay
        return taken


class FewerAttempts(Sender):
    """A job that gave way has two connection attempts fewer."""

    def forget_attempts(self) -> None:
        gave_way = self._attempts.connects > 0
        super().forget_attempts()
        self._attempts.connects = 2 if gave_way else 0


class ThirdConflict(Sender):
    """The job that yields in every third conflict is lost."""

    _conflicts = 0

    def _meet(self) -> bool:
        taken = super()._meet()
        if not taken:
            self._conflicts += 1
            if self._conflicts % 3 == 0:
                self.jobs.popleft()
        return taken


class DeafAfterGap(Built):
    """Ignores STX for a second after an interrupted block."""

    _until: Ns = 0

    def _handle(self, events: Sequence[object], now: Ns) -> Sequence[object]:
        if any(isinstance(event, BlockRefused) and event.why is Refusal.GAP for event in events):
            self._until = now + ms(1000)
        return super()._handle(events, now)

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return [] if now < self._until and data == STX else super().receive(data, now)


class NakBringsAgain(Built):
    """NAK in idle brings its last block again."""

    _offered, _last = b"", b""

    def stimulate(self, now: Ns, block: bytes = b"U\x10\x02\x15V") -> None:
        self._offered = block
        super().stimulate(now, block)

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        idle = not self.link._sender.busy and not self.link._receiver.busy
        events = super().receive(data, now)
        if any(isinstance(event, BlockSent) for event in events):
            self._last = self._offered
        elif data == NAK and idle and self._last:
            self.link.send(self._last, now)
        return events


def other_after_power(other: Callable[[], Built]) -> Powered:
    """Begins as it is set; each time the supply returns it is the other one."""
    first = iter((Built(RHO3, Priority.LOW),))
    return Powered(lambda: next(first, None) or other())
