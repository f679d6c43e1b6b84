"""The tester's side of a probe: sends, expects, measures.  A deviation of the station ends the test by an exception: its verdict."""

from collections.abc import Callable
from dataclasses import dataclass, field

from gateway.links.serial.tool_wire import Heard, Wire
from gateway.pure.lines.texts import said
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char, wire_block
from protocols.p3964r.profiles import Priority, Profile

TOLERANCE = ms(20)  # and one character time (serial-protocols 6)
QUIET = ms(300)  # longer than the longest character delay
MOST_BLOCKS = 32  # of a partner before it is quiet
NAMES = {Char.STX: "STX", Char.DLE: "DLE", Char.NAK: "NAK", Char.ETX: "ETX", Char.ETB: "ETB"}


class Verdict(Exception):
    """Ends a test; the class is the verdict, the text its reason."""

    word = ""


class Fail(Verdict):
    word = "FAIL"


class Warn(Verdict):
    word = "WARN"


class Inconclusive(Verdict):
    word = "INCONCLUSIVE"


class NotRun(Verdict):
    word = "NOT RUN"


@dataclass(frozen=True, slots=True)
class Measured:
    """One time; expected None: only recorded."""

    what: str
    ns: Ns
    expected_ns: Ns | None
    tolerance_ns: Ns


@dataclass(slots=True)
class Notes:
    """Observations of one test."""

    times: list[Measured] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    wire: list[tuple[Ns, str, int | Damage]] = field(default_factory=list)  # moment, "us" or "station", character


def named(what: int | Damage | None) -> str:
    """A character in words."""
    if what is None:
        return "nothing"
    if isinstance(what, Damage):
        return "BREAK" if what is Damage.BREAK else "a damaged character"
    return NAMES.get(Char(what), "") if what in NAMES else f"{what:02X}h"


@dataclass(slots=True)
class Stimulus:
    """How the station is made to send.  `blocks`: an own block was used for that."""

    name: str
    trigger: Callable[["Bench"], None]
    timeout: Ns = ms(2000)


class Bench:
    """One station under test at one wire."""

    def __init__(
        self, wire: Wire, profile: Profile, priority: Priority, stimulus: Stimulus | None, hold: Callable[[bool], None] | None
    ) -> None:
        self.wire, self.profile, self.priority, self.stimulus, self.hold = wire, profile, priority, stimulus, hold
        self.notes = Notes()
        self.mark: Ns = 0  # end of the last character sent or received
        self.harmless = b"UC"  # a block that causes no block in return

    @property
    def tolerance(self) -> Ns:
        return self.wire.char_ns + TOLERANCE

    # ---- saying
    def say(self, data: bytes) -> None:
        self.wire.write(data)
        self.mark = self.wire.drained()
        self.notes.wire += [(self.mark - (len(data) - at) * self.wire.char_ns, "us", byte) for at, byte in enumerate(data, 1)]

    def spoil(self, kind: Damage = Damage.PARITY) -> None:
        """One damaged character; the test is not run where the port cannot."""
        self.pass_time(self.wire.drained())
        if not (self.wire.send_break() if kind is Damage.BREAK else self.wire.spoil()):
            raise NotRun(said("{} cannot send {}", self.wire.name, "BREAK" if kind is Damage.BREAK else "a character with wrong parity"))
        self.mark = self.wire.drained()
        self.notes.wire.append((self.mark, "us", kind))

    def pass_time(self, until: Ns) -> None:
        """Nothing may come until then that matters: whatever comes is noted."""
        while self._hear(until) is not None:
            pass

    # ---- hearing
    def _hear(self, until: Ns) -> Heard | None:
        heard = self.wire.hear(until)
        if heard is not None:
            self.mark = heard.stamp
            self.notes.wire.append((heard.stamp, "station", heard.what))
        return heard

    def answer(self, within: Ns) -> int | Damage | None:
        """The next character, within this time after the last one on the line; None: silence."""
        heard = self._hear(self.mark + within)
        return None if heard is None else heard.what

    def expect(self, char: int, within: Ns, after: str) -> Ns:
        """That character is next; how long it took since the last one on the line."""
        start = self.mark
        got = self.answer(within + self.tolerance)
        if got != char:
            raise Fail(
                said("after {}: {}, expected {}", after, named(got), named(char))
                + (said(" within {:.0f} ms", within / 1e6) if got is None else "")
            )
        return self.mark - start

    def expect_at(self, char: int, due: Ns, after: str) -> None:
        """That character comes `due` after the last one on the line, not before and not later."""
        start = self.mark
        got = self.answer(2 * due + ms(500))
        if got != char:
            raise Fail(said("after {}: {}, expected {} after {:.0f} ms", after, named(got), named(char), due / 1e6))
        self.measured(said("{} after {}", named(char), after), self.mark - start, due)

    def silence(self, how_long: Ns, after: str) -> None:
        """No character for so long."""
        got = self.answer(how_long)
        if got is not None:
            raise Fail(said("after {}: {}, expected silence for {:.0f} ms", after, named(got), how_long / 1e6))

    def measured(self, what: str, took: Ns, expected: Ns | None) -> None:
        """Records a time; a wrong one ends the test."""
        self.notes.times.append(Measured(what, took, expected, self.tolerance))
        if expected is not None and abs(took - expected) > self.tolerance:
            raise Fail(
                said("{}: {:.1f} ms, expected {:.0f} ms, tolerance {:.1f} ms", what, took / 1e6, expected / 1e6, self.tolerance / 1e6)
            )

    def remark(self, text: str) -> None:
        self.notes.remarks.append(text)

    # ---- larger pieces
    def connect(self) -> None:
        """STX and the station's DLE."""
        self.say(bytes((Char.STX,)))
        self.measured("DLE after STX", self.expect(Char.DLE, self.profile.ack_delay, "STX"), None)

    def give(self, data: bytes) -> int | Damage | None:
        """Send a complete good block; return the answer to it."""
        self.connect()
        self.say(wire_block(data, self.profile.block_check))
        return self.answer(self.profile.ack_delay)

    def give_good(self, data: bytes, what: str = "a good block") -> None:
        """Send a complete good block, which must be acknowledged."""
        got = self.give(data)
        if got != Char.DLE:
            raise Fail(said("after {}: {}, expected DLE", what, named(got)))

    def make_it_send(self, after: str = "the stimulus") -> None:
        """Wait for the station's STX."""
        if self.stimulus is None:
            raise NotRun("the station is not made to send (--stimulus none)")
        self.stimulus.trigger(self)
        got = self.answer(self.stimulus.timeout)
        while got == Char.NAK:
            got = self.answer(self.stimulus.timeout)
        if got is None:
            raise Inconclusive(said("no STX within {:.0f} s after {}: it did not send", self.stimulus.timeout / 1e9, after))
        if got != Char.STX:
            raise Fail(said("after {}: {}, expected STX", after, named(got)))

    def take(self) -> bytes:
        """The rest of the station's block after its STX, answered DLE; the data."""
        block = self.take_unanswered()
        self.say(bytes((Char.DLE,)))
        return block

    def take_unanswered(self) -> bytes:
        """The same without the last DLE."""
        self.say(bytes((Char.DLE,)))
        return self.read_block()

    def read_block(self) -> bytes:
        """The characters of a block that is under way, with its check."""
        data, escaped, check = bytearray(), False, 0
        while True:
            got = self.answer(self.profile.char_delay + self.tolerance)
            if not isinstance(got, int):
                raise Fail(said("inside the station's block: {} after {} data characters", named(got), len(data)))
            check ^= got
            if escaped and got in (Char.ETX, Char.ETB):
                break
            if escaped and got != Char.DLE:
                raise Fail(said("the station's block has DLE {}: a DLE is doubled or followed by ETX", named(got)))
            if escaped or got != Char.DLE:
                data.append(got)
            escaped = got == Char.DLE and not escaped
        if self.profile.block_check:
            self._judge_check(bytes(data), check, self.answer(self.profile.char_delay + self.tolerance))
        return bytes(data)

    def _judge_check(self, data: bytes, check: int, got: int | Damage | None) -> None:
        if got == check:
            return
        if isinstance(got, int) and got ^ check == Char.STX:
            raise Fail(said("block check {:02X}h, expected {:02X}h: off by 02h, the station includes STX", got, check))
        if isinstance(got, int) and got ^ check == Char.DLE and data.count(Char.DLE) % 2:
            raise Fail(said("block check {:02X}h, expected {:02X}h: the station counts a doubled DLE once", got, check))
        raise Fail(said("block check {}, expected {:02X}h", named(got), check))

    def swallow(self, quiet: Ns) -> None:
        """Answers whatever the station still sends with DLE, right or wrong, until it is quiet: it shall repeat nothing."""
        for _ in range(MOST_BLOCKS):
            got = self.answer(quiet)
            if got is None:
                return
            if got == Char.STX:
                self.say(bytes((Char.DLE,)))
            while self.answer(self.profile.char_delay) is not None:
                pass
            self.say(bytes((Char.DLE,)))
        raise Inconclusive("the station does not fall silent")

    def settle(self, quiet: Ns | None = None) -> None:
        """Accept what the station still has to send until it is quiet."""
        wait = self.profile.char_delay + QUIET if quiet is None else quiet
        self.mark = max(self.mark, self.wire.now())
        for _ in range(MOST_BLOCKS):
            got = self.answer(wait)
            if got is None:
                return
            if got == Char.STX:
                try:
                    self.take()
                except Verdict:
                    self.say(bytes((Char.NAK,)))
        raise Inconclusive("the station does not fall silent")
