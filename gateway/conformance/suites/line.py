"""The tester's side of a 3964R line: sends, expects, measures; unsolicited blocks of the station are served and noted."""

import contextlib
import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from gateway.conformance.framework.base import TOLERANCE, Seen, Tester, hexed
from gateway.conformance.framework.causes import PREPARING
from gateway.conformance.framework.host import Host
from gateway.links.serial.tool_wire import Wire
from gateway.pure.conformance.verdict import Disturbed, Ended, Fail, Inconclusive, NotApplicable
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char, wire_block
from protocols.p3964r.profiles import Priority, Profile

NAMES = {2: "STX (02h)", 3: "ETX (03h)", 16: "DLE (10h)", 21: "NAK (15h)", 23: "ETB (17h)"}
STX, DLE, NAK = (bytes((char,)) for char in (Char.STX, Char.DLE, Char.NAK))
QUIET = ms(300)
MOST_REST = 8  # characters after a block
MOST_JOBS = 8  # of the station may wait for their answers
TRIES = 12  # connection attempts of the station that may pass first
MOST_BLOCK = 4200  # characters; more are not a block
JOB_WAIT = ms(20_500)  # a station may wait 20 s for a reaction before its next job
BETWEEN = ms(60)  # between an answer and a STX that belongs to something else


def named(what: int | Damage | None) -> str:
    """A character in hex and words."""
    if what is None:
        return "nothing"
    if isinstance(what, Damage):
        return "BREAK" if what is Damage.BREAK else "a damaged character"
    return NAMES.get(what, f"{what:02X}h")


@dataclass(slots=True)
class LineSetup:
    """Known facts about the station and the bench."""

    profile: Profile
    priority: Priority | None  # of the station; None: not known
    stimulus: Callable[["LineTester"], None] | None = None
    stimulus_name: str = ""
    stimulus_wait: Ns = ms(5000)
    hold: Callable[[bool], None] | None = None
    power: Callable[[bool], None] | None = None
    pics: Mapping[str, object] = field(default_factory=dict)
    write: tuple[int, ...] = ()  # data blocks that may be written
    known: Mapping[str, bytes] = field(default_factory=dict)
    reaction_wait: Ns = ms(5000)
    missing: int = 99
    db: int = 10
    words: int = 128
    job: int = 64  # words the station serves in one job
    size: int | None = None  # of the block that is read, where it was found out
    seed: int = 1
    form_fault: str = ""  # the case that found blocks of reactions in a wrong form
    misleading: dict[int, str] = field(default_factory=dict)  # error numbers, and the case that found each


@dataclass(frozen=True, slots=True)
class Block:
    """A block of the station: its data, and the fault of its form ("": none)."""

    data: bytes
    fault: str = ""
    raw: bytes = b""


class LineTester(Tester):
    """One station at one wire."""

    def __init__(self, wire: Wire, setup: LineSetup, host: Host | None = None) -> None:
        super().__init__()
        self.wire, self.setup, self._host = wire, setup, host or Host()
        self.mark: Ns = 0  # end of the last character sent or received
        self.clock = "virtual" if wire.simulated else "monotonic clock of this host, at the port"
        self.slowest: Ns = 0  # its longest DLE after STX so far
        self.judges_form = False  # of the blocks of reactions: not during discovery
        self.on_block: Callable[[bytes], None] | None = None  # handler of an unexpected block
        self.unanswered = b""  # the station's last block, until a telegram of ours follows it
        self.on_unanswered: Callable[[bytes], bool] | None = None  # sends what the station waits for before its next job, if it can
        self.sends_last = ""  # the case in which a stimulus last brought a STX
        self._answering = False
        self._judges_stx = False

    @property
    def profile(self) -> Profile:
        return self.setup.profile

    @property
    def tolerance(self) -> Ns:
        return self.wire.char_ns + TOLERANCE

    @property
    def conflict_wait(self) -> Ns:
        """How long a station that yields may take to answer STX; one with priority must still be waiting for DLE then."""
        usual = min(self.profile.ack_delay // 2, ms(200))
        return max(usual, min(self.slowest * 3 // 2 + self.tolerance, self.profile.ack_delay * 8 // 10))

    def late(self) -> Ns:
        return self._host.late(self.wire)

    def uncertainty(self) -> Ns:
        return 0 if self.wire.simulated else self.wire.char_ns + self.late()

    def doubt(self, took: Ns) -> tuple[Ns, Ns]:
        """Uncertainty of this one time, not of the complete case."""
        if self.wire.simulated:
            return 0, 0
        since = self.mark - took
        return self.wire.char_ns + self._host.ends(self.wire, since), self.wire.char_ns + self._host.within(self.wire, since)

    def _left_open(self, since: Ns) -> Ns:
        """Share of a wait since then that remains for a device delayed by this host."""
        return 0 if self.wire.simulated else self.wire.char_ns + self._host.within(self.wire, since)

    def begin(self) -> None:
        """A case starts now."""
        self.wire.late_ns = 0
        self.mark = self.wire.now()

    # ---- saying
    def say(self, data: bytes) -> None:
        self._host.sample(self.wire)
        self.wire.write(data)
        self.mark = self.wire.drained()
        self.notes.trace.append(Seen(self.mark, "tester", data))

    def spoil(self, kind: Damage = Damage.PARITY) -> None:
        """One damaged character; N/A where the port cannot."""
        while self._hear(self.wire.drained()) is not None:
            pass
        if not (self.wire.send_break() if kind is Damage.BREAK else self.wire.spoil()):
            raise NotApplicable(f"{self.wire.name} cannot send {'BREAK' if kind is Damage.BREAK else 'a character with wrong parity'}")
        self.mark = self.wire.drained()
        self.notes.trace.append(Seen(self.mark, "tester", b"", named(kind)))

    # ---- hearing
    def _hear(self, until: Ns) -> int | Damage | None:
        heard = self.wire.hear(until)
        self._host.sample(self.wire)
        if heard is None:
            return None
        self.mark = heard.stamp
        what = heard.what
        self.notes.trace.append(
            Seen(heard.stamp, "device", b"", named(what)) if isinstance(what, Damage) else Seen(heard.stamp, "device", bytes((what,)))
        )
        return what

    def char(self, until: Ns) -> int | Damage | None:
        """The next character, at the latest at that moment."""
        return self._hear(until)

    def answer(self, within: Ns) -> int | Damage | None:
        """The next character, within this time after the last one on the line; None: silence."""
        return self._hear(self.mark + within)

    def awaited(self, within: Ns) -> int | Damage | None:
        """The next character, due by then.  A wait in which this host was delayed is extended by as much: until its complete interval is
        over there is no verdict on the station, which may be on this host as well.
        """
        start = self.mark
        while (got := self._hear(start + within + self._left_open(start))) is None:
            if self.wire.now() >= start + within + self._left_open(start):
                return None
        return got

    def fail(self, after: str, got: int | Damage | None, expected: str) -> None:
        raise Fail(f"after {after}: {named(got)}, expected {expected}", expected, named(got))

    def expect(self, char: int, within: Ns, after: str) -> Ns:
        """That character is next; how long it took since the last one on the line."""
        start = self.mark
        got = self.awaited(within + self.tolerance)
        if got != char:
            self.fail(after, got, f"{named(char)} within {within / 1e6:.0f} ms")
        return self.mark - start

    def expect_at(self, char: int, due: Ns, after: str) -> None:
        """That character comes `due` after the last one on the line, not before and not later."""
        start = self.mark
        got = self.answer(2 * due + ms(500))
        if got != char:
            self.fail(after, got, f"{named(char)} after {due / 1e6:.0f} ms")
        self.timed(f"{named(char)} after {after}", self.mark - start, due - self.tolerance, due + self.tolerance)

    def silence(self, how_long: Ns, after: str, idle: bool = True) -> None:
        """No character for so long; in idle the station's own jobs are served and noted."""
        end = self.mark + how_long
        while True:
            got = self._hear(end)
            if got is None:
                return
            if got != Char.STX or not idle:
                self.fail(after, got, f"silence for {how_long / 1e6:.0f} ms")
            if self.serve() is None:
                self.fail(after, got, f"silence for {how_long / 1e6:.0f} ms, or a whole block: no block follows its STX")
            end = max(end, self.mark + self.tolerance)

    # ---- the station's own traffic
    def serve(self) -> bytes | None:
        """Its STX was received: accept the block as a good partner; return the data."""
        self.notes.unasked += 1
        self.say(DLE)
        block = self.read()
        if block is None:
            return None
        self._pass_over_rest()
        self.say(DLE)
        if self.on_block is not None:
            self.on_block(block.data)
        return block.data

    def _pass_over_rest(self) -> None:
        """Read what follows its block: it is judged with the block (SND_BV_02), not where the next STX goes out."""
        for _ in range(MOST_REST):
            if self.answer(self.wire.char_ns + ms(1)) is None:
                return
        self.remark("characters after its block")

    def answers_jobs(self) -> bool:
        """The station's own jobs, each of which may come only after the answer to the one before; whether there was one."""
        if self.on_unanswered is None or self._answering or not self.unanswered:
            return False
        self._answering = True
        answered = 0
        try:
            while self.unanswered and answered < MOST_JOBS:
                job, self.unanswered = self.unanswered, b""
                if not self.on_unanswered(job):
                    break
                answered += 1
        except Ended:  # a case of its own judges the station's handling of the answer
            pass
        finally:
            self._answering = False
        return answered > 0

    def read(self) -> Block | None:
        """The characters of a block after our DLE, to its end and with its check; None: it broke off."""
        raw, data, escaped, odd = bytearray(), bytearray(), False, ""
        while len(raw) < MOST_BLOCK:
            got = self.awaited(self.profile.char_delay + self.tolerance)
            if not isinstance(got, int):
                return None
            raw.append(got)
            if escaped and got in (Char.ETX, Char.ETB):
                block = self._checked(raw, data, odd)
                self.unanswered = b"" if block is None else block.data
                return block
            if escaped and got != Char.DLE:
                odd = odd or f"DLE is followed by {named(got)}: it is doubled, or ETX follows"
                data += bytes((Char.DLE, got))
            elif escaped or got != Char.DLE:
                data.append(got)
            escaped = got == Char.DLE and not escaped
        return None

    def _checked(self, raw: bytearray, data: bytearray, odd: str) -> Block | None:
        if not self.profile.block_check:
            return Block(bytes(data), odd, bytes(raw))
        right = 0
        for byte in raw:
            right ^= byte
        got = self.awaited(self.profile.char_delay + self.tolerance)
        if not isinstance(got, int):
            return Block(bytes(data), odd or f"no block check, {right:02X}h expected", bytes(raw))
        raw.append(got)
        if got != right:
            why = "; off by 02h: it includes STX" if got ^ right == 2 else ""
            if got ^ right == 0x10 and data.count(Char.DLE) % 2:
                why = "; it counts a doubled DLE once"
            odd = odd or f"block check {got:02X}h, {right:02X}h expected{why}"
        return Block(bytes(data), odd, bytes(raw))

    def settle(self, quiet: Ns | None = None) -> None:
        """Accept what the station still has to send until it is quiet; INCONC if it never is."""
        wait = self.profile.char_delay + QUIET if quiet is None else quiet
        self.mark = max(self.mark, self.wire.now())
        blocks, characters = 0, 0
        while (got := self.answer(wait)) is not None:
            characters += 1
            if characters > 2000 or blocks > 120:
                raise Inconclusive("the station does not fall silent", "silence", named(got))
            if got == Char.STX:
                blocks += 1
                wait = min(wait, BETWEEN) if blocks > 3 else wait
                self.serve()
                self.answers_jobs()

    # ---- larger pieces
    def connect(self) -> None:
        """STX and the station's DLE, as the beginning of something else."""
        with self.given():
            self.open()

    def open(self) -> int:
        """STX and the station's DLE, the NAKs before it; its own send requests are served first if they collide."""
        while self._hear(self.wire.now()) is not None:
            if self.notes.trace[-1].data == STX:
                self.serve()
                self.answers_jobs()
        refused = 0
        for _ in range(TRIES):
            self.say(STX)
            start = self.mark
            got = self.awaited(self.profile.ack_delay + self.tolerance)
            if got == Char.STX:
                got = self.answer(max(ms(100), self.conflict_wait if self.slowest > ms(60) else 0))
                if got == Char.DLE:
                    return refused
                if got is None:
                    self.serve()
                    self.answers_jobs()
                    continue
            if got == Char.DLE:
                self.slowest = max(self.slowest, self.mark - start)
                self.timed("DLE after STX", self.mark - start, None, self.profile.ack_delay + self.tolerance)
                return refused
            if got != Char.NAK or refused > 2:
                self.fail("STX", got, f"{named(Char.DLE)} within {self.profile.ack_delay / 1e6:.0f} ms")
            refused += 1  # no buffer: it may have been busy with the block before
            self._let_go(self.mark + ms(500))
        raise Disturbed("the station sends without a pause", "DLE (10h)", "STX (02h)")

    def _let_go(self, until: Ns) -> None:
        """Serve what it sends until then; the form is not judged here."""
        while (got := self._hear(until)) is not None:
            if got == Char.STX:
                self.serve()

    @contextlib.contextmanager
    def each_stx(self) -> Iterator[None]:
        """Within the block the answer to STX is judged with each block: in a long run no other case finds a missing one."""
        self._judges_stx = True
        try:
            yield
        finally:
            self._judges_stx = False

    def block(self, wire: bytes, what: str) -> int | Damage | None:
        """Connects and sends these characters after the DLE; returns the answer."""
        if self._judges_stx:
            self.open()
        else:
            self.connect()
        self.say(wire)
        start = self.mark
        got = self.awaited(self.profile.ack_delay + self.tolerance)
        if got is not None:
            self.timed(f"answer to {what}", self.mark - start, None, None)
        if got == Char.DLE and self.wire.simulated and self.mark < start:  # a real port reports when it read, not when it came
            raise Fail(f"{what} is acknowledged before its end", "DLE (10h) after the last character", "DLE (10h) inside the block")
        return got

    def good(self, data: bytes, what: str = "a good block") -> None:
        """Send a complete good block, which must be acknowledged."""
        got = self.block(wire_block(data, self.profile.block_check), what)
        if got != Char.DLE:
            self.fail(what, got, named(Char.DLE))
        self.unanswered = b""

    def good_once(self, data: bytes, what: str) -> None:
        """A good block with one answer: a station that took a character inside for the end, or for a request, answers that as well."""
        self.good(data, what)
        got = self.answer(6 * self.wire.char_ns + ms(5))
        if got == Char.STX:
            self.serve()
        elif got is not None:
            self.fail(f"DLE to {what}", got, "nothing")

    def refused(self, wire: bytes, what: str) -> None:
        """Characters after the DLE that must be answered with NAK."""
        got = self.block(wire, what)
        if got != Char.NAK:
            self.fail(what, got, named(Char.NAK))

    @property
    def harmless(self) -> bytes:
        """A block that triggers no block in return: for RK512 an unsolicited reaction telegram."""
        return bytes(4) if self.setup.pics.get("rk512") else b"UC"

    def starts_sending(self) -> None:
        """Make the station send; wait for its STX.  FAIL once if it sent before and does not any more."""
        if (stimulus := self.setup.stimulus) is None:
            raise NotApplicable("the bench names no [stimulus] and the station has none of its own")
        with self.given():
            if self.answers_jobs():
                self.settle(BETWEEN)
            stimulus(self)
        try:
            with self.given():
                self.first_stx(self.setup.stimulus_wait)
        except Inconclusive as ended:
            before, self.sends_last = self.sends_last, ""
            if not before or self.setup.stimulus_name in ("fetch", "operator") or ended.got != named(None):
                raise
            stimulus(self)
            if self.answer(JOB_WAIT) != Char.STX:
                raise Fail(f"it sends no job any more; it sent the last one in {before}", ended.expected, "nothing") from ended
        self.sends_last = self.case

    def first_stx(self, within: Ns) -> None:
        """Its STX; a NAK before it (it became ready) is passed over."""
        got = self.answer(within)
        for _ in range(TRIES):
            if got != Char.NAK:
                break
            got = self.answer(within)
        if got != Char.STX:
            self.fail(f"the stimulus ({self.setup.stimulus_name})", got, f"{named(Char.STX)} within {within / 1e9:.0f} s")

    def take(self, acknowledge: bool = True) -> Block:
        """The rest of the station's block after its STX."""
        with self.given():
            self.say(DLE)
            block = self.read()
            if block is None:
                raise Fail("the station's block breaks off", "a whole block", self.last(24))
        if acknowledge:
            self.say(DLE)
        return block

    def last(self, count: int) -> str:
        """The last characters of the station, for `got`."""
        heard = list(itertools.chain.from_iterable(piece.data for piece in self.notes.trace[-4 * count :] if piece.side == "device"))
        return hexed(bytes(heard[-count:]), count)

    def alive(self) -> None:
        """The suite's postamble: the station is idle and accepts a good block."""
        try:
            self.settle()
            self.good(self.harmless, "a good block after the case")
        except Inconclusive as ended:
            if isinstance(ended, Disturbed):
                raise
            raise Fail(
                f"left the station unusable: {ended.reason.removeprefix(PREPARING)}", ended.expected or "DLE (10h)", ended.got
            ) from ended
        except Fail as failed:
            raise Fail(f"left the station unusable: {failed.reason}", failed.expected, failed.got) from failed
