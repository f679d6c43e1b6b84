"""3964R: our station with one fault each, and stations that are correct in another way (numbers: serial-protocols 1.2 to 1.6)."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from gateway.conformance.peers.p3964r_lasting import (
    DeafAfterGap,
    FewerAttempts,
    HastyRepeats,
    LongCheck,
    NakBringsAgain,
    PatientAtLast,
    Prolongs,
    ShortAfterStx,
    ThirdConflict,
    other_after_power,
)
from gateway.conformance.peers.p3964r_receivers import (
    AnswersInside,
    AnswersNak,
    AnyCheck,
    AnyCheckAfterDamage,
    CheckOfDle,
    CheckOfNak,
    DamageEnds,
    DleInIdle,
    EmptyHangs,
    EveryTenth,
    FalseEnd,
    GarbageKills,
    Locks,
    NakEnds,
    NaksGapTwice,
    NoTimer,
    NoTimerBeforeCheck,
    NoTimerInPair,
    NoZeroFirst,
    OnceToo,
    OrComplement,
    PairKeepsTimer,
    PairRestarts,
    Restarts,
    SilentGap,
    StrayOpens,
    TailOpens,
    TimerOfBlock,
    TopBitOfCheck,
    ZeroIsGood,
)
from gateway.conformance.peers.p3964r_repeats import (
    AnswersOldStx,
    AsciiAcknowledges,
    AsciiConnects,
    ChangesThird,
    ClashCheck,
    ConnectCheck,
    DropsAll,
    DropsWhenCorrupted,
    FromTheBeginning,
    KeepsBlocks,
    KeepsConnects,
    NaksLater,
    RepeatCheck,
    ShortRepeats,
)
from gateway.conformance.peers.p3964r_senders import (
    AnyAcknowledges,
    AnyIsDle,
    CountsOneMore,
    DeafInBlock,
    Differs,
    DropsInConflict,
    GivesUpAtOnce,
    ImpatientForAcknowledge,
    LateDleOpens,
    LosesNext,
    NakAcknowledges,
    NoYield,
    SendsTwice,
    SilenceAcknowledges,
    TwiceAfterConflict,
    WithoutStx,
)
from gateway.conformance.peers.p3964r_stations import (
    BreakHangs,
    BreakUnheard,
    Crowded,
    DeafAfter,
    DleTwice,
    Drops,
    Echoes,
    EverySecondStx,
    FlipsPriority,
    Hurried,
    LateDle,
    NakOpens,
    NaksFirstStx,
    NaksSecondDle,
    NakTwice,
    NeverDoublesDle,
    ResetsOnConflict,
    WedgesInARow,
    check_without_end,
    complement,
    extra,
    no_check,
    no_end,
    seven_bits,
    wrong_own_check,
    wrong_reaction_check,
)
from gateway.conformance.peers.powered import Powered
from gateway.conformance.peers.stations import (
    ActiveStation,
    AnswersLate,
    Built,
    Chatty,
    DeafToDamage,
    Maker,
    Mutant,
    Variant,
    link_of,
)
from gateway.conformance.serial.partners import (
    Late,
    NaksConflicts,
    NoNak,
    OwnCheck,
    Silent,
    counts_once,
    includes_stx,
)
from protocols.base.machine import ms
from protocols.p3964r.events import BlockReceived, BlockRefused, BlockSent
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
from protocols.p3964r.sender import Sender

LOW, HIGH = Priority.LOW, Priority.HIGH
R, S, C = "3964R_RCV_", "3964R_SND_", "3964R_CON_"
TIMED = (f"{R}TI_01", f"{R}TI_02", f"{R}TI_03", f"{R}TI_04")


def _profile(**changes: Any) -> Callable[[], object]:
    return lambda: Built(replace(RHO3, **changes))


def _mutant(name: str, what: str, expects: Sequence[str], make: Maker, priority: Priority = LOW) -> Mutant:
    return Mutant(name, what, tuple(expects), make, link_of(RHO3, priority), {})


def _with(receiver: type[Receiver] | None = None, sender: type[Sender] | None = None, priority: Priority = LOW) -> Maker:
    return lambda: Built(RHO3, priority, receiver=receiver, sender=sender)


def _changed(**changes: Any) -> Maker:
    return lambda: other_after_power(lambda: Built(replace(RHO3, **changes)))


MUTANTS = (
    _mutant("silent", "never answers", [f"{R}BV_01"], lambda: Silent(RHO3, LOW)),
    _mutant("no-nak", "never sends NAK", [f"{R}BI_01", f"{R}TI_01", f"{S}BI_01"], lambda: NoNak(RHO3, LOW)),
    _mutant("drops-its-job", "gives way in a conflict and forgets its own job", [f"{C}BV_02"], lambda: Drops(RHO3, LOW)),
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
    Mutant(
        "no-wait-for-buffer",
        "CP 341 that answers NAK at once without a buffer",
        (f"{R}BO_06",),
        lambda: Built(replace(SIEMENS_CP341, no_buffer_wait=0)),
        link_of(SIEMENS_CP341, LOW),
        {},
    ),
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
    _mutant("complement", "complements the check", [f"{R}BV_02"], lambda: OwnCheck(RHO3, LOW, "rk512", complement)),
    _mutant("never-doubles", "sends a DLE of its data once", [f"{S}BV_02"], lambda: NeverDoublesDle(RHO3, LOW)),
    _mutant("any-check", "does not look at the check", [f"{R}BI_01"], _with(AnyCheck)),
    _mutant("top-bit-of-check", "does not look at bit 7 of the check", [f"{R}BI_01"], _with(TopBitOfCheck)),
    _mutant("zero-is-good", "a check of 00h is good", [f"{R}BI_03"], _with(ZeroIsGood)),
    _mutant("complement-is-good", "the complement is good as well", [f"{R}BI_03"], _with(OrComplement)),
    _mutant("once-is-good", "a check that counts DLE once is good as well", [f"{R}BI_02"], _with(OnceToo)),
    _mutant("check-10h", "refuses a check of 10h", [f"{R}BV_04"], _with(CheckOfDle)),
    _mutant("check-15h", "refuses a check of 15h", [f"{R}BV_05"], _with(CheckOfNak)),
    _mutant("stx-restarts", "02h in the data begins the block anew", [f"{R}BV_10"], _with(Restarts)),
    _mutant("pair-restarts", "DLE STX in the data begins the block anew", [f"{R}BI_06"], _with(PairRestarts)),
    _mutant("nak-ends", "15h in the data ends the block", [f"{R}BV_11"], _with(NakEnds)),
    _mutant("seven-bits", "hears seven bits", [f"{R}BV_19"], lambda: Built(hears=seven_bits)),
    _mutant("no-zvz", "waits for characters for ever", [f"{R}TI_01"], _with(NoTimer)),
    _mutant("zvz-of-block", "ZVZ runs once for the block", [f"{R}TI_05"], _with(TimerOfBlock)),
    _mutant("no-zvz-before-check", "ZVZ does not run before the check", [f"{R}TI_03"], _with(NoTimerBeforeCheck)),
    _mutant("no-zvz-in-pair", "ZVZ does not run after a DLE", [f"{R}TI_04"], _with(NoTimerInPair)),
    _mutant("silent-gap", "leaves a broken block without NAK", [f"{R}TI_01"], _with(SilentGap)),
    _mutant("locks", "deaf after five refused blocks", [f"{R}BI_01", f"{R}BI_04", f"{R}RC_01"], _with(Locks)),
    _mutant("garbage-kills", "deaf after twenty stray characters", [f"{R}RC_03"], _with(GarbageKills)),
    _mutant("tail-opens", "02h in the rest of a refused block opens one", [f"{R}BI_07"], _with(TailOpens)),
    _mutant("empty-hangs", "an empty block makes it deaf", [f"{R}CA_02"], _with(EmptyHangs)),
    _mutant("every-25th", "refuses every 25th good block", [f"{R}ST_01"], _with(EveryTenth)),
    _mutant("dle-in-idle", "answers DLE in idle with DLE", [f"{R}BO_04"], _with(DleInIdle)),
    _mutant("stray-opens", "any character in idle opens a block", [f"{R}BO_01"], _with(StrayOpens)),
    _mutant("answers-nak", "answers NAK in idle", [f"{R}BO_02"], _with(AnswersNak)),
    _mutant("break-unheard", "takes a block with a BREAK inside", [f"{R}BI_10"], BreakUnheard),
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
    _mutant("own-check-wrong", "its own check is wrong", [f"{S}BV_02"], lambda: Built(says=wrong_own_check)),
    _mutant("check-without-end", "its check leaves out DLE ETX", [f"{S}BV_02"], lambda: Built(says=check_without_end)),
    _mutant("no-check", "sends no check", [f"{S}BV_02"], lambda: Built(says=no_check)),
    _mutant("no-end", "its block does not end", [f"{S}BV_01"], lambda: Built(says=no_end)),
    _mutant(
        "dead-after-power", "does not work after a power failure", ["3964R_SUP_RC_01"], lambda: Powered(lambda: Built(RHO3, LOW), False)
    ),
    _mutant("every-second-stx", "answers one STX of two", [f"{R}BV_01"], lambda: EverySecondStx(RHO3, LOW)),
    _mutant("naks-first-stx", "NAK to each STX, DLE to its repeat", [f"{R}BV_01"], lambda: NaksFirstStx(RHO3, LOW)),
    _mutant("dle-twice", "acknowledges with two DLE", [f"{R}BV_02"], DleTwice),
    _mutant("nak-opens", "answers NAK in idle with STX, and sends nothing", [f"{R}BO_02"], lambda: NakOpens(RHO3, LOW)),
    _mutant("deaf-after-nak", "deaf for 1 s after NAK", ["3964R_SEQ_RC_01"], lambda: DeafAfter(BlockRefused, ms(1000))),
    _mutant("deaf-after-own", "deaf for 100 ms after its own block", ["3964R_SEQ_BO_01"], lambda: DeafAfter(BlockSent, ms(100))),
    _mutant("nak-twice", "refuses with two NAK", ["3964R_SEQ_BI_01"], NakTwice),
    _mutant("wedges", "sends no more after many jobs in a row", ["3964R_SND_ST_01"], WedgesInARow),
    _mutant("flips-priority", "a conflict changes its priority", [f"{C}ST_01", f"{C}BV_03"], lambda: FlipsPriority(RHO3, LOW)),
    _mutant("extra-character", "a carriage return after its block", [f"{S}BV_02"], lambda: Built(says=extra)),
    _mutant("repeat-check", "the check of a repeated block is wrong", [f"{S}BV_05"], _with(sender=RepeatCheck)),
    _mutant("connect-check", "the check counts a repeated STX", [f"{S}BV_04"], _with(sender=ConnectCheck)),
    _mutant("keeps-connects", "connection attempts are not counted anew", [f"{S}RC_02"], _with(sender=KeepsConnects)),
    _mutant("keeps-blocks", "block attempts are not counted anew", [f"{S}RC_03", f"{S}BI_09"], _with(sender=KeepsBlocks)),
    _mutant("short-repeats", "a repeated STX waits 120 ms", [f"{S}TI_04"], _with(sender=ShortRepeats)),
    _mutant("clash-check", "its check is wrong after it gave way", [f"{C}BV_04"], ClashCheck),
    _mutant("drops-when-corrupted", "a corrupted block in a conflict loses its job", [f"{C}BI_02"], DropsWhenCorrupted),
    _mutant("answers-old-stx", "answers the STX of a conflict after its block", [f"{C}BO_01"], AnswersOldStx, HIGH),
    _mutant("naks-later", "NAK 220 ms after a good block", ["3964R_SEQ_BO_02"], lambda: NaksLater(BlockReceived)),
    _mutant("naks-after-own", "NAK 220 ms after its own block", ["3964R_SEQ_BO_03"], lambda: NaksLater(BlockSent)),
    _mutant("false-end", "10h 03h in its data ends a block", [f"{R}BV_20"], _with(receiver=FalseEnd)),
    _mutant("answers-inside", "answers 02h in the data with DLE", [f"{R}BV_10", f"{R}BV_19"], _with(receiver=AnswersInside)),
    _mutant("no-zero-first", "refuses a block that begins with 00", [f"{R}BV_19"], lambda: Built(layer="raw", receiver=NoZeroFirst)),
    _mutant("pair-keeps-timer", "ZVZ does not restart after a pair", [f"{R}TI_05"], _with(receiver=PairKeepsTimer)),
    _mutant("impatient", "an acknowledgement 300 ms after its block is too late", [f"{S}TI_05"], _with(sender=ImpatientForAcknowledge)),
    _mutant("twice-after-conflict", "a job that gave way is sent twice", [f"{C}BO_02"], _with(sender=TwiceAfterConflict)),
    _mutant("reaction-check", "the check of its reactions is wrong", [f"{S}BV_06"], lambda: Built(says=wrong_reaction_check)),
    _mutant("echoes", "each character is returned", [f"{R}BV_01"], Echoes),
    _mutant("long-check", "does not look at the check of a long block", [f"{R}BI_11"], _with(LongCheck)),
    _mutant("deaf-after-gap", "deaf for 1 s after a block that broke off", [f"{R}RC_02"], lambda: DeafAfterGap(RHO3, LOW)),
    _mutant("hasty-repeats", "a repeated block waits 200 ms", [f"{S}TI_06"], _with(sender=HastyRepeats)),
    _mutant("patient-at-last", "the last repeat of a block waits 2.5 s", [f"{S}TI_06"], _with(sender=PatientAtLast)),
    _mutant("short-after-stx", "loses a character after a repeated STX", [f"{S}BI_11"], _with(sender=ShortAfterStx)),
    _mutant("nak-brings-again", "NAK in idle brings its last block again", [f"{S}BO_04"], lambda: NakBringsAgain(RHO3, LOW)),
    _mutant("prolongs", "our STX prolongs its QVZ", [f"{C}TI_01"], _with(sender=Prolongs, priority=HIGH), HIGH),
    _mutant("fewer-attempts", "a job that gave way has fewer attempts", [f"{C}RC_01"], _with(sender=FewerAttempts)),
    _mutant("third-conflict", "each third conflict loses the job", [f"{C}ST_01"], _with(sender=ThirdConflict)),
    _mutant("changes-third", "changes a block from its second repeat on", [f"{S}BV_05"], _with(sender=ChangesThird)),
    _mutant("from-the-beginning", "QVZ runs from the beginning of a block", [f"{S}TI_07"], _with(sender=FromTheBeginning)),
    _mutant("drops-all", "gives up all jobs with the one that failed", [f"{S}RC_04"], _with(sender=DropsAll)),
    _mutant("ascii-acknowledges", "06h acknowledges its block", [f"{S}BI_07"], _with(sender=AsciiAcknowledges)),
    _mutant("ascii-connects", "06h after STX lets it send", [f"{S}BI_03"], _with(sender=AsciiConnects)),
    _mutant("damage-ends", "NAK at once at a damaged character, the rest opens a block", [f"{R}BI_12"], _with(DamageEnds)),
    _mutant("naks-gap-twice", "two NAK for a block that broke off", ["3964R_SEQ_BI_02"], _with(NaksGapTwice)),
    _mutant("zvz-after-power", "ZVZ 500 ms after a power failure", ["3964R_SUP_BV_01"], _changed(char_delay=ms(500))),
    _mutant("qvz-after-power", "QVZ 250 ms after a power failure", ["3964R_SUP_BV_02"], _changed(ack_delay=ms(250))),
    _mutant(
        "high-after-power", "has priority after a power failure", ["3964R_SUP_BV_02"], lambda: other_after_power(lambda: Built(RHO3, HIGH))
    ),
)


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
    _variant("very-slow", "CP 341 that answers STX after 212 ms", SIEMENS_CP341, make=lambda: AnswersLate(SIEMENS_CP341, late=ms(212))),
    _variant("chatty", "sends every 2 s", make=Chatty),
    _variant("chatty-high", "sends every 2 s, with priority", priority=HIGH, make=lambda: Chatty(RHO3, HIGH)),
    _variant("active", "an RK512 station with jobs of its own", make=ActiveStation),
    _variant("raw", "raw blocks, no RK512", make=lambda: Built(layer="raw")),
    _variant("powered", "its supply can be switched", make=lambda: Powered(lambda: Built(RHO3, LOW))),
    _variant("read-only", "nothing may be written", touch=False),
    _variant("no-wait", "rho 3 that answers NAK at once without a buffer", make=_profile(no_buffer_wait=0)),
    _variant("crowded", "three jobs of its own in a row", make=Crowded),
    _variant("hurried", "RK512 commands that do not wait for reactions", make=Hurried),
    _variant("naks-second-dle", "NAK to the second of two DLE", make=NaksSecondDle),
    _variant("long-blocks", "takes 1024 characters", make=lambda: Built(replace(RHO3, max_received=1024))),
)
