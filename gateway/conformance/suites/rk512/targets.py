"""RK512, passive side: targets of a job (DX, amounts, locked jobs), and after-effects of an abandoned one (serial-protocols 2.1, 2.5)."""

from gateway.conformance.suites.line import LineTester
from gateway.conformance.suites.rk512.passive import (
    BASIC,
    READ_BACK,
    REFUSES,
    WRITE,
    WRITES,
    borrowed,
    compared,
    pattern,
    send_in_pieces,
    served_again,
)
from gateway.conformance.suites.rk512.telegrams import (
    DB,
    DX_SEND,
    FETCH,
    SEND,
    Reaction,
    ask,
    db_of,
    fetch,
    header,
    number_words,
    read,
    refused,
    room,
    saved,
    write,
)
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable
from protocols.base.machine import ms
from protocols.p3964r.characters import Char, wire_block

PAS = Purposes[LineTester]("RK512_PAS", "passive", "serial-protocols 2", condition=("passive",), preamble=(BASIC,))
DX = 0x58
FLAG = b"\x06\x04"  # flag 6.4, no CPU
LOCKED = 0x32
LONG_SEND = "RK512_PAS_BV_17"
MANY = 257  # words: one, if the high byte of the amount is lost


@PAS.case(
    "BV_18",
    "DX and the data block of the same number are two blocks",
    "DX und der Datenbaustein gleicher Nummer sind zwei Bausteine",
    clause="serial-protocols 2.1",
    condition=WRITE,
    preamble=(BASIC, WRITES, READ_BACK),
)
def other_blocks(t: LineTester) -> None:
    """DX gets the word that it has; where it cannot be read, one that differs from the word of the data block."""
    with borrowed(t, 1) as db:
        before = saved(t, db, 0, 1)
        there = ask(t, header(FETCH, DX, db, 0, 1))
        readable = there.number == 0 and len(there.data) == 2
        if readable and there.data == before:
            _is_another_block(t, db, before)
            raise NotApplicable(f"DX{db} and DB{db} hold the same words")
        word = there.data if readable else bytes(byte ^ 0x5A for byte in before)
        found = ask(t, header(DX_SEND, DX, db, 0, 1) + word)
        t.remark(f"SEND to DX: {number_words(found.number)}")
        if saved(t, db, 0, 1) == word:
            raise Fail(f"SEND to DX{db}.DW0 was written to DB{db}.DW0", before.hex(" ").upper(), word.hex(" ").upper())


def _is_another_block(t: LineTester, db: int, word: bytes) -> None:
    """Data written to the data block must not appear in DX."""
    other = bytes(byte ^ 0x5A for byte in word)
    with t.given():
        write(t, db, 0, other)
    there = ask(t, header(FETCH, DX, db, 0, 1))
    if there.number == 0 and there.data == other:
        raise Fail(f"FETCH of DX{db} brings the words of DB{db}: types X and D are one", word.hex(" ").upper(), there.words())


@PAS.case(
    "BI_21",
    "a follow-on SEND without a first one is refused and writes nothing",
    "ein Folge-SEND ohne ersten wird abgelehnt und schreibt nichts",
    clause="serial-protocols 2.3",
    condition=WRITE,
    preamble=(BASIC, REFUSES, WRITES, READ_BACK),
)
def lone_send(t: LineTester) -> None:
    """After a complete SEND: a station that keeps its place writes there, others at the beginning."""
    words = room(t, 16)
    if words < 4:
        raise NotApplicable(f"DB{t.setup.db} has {t.setup.words} words")
    with borrowed(t, words) as db:
        before = saved(t, db, 0, words)
        with t.given():
            write(t, db, 0, before[:4])
        found = ask(t, b"\xff\0" + bytes((SEND, DB)) + bytes(byte ^ 0xFF for byte in before[4:8]))
        after = saved(t, db, 0, words)
        if after != before:
            raise Fail("a follow-on SEND without a first one was written", before.hex(" ").upper(), after.hex(" ").upper())
        if not found.number:
            raise Fail("a follow-on SEND without a first one is acknowledged", number_words(0x36), found.words())


@PAS.case(
    "BI_17",
    "both bytes of the amount count: 257 words are not 1",
    "beide Bytes der Anzahl zählen: 257 Wörter sind nicht 1",
    clause="serial-protocols 2.1",
    preamble=(BASIC, REFUSES),
)
def high_amount(t: LineTester) -> None:
    found = ask(t, header(FETCH, DB, t.setup.db, 0, MANY))
    if found.number == 0 and len(found.data) == 2:
        raise Fail(f"FETCH of {MANY} words brings one word", "a refusal, or 128 bytes and follow-on telegrams", found.words())
    if found.number == 0 and len(found.data) != 128:
        raise Fail(f"FETCH of {MANY} words brings {len(found.data)} bytes", "a refusal, or 128 bytes", found.words())
    served_again(t, f"a FETCH of {MANY} words")


@PAS.case(
    "BI_18",
    "a SEND that announces 257 words and brings 1 is refused and writes nothing",
    "ein SEND mit angekündigten 257 Wörtern und einem gesandten wird abgelehnt und schreibt nichts",
    clause="serial-protocols 2.3",
    condition=WRITE,
    preamble=(BASIC, WRITES, REFUSES),
)
def high_amount_send(t: LineTester) -> None:
    with borrowed(t, 1) as db:
        before = saved(t, db, 0, 1)
        found = ask(t, header(SEND, DB, db, 0, MANY) + bytes(byte ^ 0xFF for byte in before))
        served_again(t, f"a SEND that announces {MANY} words")
        compared(saved(t, db, 0, 1), before, f"DB{db}.DW0 after a SEND that announces {MANY} words and brings 1")
        if found.number == 0:
            raise Fail(f"a SEND that announces {MANY} words and brings 1 is acknowledged", "34h: length wrong", found.words())


@PAS.case(
    "RC_06",
    "what an abandoned SEND brought is not in the next one",
    "was ein abgebrochener SEND brachte, steht nicht im nächsten",
    clause="serial-protocols 2.3",
    condition=WRITE,
    preamble=(BASIC, WRITES, READ_BACK, LONG_SEND),
)
def after_abandoned(t: LineTester) -> None:
    words = room(t, 100)
    if words <= 64:
        raise NotApplicable(f"the block has {words} words for this bench")
    with borrowed(t, words) as db:
        send_in_pieces(t, db, pattern(words, 0x7001), first_only=True)
        found = header(SEND, DB, db, 0, words) + pattern(words)[:128]
        said = ask(t, found)
        if said.number:  # 36h once is allowed: a follow-on telegram was due
            said = ask(t, found)
        if said.number:
            raise Fail(f"a long SEND after one that was abandoned: {said.words()}", "00h, or 36h once", said.words())
        _rest(t, db, pattern(words))
        compared(saved(t, db, 0, words), pattern(words), f"{2 * words} bytes sent after an abandoned SEND")


def _rest(t: LineTester, db: int, content: bytes) -> None:
    """The follow-on telegrams of a SEND whose first piece was acknowledged."""
    for at in range(128, len(content), 128):
        said = ask(t, bytes((0xFF, 0, SEND, DB)) + content[at : at + 128])
        if said.number or said.data:
            raise Fail(f"piece of a long SEND to DB{db}: {said.words()}", "FF 00 00 00", said.words())


# ---- amounts and places
@PAS.case(
    "ST_03",
    "FETCH of every amount, from even and odd words, brings what single words bring",
    "FETCH jeder Anzahl, ab geraden und ungeraden Wörtern, bringt dasselbe wie einzelne Wörter",
    preamble=(BASIC, "RK512_PAS_BV_02"),
)
def every_amount(t: LineTester) -> None:
    """Where the bench allows it, in a block whose words all differ."""
    if not t.setup.write:
        _amounts(t, t.setup.db)
        return
    words = t.setup.words
    with borrowed(t, words) as db:
        for at in range(0, words, t.setup.job):
            write(t, db, at, pattern(words)[2 * at : 2 * (at + t.setup.job)])
        _amounts(t, db)


def _amounts(t: LineTester, db: int) -> None:
    """The first, the middle and the last word of each job are compared with the word alone."""
    single: dict[int, bytes] = {}
    for amount in range(2, min(t.setup.job, t.setup.words, 64) + 1):
        start = amount * 7 % (t.setup.words - amount + 1)
        got = read(t, db, start, amount)
        for at in sorted({0, amount // 2, amount - 1}):
            word, part = start + at, got[2 * at : 2 * at + 2]
            if word not in single:
                single[word] = read(t, db, word, 1)
            if part != single[word]:
                what = f"FETCH DB{db}.DW{start}, {amount} words: DW{word} alone is not the same"
                raise Fail(what, single[word].hex(" ").upper(), part.hex(" ").upper())


@PAS.case(
    "BV_19",
    "the same data sent to two places are at both",
    "dieselben Daten, an zwei Stellen gesendet, stehen an beiden",
    condition=WRITE,
    preamble=(BASIC, WRITES, READ_BACK),
)
def two_places(t: LineTester) -> None:
    words = room(t, 4)
    if words < 4:
        raise NotApplicable(f"the block has {words} words for this bench")
    with borrowed(t, 4) as db:
        write(t, db, 0, pattern(4, 0x2102))
        for word in (0, 2):
            write(t, db, word, b"\x5a\x3c\x69\x96")
        compared(read(t, db, 0, 4), b"\x5a\x3c\x69\x96" * 2, f"DB{db}.DW0, 4 words after two SENDs of the same data")


EXTREMES = (0x0000, 0xFFFF, 0x8000, 0x7FFF, 0x00FF, 0xFF00, *(1 << bit for bit in range(16)))


@PAS.case(
    "BV_20",
    "0000h, FFFFh, 8000h, 7FFFh and each single bit read back as written",
    "0000h, FFFFh, 8000h, 7FFFh und jedes einzelne Bit werden gelesen, wie sie geschrieben wurden",
    condition=WRITE,
    preamble=(BASIC, WRITES, READ_BACK),
)
def extremes(t: LineTester) -> None:
    words = room(t, len(EXTREMES))
    with borrowed(t, words) as db:
        for at in range(0, len(EXTREMES), words):
            data = b"".join(value.to_bytes(2, "big") for value in EXTREMES[at : at + words])
            write(t, db, 0, data)
            compared(read(t, db, 0, len(data) // 2), data, f"DB{db}.DW0, {len(data) // 2} words")


# ---- blocks that break off
@PAS.case(
    "BO_07",
    "a FETCH that breaks off before its end is not executed",
    "ein vor dem Ende abgebrochener FETCH wird nicht ausgeführt",
    clause="serial-protocols 1.4",
)
def broken_off_fetch(t: LineTester) -> None:
    wire = wire_block(fetch(t.setup.db, 0, 1), t.profile.block_check)
    for left in (1, 3):
        t.connect()
        t.say(wire[:-left])
        got = t.answer(2 * t.profile.char_delay + ms(500))  # the suite 3964r judges the NAK
        if got != Char.STX:
            got = t.answer(t.setup.reaction_wait // 4)
        said = t.serve() if got == Char.STX else None
        if said is not None and said[:3] in (b"\0\0\0", b"\xff\0\0"):
            raise Fail(f"a FETCH without its last {left} characters was executed", "no reaction", said.hex(" ").upper())


@PAS.case(
    "BO_08",
    "a SEND that breaks off before its end writes nothing",
    "ein vor dem Ende abgebrochener SEND schreibt nichts",
    clause="serial-protocols 1.4",
    condition=WRITE,
    preamble=(BASIC, WRITES, READ_BACK, "RK512_PAS_BO_07"),
)
def broken_off_send(t: LineTester) -> None:
    with borrowed(t, 1) as db:
        before = saved(t, db, 0, 1)
        wire = wire_block(header(SEND, DB, db, 0, 1) + bytes(byte ^ 0x5A for byte in before), t.profile.block_check)
        for left in (1, 3):
            t.connect()
            t.say(wire[:-left])
            t.answer(2 * t.profile.char_delay + ms(500))
            t.settle(ms(300))
            compared(saved(t, db, 0, 1), before, f"the block after a SEND without its last {left} characters")


# ---- coordination flags
def _locked(t: LineTester) -> Reaction:
    """A FETCH sets the flag, or finds it set: the reaction to the second one."""
    telegram = header(FETCH, DB, t.setup.db, 0, 1, FLAG)
    first = ask(t, telegram)
    if first.number not in (0, LOCKED):
        raise NotApplicable(f"serves no coordination flags: {number_words(first.number)}")
    return ask(t, telegram)


@PAS.case(
    "CA_08",
    "a job whose coordination flag is set is refused with 32h",
    "ein Auftrag, dessen Koordinierungsmerker gesetzt ist, wird mit 32h abgelehnt",
    clause="serial-protocols 2.5",
    condition=("flags",),
    preamble=(BASIC, "RK512_PAS_CA_07"),
)
def locks(t: LineTester) -> None:
    found = _locked(t)
    if found.number != LOCKED:
        raise Fail(f"flag 6.4 was set by the job before: {found.words()}", number_words(LOCKED), found.words())
    if found.data:
        raise Fail(f"{len(found.data)} data bytes after 32h", "4 bytes", found.words())


@PAS.case(
    "BI_19",
    "a SEND that is refused with 32h writes nothing",
    "ein mit 32h abgelehnter SEND schreibt nichts",
    clause="serial-protocols 2.5",
    condition=("flags", "write"),
    preamble=(BASIC, WRITES, READ_BACK, "RK512_PAS_CA_08"),
)
def locked_send(t: LineTester) -> None:
    with borrowed(t, 1) as db:
        before = saved(t, db_of(t), 0, 1)
        with t.given():
            _locked(t)
        found = ask(t, header(SEND, DB, db, 0, 1, FLAG) + bytes(byte ^ 0xFF for byte in before))
        if found.number != LOCKED:
            raise Fail(f"a SEND whose flag is set: {found.words()}", number_words(LOCKED), found.words())
        compared(saved(t, db, 0, 1), before, f"DB{db}.DW0 after a SEND refused with 32h")


@PAS.case(
    "BI_20",
    "byte 3 is e, F or 7Fh: refused with 16h",
    "Byte 3 ist e, F oder 7Fh: mit 16h abgelehnt",
    clause="serial-protocols 2.4",
    preamble=(BASIC, "RK512_PAS_BI_05"),
    beside=Particulars(early=True),
)
def near_commands(t: LineTester) -> None:
    for command in (0x65, 0x46, 0x7F):
        refused(t, "RK512_PAS_BI_20", "wrong_command", header(command, DB, t.setup.db, 0, 1), 0x16, (0x10,))


@PAS.case("BV_12", "a header that holds 10h three times", "ein Kopf, der dreimal 10h enthält", clause="serial-protocols 1.2, vector 9")
def header_with_dle(t: LineTester) -> None:
    found = ask(t, fetch(16, 16, 16))
    if found.number == 0 and len(found.data) != 32:
        raise Fail(f"{len(found.data)} data bytes, expected 32", "32 data bytes", found.words())
    if found.number not in (0, 0x14, 0x0A) and found.number != ask(t, fetch(t.setup.missing, 0, 1)).number:
        raise Fail(
            f"FETCH DB16.DW16, 16 words: {number_words(found.number)}: the header was not read as sent", "00h, 14h or 0Ah", found.words()
        )


@PAS.case("BV_13", "two reads bring the same, and one reaction each", "zwei Lesezugriffe bringen dasselbe, je eine Reaktion")
def one_reaction(t: LineTester) -> None:
    first = read(t, t.setup.db, 0, room(t, 4))
    got = t.answer(t.tolerance + ms(150))
    if got == Char.STX:
        again = t.serve()
        if again is not None and again == bytes(4) + first:
            raise Fail("the reaction was sent twice", "one reaction", again.hex(" ").upper())
    elif got is not None:
        t.fail("an acknowledged reaction", got, "nothing")
    read(t, t.setup.db, 0, room(t, 4))
