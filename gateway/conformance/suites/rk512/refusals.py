"""RK512, passive side: refusals, what must have no after-effects, and what the station serves after a disturbance."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from gateway.conformance.suites.line import NAK, LineTester
from gateway.conformance.suites.rk512.passive import BASIC, PAS, READ_BACK, REFUSES, WRITE, WRITES, borrowed, compared
from gateway.conformance.suites.rk512.telegrams import (
    DB,
    FETCH,
    SEND,
    NoReaction,
    ask,
    db_of,
    fetch,
    header,
    number_words,
    own_numbers,
    reaction,
    read,
    refused,
    room,
    saved,
    write,
)
from gateway.pure.conformance.purpose import Particulars
from gateway.pure.conformance.verdict import Fail, Inconclusive, NotApplicable, Warn
from protocols.base.machine import ms
from protocols.p3964r.characters import Char, wire_block

__all__ = ["PAS"]  # the registry finds the complete group here

CYCLES = 40
SUITS_BOTH = (0x16, 0x10, 0x14, 0x0A)  # some maker has it for one of both
OWN = "RK512_PAS_BI_"
EARLY = Particulars(early=True)  # it judges an error number
FOREIGN = 7  # byte 1 is neither 00 nor FF


@PAS.case(
    "BI_01",
    "a command that cannot be executed is refused with a number and four bytes",
    "ein nicht ausführbarer Befehl wird mit einer Nummer und vier Bytes abgelehnt",
    clause="serial-protocols 2.4",
)
def is_refused(t: LineTester) -> None:
    found = ask(t, header(0x51, DB, t.setup.db, 0, 1))
    if found.number == 0 or found.data:
        raise Fail(f"byte 3 is 51h: {found.words()}", "00 00 00 and an error number, no data", found.words())
    other = ask(t, fetch(t.setup.missing, 0, 1))
    if other.number == found.number and found.number not in (*SUITS_BOTH, *own_numbers(t)):
        what = f"a wrong command and a missing block are refused with the same misleading number: {number_words(found.number)}"
        raise Fail(what, f"{number_words(0x16)}; {number_words(0x14)}", found.words())


def _refusal(
    number: int, name: str, summary: str, german: str, telegram: Callable[[LineTester], bytes], wanted: int, others: tuple[int, ...]
) -> None:
    @PAS.case(
        f"BI_{number:02}",
        f"{summary}: refused with {wanted:02X}h",
        f"{german}: mit {wanted:02X}h abgelehnt",
        clause="serial-protocols 2.4",
        preamble=(BASIC, REFUSES),
        beside=EARLY,
    )
    def body(t: LineTester) -> None:
        with _may_be_silent(number):
            refused(t, f"{OWN}{number:02}", name, telegram(t), wanted, others)


@contextmanager
def _may_be_silent(number: int) -> Iterator[None]:
    """A block that begins with neither 00 nor FF may count as no command: silence is WARN (AX-1781)."""
    try:
        yield
    except NoReaction as failed:
        if number == FOREIGN:
            raise Warn("not answered; other makers refuse it with 10h", "10h: header error", failed.got) from failed
        raise


def _missing(t: LineTester) -> int:
    if ask(t, fetch(t.setup.missing, 0, 1)).number == 0:
        raise NotApplicable(f"DB{t.setup.missing} exists; missing_db in [link] names one that does not")
    return t.setup.missing


_ROWS: tuple[tuple[str, str, str, Callable[[LineTester], bytes], int, tuple[int, ...]], ...] = (
    (
        "missing_block",
        "FETCH of a block that does not exist",
        "FETCH eines Bausteins, den es nicht gibt",
        lambda t: fetch(t.setup.missing, 0, 1),
        0x14,
        (0x0A,),
    ),
    (
        "missing_block_send",
        "SEND to a block that does not exist",
        "SEND in einen Baustein, den es nicht gibt",
        lambda t: header(SEND, DB, _missing(t), 0, 1) + b"\0\0",
        0x14,
        (0x0A,),
    ),
    (
        "behind_the_end",
        "words beyond the end of the block",
        "Wörter hinter dem Ende des Bausteins",
        lambda t: fetch(t.setup.db, (t.setup.size or 256) - 1, 2),
        0x14,
        (0x0A, 0x34),
    ),
    (
        "wrong_command",
        "byte 3 is not one of A, O, E",
        "Byte 3 ist weder A noch O noch E",
        lambda t: header(0x51, DB, t.setup.db, 0, 1),
        0x16,
        (0x10,),
    ),
    ("wrong_type", "byte 4 names no type", "Byte 4 nennt keinen Typ", lambda t: header(FETCH, 0x71, t.setup.db, 0, 1), 0x0C, (0x10, 0x12)),
    (
        "wrong_byte_1",
        "byte 1 is neither 00 nor FF",
        "Byte 1 ist weder 00 noch FF",
        lambda t: b"\x55" + fetch(t.setup.db, 0, 1)[1:],
        0x10,
        (0x36, 0x16),
    ),
    (
        "follow_on_alone",
        "a follow-on telegram without a first one",
        "ein Folgetelegramm ohne ein erstes",
        lambda t: b"\xff\x00\x45\x44",
        0x36,
        (0x10,),
    ),
    ("short_header", "a header of nine bytes", "ein Kopf von neun Bytes", lambda t: fetch(t.setup.db, 0, 1)[:9], 0x34, (0x10,)),
    (
        "data_behind_fetch",
        "FETCH with data after the header",
        "FETCH mit Daten hinter dem Kopf",
        lambda t: fetch(t.setup.db, 0, 1) + b"\0\0",
        0x34,
        (0x10,),
    ),
    ("amount_0", "an amount of 0", "eine Anzahl 0", lambda t: fetch(t.setup.db, 0, 0), 0x34, (0x10, 0x14)),
)
for _number, (_name, _summary, _german, _telegram, _wanted, _others) in enumerate(_ROWS, 2):
    _refusal(_number, _name, _summary, _german, _telegram, _wanted, _others)


def _refused(t: LineTester, case: str, name: str, telegram: bytes, number: int, others: tuple[int, ...]) -> Inconclusive | None:
    """Whether the refused command has an effect, even if another case has failed."""
    try:
        refused(t, case, name, telegram, number, others)
    except Inconclusive as ended:
        if not ended.caused_by:
            raise
        return ended
    return None


def _no_effect(number: int, name: str, summary: str, german: str, data: bytes, words: int) -> None:
    """A SEND that is refused for its length writes nothing; into a missing block where none may be written."""

    @PAS.case(
        f"BI_{number}",
        f"{summary}: 34h, and nothing is written",
        f"{german}: 34h, und nichts wird geschrieben",
        clause="serial-protocols 2.3",
        preamble=(BASIC, REFUSES),
        beside=EARLY,
    )
    def body(t: LineTester) -> None:
        case = f"{OWN}{number}"
        if not t.setup.write:
            refused(t, case, name, header(SEND, DB, _missing(t), 0, words) + data, 0x34, (0x10, 0x14, 0x0A))
            return
        with borrowed(t, 4) as db:
            before = saved(t, db, 0, 4)
            changed = bytes(byte ^ 0xFF for byte in before)
            try:
                known = _refused(t, case, name, header(SEND, DB, db, 0, words) + (changed + bytes(8))[: len(data)], 0x34, (0x10,))
            finally:
                t.settle(ms(100))
            compared(saved(t, db, 0, 4), before, "the block after a refused SEND")
            if known is not None:
                raise known


for _row in (
    (12, "send_too_short", "SEND that brings less than it announces", "SEND mit weniger Daten als angekündigt", bytes(2), 2),
    (13, "send_too_long", "SEND that brings more than it announces", "SEND mit mehr Daten als angekündigt", bytes(4), 1),
    (14, "send_odd", "SEND with an odd number of bytes", "SEND mit ungerader Anzahl Bytes", bytes(3), 2),
    (15, "send_no_data", "SEND without data", "SEND ohne Daten", b"", 1),
):
    _no_effect(*_row)


@PAS.case(
    "BI_16",
    "SEND beyond the end of the block is refused and writes nothing",
    "SEND hinter das Ende wird abgelehnt und schreibt nichts",
    condition=WRITE,
    preamble=(BASIC, WRITES),
    beside=EARLY,
)
def send_behind(t: LineTester) -> None:
    last = (t.setup.size or 256) - 1
    with borrowed(t, 2) as db:
        before, end = saved(t, db, 0, 2), ask(t, fetch(db, last, 1)).data
        telegram = header(SEND, DB, db, last, 2) + (b"\x5a\x5a" if end != b"\x5a\x5a" else b"\x3c\x3c") + b"\xa5\xa5"
        known = _refused(t, f"{OWN}16", "behind_the_end", telegram, 0x14, (0x0A, 0x34))
        compared(saved(t, db, 0, 2), before, "the block after a refused SEND")
        after = ask(t, fetch(db, last, 1)).data
        if after != end:
            write(t, db, last, end)
        compared(after, end, f"DB{db}.DW{last}, the last word, after a refused SEND")
        if known is not None:
            raise known


@PAS.case(
    "RC_05",
    "the number of a refusal is not in the next reaction",
    "die Nummer einer Ablehnung steht nicht in der nächsten Reaktion",
    condition=WRITE,
    preamble=(BASIC, WRITES, REFUSES),
)
def forgotten_number(t: LineTester) -> None:
    db = db_of(t)
    before = saved(t, db, 0, 1)
    for telegram in (header(0x51, DB, t.setup.db, 0, 1), fetch(t.setup.missing, 0, 1)):
        if ask(t, telegram).number:
            write(t, db, 0, before)
            t.settle(ms(100))


# ---- effects seen through the link
@PAS.case(
    "BO_01",
    "a command whose block is refused has no effect",
    "ein Auftrag, dessen Block abgelehnt wird, bleibt wirkungslos",
    condition=("block_check",),
    clause="serial-protocols 1.4",
)
def refused_command(t: LineTester) -> None:
    wire = wire_block(fetch(t.setup.db, 0, 1))
    t.connect()
    t.say(wire[:-1] + bytes((wire[-1] ^ 0x40,)))
    with t.given():
        if (got := t.answer(t.profile.ack_delay + t.tolerance)) != Char.NAK:
            t.fail("a wrong block check", got, "NAK (15h)")
    got = t.answer(t.setup.reaction_wait // 4)
    if got == Char.STX:
        said = t.serve()
        if said is not None and said[:3] in (b"\0\0\0", b"\xff\0\0"):
            raise Fail("a command with a wrong block check was executed", "no reaction", said.hex(" ").upper())


@PAS.case(
    "BO_02",
    "a refused SEND, then the same with a right check: written once",
    "ein abgelehnter SEND, dann derselbe mit richtiger Prüfung: einmal geschrieben",
    condition=("block_check", "write"),
    preamble=(BASIC, WRITES, READ_BACK),
)
def refused_send(t: LineTester) -> None:
    with borrowed(t, 1) as db:
        before = saved(t, db, 0, 1)
        changed = bytes(byte ^ 0x5A for byte in before)
        wire = wire_block(header(SEND, DB, db, 0, 1) + changed)
        t.connect()
        t.say(wire[:-1] + bytes((wire[-1] ^ 0x40,)))
        t.answer(t.profile.ack_delay)
        t.settle(ms(300))
        compared(saved(t, db, 0, 1), before, "the block after a SEND with a wrong block check")
        write(t, db, 0, changed)
        compared(saved(t, db, 0, 1), changed, "the block after the repeat")


@PAS.case(
    "BO_03",
    "a reaction answered with NAK is sent again, the same",
    "eine mit NAK beantwortete Reaktion kommt noch einmal, dieselbe",
    clause="serial-protocols 1.3",
)
def nak_to_reaction(t: LineTester) -> None:
    with t.given():
        t.good(fetch(t.setup.db, 0, room(t, 2)), "a command telegram")
        t.first_stx(t.setup.reaction_wait)
    first = t.take(acknowledge=False)
    t.say(NAK)
    got = t.answer(t.profile.retry_pause + ms(300))
    if got != Char.STX:
        t.fail("NAK to the reaction", got, "STX (02h)")
    again = t.take()
    compared(again.data, first.data, "the repeated reaction")


@PAS.case(
    "BO_04",
    "an unsolicited reaction is not answered",
    "eine Reaktion ohne Auftrag wird nicht beantwortet",
    clause="serial-protocols 2.6",
)
def unasked_reaction(t: LineTester) -> None:
    with t.given():
        t.good(bytes(4), "an unsolicited reaction")
    got = t.answer(ms(500))
    if got == Char.STX:
        said = t.serve()
        if said is not None and len(said) == 4 and said[:3] in (b"\0\0\0", b"\xff\0\0"):
            raise Warn("answers a reaction with a reaction", "nothing", said.hex(" ").upper())


@PAS.case(
    "BO_05",
    "a command while its reaction is on the way: the station stays usable",
    "ein Auftrag, während die Reaktion unterwegs ist: der Teilnehmer bleibt brauchbar",
    clause="serial-protocols 2.6",
)
def overtaken(t: LineTester) -> None:
    with t.given():
        t.good(fetch(t.setup.db, 0, 1), "a command telegram")
        t.first_stx(t.setup.reaction_wait)
    t.take(acknowledge=False)
    t.settle(t.profile.ack_delay + ms(300))
    read(t, t.setup.db, 0, 1)


@PAS.case(
    "BO_06",
    "a telegram of one byte is refused or ignored",
    "ein Telegramm aus einem Byte wird abgelehnt oder nicht beachtet",
    clause="serial-protocols 2.4",
)
def one_byte(t: LineTester) -> None:
    with t.given():
        t.good(b"\x55", "a telegram of one byte")
    t.settle(ms(500))
    read(t, t.setup.db, 0, 1)


@PAS.case(
    "TI_01",
    "the reaction comes within the reaction time",
    "die Reaktion kommt innerhalb der Reaktionszeit",
    clause="serial-protocols 2.2",
    beside=Particulars(limits="reaction_ms of the bench, 5 s without"),
)
def in_time(t: LineTester) -> None:
    for words in (1, room(t, 64)):
        with t.given():
            t.good(fetch(t.setup.db, 0, words), "a command telegram")
        start = t.mark
        got = t.answer(2 * t.setup.reaction_wait)
        if got != Char.STX:
            t.fail("an acknowledged command", got, "STX (02h)")
        took = t.mark - start
        with t.given():
            t.take()
        t.timed(f"STX of the reaction to a FETCH of {words} words", took, None, t.setup.reaction_wait)


@PAS.case("ST_01", f"{CYCLES} reads without a pause", f"{CYCLES} Lesezugriffe ohne Pause")
def reads(t: LineTester) -> None:
    for count in range(CYCLES):  # the link is judged as well: one that stumbles now and then is found here
        found = ask(t, fetch(t.setup.db, count % max(1, room(t, 32)), 1), judge_link=True)
        if found.number or len(found.data) != 2:
            raise Fail(f"read {count + 1}: {found.words()}", "00h and two bytes", found.words())


@PAS.case(
    "ST_02",
    f"{CYCLES // 2} writes, each read back",
    f"{CYCLES // 2} Schreibzugriffe, je zurückgelesen",
    condition=WRITE,
    preamble=(BASIC, WRITES, READ_BACK),
)
def writes(t: LineTester) -> None:
    with borrowed(t, 2) as db:
        for count in range(CYCLES // 2):
            data = bytes((count, 0xFF - count, 0x10, count * 7 & 0xFF))
            write(t, db, 0, data)
            compared(read(t, db, 0, 2), data, f"write {count + 1}")


@PAS.case(
    "RC_03",
    "after refusals of every kind the next job is served",
    "nach Ablehnungen aller Art wird der nächste Auftrag bedient",
    preamble=(BASIC, REFUSES),
)
def after_refusals(t: LineTester) -> None:
    for telegram in (header(0x51, DB, t.setup.db, 0, 1), fetch(t.setup.missing, 0, 1), b"\xff\x00\x45\x44", fetch(t.setup.db, 0, 1)[:9]):
        with t.given():
            t.good(telegram, "a wrong command")
        with suppress(Fail):  # refused, as late as it likes, or not answered: the other cases judge that
            reaction(t)
        t.settle(ms(300))
        try:
            read(t, t.setup.db, 0, 1)
        except Inconclusive as ended:
            raise Fail(f"after {telegram.hex(' ').upper()}: {ended.reason}", ended.expected, ended.got) from ended


@PAS.case(
    "RC_04",
    "after a reaction that was never acknowledged the next job is served",
    "nach einer nie quittierten Reaktion wird der nächste Auftrag bedient",
)
def unacknowledged(t: LineTester) -> None:
    with t.given():
        t.good(fetch(t.setup.db, 0, 1), "a command telegram")
        t.first_stx(t.setup.reaction_wait)
    got: int | object = Char.STX
    for _ in range(20):
        if got != Char.STX:
            break
        t.say(NAK)
        got = t.answer(t.profile.retry_pause + ms(250))
    t.settle()
    try:
        read(t, t.setup.db, 0, 1)
    except Inconclusive as ended:
        raise Fail(f"after a reaction that was abandoned: {ended.reason}", ended.expected, ended.got) from ended
