"""An active RK512 station on a wire for send and fetch: one command, its reaction, reported in words when it fails.

The link is the product's own (protocols.p3964r.link).  Faults carry both vocabularies: QVZ/ADT, ZVZ/CDT, BWZ.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from gateway.conformance.serial.cases_rk512 import FETCH, SEND, TYPE_DB, header, words_of
from gateway.links.serial.tool_wire import Wire
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.events import BlockReceived, BlockRefused, BlockSent, Failure, SamePriority, SendFailed, SendRepeated, Stage
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import Priority, Profile

MOST_BYTES = 128  # in one telegram
TELEGRAM_WORDS = 64
SHORT = 32  # characters every station takes
FAILED = {
    (Stage.CONNECT, Failure.SILENT): "no answer to STX within QVZ/ADT {qvz:.0f} ms, {tries}: partner off, cable, wires or speed wrong",
    (Stage.CONNECT, Failure.NAK): "every STX was answered with NAK ({tries}): the partner is not ready, its buffer is full",
    (Stage.CONNECT, Failure.WRONG): "STX was answered with another character ({tries}): wrong speed or parity, echo, or no 3964R",
    (Stage.CONNECT, Failure.DAMAGED): "the answers to STX came damaged ({tries}): wrong speed or parity",
    (Stage.CONNECT, Failure.CONFLICT): "both sent STX again and again: do both stations have the same priority?",
    (Stage.BLOCK, Failure.SILENT): "no answer to the block within QVZ/ADT {qvz:.0f} ms",
    (
        Stage.BLOCK,
        Failure.NAK,
    ): "the block was refused (NAK): block check, parity, ZVZ/CDT {zvz:.0f} ms, or 3964 instead of 3964R at the partner{size}",
}


class Refused(Exception):
    """The job failed; the text gives the reason in words."""


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
    _told: list[object] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.link = Link(self.profile, self.priority)

    def send(self, db: int, word: int, data: bytes) -> int:
        """SEND; how many telegrams it took.  Refused gives the reason."""
        if len(data) % 2:
            raise ValueError(f"data of {len(data)} bytes: data words have two each")
        telegrams = 0
        for at in range(0, len(data), MOST_BYTES):
            piece = data[at : at + MOST_BYTES]
            reaction = self.ask(header(SEND, TYPE_DB, db, word + at // 2, len(piece) // 2) + piece)
            if len(reaction) > 4:
                raise Refused(f"the reaction to SEND brought {len(reaction) - 4} data bytes, none expected")
            telegrams += 1
        return telegrams

    def fetch(self, db: int, word: int, words: int) -> bytes:
        """FETCH; 2 x words bytes.  Refused gives the reason."""
        data = b""
        while len(data) < 2 * words:
            here = min(TELEGRAM_WORDS, words - len(data) // 2)
            reaction = self.ask(header(FETCH, TYPE_DB, db, word + len(data) // 2, here))
            if len(reaction) != 4 + 2 * here:
                raise Refused(f"the reaction to FETCH of {here} words brought {len(reaction) - 4} bytes, expected {2 * here}")
            data += reaction[4:]
        return data

    def ask(self, telegram: bytes) -> bytes:
        """One command telegram; the reaction to it, without error number."""
        job = self.link.send(telegram, self.wire.now())
        self.traffic.append(Traffic(True, telegram, self.wire.now()))
        self._run(lambda: any(isinstance(event, BlockSent | SendFailed) and event.job == job for event in self._told), None)
        failed = next((event for event in self._told if isinstance(event, SendFailed)), None)
        if failed is not None:
            raise Refused(self._why(failed))
        if not self._run(lambda: bool(self._blocks), self.wire.now() + self.reaction_wait):
            raise Refused(f"no reaction telegram within {self.reaction_wait / 1e9:.0f} s: does the partner speak RK512 (not raw 3964R)?")
        reaction = self._blocks.pop(0)
        self.traffic.append(Traffic(False, reaction, self.wire.now()))
        if len(reaction) < 4 or reaction[0] not in (0x00, 0xFF) or reaction[1:3] != b"\x00\x00":
            raise Refused(f"no reaction telegram: {reaction[:16].hex(' ')}")
        if reaction[3]:
            raise Refused(f"the partner refuses: {reaction[3]:02X}h, {words_of(reaction[3])}")
        return reaction

    def listen(self, how_long: Ns) -> list[bytes]:
        """Takes what the partner sends by itself."""
        self._run(lambda: False, self.wire.now() + how_long)
        blocks, self._blocks = self._blocks, []
        return blocks

    def _why(self, failed: SendFailed) -> str:
        repeats = [event for event in self._told if isinstance(event, SendRepeated)]
        reason = failed.stage, failed.why
        if failed.why is Failure.NAK and any((event.stage, event.why) == (Stage.BLOCK, Failure.NAK) for event in repeats):
            reason = Stage.BLOCK, Failure.NAK  # it was ready at first; a NAK late in a long block answers the next STX
        text = FAILED.get(reason, f"not sent: {failed.stage.name.lower()}, {failed.why.name.lower()}")
        if any(isinstance(event, SamePriority) for event in self._told):
            text = f"both stations have the same priority ({self.priority.name.lower()}): set one to high, the other to low"
        tries = f"{len(repeats) + 1} attempts" if repeats else "1 attempt"
        length = len(self.traffic[-1].data)
        size = f"; or its {length} characters are more than the partner takes" if length > SHORT else ""
        return text.format(qvz=self.profile.ack_delay / 1e6, zvz=self.profile.char_delay / 1e6, tries=tries, size=size)

    # ---- the loop
    def _run(self, done: Callable[[], bool], until: Ns | None) -> bool:
        if until is None:
            self._told.clear()
        self._flush()
        while not done():
            now = self.wire.now()
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

    def _sent_due(self) -> Ns | None:
        return self.wire.drained() if self._sent_owed else None

    def _flush(self) -> None:
        output = self.link.take_output()
        if output:
            self.wire.write(output)
            self._sent_owed = True

    def _handle(self, events: Sequence[object], now: Ns) -> None:
        for event in events:
            self._told.append(event)
            self.on_event(event)
            if isinstance(event, BlockReceived):
                self._blocks.append(event.data)
            elif isinstance(event, BlockRefused) and len(self._told) > 10_000:
                del self._told[:5_000]
