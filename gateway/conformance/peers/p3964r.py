"""3964R: our station with one fault each, and stations that are correct in another way (numbers: serial-protocols 1.2 to 1.6)."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from gateway.conformance.peers.powered import Powered
from gateway.conformance.peers.stations import (
    DLE,
    NAK,
    OWN_BLOCK,
    STX,
    AnswersLate,
    Built,
    Chatty,
    DeafToDamage,
    Maker,
    Mutant,
    Variant,
    fresh_link,
    link_of,
)
from gateway.conformance.serial.partners import (
    DropsItsJob,
    Late,
    NaksConflicts,
    NeverDoubles,
    NoNak,
    OwnCheck,
    Silent,
    counts_once,
    includes_stx,
)
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char, check_of
from protocols.p3964r.events import BlockRefused, BlockSent, Failure, Refusal, Stage
from protocols.p3964r.profiles import (
    LINUX,
    RHO3,
    SIEMENS_CP341,
    VIPA_CP240,
    WAGO,
    BrokenPair,
    Priority,
    Profile,
)
from protocols.p3964r.receiver import Receiver
from protocols.p3964r.receiver import State as Hearing
from protocols.p3964r.sender import Sender
from protocols.p3964r.sender import State as Saying

LOW, HIGH = Priority.LOW, Priority.HIGH
R, S, C = "3964R_RCV_", "3964R_SND_", "3964R_CON_"
TIMED = (f"{R}TI_01", f"{R}TI_02", f"{R}TI_03", f"{R}TI_04")


# ---- receivers
class AnyCheck(Receiver):
    def _judge(self, check: int) -> None:
        super()._judge(self._check)


class TopBitOfCheck(Receiver):
    def _judge(self, check: int) -> None:
        super()._judge(self._check if (check ^ self._check) == 0x80 else check)


class ZeroIsGood(Receiver):
    def _judge(self, check: int) -> None:
        super()._judge(self._check if check == 0 else check)


class OrComplement(Receiver):
    def _judge(self, check: int) -> None:
        super()._judge(self._check if check == self._check ^ 0xFF else check)


class OnceToo(Receiver):
    """Takes a check that counts a doubled DLE once as well."""

    def _judge(self, check: int) -> None:
        super()._judge(self._check if check == self._check ^ Char.DLE and Char.DLE in self._data else check)


class CheckOfDle(Receiver):
    """A check of 10h is taken for the start of a pair."""

    def _judge(self, check: int) -> None:
        super()._judge(check ^ 0xFF if check == Char.DLE else check)


class CheckOfNak(Receiver):
    def _judge(self, check: int) -> None:
        super()._judge(check ^ 0xFF if check == Char.NAK else check)


class Restarts(Receiver):
    """02h inside a block begins it anew."""

    def _collect(self, data: bytes, at: int) -> int:
        if data[at] == Char.STX:
            self._data.clear()
            self._count, self._check = 0, 0
            self._guard.untouched = False
            return at + 1
        return super()._collect(data[: at + 1], at)


class NakEnds(Receiver):
    """15h inside a block ends it."""

    def _collect(self, data: bytes, at: int) -> int:
        if data[at] == Char.NAK:
            self._refuse(Refusal.ORDER)
            return at + 1
        return super()._collect(data[: at + 1], at)


class NoTimer(Receiver):
    """Waits for the next character for ever."""

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        found = super().hear(data, at, now)
        self.due = None
        return found

    def sent(self, now: Ns) -> None:
        super().sent(now)
        self.due = None


class TimerOfBlock(Receiver):
    """The character delay runs once, from the DLE on."""

    _began: Ns = 0

    def sent(self, now: Ns) -> None:
        super().sent(now)
        if self._state is Hearing.DATA and self._guard.untouched:
            self._began = now

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        found = super().hear(data, at, now)
        if self.due is not None and not self._guard.untouched and self._state in (Hearing.DATA, Hearing.ESCAPED, Hearing.CHECK):
            self.due = min(self.due, self._began + self._profile.char_delay)
        return found


class NoTimerBeforeCheck(Receiver):
    def hear(self, data: bytes, at: int, now: Ns) -> int:
        found = super().hear(data, at, now)
        if self._state is Hearing.CHECK and self.due is not None:
            self.due += ms(2000)
        return found


class NoTimerInPair(Receiver):
    def hear(self, data: bytes, at: int, now: Ns) -> int:
        found = super().hear(data, at, now)
        if self._state is Hearing.ESCAPED and self.due is not None:
            self.due += ms(2000)
        return found


class SilentGap(Receiver):
    """Leaves a block that broke off without a word."""

    def expire(self, now: Ns) -> None:
        inside = self._state in (Hearing.DATA, Hearing.ESCAPED, Hearing.CHECK)
        before = len(self._box.output)
        super().expire(now)
        if inside:
            del self._box.output[before:]


class Locks(Receiver):
    """After five refused blocks it hears nothing any more."""

    _bad = 0

    def _refuse(self, why: Refusal) -> None:
        self._bad += 1
        super()._refuse(why)

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        return len(data) if self._bad >= 5 else super().hear(data, at, now)


class GarbageKills(Receiver):
    """Twenty stray characters fill its buffer for ever."""

    _full = False

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        self._full = self._full or self._strays > 20
        return len(data) if self._full else super().hear(data, at, now)


class TailOpens(Receiver):
    """NAK at once at a broken pair, and a 02h of the rest opens a block."""

    def _broken_pair(self, byte: int) -> None:
        self._refuse(Refusal.ORDER)
        self._guard.torn = self._guard._restless = False

    def _open(self, now: Ns) -> None:
        self._guard.torn = self._guard._restless = False
        super()._open(now)


class EmptyHangs(Receiver):
    """An empty block is never answered, and nothing is after it."""

    _hung = False

    def _deliver(self) -> None:
        if not self._data:
            self._hung = True
            self._rest()
        else:
            super()._deliver()

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        return len(data) if self._hung else super().hear(data, at, now)


class EveryTenth(Receiver):
    """Every 25th good block is refused."""

    _good = 0

    def _deliver(self) -> None:
        self._good += 1
        if self._good % 25 == 0:
            self._refuse(Refusal.CHECK)
        else:
            super()._deliver()


class DleInIdle(Receiver):
    """A DLE in idle is answered with DLE."""

    def _stray(self, now: Ns) -> None:
        super()._stray(now)

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        if self._state is Hearing.IDLE and data[at] == Char.DLE:
            self._box.say(Char.DLE)
        return super().hear(data, at, now)


class StrayOpens(Receiver):
    """Any character in idle is taken for STX."""

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        if self._state is Hearing.IDLE and data[at] not in (Char.STX, Char.NAK, Char.DLE):
            self._open(now)
            return at + 1
        return super().hear(data, at, now)


class AnswersNak(Receiver):
    """NAK in idle is answered with NAK."""

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        if self._state is Hearing.IDLE and data[at] == Char.NAK:
            self._box.say(Char.NAK)
        return super().hear(data, at, now)


# ---- senders
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


class Differs(Sender):
    """The repeat of a block carries another last character."""

    def _transmit(self, now: Ns) -> None:
        if self._blocks:
            job = self.jobs[0]
            self.jobs[0] = replace(job, block=job.block[:-1] + bytes((job.block[-1] ^ 1,)))
        super()._transmit(now)


class DeafInBlock(Sender):
    """NAK inside its block is not heard."""

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
        self._blocks += 1
        if self._exhausted():
            self._give_up(why, Stage.BLOCK)
        else:
            self._transmit(now)


class CountsOneMore(Sender):
    """One block attempt more after NAK."""

    def _exhausted(self) -> bool:
        return self._revoked or self._connects >= self._profile.connect_attempts or self._blocks > self._profile.block_attempts


class NoYield(Sender):
    """Without priority it does not give way in a repeat."""

    def _meet(self) -> bool:
        if self._connects + self._blocks > 0:
            self._conflict = True
            return True
        return super()._meet()


class DropsInConflict(Sender):
    def _meet(self) -> bool:
        taken = super()._meet()
        if not taken:
            self.jobs.popleft()
        return taken


class LateDle(Built):
    """A DLE after it gave up brings the block."""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        sender = self.link._sender
        if data == DLE and not sender.busy and not self.link._receiver.busy and isinstance(sender, LateDleOpens) and sender._lost_block:
            lost, sender._lost_block = sender._lost_block, b""
            self.link._box.output += lost + DLE + bytes((Char.ETX,))
            return []
        return super().receive(data, now)


class BreakHangs(Built):
    """After a BREAK in idle it hears nothing any more."""

    _hung = False

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        self._hung = self._hung or kind is Damage.BREAK
        return super().damaged(kind, now)

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return [] if self._hung else super().receive(data, now)


class ResetsOnConflict(Built):
    """Forgets the line when both send STX: no answer, no job."""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        if data == STX and self.link._sender.state is Saying.CONNECT:
            fresh_link(self, self.priority)
            return []
        return super().receive(data, now)


# ---- what is said
def _seven_bits(byte: int) -> bytes:
    return bytes((byte & 0x7F,))


def _extra(output: bytes) -> bytes:
    return output + b"\r" if _block(output) else output


def _block(output: bytes) -> bool:
    return len(output) >= 4 and bytes((Char.DLE, Char.ETX)) in output


def _complement(block: bytes) -> int:
    return block[-1] ^ 0xFF


def _wrong_own_check(output: bytes) -> bytes:
    return output[:-1] + bytes((output[-1] ^ 0x40,)) if _block(output) else output


def _check_without_end(output: bytes) -> bytes:
    return output[:-1] + bytes((check_of(output[:-3]),)) if _block(output) else output


def _no_check(output: bytes) -> bytes:
    return output[:-1] if _block(output) else output


def _no_end(output: bytes) -> bytes:
    return output[:-3] if _block(output) else output


def _profile(**changes: Any) -> Callable[[], object]:
    return lambda: Built(replace(RHO3, **changes))


class DeafAfter(Built):
    """Hears nothing for a while after such an event."""

    def __init__(self, event: type[BlockSent] | type[BlockRefused], how_long: Ns) -> None:
        super().__init__(RHO3, LOW)
        self._event, self._how_long, self._until = event, how_long, 0

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        if now < self._until and data == STX:
            return []
        events = super().receive(data, now)
        if any(isinstance(event, self._event) for event in events):
            self._until = now + self._how_long
        return events


class NakTwice(Built):
    """Refuses with two NAK."""

    def take_output(self) -> bytes:
        output = super().take_output()
        return NAK + NAK if output == NAK else output


class WedgesInARow(Built):
    """The twelfth job within ten seconds, and all behind it, are not sent."""

    def __init__(self) -> None:
        super().__init__(RHO3, LOW)
        self._moments: list[Ns] = []

    def stimulate(self, now: Ns, block: bytes = OWN_BLOCK) -> None:
        self._moments = [moment for moment in self._moments if now - moment < ms(10_000)] + [now]
        if len(self._moments) < 12:
            super().stimulate(now, block)


class FlipsPriority(Built):
    """Each conflict changes its priority."""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        met = data == STX and self.link._sender.state is Saying.CONNECT
        events = super().receive(data, now)
        if met:
            self._met += 1
            self.link._sender._priority = HIGH if self._met % 3 == 0 else LOW
        return events

    _met = 0


def _mutant(name: str, what: str, expects: Sequence[str], make: Maker, priority: Priority = LOW) -> Mutant:
    return Mutant(name, what, tuple(expects), make, link_of(RHO3, priority), {})


def _with(receiver: type[Receiver] | None = None, sender: type[Sender] | None = None, priority: Priority = LOW) -> Maker:
    return lambda: Built(RHO3, priority, receiver=receiver, sender=sender)


class _Never(NeverDoubles, Built):
    """Sends a DLE of its data once."""


class EverySecondStx(Built):
    """One STX of two is not heard."""

    _heard = b""
    _count = 0

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        self._heard = data
        return super().receive(data, now)

    def take_output(self) -> bytes:
        output = super().take_output()
        if self._heard == STX and output == DLE:
            self._count += 1
            if self._count % 2:
                fresh_link(self, LOW)
                return b""
        return output


class NakOpens(Built):
    """NAK in idle makes it send STX, and nothing after it."""

    _opens = False

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        idle = self.link.deadline() is None and not self.link.pending
        self._opens = data == NAK and idle
        return super().receive(data, now)

    def take_output(self) -> bytes:
        output = super().take_output()
        opens, self._opens = self._opens, False
        return output or (STX if opens else b"")


class _Drops(DropsItsJob, Built):
    pass


MUTANTS = (
    _mutant("silent", "never answers", [f"{R}BV_01"], lambda: Silent(RHO3, LOW)),
    _mutant("no-nak", "never sends NAK", [f"{R}BI_01", f"{R}TI_01", f"{S}BI_01"], lambda: NoNak(RHO3, LOW)),
    _mutant("drops-its-job", "gives way in a conflict and forgets its own job", [f"{C}BV_02"], lambda: _Drops(RHO3, LOW)),
    _mutant("slow", "everything 3 s late", [f"{R}BV_01"], lambda: Late(RHO3, LOW, late=ms(3000))),
    _mutant("slow-40ms", "its timers 40 ms late", [f"{R}TI_01", f"{S}TI_01"], lambda: Late(RHO3, LOW, late=ms(40))),
    _mutant("connect-attempts-2", "2 connection attempts", [f"{S}BI_01"], _profile(connect_attempts=2)),
    _mutant("connect-attempts-7", "7 connection attempts", [f"{S}BI_01"], _profile(connect_attempts=7)),
    _mutant("block-attempts-2", "2 block attempts", [f"{S}BI_09"], _profile(block_attempts=2)),
    _mutant("block-attempts-7", "one block attempt too many", [f"{S}BI_09"], _with(sender=CountsOneMore)),
    _mutant("qvz-300", "QVZ 300 ms", [f"{S}TI_01", f"{S}TI_02"], _profile(ack_delay=ms(300))),
    _mutant("qvz-800", "QVZ 800 ms", [f"{S}TI_01"], _profile(ack_delay=ms(800))),
    _mutant("zvz-100", "ZVZ 100 ms", [f"{R}TI_01"], _profile(char_delay=ms(100))),
    _mutant("zvz-400", "ZVZ 400 ms", [f"{R}TI_01"], _profile(char_delay=ms(400))),
    _mutant("no-nak-at-the-end", "gives up without NAK", [f"{S}BI_01"], _profile(nak_when_giving_up=False)),
    _mutant("pause-before-repeat", "waits 1 s before a repeat", [f"{S}BI_06"], _profile(retry_pause=ms(1000))),
    _mutant("no-wait-for-buffer", "NAK at once without a buffer", [f"{R}BO_06"], _profile(no_buffer_wait=0)),
    _mutant("long-wait-for-buffer", "NAK after 1 s without a buffer", [f"{R}BO_06"], _profile(no_buffer_wait=ms(1000))),
    _mutant("short-buffer", "blocks of 64 characters at most", [f"{R}BV_16"], _profile(max_received=64)),
    _mutant("limit-137", "one character less than its profile", [f"{R}BV_17"], _profile(max_received=137)),
    _mutant(
        "yields",
        "gives way in a repeat in spite of priority",
        [f"{C}BV_03"],
        lambda: Built(replace(RHO3, yields_to_second_conflict=True), HIGH),
        HIGH,
    ),
    _mutant("drops-dle", "leaves out a DLE that is not doubled", [f"{R}BI_06"], _profile(broken_pair=BrokenPair.DROP_DLE)),
    _mutant("counts-once", "a doubled DLE enters the check once", [f"{R}BV_03"], lambda: OwnCheck(RHO3, LOW, "rk512", counts_once)),
    _mutant("includes-stx", "begins the check with STX", [f"{R}BV_02"], lambda: OwnCheck(RHO3, LOW, "rk512", includes_stx)),
    _mutant("complement", "complements the check", [f"{R}BV_02"], lambda: OwnCheck(RHO3, LOW, "rk512", _complement)),
    _mutant("never-doubles", "sends a DLE of its data once", [f"{S}BV_02"], lambda: _Never(RHO3, LOW)),
    _mutant("any-check", "does not look at the check", [f"{R}BI_01"], _with(AnyCheck)),
    _mutant("top-bit-of-check", "does not look at bit 7 of the check", [f"{R}BI_01"], _with(TopBitOfCheck)),
    _mutant("zero-is-good", "a check of 00h is good", [f"{R}BI_03"], _with(ZeroIsGood)),
    _mutant("complement-is-good", "the complement is good as well", [f"{R}BI_03"], _with(OrComplement)),
    _mutant("once-is-good", "a check that counts DLE once is good as well", [f"{R}BI_02"], _with(OnceToo)),
    _mutant("check-10h", "refuses a check of 10h", [f"{R}BV_04"], _with(CheckOfDle)),
    _mutant("check-15h", "refuses a check of 15h", [f"{R}BV_05"], _with(CheckOfNak)),
    _mutant("stx-restarts", "02h in the data begins the block anew", [f"{R}BV_10"], _with(Restarts)),
    _mutant("nak-ends", "15h in the data ends the block", [f"{R}BV_11"], _with(NakEnds)),
    _mutant("seven-bits", "hears seven bits", [f"{R}BV_19"], lambda: Built(hears=_seven_bits)),
    _mutant("no-zvz", "waits for characters for ever", [f"{R}TI_01"], _with(NoTimer)),
    _mutant("zvz-of-block", "ZVZ runs once for the block", [f"{R}TI_05"], _with(TimerOfBlock)),
    _mutant("no-zvz-before-check", "ZVZ does not run before the check", [f"{R}TI_03"], _with(NoTimerBeforeCheck)),
    _mutant("no-zvz-in-pair", "ZVZ does not run behind a DLE", [f"{R}TI_04"], _with(NoTimerInPair)),
    _mutant("silent-gap", "leaves a broken block without NAK", [f"{R}TI_01"], _with(SilentGap)),
    _mutant("locks", "deaf after five refused blocks", [f"{R}BI_01", f"{R}BI_04", f"{R}RC_01"], _with(Locks)),
    _mutant("garbage-kills", "deaf after twenty stray characters", [f"{R}RC_03"], _with(GarbageKills)),
    _mutant("tail-opens", "02h in the rest of a refused block opens one", [f"{R}BI_07"], _with(TailOpens)),
    _mutant("empty-hangs", "an empty block makes it deaf", [f"{R}CA_02"], _with(EmptyHangs)),
    _mutant("every-25th", "refuses every 25th good block", [f"{R}ST_01"], _with(EveryTenth)),
    _mutant("dle-in-idle", "answers DLE in idle with DLE", [f"{R}BO_04"], _with(DleInIdle)),
    _mutant("stray-opens", "any character in idle opens a block", [f"{R}BO_01"], _with(StrayOpens)),
    _mutant("answers-nak", "answers NAK in idle", [f"{R}BO_02"], _with(AnswersNak)),
    _mutant("break-hangs", "deaf after BREAK", [f"{R}BO_03", f"{R}BI_10"], BreakHangs),
    _mutant(
        "ignores-parity",
        "takes a damaged character for a good one",
        [f"{R}BI_08"],
        lambda: DeafToDamage(receiver=AnyCheckAfterDamage),
    ),
    _mutant("any-is-dle", "any answer to STX lets it send", [f"{S}BI_02", f"{S}BI_03"], _with(sender=AnyIsDle)),
    _mutant("any-acknowledges", "any character acknowledges its block", [f"{S}BI_06"], _with(sender=AnyAcknowledges)),
    _mutant("nak-acknowledges", "NAK acknowledges its block", [f"{S}BI_06"], _with(sender=NakAcknowledges)),
    _mutant("silence-acknowledges", "silence acknowledges its block", [f"{S}TI_03"], _with(sender=SilenceAcknowledges)),
    _mutant("no-repeat", "a refused block is not repeated", [f"{S}BI_06", f"{S}TI_03"], _with(sender=GivesUpAtOnce)),
    _mutant("sends-twice", "sends an acknowledged block again", [f"{S}BV_03"], _with(sender=SendsTwice)),
    _mutant("repeat-differs", "the repeat carries other data", [f"{S}BI_06", f"{S}TI_03"], _with(sender=Differs)),
    _mutant("deaf-in-block", "NAK inside its block is not heard", [f"{S}BI_05"], _with(sender=DeafInBlock)),
    _mutant("late-dle", "a DLE after it gave up brings the block", [f"{S}BO_02"], lambda: LateDle(sender=LateDleOpens)),
    _mutant("loses-next", "the job after a failed one is lost", [f"{S}RC_01"], _with(sender=LosesNext)),
    _mutant("without-stx", "repeats a refused block without STX", [f"{S}BI_06", f"{S}TI_03"], _with(sender=WithoutStx)),
    _mutant("naks-conflicts", "answers a conflicting STX with NAK", [f"{C}BV_01"], lambda: NaksConflicts(RHO3, LOW)),
    _mutant("wrong-priority", "behaves with priority, is set without", [f"{C}BV_01"], lambda: Built(RHO3, HIGH), LOW),
    _mutant("wrong-priority-2", "behaves without priority, is set with it", [f"{C}BV_01"], lambda: Built(RHO3, LOW), HIGH),
    _mutant("no-yield", "does not give way in a repeat", [f"{C}BV_03"], _with(sender=NoYield)),
    _mutant("drops-in-conflict", "the job that gave way is lost", [f"{C}BV_02"], _with(sender=DropsInConflict)),
    _mutant("resets-on-conflict", "forgets the line in a conflict", [f"{C}BV_01", f"{C}BV_02"], ResetsOnConflict),
    _mutant("own-check-wrong", "its own check is wrong", [f"{S}BV_02"], lambda: Built(says=_wrong_own_check)),
    _mutant("check-without-end", "its check leaves out DLE ETX", [f"{S}BV_02"], lambda: Built(says=_check_without_end)),
    _mutant("no-check", "sends no check", [f"{S}BV_02"], lambda: Built(says=_no_check)),
    _mutant("no-end", "its block does not end", [f"{S}BV_01"], lambda: Built(says=_no_end)),
    _mutant(
        "dead-after-power", "does not work after a power failure", ["3964R_SUP_RC_01"], lambda: Powered(lambda: Built(RHO3, LOW), False)
    ),
    _mutant("every-second-stx", "answers one STX of two", [f"{R}BV_01"], lambda: EverySecondStx(RHO3, LOW)),
    _mutant("nak-opens", "answers NAK in idle with STX, and sends nothing", [f"{R}BO_02"], lambda: NakOpens(RHO3, LOW)),
    _mutant("deaf-after-nak", "deaf for 1 s after NAK", ["3964R_SEQ_RC_01"], lambda: DeafAfter(BlockRefused, ms(1000))),
    _mutant("deaf-after-own", "deaf for 100 ms after its own block", ["3964R_SEQ_BO_01"], lambda: DeafAfter(BlockSent, ms(100))),
    _mutant("nak-twice", "refuses with two NAK", ["3964R_SEQ_BI_01"], NakTwice),
    _mutant("wedges", "sends no more after many jobs in a row", ["3964R_SND_ST_01"], WedgesInARow),
    _mutant("flips-priority", "a conflict changes its priority", [f"{C}ST_01", f"{C}BV_03"], lambda: FlipsPriority(RHO3, LOW)),
    _mutant("extra-character", "a carriage return behind its block", [f"{S}BV_02"], lambda: Built(says=_extra)),
)


class AnyCheckAfterDamage(Receiver):
    """The adapter passes a damaged character on as good, and the block check is ignored."""

    def _judge(self, check: int) -> None:
        super()._judge(self._check if b"U" in self._data[1:] else check)


def _variant(
    name: str, what: str, profile: Profile = RHO3, priority: Priority = LOW, make: Maker | None = None, touch: bool = True, **pics: object
) -> Variant:
    return Variant(name, what, make or (lambda: Built(profile, priority)), link_of(profile, priority), dict(pics), touch)


VARIANTS = (
    _variant("low", "rho 3 without priority"),
    _variant("high", "rho 3 with priority", priority=HIGH),
    _variant("siemens", "CP 341: NAK to stray characters, NAK at start", SIEMENS_CP341),
    _variant("vipa", "CP 240: three connection attempts, no wait for a buffer", VIPA_CP240, HIGH),
    _variant("linux", "Linux line discipline: one counter, backs off", LINUX, HIGH),
    _variant("wago", "gives up after one silence", WAGO),
    _variant("plain", "3964 without block check", RHO3.plain()),
    _variant("slow", "answers with DLE after 120 ms", make=AnswersLate),
    _variant("chatty", "sends every 2 s", make=Chatty),
    _variant("chatty-high", "sends every 2 s, with priority", priority=HIGH, make=lambda: Chatty(RHO3, HIGH)),
    _variant("raw", "raw blocks, no RK512", make=lambda: Built(layer="raw")),
    _variant("powered", "its supply can be switched", make=lambda: Powered(lambda: Built(RHO3, LOW))),
    _variant("read-only", "nothing may be written", touch=False),
    _variant("long-blocks", "takes 1024 characters", make=lambda: Built(replace(RHO3, max_received=1024))),
)
