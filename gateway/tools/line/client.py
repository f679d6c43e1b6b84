"""An active RK512 station on a wire for send and fetch: one command, its reaction, reported in words when it fails.

The link is the product's own (protocols.p3964r.link).  Faults carry both vocabularies: QVZ/ADT, ZVZ/CDT, BWZ.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from gateway.conformance.serial.cases_rk512 import FETCH, SEND, TYPE_DB, header, words_of
from gateway.links.serial.tool_wire import Wire
from gateway.pure.lines.texts import Text, said
from gateway.tools.line.transfer import TELEGRAM_WORDS
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.events import BlockReceived, BlockRefused, BlockSent, Failure, Refusal, SamePriority, SendFailed, SendRepeated, Stage
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import Priority, Profile
from protocols.rk512.header import FIRST, FOLLOW_ON, is_reaction

MOST_BYTES = 128  # in one telegram
SHORT = 32  # characters every station accepts
MOST_CONFLICTS = 16  # blocks a partner may send before our job: then it leaves no room for it
NO_ANSWER = "no answer to STX within QVZ/ADT {:.0f} ms"
UNANSWERED = "no answer to the block within QVZ/ADT {:.0f} ms"
SEEN = {  # result of one attempt; the first value is QVZ in ms
    (Stage.CONNECT, Failure.SILENT): NO_ANSWER,
    (Stage.CONNECT, Failure.NAK): "NAK to STX",
    (Stage.CONNECT, Failure.WRONG): "another character than DLE to STX",
    (Stage.CONNECT, Failure.DAMAGED): "a damaged answer to STX",
    (Stage.CONNECT, Failure.CONFLICT): "a conflict of both STX",
    (Stage.BLOCK, Failure.SILENT): UNANSWERED,
    (Stage.BLOCK, Failure.NAK): "the block refused (NAK)",
    (Stage.BLOCK, Failure.WRONG): "another character than DLE to the block",
    (Stage.BLOCK, Failure.DAMAGED): "a damaged answer to the block",
}
MEANS = {  # the attempts that ended so point at this
    (Stage.CONNECT, Failure.SILENT): "partner off, cable, wires or speed wrong",
    (Stage.CONNECT, Failure.NAK): "the partner is not ready, its buffer is full",
    (Stage.CONNECT, Failure.WRONG): "wrong speed or parity, echo, or no 3964R",
    (Stage.CONNECT, Failure.DAMAGED): "wrong speed or parity",
    (Stage.CONNECT, Failure.CONFLICT): "do both stations have the same priority?",
    (Stage.BLOCK, Failure.SILENT): "the partner is busy, or it expects 3964 without block check",
    (Stage.BLOCK, Failure.NAK): "block check, parity, ZVZ/CDT, or 3964 instead of 3964R at the partner",
}
NOT_TAKEN = {
    Refusal.GAP: "the character delay ZVZ/CDT was exceeded in it; or the partner sends no block check: 3964, not 3964R",
    Refusal.ORDER: "a DLE in it was not doubled",
    Refusal.LENGTH: "it was longer than the profile allows",
    Refusal.CHECK: "its block check was wrong; or the partner sends none: 3964, not 3964R",
    Refusal.DAMAGED: "it was received damaged: parity or speed",
    Refusal.BREAK: "a BREAK ended it",
}


class Refused(Exception):
    """The job failed; `text` names the reason."""

    def __init__(self, text: Text) -> None:
        super().__init__(str(text))
        self.text = text


@dataclass(slots=True)
class Traffic:
    """One telegram that went over the line."""

    ours: bool
    data: bytes
    ns: Ns


@dataclass(slots=True)
class Client:
    """Jobs one after another at one wire."""

    wire: Wire
    profile: Profile
    priority: Priority
    reaction_wait: Ns = ms(5000)
    on_event: Callable[[object], None] = lambda event: None
    traffic: list[Traffic] = field(default_factory=list)
    link: Link = field(init=False)
    _blocks: list[bytes] = field(default_factory=list)
    _events: list[object] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.link = Link(self.profile, self.priority)

    def send(self, db: int, word: int, data: bytes) -> int:
        """SEND; return the number of telegrams.  Refused names the reason."""
        if len(data) % 2:
            raise ValueError(f"data of {len(data)} bytes: data words have two each")
        telegrams = 0
        for at in range(0, len(data), MOST_BYTES):
            piece = data[at : at + MOST_BYTES]
            reaction = self.ask(header(SEND, TYPE_DB, db, word + at // 2, len(piece) // 2) + piece, 0)
            if len(reaction) > 4:
                raise Refused(said("the reaction to SEND brought {} data bytes, none expected", len(reaction) - 4))
            telegrams += 1
        return telegrams

    def fetch(self, db: int, word: int, words: int) -> bytes:
        """FETCH; return 2 x words bytes.  Refused names the reason."""
        data = b""
        while len(data) < 2 * words:
            here = min(TELEGRAM_WORDS, words - len(data) // 2)
            reaction = self.ask(header(FETCH, TYPE_DB, db, word + len(data) // 2, here), 2 * here)
            if len(reaction) != 4 + 2 * here:
                raise Refused(said("the reaction to FETCH of {} words brought {} bytes, expected {}", here, len(reaction) - 4, 2 * here))
            data += reaction[4:]
        return data

    def ask(self, telegram: bytes, size: int) -> bytes:
        """One command telegram; the reaction to it, without error number.  size: bytes it brings."""
        job = self._job = self.link.send(telegram, self.wire.now())
        self.traffic.append(Traffic(True, telegram, self.wire.now()))
        self._run(lambda: self._over(job) or self._crowded(), None)
        failed = next((event for event in self._events if isinstance(event, SendFailed)), None)
        if failed is not None:
            raise Refused(self._why(failed))
        if not self._over(job):
            raise Refused(said("the partner sent {} blocks of its own and left no room for our job: it has priority", MOST_CONFLICTS))
        self._run(lambda: bool(self._blocks), self.wire.now() + self.reaction_wait)
        if self._blocks and not self._fits(size):  # of a command before this tool was there, which its partner kept: ours follows
            self._run(lambda: self._fits(size), self.wire.now() + self.profile.ack_delay)
        reaction = self._blocks.pop() if self._blocks else None
        self._blocks.clear()
        if reaction is None:
            raise Refused(self._no_reaction())
        self.traffic.append(Traffic(False, reaction, self.wire.now()))
        if not is_reaction(reaction):
            raise Refused(said("no reaction telegram: {}", reaction[:16].hex(" ")))
        if reaction[3]:
            raise Refused(said("the partner refuses: {:02X}h, {}", reaction[3], words_of(reaction[3])))
        return reaction

    def _fits(self, size: int) -> bool:
        """Whether the last block may be the reaction to a command that requests so many bytes."""
        last = self._blocks[-1]
        return is_reaction(last) and (last[3] != 0 or len(last) == 4 + size)

    def _over(self, job: int) -> bool:
        return any(isinstance(event, BlockSent | SendFailed) and event.job == job for event in self._events)

    def _crowded(self) -> bool:
        return sum(isinstance(event, BlockReceived) for event in self._events) >= MOST_CONFLICTS

    def _no_reaction(self) -> Text:
        wait = self.reaction_wait / 1e9
        refused = [event.why for event in self._events if isinstance(event, BlockRefused)]
        known = next((NOT_TAKEN[why] for why in refused if why in NOT_TAKEN), None)
        if known is not None:
            return said("the reaction telegram could not be taken: {}", known)
        own = sum(not one.ours and _is_command(one.data) for one in self.traffic)
        if own:
            return said("no reaction telegram within {:.0f} s; the partner sent {} commands of its own instead", wait, own)
        return said("no reaction telegram within {:.0f} s: does the partner speak RK512 (not raw 3964R)?", wait)

    def listen(self, how_long: Ns) -> list[bytes]:
        """Receive what the partner sends on its own."""
        self._run(lambda: False, self.wire.now() + how_long)
        blocks, self._blocks = self._blocks, []
        return blocks

    def _why(self, failed: SendFailed) -> Text:
        if any(isinstance(event, SamePriority) for event in self._events):
            return said("both stations have the same priority ({}): set one to high, the other to low", self.priority.name.lower())
        seen = Counter((event.stage, event.why) for event in self._events if isinstance(event, SendRepeated | SendFailed))
        ways = [(said(SEEN.get(key, "something else"), self.profile.ack_delay / 1e6), count) for key, count in seen.items()]
        listed: str = said("{} ({})", ways[0][0], _attempts(ways[0][1]))
        for text, count in ways[1:]:
            listed = said("{}; {} ({})", listed, text, _attempts(count))
        reason = (Stage.BLOCK, Failure.NAK) if (Stage.BLOCK, Failure.NAK) in seen else (failed.stage, failed.why)
        if (Stage.CONNECT, Failure.SILENT) in seen and len(seen) > 1:
            means: str = "the partner answers later than our QVZ/ADT: choose its --profile, or one with a longer QVZ"
        else:  # it was ready at first where a block was refused; a NAK late in a long block answers the next STX
            means = MEANS.get(reason, "wrong speed or parity")
        length = len(self.traffic[-1].data)
        if reason == (Stage.BLOCK, Failure.NAK) and length > SHORT:
            means = said("{}; or its {} characters are more than the partner accepts", means, length)
        return said("{}: {}", listed, means)

    # ---- the loop
    def _run(self, done: Callable[[], bool], until: Ns | None) -> bool:
        if until is None:
            self._events.clear()
        self._flush()
        while not done():
            now = self.wire.now()
            if until is not None and self.link.receiving:
                until = max(until, now + self.profile.char_delay)  # the wait is for the beginning of the block
            moments = [moment for moment in (until, self.link.deadline(), self._sent_due()) if moment is not None]
            if until is not None and now >= until:
                return False
            heard = self.wire.hear(min(moments, default=now + ms(100)))
            now = self.wire.now()
            if self._sent_owed and now >= self.wire.drained():
                self._sent_owed = False
                self._handle(self.link.sent(now), now)
            if heard is not None:
                what = heard.what
                self._handle(self.link.damaged(what, now) if isinstance(what, Damage) else self.link.receive(bytes((what,)), now), now)
            due = self.link.deadline()
            if due is not None and now >= due:
                self._handle(self.link.wake(now), now)
            self._flush()
        return True

    _sent_owed: bool = False
    _job: int = 0

    def _sent_due(self) -> Ns | None:
        return self.wire.drained() if self._sent_owed else None

    def _flush(self) -> None:
        output = self.link.take_output()
        if output:
            self.wire.write(output)
            self._sent_owed = True

    def _handle(self, events: Sequence[object], now: Ns) -> None:
        for event in events:
            self._events.append(event)
            self.on_event(event)
            if isinstance(event, BlockReceived) and _is_command(event.data):
                self.traffic.append(Traffic(False, event.data, now))  # RK512 lets it send its own while we wait (serial-protocols 2.6)
            elif isinstance(event, BlockReceived):
                if not 0 < self.link.overtaken_by <= self._job:  # else its partner wished to send it before it had our command (AX-242)
                    self._blocks.append(event.data)
            elif isinstance(event, BlockSent):
                self._blocks.clear()  # blocks received before our command was accepted are not answers to it: a repeated reaction
            elif isinstance(event, BlockRefused) and len(self._events) > 10_000:
                del self._events[:5_000]


def _attempts(count: int) -> Text:
    return said("{} attempts", count) if count > 1 else said("1 attempt")


def _is_command(data: bytes) -> bool:
    return len(data) > 2 and data[0] in (FIRST, FOLLOW_ON) and data[2] in b"AEO"
