"""3964R: senders with one fault each (used by peers.p3964r)."""

from dataclasses import replace

from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char
from protocols.p3964r.events import BlockSent, Failure, Stage
from protocols.p3964r.sender import Sender
from protocols.p3964r.sender import State as Saying


class AnyIsDle(Sender):
    """Any character after STX lets it send."""

    def _hear_answer_to_stx(self, byte: int, now: Ns) -> bool:
        return super()._hear_answer_to_stx(byte if byte == Char.STX else Char.DLE, now)


class AnyAcknowledges(Sender):
    """Any character after the block is an acknowledgement."""

    def hear(self, byte: int, now: Ns) -> bool:
        return super().hear(Char.DLE if self.state is Saying.ANSWER else byte, now)


class NakAcknowledges(Sender):
    def hear(self, byte: int, now: Ns) -> bool:
        return super().hear(Char.DLE if self.state is Saying.ANSWER and byte == Char.NAK else byte, now)


class SilenceAcknowledges(Sender):
    def expire(self, now: Ns) -> None:
        if self.state is Saying.ANSWER:
            self._succeed()
        else:
            super().expire(now)


class GivesUpAtOnce(Sender):
    """A refused block is not repeated."""

    def _block_failed(self, why: Failure, now: Ns) -> None:
        self._give_up(why, Stage.BLOCK)


class SendsTwice(Sender):
    """An acknowledged block is sent once more."""

    _twice = False

    def _succeed(self) -> None:
        self._twice = not self._twice
        if self._twice:
            self._connect()
        else:
            super()._succeed()


class ImpatientForAcknowledge(Sender):
    """A DLE 300 ms after its block is too late for it."""

    def hear(self, byte: int, now: Ns) -> bool:
        late = self.state is Saying.ANSWER and self.due is not None and now > self.due - self._profile.ack_delay + ms(300)
        return super().hear(Char.NAK if late else byte, now)


class TwiceAfterConflict(Sender):
    """A job that gave way is sent twice."""

    _gave_way = False

    def _meet(self) -> bool:
        taken = super()._meet()
        self._gave_way = self._gave_way or not taken
        return taken

    def _succeed(self) -> None:
        if self._gave_way:
            self._gave_way = False
            self._connect()
        else:
            super()._succeed()


class Differs(Sender):
    """The repeat of a block carries another last character."""

    def _transmit(self, now: Ns) -> None:
        if self._attempts.blocks:
            job = self.jobs[0]
            self.jobs[0] = replace(job, block=job.block[:-1] + bytes((job.block[-1] ^ 1,)))
        super()._transmit(now)


class DeafInBlock(Sender):
    """NAK inside its block is not received."""

    def _hear_inside(self, byte: int, now: Ns) -> None:
        if byte != Char.NAK:
            super()._hear_inside(byte, now)


class LateDleOpens(Sender):
    """A DLE after it gave up still lets the block out."""

    _lost_block: bytes = b""

    def _give_up(self, why: Failure, stage: Stage) -> None:
        self._lost_block = self.jobs[0].block
        super()._give_up(why, stage)


class LosesNext(Sender):
    """After it gave up, the next job is lost."""

    _lose = False

    def _give_up(self, why: Failure, stage: Stage) -> None:
        self._lose = True
        super()._give_up(why, stage)

    def start(self, now: Ns) -> None:
        if self._lose:
            self._lose = False
            self._finish(BlockSent(self.jobs[0].number))
        else:
            super().start(now)


class WithoutStx(Sender):
    """A refused block is repeated without a new connection."""

    def _block_failed(self, why: Failure, now: Ns) -> None:
        self._attempts.blocks += 1
        if self._exhausted():
            self._give_up(why, Stage.BLOCK)
        else:
            self._transmit(now)


class CountsOneMore(Sender):
    """One block attempt more after NAK."""

    def _exhausted(self) -> bool:
        tried, profile = self._attempts, self._profile
        return self._revoked or tried.connects >= profile.connect_attempts or tried.blocks > profile.block_attempts


class NoYield(Sender):
    """Without priority it does not yield in a repeat."""

    def _meet(self) -> bool:
        if self._attempts.failed > 0:
            self._conflict = True
            return True
        return super()._meet()


class DropsInConflict(Sender):
    def _meet(self) -> bool:
        taken = super()._meet()
        if not taken:
            self.jobs.popleft()
        return taken
