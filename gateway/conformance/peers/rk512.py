"""RK512: our station with one fault each, and stations that are correct in another way (serial-protocols 2)."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from gateway.conformance.peers.powered import Powered
from gateway.conformance.peers.stations import ActiveStation, AnswersLate, Built, Chatty, Maker, Mutant, Variant, link_of
from gateway.conformance.serial.partners import Blocks, Late
from protocols.base.machine import Ns, ms
from protocols.p3964r.profiles import RHO3, SIEMENS_CP341, VIPA_CP240, WAGO, Priority, Profile
from protocols.rk512.active import Active
from protocols.rk512.active import Event as ActiveEvent
from protocols.rk512.dialects import DIALECTS, Dialect
from protocols.rk512.flags import Flags
from protocols.rk512.header import ErrorNumber, Header, Kind
from protocols.rk512.passive import Areas, Passive, Refused
from protocols.rk512.passive import Event as PassiveEvent
from protocols.rk512.station import Event as StationEvent
from protocols.rk512.station import Station as Roles

LOW = Priority.LOW
P, A = "RK512_PAS_", "RK512_ACT_"
Change = Callable[[bytes, bytes], bytes | None]  # command, reaction -> what is said instead


class Memory(Blocks):
    """Data blocks whose reads and writes are changed."""

    def __init__(
        self, read: Callable[[bytes, int, int, int], bytes] | None = None, where: Callable[[int, int], tuple[int, int]] | None = None
    ) -> None:
        super().__init__()
        self._changed, self._where = read, where or (lambda db, word: (db, word))

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        found = super().read(*self._where(db, word), words)
        return found if isinstance(found, ErrorNumber) or self._changed is None else self._changed(found, db, word, words)

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(*self._where(db, word), data)


class NotWritten(Blocks):
    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        there = self.read(db, word, len(data) // 2)
        return there if isinstance(there, ErrorNumber) else None


class Swapped(Blocks):
    """Exchanges the bytes of each word it writes."""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, word, b"".join(data[at + 1 : at + 2] + data[at : at + 1] for at in range(0, len(data), 2)))


class OffByOne(Blocks):
    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, min(word + 1, 127 - len(data) // 2), data)


class FirstWordOnly(Blocks):
    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, word, data[:2])


class LosesLast(Blocks):
    """The last word of a job of more than eight is not written."""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, word, data[:-2] if len(data) > 16 else data)


class EveryTwelfth(Blocks):
    """Each twelfth write is lost."""

    _count = 0

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        self._count += 1
        return None if self._count % 12 == 0 else super().write(db, word, data)


class Growing(Blocks):
    """Every block there is, zeros where nothing was written."""

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        return super().read(db, word, words) if db in self.content else bytes(2 * words)

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, word, data) if db in self.content else None


class ReadsBeyond(Blocks):
    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        if db in self.content and word < 128 < word + words:
            return (bytes(self.content[db][2 * word :]) + bytes(2 * words))[: 2 * words]
        return super().read(db, word, words)


class WritesToTheEnd(Blocks):
    """What fits is written, then the job is refused."""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        if db in self.content:
            super().write(db, word, data[: max(0, 2 * (128 - word))])
        return super().write(db, word, data)


class WritesBeyond(Blocks):
    """Words behind the end land at the beginning."""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        if db in self.content and word + len(data) // 2 > 128:
            return super().write(db, 0, data)
        return super().write(db, word, data)


class Told(Passive):
    """Our passive station with one reaction changed: `change(command, reaction)`; None: nothing is said."""

    def __init__(self, blocks: Blocks, change: Change, dialect: Dialect | None = None) -> None:
        super().__init__(blocks, dialect)
        self._change, self._command = change, b""

    def telegram(self, data: bytes, now: Ns) -> list[PassiveEvent]:
        self._command = data
        return super().telegram(data, now)

    def take_output(self) -> bytes | None:
        output = super().take_output()
        return output if output is None else self._change(self._command, output)


class StickyNumber(Told):
    """The number of a refusal is in the next reaction to SEND as well."""

    def __init__(self, blocks: Blocks) -> None:
        super().__init__(blocks, self._stuck)
        self._number = 0

    def _stuck(self, command: bytes, said: bytes) -> bytes:
        number, self._number = self._number, said[3]
        return said[:3] + bytes((number,)) if number and len(said) == 4 and not said[3] else said


class ShortSends(Passive):
    """Writes what came, whatever was announced."""

    def _wrong_amount(self, header: Header, data_bytes: int) -> tuple[int, str] | None:
        return None if header.command == 0x41 else super()._wrong_amount(header, data_bytes)


class WritesThenRefuses(Passive):
    """Writes what came, then finds the length wrong."""

    def _wrong_amount(self, header: Header, data_bytes: int) -> tuple[int, str] | None:
        fault = super()._wrong_amount(header, data_bytes)
        if fault is not None and header.command == 0x41 and data_bytes:
            self._blocks.write(header.db, header.address, b"\x77" * (data_bytes // 2 * 2 or 2))
        return fault


class NoLength(Passive):
    """Does not look behind the header of a FETCH."""

    def _wrong_amount(self, header: Header, data_bytes: int) -> tuple[int, str] | None:
        return super()._wrong_amount(header, 0 if header.command == 0x45 else data_bytes)


class NoFirstByte(Passive):
    def _form(self, data: bytes) -> tuple[int, str] | None:
        return super()._form(b"\x00" + data[1:] if data[:1] not in (b"\x00", b"\xff") else data)

    def telegram(self, data: bytes, now: Ns) -> list[PassiveEvent]:
        return super().telegram(b"\x00" + data[1:] if data[:1] == b"\x55" and len(data) > 9 else data, now)


class LockedByFollowOn(Passive):
    """A long job that is abandoned is waited for for ever."""

    def _refuse(self, fault: tuple[int, str], data: bytes) -> Refused:
        kept = self._open
        refused = super()._refuse(fault, data)
        self._open = kept
        return refused


class SilentToErrors(Passive):
    def take_output(self) -> bytes | None:
        output = super().take_output()
        return None if output is not None and output[3] else output


class DiesOfErrors(Passive):
    """After four refusals nothing is served."""

    _bad = 0

    def take_output(self) -> bytes | None:
        output = super().take_output()
        if output is not None and output[3]:
            self._bad += 1
        return None if self._bad > 4 else output


class Twice(Built):
    """Each reaction comes twice."""

    def _serve(self, data: bytes, now: Ns) -> None:
        assert self.passive is not None
        self.passive.telegram(data, now)
        while (reaction := self.passive.take_output()) is not None:
            self.link.send(reaction, now)
            self.link.send(reaction, now)


class OneByteKills(Built):
    """A telegram of less than four bytes ends its service."""

    def _serve(self, data: bytes, now: Ns) -> None:
        if len(data) < 4:
            self.passive = None
        super()._serve(data, now)


class Slow(Built):
    """The reaction comes after seven seconds."""

    _due: Ns | None = None
    _waiting: bytes = b""

    def _serve(self, data: bytes, now: Ns) -> None:
        self._due, self._waiting = now + ms(7000), data

    def deadline(self) -> Ns | None:
        moments = [moment for moment in (super().deadline(), self._due) if moment is not None]
        return min(moments, default=None)

    def wake(self, now: Ns) -> Sequence[object]:
        if self._due is not None and now >= self._due:
            self._due = None
            super()._serve(self._waiting, now)
        due = self.link.deadline()
        return super().wake(now) if due is not None and due <= now else []


class Beside(Built):
    """A command whose block check was wrong is executed all the same."""

    def _handle(self, events: Sequence[object], now: Ns) -> Sequence[object]:
        handled = super()._handle(events, now)
        if any(type(event).__name__ == "BlockRefused" for event in events):
            self._serve(bytes((0, 0, 0x45, 0x44, 10, 0, 0, 1, 0xFF, 0xFF)), now)
        return handled


class WordsForBytes(Areas):
    """Counts words where bytes are meant."""

    def read_area(self, kind: Kind, block: int, address: int, amount: int) -> bytes | ErrorNumber:
        return bytes(2 * amount)

    def write_area(self, kind: Kind, block: int, address: int, data: bytes) -> ErrorNumber | None:
        return ErrorNumber.TYPE_NOT_SERVED


class AllAreas(Areas):
    """Serves all types."""

    def read_area(self, kind: Kind, block: int, address: int, amount: int) -> bytes | ErrorNumber:
        return bytes(kind.unit * amount)

    def write_area(self, kind: Kind, block: int, address: int, data: bytes) -> ErrorNumber | None:
        return None


# ---- active
class Hangs(Active):
    """A reaction it does not like is waited for again, for ever."""

    def reaction(self, data: bytes, now: Ns) -> list[ActiveEvent]:
        if data[3:4] != b"\x00" or data[:1] not in (b"\x00", b"\xff"):
            self._until = None
            return []
        return [*super().reaction(data, now)]


class HangsWhenShort(Active):
    def reaction(self, data: bytes, now: Ns) -> list[ActiveEvent]:
        if len(data) < 4:
            self._until = None
            return []
        return [*super().reaction(data, now)]


class WaitsForEver(Active):
    """No limit for the reaction."""

    def acknowledged(self, now: Ns) -> list[ActiveEvent]:
        events = super().acknowledged(now)
        if self._until is not None:
            self._until += ms(10_000_000)
        return [*events]


class HangsAtError(Active):
    def reaction(self, data: bytes, now: Ns) -> list[ActiveEvent]:
        if data[3:4] == b"\x14":
            self._until = None
            return []
        return [*super().reaction(data, now)]


class HangsWhenLong(Active):
    def reaction(self, data: bytes, now: Ns) -> list[ActiveEvent]:
        if self._until is not None and len(data) > 8:
            self._until = None
            return []
        return [*super().reaction(data, now)]


class CommandTwice(ActiveStation):
    """Each FETCH is sent twice."""

    _repeated = 0

    def _serve(self, data: bytes, now: Ns) -> None:
        if data[:4] == bytes(4) and self._jobs % 2 and self._repeated != self._jobs:
            self._repeated = self._jobs
            self.active.fetch(0, 2, block=5)
        super()._serve(data, now)


class StopsAtCommand(Roles):
    """A command in place of the reaction is dropped, and so is all after it."""

    _stopped = False

    def block(self, data: bytes, now: Ns, overtaken: bool = False) -> list[StationEvent]:
        if self.active.awaiting and len(data) > 4 and data[2] == 0x45:
            self._stopped = True
        return [] if self._stopped else super().block(data, now, overtaken)

    def take_block(self) -> bytes | None:
        return None if self._stopped else super().take_block()


class WrongAmount(ActiveStation):
    """Announces one word less than it sends."""

    def _hand_over(self, now: Ns) -> None:
        while (block := self.roles.take_block()) is not None:
            if len(block) > 10 and block[2] == 0x41:
                block = block[:7] + bytes((block[7] - 1,)) + block[8:]
            elif len(block) == 10 and block[2] == 0x45:
                block = block[:6] + b"\0\0" + block[8:]
            self.link.send(block, now)


def _passive(change: Change) -> Maker:
    return lambda: Built(passive=lambda station: Told(station.blocks, change))


def _number(old: int, new: int) -> Maker:
    """One error number is told in place of another."""
    return _passive(lambda command, said: said[:3] + bytes((new,)) + said[4:] if said[3] == old else said)


def _memory(make: Callable[[], Blocks]) -> Maker:
    def station() -> Built:
        def passive(built: Built) -> Passive:
            built.blocks = make()
            return Passive(built.blocks)

        return Built(passive=passive)

    return station


def _kind(kind: type[Passive]) -> Maker:
    return lambda: Built(passive=lambda station: kind(station.blocks))


def _only_follow(change: Change) -> Change:
    return lambda command, said: change(command, said) if command[:1] == b"\xff" else said


def _only_fetch(change: Change) -> Change:
    return lambda command, said: change(command, said) if command[2:3] == b"E" and not said[3] else said


def _only_send(change: Change) -> Change:
    return lambda command, said: change(command, said) if command[2:3] == b"A" and not said[3] else said


def _mutant(name: str, what: str, expects: Sequence[str], make: Maker) -> Mutant:
    return Mutant(name, what, tuple(expects), make, link_of(RHO3, LOW), {})


def _swap(data: bytes) -> bytes:
    return b"".join(data[at + 1 : at + 2] + data[at : at + 1] for at in range(0, len(data), 2))


class ReactsLate(Powered):
    """What was asked before the power failure is answered after it."""

    def __init__(self) -> None:
        super().__init__(lambda: Late(RHO3, LOW, late=ms(20)))

    def power(self, on: bool, now: Ns) -> None:
        before = self._device
        super().power(on, now)
        if on:
            self._device = before


MUTANTS = (
    _mutant("no-reaction", "never reacts", [f"{P}BV_01"], _passive(lambda command, said: None)),
    _mutant("first-byte", "reactions begin with 01", [f"{P}BV_01"], _passive(lambda command, said: b"\x01" + said[1:])),
    _mutant("always-error", "refuses all with 14h", [f"{P}BV_01"], _passive(lambda command, said: b"\0\0\0\x14")),
    _mutant("byte-short", "a FETCH brings a byte too few", [f"{P}BV_01"], _passive(_only_fetch(lambda command, said: said[:-1]))),
    _mutant(
        "word-more",
        "a FETCH of more than one word brings a word more",
        [f"{P}BV_02"],
        _passive(_only_fetch(lambda command, said: said + b"\0\0" if len(said) > 6 else said)),
    ),
    _mutant("most-32", "at most 64 bytes in a reaction", [f"{P}BV_02"], _passive(_only_fetch(lambda command, said: said[:68]))),
    _mutant(
        "data-behind-send", "the reaction to SEND carries data", [f"{P}BV_04"], _passive(_only_send(lambda command, said: said + b"\0"))
    ),
    _mutant("send-refused", "refuses every SEND", [f"{P}BV_04"], _passive(_only_send(lambda command, said: said[:3] + b"\x0a"))),
    _mutant("not-written", "acknowledges a SEND without writing", [f"{P}BV_05"], _memory(NotWritten)),
    _mutant("swaps-written", "exchanges the bytes it writes", [f"{P}BV_05"], _memory(Swapped)),
    _mutant(
        "swaps-read", "exchanges the bytes it reads", [f"{P}BV_05"], _memory(lambda: Memory(lambda data, db, word, words: _swap(data)))
    ),
    _mutant(
        "reverse",
        "words in reverse order",
        [f"{P}BV_05"],
        _memory(lambda: Memory(lambda data, db, word, words: b"".join(data[at : at + 2] for at in range(len(data) - 2, -2, -2)))),
    ),
    _mutant("off-by-one", "writes one word behind", [f"{P}BV_05"], _memory(OffByOne)),
    _mutant("first-word-only", "writes the first word only", [f"{P}BV_05"], _memory(FirstWordOnly)),
    _mutant("loses-last", "loses the last word of longer jobs", [f"{P}BV_05", f"{P}BV_06"], _memory(LosesLast)),
    _mutant(
        "byte-address",
        "counts bytes where words are meant",
        [f"{P}BV_07", f"{P}BV_08"],
        _memory(lambda: Memory(where=lambda db, word: (db, word // 2))),
    ),
    _mutant("six-bits", "word numbers of six bits", [f"{P}BV_08"], _memory(lambda: Memory(where=lambda db, word: (db, word & 0x3F)))),
    _mutant(
        "one-block",
        "all blocks are one",
        [f"{P}BV_09"],
        _memory(lambda: Memory(where=lambda db, word: (10 if db in (5, 10, 11, 16) else db, word))),
    ),
    _mutant(
        "block-bit",
        "DB 10 and 11 are one",
        [f"{P}BV_09"],
        _memory(lambda: Memory(where=lambda db, word: (db & ~1 if db == 11 else db, word))),
    ),
    _mutant(
        "loses-10h",
        "a 10h of a pair of equal bytes is lost",
        [f"{P}BV_10"],
        _memory(lambda: Memory(lambda data, db, word, words: data.replace(b"\x10\x10", b"\x10\x00"))),
    ),
    _mutant(
        "seven-bits-data",
        "the top bit of data is lost",
        [f"{P}BV_05"],
        _memory(lambda: Memory(lambda data, db, word, words: bytes(byte & 0x7F for byte in data))),
    ),
    _mutant("each-12th", "each twelfth write is lost", [f"{P}ST_02", f"{P}BV_08", f"{P}BV_07"], _memory(EveryTwelfth)),
    _mutant("any-block", "serves blocks that are not there", [f"{P}BI_02"], _memory(Growing)),
    _mutant("reads-beyond", "reads behind the end", [f"{P}BI_04"], _memory(ReadsBeyond)),
    _mutant("writes-beyond", "writes behind the end, at the beginning", [f"{P}BI_16"], _memory(WritesBeyond)),
    _mutant("stop-for-missing", "reports CPU in STOP for a missing block", [f"{P}BI_02"], _number(0x14, 0x2A)),
    _mutant("locked-for-missing", "reports locked for a missing block", [f"{P}BI_02"], _number(0x14, 0x32)),
    _mutant("stop-for-type", "reports CPU in STOP for a wrong type", [f"{P}BI_06"], _number(0x0C, 0x2A)),
    _mutant("missing-for-command", "reports block missing for a wrong command", [f"{P}BI_05"], _number(0x16, 0x14)),
    _mutant("missing-for-length", "reports CPU in STOP for a wrong length", [f"{P}BI_09", f"{P}BI_12"], _number(0x34, 0x2A)),
    _mutant("sequence-as-stop", "reports CPU in STOP for a lone follow-on", [f"{P}BI_08"], _number(0x36, 0x2A)),
    _mutant("types-as-stop", "reports CPU in STOP for a type it does not serve", [f"{P}CA_01"], _number(0x12, 0x2A)),
    _mutant(
        "data-behind-error",
        "data behind an error number",
        [f"{P}BI_01"],
        _passive(lambda command, said: said + b"\0\0" if said[3] else said),
    ),
    _mutant("silent-errors", "never refuses, is silent", [f"{P}BI_01"], _kind(SilentToErrors)),
    _mutant(
        "dies-of-errors",
        "serves nothing after five refusals",
        [f"{P}BV_09", f"{P}BI_06", f"{P}RC_03", f"{P}BI_05", f"{P}CA_01", f"{P}CA_02", f"{P}CA_03"],
        _kind(DiesOfErrors),
    ),
    _mutant("short-sends", "writes what came, whatever was announced", [f"{P}BI_12", f"{P}BI_13"], _kind(ShortSends)),
    _mutant("writes-then-refuses", "writes, then refuses for the length", [f"{P}BI_12", f"{P}BI_13"], _kind(WritesThenRefuses)),
    _mutant("data-behind-fetch", "does not look behind the header", [f"{P}BI_10"], _kind(NoLength)),
    _mutant("any-first-byte", "serves a telegram whose byte 1 is 55h", [f"{P}BI_07"], _kind(NoFirstByte)),
    _mutant("locked-by-follow-on", "an abandoned SEND locks it", [f"{P}RC_01", f"{P}RC_02"], _kind(LockedByFollowOn)),
    _mutant(
        "follow-on-again",
        "each follow-on brings the beginning",
        [f"{P}BV_15", f"{P}BV_14"],
        _passive(_only_follow(lambda command, said: said[:4] + bytes(len(said) - 4))),
    ),
    _mutant(
        "follow-on-short",
        "a follow-on is a byte short",
        [f"{P}BV_14"],
        _passive(_only_follow(lambda command, said: said[:-1] if len(said) > 4 else said)),
    ),
    _mutant(
        "follow-on-refused", "the second piece is refused", [f"{P}BV_14"], _passive(_only_follow(lambda command, said: b"\xff\0\0\x36"))
    ),
    _mutant("reaction-twice", "each reaction comes twice", [f"{P}BV_13"], Twice),
    _mutant("one-byte-kills", "a telegram of one byte ends its service", [f"{P}BO_06"], OneByteKills),
    _mutant("slow-reaction", "reacts after seven seconds", [f"{P}BV_01"], Slow),
    _mutant("executes-refused", "executes a command whose block it refused", [f"{P}BO_01"], Beside),
    _mutant(
        "bytes-as-words",
        "counts words where bytes are meant",
        [f"{P}CA_01"],
        lambda: Built(passive=lambda station: Passive(station.blocks, areas=WordsForBytes())),
    ),
    _mutant("hangs-at-errors", "stops after a reaction with an error", [f"{A}BI_01"], lambda: ActiveStation(active=Hangs)),
    _mutant("hangs-when-short", "stops after a short reaction", [f"{A}BI_06"], lambda: ActiveStation(active=HangsWhenShort)),
    _mutant("waits-for-ever", "waits for a reaction for ever", [f"{A}BI_09", f"{A}BI_10"], lambda: ActiveStation(active=WaitsForEver)),
    _mutant("hangs-at-14h", "stops after error number 14h", [f"{A}BI_01"], lambda: ActiveStation(active=HangsAtError)),
    _mutant("hangs-when-long", "stops after a reaction that is too long", [f"{A}BI_07"], lambda: ActiveStation(active=HangsWhenLong)),
    _mutant("command-twice", "sends each FETCH twice", [f"{A}BV_02"], CommandTwice),
    _mutant(
        "stops-at-command", "a command in place of the reaction ends its work", [f"{A}BI_09"], lambda: ActiveStation(roles=StopsAtCommand)
    ),
    _mutant("reaction-after-power", "reacts to a command of before the power failure", ["RK512_SUP_RC_01"], ReactsLate),
    _mutant("sticky-number", "the number of a refusal is in the next reaction", [f"{P}RC_05"], _kind(StickyNumber)),
    _mutant("writes-to-the-end", "a refused SEND is written up to the end", [f"{P}BI_16"], _memory(WritesToTheEnd)),
    _mutant("reaction-ff", "the first reaction begins with FF", [f"{P}BV_01"], _passive(lambda command, said: b"\xff" + said[1:])),
    _mutant("wrong-amount", "announces another amount than it sends", [f"{A}BV_01"], WrongAmount),
)


def _variant(name: str, what: str, profile: Profile = RHO3, make: Maker | None = None, touch: bool = True, **pics: object) -> Variant:
    return Variant(name, what, make or (lambda: Built(profile, LOW)), link_of(profile, LOW), dict(pics), touch)


def _dialect(dialect: Dialect, profile: Profile = RHO3) -> Maker:
    return lambda: Built(profile, passive=lambda station: Passive(station.blocks, dialect))


def _small() -> Blocks:
    found = Blocks((10,))
    found.content = {10: bytearray(bytes((10, 0)) * 128)}
    return found


VARIANTS = (
    _variant("standard", "as Siemens, passive"),
    _variant("cp341", "CP 341 on its link profile", SIEMENS_CP341, _dialect(DIALECTS["siemens-cp341"], SIEMENS_CP341)),
    _variant("vipa", "VIPA CP 240", VIPA_CP240),
    _variant("wago", "no follow-on telegrams, 62 words", WAGO, _dialect(DIALECTS["wago"], WAGO)),
    _variant("read-only", "nothing may be written", touch=False),
    _variant("slow", "DLE after 120 ms", make=AnswersLate),
    _variant("chatty", "sends a block every 2 s", make=Chatty),
    _variant("not-allowed", "0Ah for a missing block", make=_number(0x14, 0x0A)),
    _variant(
        "own-number",
        "2Ah for a missing block, as declared in its PICS",
        make=_number(0x14, 0x2A),
        errors={"missing_block": "2A", "missing_block_send": "2A", "behind_the_end": "2A", "send_too_short": "2A", "type": "2A"},
    ),
    _variant("all-types", "serves all types", make=lambda: Built(passive=lambda station: Passive(station.blocks, areas=AllAreas()))),
    _variant("follow-on-00", "follow-on reactions begin with 00", make=_dialect(replace(Dialect(), follow_on_reaction=False))),
    _variant("one-block", "has one data block", make=_memory(_small)),
    _variant(
        "flags",
        "serves coordination flags",
        make=lambda: Built(passive=lambda station: Passive(station.blocks, replace(Dialect(), coordination_flag="serve"), flags=Flags())),
    ),
    _variant("powered", "its supply can be switched", make=lambda: Powered(Built)),
    _variant("active", "both roles", make=ActiveStation),
    _variant("active-no-nesting", "both roles, no nesting", make=lambda: ActiveStation(nesting=False)),
)
