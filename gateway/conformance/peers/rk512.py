"""RK512: our station with one fault each, and stations that are correct in another way (serial-protocols 2)."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from gateway.conformance.peers.p3964r_receivers import StaysDoubled, TakesBrokenOff
from gateway.conformance.peers.p3964r_stations import NeverDoublesDle, check_counts_once, check_doubled, wrong_long_check
from gateway.conformance.peers.powered import Powered
from gateway.conformance.peers.rk512_active import (
    CommandTwice,
    Hangs,
    HangsAtError,
    HangsInStop,
    HangsWhenLocked,
    HangsWhenLong,
    HangsWhenShort,
    LongJobs,
    NoCommand,
    Patient,
    RefusesReaction,
    SmallLetters,
    SmallType,
    StopsAtCommand,
    WaitsForEver,
    WrongAmount,
)
from gateway.conformance.peers.rk512_memories import (
    AllAreas,
    EvenWords,
    EveryTwelfth,
    FirstWordOnly,
    Growing,
    LosesLast,
    Memory,
    NoMinusOne,
    NotWritten,
    OffByOne,
    Once,
    ReadsBeyond,
    Rotates,
    Swapped,
    WordsForBytes,
    WritesBeyond,
    WritesToTheEnd,
    swap,
)
from gateway.conformance.peers.rk512_passive import (
    Beside,
    Change,
    ChangedReactions,
    ChattyAndSilent,
    DiesOfErrors,
    FetchDx,
    Ignores,
    KeepsPieces,
    LockedByFollowOn,
    LoneSend,
    LowAmount,
    NeverLocks,
    NoFirstByte,
    NoLength,
    OneByteKills,
    ReactsLate,
    SendDx,
    ShortSends,
    SilentToErrors,
    Slow,
    StickyNumber,
    Twice,
    WritesLocked,
    WritesThenRefuses,
)
from gateway.conformance.peers.stations import ActiveStation, AnswersLate, Built, Chatty, Maker, Mutant, Variant, link_of
from gateway.conformance.serial.partners import Blocks
from protocols.base.machine import ms
from protocols.p3964r.profiles import RHO3, SIEMENS_CP341, VIPA_CP240, WAGO, Priority, Profile
from protocols.rk512.dialects import DIALECTS, Dialect
from protocols.rk512.flags import Flags
from protocols.rk512.passive import Passive

LOW = Priority.LOW
P, A = "RK512_PAS_", "RK512_ACT_"


def _passive(change: Change) -> Maker:
    return lambda: Built(passive=lambda station: ChangedReactions(station.blocks, change))


def _number(old: int, new: int) -> Maker:
    """One error number is reported in place of another."""
    return _passive(lambda command, said: said[:3] + bytes((new,)) + said[4:] if said[3] == old else said)


def _all_as(said: bytes, number: int) -> bytes:
    return said[:3] + bytes((number,)) + said[4:] if said[3] else said


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


def _last_of_63(command: bytes, said: bytes) -> bytes:
    return said[:-2] + b"\0\0" if len(said) == 4 + 2 * 63 else said


def _mutant(name: str, what: str, expects: Sequence[str], make: Maker) -> Mutant:
    return Mutant(name, what, tuple(expects), make, link_of(RHO3, LOW), {})


SERVES = replace(Dialect(), coordination_flag="serve")


def _flagged(name: str, what: str, expects: Sequence[str], make: Callable[[Blocks], Passive]) -> Mutant:
    """Its PICS states that it keeps coordination flags."""
    return replace(_mutant(name, what, expects, lambda: Built(passive=lambda station: make(station.blocks))), pics={"flags": True})


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
    _mutant("swaps-read", "exchanges the bytes it reads", [f"{P}BV_05"], _memory(lambda: Memory(lambda data, db, word, words: swap(data)))),
    _mutant(
        "reverse",
        "words in reverse order",
        [f"{P}BV_05"],
        _memory(lambda: Memory(lambda data, db, word, words: b"".join(data[at : at + 2] for at in range(len(data) - 2, -2, -2)))),
    ),
    _mutant("off-by-one", "writes one word too far", [f"{P}BV_05"], _memory(OffByOne)),
    _mutant("first-word-only", "writes the first word only", [f"{P}BV_05"], _memory(FirstWordOnly)),
    _mutant("even-words", "loses the last one of an odd number of words", [f"{P}BV_05"], _memory(EvenWords)),
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
    _mutant("each-12th", "each twelfth write is lost", [f"{P}ST_02", f"{P}BV_08", f"{P}BV_07", f"{P}BV_05"], _memory(EveryTwelfth)),
    _mutant("any-block", "serves blocks that are not there", [f"{P}BI_02"], _memory(Growing)),
    _mutant("reads-beyond", "reads beyond the end", [f"{P}BI_04"], _memory(ReadsBeyond)),
    _mutant("writes-beyond", "writes beyond the end, at the beginning", [f"{P}BI_16"], _memory(WritesBeyond)),
    _mutant("stop-for-missing", "reports CPU in STOP for a missing block", [f"{P}BI_02"], _number(0x14, 0x2A)),
    _mutant("stop-for-all", "reports CPU in STOP whatever it refuses", [f"{P}BI_01"], _passive(lambda command, said: _all_as(said, 0x2A))),
    _mutant("locked-for-missing", "reports locked for a missing block", [f"{P}BI_02"], _number(0x14, 0x32)),
    _mutant("stop-for-type", "reports CPU in STOP for a wrong type", [f"{P}BI_06"], _number(0x0C, 0x2A)),
    _mutant("missing-for-command", "reports block missing for a wrong command", [f"{P}BI_05"], _number(0x16, 0x14)),
    _mutant("missing-for-length", "reports CPU in STOP for a wrong length", [f"{P}BI_09", f"{P}BI_12"], _number(0x34, 0x2A)),
    _mutant("sequence-as-stop", "reports CPU in STOP for a lone follow-on", [f"{P}BI_08"], _number(0x36, 0x2A)),
    _mutant("types-as-stop", "reports CPU in STOP for a type it does not serve", [f"{P}CA_01"], _number(0x12, 0x2A)),
    _mutant(
        "data-behind-error",
        "data after an error number",
        [f"{P}BI_01"],
        _passive(lambda command, said: said + b"\0\0" if said[3] else said),
    ),
    _mutant("silent-errors", "never refuses, is silent", [f"{P}BI_01"], _kind(SilentToErrors)),
    _mutant(
        "dies-of-errors",
        "serves nothing after five refusals",
        [f"{P}BI_01", f"{P}BV_09", f"{P}BI_06", f"{P}RC_03", f"{P}BI_05", f"{P}CA_01", f"{P}CA_02", f"{P}CA_03", f"{P}CA_07"],
        _kind(DiesOfErrors),
    ),
    _mutant("short-sends", "writes what came, whatever was announced", [f"{P}BI_12", f"{P}BI_13"], _kind(ShortSends)),
    _mutant("writes-then-refuses", "writes, then refuses for the length", [f"{P}BI_12", f"{P}BI_13"], _kind(WritesThenRefuses)),
    _mutant("data-behind-fetch", "ignores what follows the header", [f"{P}BI_10"], _kind(NoLength)),
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
    _mutant("hangs-at-2ah", "stops after error number 2Ah", [f"{A}BI_11"], lambda: ActiveStation(active=HangsInStop)),
    _mutant("hangs-at-32h", "stops after error number 32h", [f"{A}BI_12"], lambda: ActiveStation(active=HangsWhenLocked)),
    _mutant("hangs-when-long", "stops after a reaction that is too long", [f"{A}BI_07"], lambda: ActiveStation(active=HangsWhenLong)),
    _mutant("command-twice", "sends each FETCH twice", [f"{A}BV_02"], CommandTwice),
    _mutant(
        "stops-at-command", "a command in place of the reaction ends its work", [f"{A}BI_09"], lambda: ActiveStation(roles=StopsAtCommand)
    ),
    _mutant("reaction-after-power", "reacts to a command of before the power failure", ["RK512_SUP_RC_01"], ReactsLate),
    _mutant("sticky-number", "the number of a refusal is in the next reaction", [f"{P}RC_05"], _kind(StickyNumber)),
    _mutant("writes-to-the-end", "a refused SEND is written up to the end", [f"{P}BI_16"], _memory(WritesToTheEnd)),
    _mutant("reaction-ff", "the first reaction begins with FF", [f"{P}BV_01"], _passive(lambda command, said: b"\xff" + said[1:])),
    _mutant("send-dx", "a SEND to DX is written to DB", [f"{P}BV_18"], _kind(SendDx)),
    _mutant("fetch-dx", "a FETCH of DX brings the words of DB", [f"{P}BV_18"], _kind(FetchDx)),
    _mutant("lone-send", "a follow-on SEND without a first one is written", [f"{P}BI_21"], _kind(LoneSend)),
    _mutant("undoubled", "a doubled DLE stays doubled in what it receives", [f"{P}BV_02"], lambda: Built(receiver=StaysDoubled)),
    _mutant("low-amount", "the high byte of the amount does not count", [f"{P}BI_17", f"{P}BI_18"], _kind(LowAmount)),
    _mutant("keeps-pieces", "what an abandoned SEND brought is in the next one", [f"{P}RC_06"], _kind(KeepsPieces)),
    _flagged("never-locks", "a coordination flag locks nothing", [f"{P}CA_08"], lambda blocks: Passive(blocks, SERVES, flags=NeverLocks())),
    _flagged("writes-locked", "writes a SEND that it refuses with 32h", [f"{P}BI_19"], lambda blocks: WritesLocked(blocks, SERVES)),
    _mutant("small-type", "its SEND names type d", [f"{A}BV_03"], SmallType),
    _mutant("no-command", "its SEND is command I", [f"{A}BV_03"], NoCommand),
    _mutant("wrong-amount", "announces another amount than it sends", [f"{A}BV_01"], WrongAmount),
    _mutant("refuses-reaction", "answers the reaction to its FETCH with NAK", ["RK512_ACT_BV_01"], RefusesReaction),
    _mutant("never-doubles", "sends a DLE of its data once", [f"{P}BV_21"], lambda: NeverDoublesDle(RHO3, LOW)),
    _mutant("check-doubled", "a block check of 10h is doubled", [f"{P}BV_21"], lambda: Built(says=check_doubled)),
    _mutant("check-counts-once", "the check of its blocks counts a doubled DLE once", [f"{P}BV_21"], lambda: Built(says=check_counts_once)),
    _mutant("long-check", "the check of its long blocks is wrong", [f"{P}BV_21"], lambda: Built(says=wrong_long_check)),
    _mutant("rotates", "longer jobs from odd words begin with the second word", [f"{P}ST_03"], _memory(Rotates)),
    _mutant("63-words", "the last of 63 words is 0", [f"{P}ST_03"], _passive(_only_fetch(_last_of_63))),
    _mutant("once", "the same data are not written again, wherever", [f"{P}BV_19"], _memory(Once)),
    _mutant("no-minus-one", "writes FFFFh as 0", [f"{P}BV_20"], _memory(NoMinusOne)),
    _mutant(
        "executes-broken-off",
        "executes a command whose block check never came",
        [f"{P}BO_07"],
        lambda: Built(receiver=TakesBrokenOff),
    ),
    _mutant("small-letters", "takes commands in small letters", [f"{P}BI_20"], SmallLetters),
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
    _variant("chatty-and-silent", "the same, and no reaction to what is not a command", make=ChattyAndSilent),
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
        make=lambda: Built(passive=lambda station: Passive(station.blocks, SERVES, flags=Flags())),
        flags=True,
    ),
    _variant("powered", "its supply can be switched", make=lambda: Powered(Built)),
    _variant("late-reactions", "reactions after 500 ms", make=lambda: Slow(ms(500))),
    _variant(
        "ignores-55h", "does not answer a telegram whose byte 1 is 55h", make=lambda: Built(passive=lambda station: Ignores(station.blocks))
    ),
    _variant("active", "both roles", make=ActiveStation),
    _variant("active-patient", "both roles, waits 20 s for a reaction", make=lambda: ActiveStation(active=Patient)),
    _variant("active-long", "both roles, jobs of 300 bytes", make=LongJobs),
    _variant("active-no-nesting", "both roles, no nesting", make=lambda: ActiveStation(nesting=False)),
)
