"""Sending side of 3964R.  Source: rho 3 Releases part 1, section 7.1 (below: 7.1)."""

from collections import deque
from dataclasses import dataclass
from enum import Enum, auto

from protocols.base.machine import Damage, Ns
from protocols.p3964r.attempts import Attempts
from protocols.p3964r.characters import DLE, NAK, STX, Char, wire_block
from protocols.p3964r.events import BlockSent, Failure, Outbox, SamePriority, SendFailed, SendRepeated, Stage
from protocols.p3964r.profiles import Interruption, Priority, Profile

DRIFT = 16  # the report of `sent` may be late by this part of the block's own time: a clock that differs from the port's count (AX-652)
MOST_JOBS = 64  # waiting ones; nothing grows while a partner is away


class State(Enum):
    """What the sender expects next."""

    IDLE = auto()
    PAUSED = auto()  # before a repeat
    CONNECT = auto()  # STX sent; waits for DLE
    SENDING = auto()  # block sent, has not yet left
    BACKING_OFF = auto()  # interrupted in the block; waits for a quiet line
    ANSWER = auto()  # block has left; waits for DLE


IDLE, PAUSED, CONNECT, SENDING, BACKING_OFF, ANSWER = State  # compared at every character: State.IDLE costs a search in its class
ON_THE_LINE = (SENDING, BACKING_OFF, ANSWER)


@dataclass(frozen=True, slots=True)
class Job:
    """A block to send, under the number its owner knows."""

    number: int
    block: bytes
    end: Char


@dataclass(slots=True)
class BlockOut:
    """The first job's block since it was put into the box."""

    wire: bytes
    turn: int  # of the box, in which that was
    since: Ns
    early: Ns | None = None  # a DLE received before the port reported that the block had left

    def answered(self, now: Ns, least: Ns) -> bool:
        """Called when the port reports that the block has left: whether an early DLE is the answer to it."""
        return self.early is not None and now - self.early <= max(least, (now - self.since) // DRIFT)


class Sender:
    """Sends one job after another; half of a Link, which starts it when the line is free."""

    def __init__(self, profile: Profile, priority: Priority, box: Outbox) -> None:
        self._profile, self._priority, self._box = profile, priority, box
        self.state = IDLE  # other than IDLE: a job is on the line
        self.due: Ns | None = None  # the deadline
        self.jobs: deque[Job] = deque()  # neither sent nor aborted
        self._number = 0
        self._attempts = Attempts()
        self._conflict = False  # the partner's STX was received and ignored
        self._repeated_at: Ns | None = None  # when STX was sent in the middle of a burst
        self._done_at: Ns | None = None  # when a block was acknowledged
        self._out = BlockOut(b"", -1, 0)
        self._stx_in = -1  # the turn of STX
        self._revoked = False  # the first job was withdrawn by its owner
        self.overtook = 0  # first job that was sent, with priority, although the partner had sent STX before it; 0: none

    @property
    def busy(self) -> bool:
        """A job is on the line: received characters answer it."""
        return self.state is not IDLE

    def add(self, block: bytes, end: Char = Char.ETX) -> int:
        if len(self.jobs) >= MOST_JOBS:
            self._drop_oldest_waiting()
        self._number += 1
        self.jobs.append(Job(self._number, block, end))
        return self._number

    def _drop_oldest_waiting(self) -> None:
        index = 1 if self.busy or self._attempts.failed else 0
        self._box.report(SendFailed(self.jobs[index].number, Failure.CROWDED, Stage.WAITING))
        del self.jobs[index]

    def start(self, now: Ns) -> None:
        """The line is free: begin the first job, or go on with it where a conflict interrupted it."""
        if self._revoked:  # it had yielded to the partner: nothing of it is on the line
            self._finish(SendFailed(self.jobs[0].number, Failure.REVOKED, Stage.WAITING))
        elif self._exhausted():
            self._give_up(Failure.CONFLICT, Stage.CONNECT)
        else:
            self._connect()
            self._repeated_at = now if now == self._done_at else None  # the next job follows in the burst that ended the last one

    def replace(self, number: int, block: bytes, end: Char = Char.ETX) -> bool:
        """Another block for a job of which no character is on the line but STX; False: it is too late, or the job is over."""
        for at, job in enumerate(self.jobs):
            if job.number == number and (at or self.state not in ON_THE_LINE):
                self.jobs[at] = Job(number, block, end)
                return True
        return False

    def revoke(self) -> None:
        """Withdraw the first job: a block on the line is completed but not repeated, none is started any more."""
        self._revoked = bool(self.jobs)

    def forget_attempts(self) -> None:
        """The partner sent a block, good or bad, to its end: the job that yielded to it restarts."""
        attempts = self._attempts
        if attempts.connects or attempts.blocks or attempts.yielded:  # no call where there is nothing to forget
            attempts.clear()

    # ---- the table
    def hear(self, byte: int, now: Ns) -> bool:
        """Take one character; False: it is not for us, the partner has the line now."""
        if self.state is SENDING and self._box.turn == self._out.turn and byte != NAK:
            self._take_back(now)
        state = self.state
        if state is CONNECT:
            return self._hear_answer_to_stx(byte, now)
        if state is ANSWER:
            if byte == DLE:
                self._succeed()
                self._done_at = now
            else:
                self._block_failed(_kind(byte), now)
        elif state is SENDING:
            self._hear_inside(byte, now)
        elif state is BACKING_OFF:
            self.due = now + self._profile.char_delay
        elif state is PAUSED and byte == STX:
            self.state, self.due = IDLE, None
            return False
        return True

    def _hear_answer_to_stx(self, byte: int, now: Ns) -> bool:
        if byte == STX:
            return self._meet()
        if now == self._repeated_at or self._box.turn == self._stx_in:
            pass  # came together with the cause of our STX: not an answer to it (AX-228)
        elif byte == DLE:
            self._transmit(now)
        elif self.due is not None:  # else our STX has not left: no answer to it; a DLE may be ahead of the port's report (AX-241)
            self._connect_failed(_kind(byte), now)
        return True

    def _hear_inside(self, byte: int, now: Ns) -> None:
        """While the block is on its way."""
        if byte == NAK:
            self._box.output.clear()  # abort: unread output is discarded
            self._block_failed(Failure.NAK, now)
        elif byte == DLE:
            self._out.early = None if self._box.output else now
        else:
            self._interrupted(now)

    def damaged(self, kind: Damage, now: Ns) -> None:
        if kind is Damage.BREAK:
            self._box.output.clear()
            self._finish(SendFailed(self.jobs[0].number, Failure.BREAK, self._stage()))
        elif self.state is CONNECT:
            if self.due is not None:  # else no answer to it either
                self._connect_failed(Failure.DAMAGED, now)
        elif self.state is ANSWER:
            self._block_failed(Failure.DAMAGED, now)
        else:
            self._out.early = None

    def _meet(self) -> bool:
        """Both stations sent STX: with priority go on, without keep the job and listen (7.1)."""
        repeated = self._attempts.failed > 0 and not self._attempts.yielded
        if self._priority is Priority.HIGH and not (repeated and self._profile.yields_to_second_conflict):
            self._conflict = True
            if not self.overtook and self._attempts.blocks == 0:
                self.overtook = self.jobs[0].number
            return True
        if self._box.turn == self._stx_in:
            del self._box.output[-1:]  # our STX has not left yet: now it never will
        if self._priority is Priority.HIGH:
            self._attempts.give_way()
        else:
            self._attempts.connects += 1
        self.state, self.due = IDLE, None
        return False

    def _interrupted(self, now: Ns) -> None:
        self._out.early = None
        if self._profile.interruption is Interruption.BACK_OFF:
            self._box.output.clear()
            self.state, self.due = BACKING_OFF, now + self._profile.char_delay

    # ---- actions of the rows
    def _connect(self) -> None:
        self._repeated_at = None
        self._box.say(STX)
        self._stx_in = self._box.turn
        self.state, self.due, self._conflict = CONNECT, None, False  # the wait runs from `sent`

    def _transmit(self, now: Ns) -> None:
        if self._revoked:  # even after a successful connection
            self._give_up(Failure.REVOKED, Stage.CONNECT)
            return
        wire = wire_block(self.jobs[0].block, self._profile.block_check, self.jobs[0].end)
        self._box.output += wire
        out = self._out
        out.wire, out.turn, out.since, out.early = wire, self._box.turn, now, None  # no new one: it would cost a call
        self.state, self.due = SENDING, None

    def _take_back(self, now: Ns) -> None:
        """A partner that sent DLE waits for our block: a DLE followed by more in one burst was not an answer (AX-241)."""
        del self._box.output[-len(self._out.wire) :]
        self._connect_failed(Failure.WRONG, now)

    def _connect_failed(self, why: Failure, now: Ns) -> None:
        if self._conflict and why is Failure.SILENT:
            self._box.report(SamePriority(Priority.HIGH))
        self._attempts.connects += 1
        if self._profile.silence_ends and why is Failure.SILENT:
            self._give_up(why, Stage.CONNECT)
        else:
            self._again(why, Stage.CONNECT, now)

    def _block_failed(self, why: Failure, now: Ns) -> None:
        self._attempts.block_failed(self._profile.connect_counter)
        self._again(why, Stage.BLOCK, now)

    def _exhausted(self) -> bool:
        return self._revoked or self._attempts.exhausted(self._profile)

    def _again(self, why: Failure, stage: Stage, now: Ns) -> None:
        if self._exhausted():
            self._give_up(why, stage)
            return
        self._box.report(SendRepeated(self.jobs[0].number, why, stage))
        pause = self._profile.retry_pause
        if self._conflict and why is Failure.NAK and stage is Stage.CONNECT:
            pause = max(
                pause, self._profile.char_delay
            )  # a partner that refuses to yield goes first, otherwise both repeat in step (AX-243)
        if pause:
            self.state, self.due = PAUSED, now + pause
        else:
            self._connect()
            self._repeated_at = now

    def _give_up(self, why: Failure, stage: Stage) -> None:
        if self._profile.nak_when_giving_up:
            self._box.say(NAK)
        self._finish(SendFailed(self.jobs[0].number, why, stage))

    def _succeed(self) -> None:
        self._finish(BlockSent(self.jobs[0].number))

    def _finish(self, event: BlockSent | SendFailed) -> None:
        self._box.report(event)
        self.jobs.popleft()
        attempts = self._attempts
        if attempts.connects or attempts.blocks or attempts.yielded:  # no call where there is nothing to forget
            attempts.clear()
        self.state, self.due, self._revoked = IDLE, None, False

    def _stage(self) -> Stage:
        return Stage.BLOCK if self.state in ON_THE_LINE else Stage.CONNECT

    # ---- time
    def sent(self, now: Ns) -> None:
        """All output has left the line: the acknowledgement delay runs from here."""
        if self.state is CONNECT and self.due is None:
            self.due = now + self._profile.ack_delay
        elif self.state is SENDING:
            if self._out.early is not None and self._out.answered(now, self._profile.early_answer):
                self._succeed()  # the partner was faster than the port's report (AX-052)
                return
            self.state, self.due = ANSWER, now + self._profile.ack_delay

    def expire(self, now: Ns) -> None:
        match self.state:
            case State.CONNECT:
                self._connect_failed(Failure.SILENT, now)
            case State.ANSWER:
                self._block_failed(Failure.SILENT, now)
            case State.BACKING_OFF:
                self._box.say(NAK)
                self._block_failed(Failure.WRONG, now)
            case _:
                self._connect()

    def lost(self) -> None:
        """The port is lost: every open job is reported."""
        stage = self._stage() if self.busy else Stage.WAITING
        for job in self.jobs:
            self._box.report(SendFailed(job.number, Failure.LOST, stage))
            stage = Stage.WAITING
        self.jobs.clear()
        self._revoked, self.overtook = False, 0
        self._attempts.clear()
        self.state, self.due = IDLE, None


def _kind(byte: int) -> Failure:
    return Failure.NAK if byte == NAK else Failure.WRONG
