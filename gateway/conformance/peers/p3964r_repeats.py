"""3964R: stations whose repeats, counters or conflicts have one fault (used by peers.p3964r)."""

from collections.abc import Sequence
from dataclasses import replace

from gateway.conformance.peers.p3964r_stations import is_block
from gateway.conformance.peers.stations import STX, Built, fresh_link
from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char
from protocols.p3964r.events import BlockReceived, BlockRefused, BlockSent, Failure, Stage
from protocols.p3964r.profiles import RHO3, Priority
from protocols.p3964r.sender import Sender
from protocols.p3964r.sender import State as Saying


class RepeatCheck(Sender):
    """The block check is not cleared before the repeat of a block."""

    def _transmit(self, now: Ns) -> None:
        super()._transmit(now)
        if self._attempts.blocks:
            self._box.output[-1] ^= 0x5A


class ConnectCheck(Sender):
    """The block check counts a STX that was repeated."""

    def _transmit(self, now: Ns) -> None:
        super()._transmit(now)
        if self._attempts.connects > 1:
            self._box.output[-1] ^= Char.STX


class KeepsConnects(Sender):
    """Connection attempts of a job count for the next one as well."""

    _kept = 0

    def start(self, now: Ns) -> None:
        super().start(now)
        self._attempts.connects += self._kept

    def _succeed(self) -> None:
        self._kept = max(0, self._attempts.connects - 1)
        super()._succeed()

    def _give_up(self, why: Failure, stage: Stage) -> None:
        self._kept = 0
        super()._give_up(why, stage)


class KeepsBlocks(Sender):
    """Block attempts of a job count for the next one as well."""

    _kept = 0

    def start(self, now: Ns) -> None:
        super().start(now)
        self._attempts.blocks += self._kept

    def _succeed(self) -> None:
        self._kept = self._attempts.blocks
        super()._succeed()

    def _give_up(self, why: Failure, stage: Stage) -> None:
        self._kept = 0
        super()._give_up(why, stage)


class ShortRepeats(Sender):
    """A repeated STX waits 120 ms."""

    def sent(self, now: Ns) -> None:
        super().sent(now)
        if self.state is Saying.CONNECT and self._attempts.connects > 1 and self.due is not None:
            self.due = now + ms(120)


class Clashes(Built):
    """A station that knows whether both have sent STX."""

    def __init__(self, priority: Priority = Priority.LOW) -> None:
        super().__init__(RHO3, priority)
        self._clash = False

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        self._clash = self._clash or (data == STX and self.link._sender.state is Saying.CONNECT)
        return super().receive(data, now)


class ClashCheck(Clashes):
    """The block of a job that gave way has a wrong check."""

    def take_output(self) -> bytes:
        output = super().take_output()
        if not self._clash or not is_block(output):
            return output
        self._clash = False
        return output[:-1] + bytes((output[-1] ^ 0x01,))


class DropsWhenCorrupted(Clashes):
    """It gave way, the block was corrupted: its own job is lost."""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        events = super().receive(data, now)
        if self._clash and any(isinstance(event, BlockRefused) for event in events):
            self._clash = False
            fresh_link(self, self.priority)
            self.link._box.output.append(Char.NAK)
        self._clash = self._clash and not any(isinstance(event, BlockReceived) for event in events)
        return events


class AnswersOldStx(Clashes):
    """With priority: the STX of a conflict is answered after its own block."""

    def __init__(self) -> None:
        super().__init__(Priority.HIGH)

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        events = super().receive(data, now)
        if self._clash and any(isinstance(event, BlockSent) for event in events):
            self._clash = False
            self.link._box.output.append(Char.DLE)
        return events


class NaksLater(Built):
    """Sends NAK 220 ms after such an event: its character delay runs on."""

    def __init__(self, event: type[BlockReceived] | type[BlockSent]) -> None:
        super().__init__(RHO3, Priority.LOW)
        self._event = event
        self._later: Ns | None = None

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        events = super().receive(data, now)
        if any(isinstance(event, self._event) for event in events):
            self._later = now + ms(220)
        return events

    def deadline(self) -> Ns | None:
        return min((due for due in (super().deadline(), self._later) if due is not None), default=None)

    def wake(self, now: Ns) -> Sequence[object]:
        due = self.link.deadline()
        if self._later is not None and now >= self._later:
            self._later = None
            if due is None:
                self.link._box.output.append(Char.NAK)
        return super().wake(now) if due is not None and due <= now else []


class ChangesThird(Sender):
    """From its second repeat on a block has another last character; the check is right for it."""

    def _transmit(self, now: Ns) -> None:
        job = self.jobs[0]
        if self._attempts.blocks > 1:
            self.jobs[0] = replace(job, block=job.block[:-1] + b"!")
        super()._transmit(now)
        self.jobs[0] = job


class FromTheBeginning(Sender):
    """The wait for the acknowledgement runs from the first character of the block."""

    def sent(self, now: Ns) -> None:
        super().sent(now)
        if self.state is Saying.ANSWER:
            self.due = self._out.since + self._profile.ack_delay


class DropsAll(Sender):
    """Gives up all jobs with the one that failed."""

    def _give_up(self, why: Failure, stage: Stage) -> None:
        super()._give_up(why, stage)
        self.jobs.clear()


class AsciiAcknowledges(Sender):
    """06h (ACK) after the block acknowledges it as well."""

    def hear(self, byte: int, now: Ns) -> bool:
        return super().hear(Char.DLE if self.state is Saying.ANSWER and byte == 0x06 else byte, now)


class AsciiConnects(Sender):
    """06h (ACK) after STX lets it send."""

    def _hear_answer_to_stx(self, byte: int, now: Ns) -> bool:
        return super()._hear_answer_to_stx(Char.DLE if byte == 0x06 else byte, now)
