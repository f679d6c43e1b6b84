"""RK512, the station is passive: jobs, contents, follow-on telegrams, refusals (serial-protocols 2.1 to 2.5)."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from gateway.conformance.suites.line import LineTester
from gateway.conformance.suites.rk512.forms import PLANTED, judge_forms
from gateway.conformance.suites.rk512.telegrams import (
    DB,
    FETCH,
    SEND,
    Reaction,
    ask,
    db_of,
    fetch,
    header,
    misleading,
    number_words,
    read,
    restored,
    room,
    saved,
    write,
)
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Ended, Fail, NotApplicable, Warn
from protocols.p3964r.characters import Char

BASIC = "RK512_PAS_BV_01"
WRITES, READ_BACK, LONG, REFUSES = "RK512_PAS_BV_04", "RK512_PAS_BV_05", "RK512_PAS_BV_14", "RK512_PAS_BI_01"
PAS = Purposes[LineTester]("RK512_PAS", "passive", "serial-protocols 2", condition=("passive",), preamble=(BASIC,))
WRITE = ("write",)


def pattern(words: int, start: int = 0x0103) -> bytes:
    """Words no two of which are equal, nor equal with their bytes exchanged."""
    return b"".join(((start + 0x0305 * at) & 0xFFFF).to_bytes(2, "big") for at in range(words))


@contextmanager
def borrowed(t: LineTester, words: int, word: int = 0) -> Iterator[int]:
    """A block that may be written; its content is written back."""
    db = db_of(t)
    before = saved(t, db, word, words)
    try:
        yield db
    except Ended:
        with suppress(Ended):  # the finding counts, not a failed clean-up after it
            restored(t, db, word, before)
        raise
    restored(t, db, word, before)


# ---- jobs
@PAS.case(
    "BV_01",
    "FETCH of one word: reaction 00 00 00 00 and two bytes",
    "FETCH eines Worts: Reaktion 00 00 00 00 und zwei Bytes",
    clause="serial-protocols 2.2",
    preamble=(),
)
def one_word(t: LineTester) -> None:
    found = ask(t, fetch(t.setup.db, 0, 1), judge_link=True)
    if found.number or len(found.data) != 2 or found.raw[0]:  # FF: of a follow-on telegram
        raise Fail(f"FETCH DB{t.setup.db}.DW0, 1 word: {found.words()}", "00 00 00 00 and two bytes", found.words())


FORM = "RK512_PAS_BV_21"


@PAS.case(
    "BV_21",
    "the blocks of its reactions follow the rule: DLE doubled, block check right",
    "die Blöcke seiner Reaktionen folgen der Regel: DLE verdoppelt, Blockprüfung richtig",
    clause="serial-protocols 1.2",
)
def reaction_forms(t: LineTester) -> None:
    judge_forms(t, FORM)


@PAS.case(
    "BV_02",
    "FETCH of 2, 3 and 64 words: as many bytes as asked",
    "FETCH von 2, 3 und 64 Wörtern: so viele Bytes wie verlangt",
    clause="serial-protocols 2.2",
)
def many_words(t: LineTester) -> None:
    if t.setup.words < 2:
        raise NotApplicable(f"DB{t.setup.db} has {t.setup.words} word")
    for words in sorted({min(2, t.setup.words), min(3, t.setup.words), room(t, 32)}):
        read(t, t.setup.db, 0, words)
    if t.setup.words >= 16 and room(t, 32) >= 16:
        found = ask(t, fetch(t.setup.db, 0, 16))
        if found.number or len(found.data) != 32:
            raise Fail(
                f"FETCH of 16 words, whose header contains 10h (doubled on the line): {found.words()}", "00h and 32 bytes", found.words()
            )
    words = min(64, t.setup.words)
    found = ask(t, fetch(t.setup.db, 0, words))
    if found.number in NO_FOLLOW_ON and not found.data:
        raise Warn(f"{words} words in one job: {number_words(found.number)}; others serve 64", "00h", found.words())
    if found.number or len(found.data) != 2 * words:
        raise Fail(f"FETCH of {words} words: {found.words()}", f"00h and {2 * words} bytes", found.words())


@PAS.case(
    "BV_03",
    "the words that the bench knows come as they are, high byte first",
    "die der Prüfumgebung bekannten Wörter kommen unverändert, High-Byte zuerst",
    condition=("known",),
)
def known(t: LineTester) -> None:
    found = False
    for name, value in t.setup.known.items():
        block, dot, word = name.upper().removeprefix("DB").partition(".DW")
        if not dot or not block.isdecimal() or not word.isdecimal():
            continue
        found = True
        got = read(t, int(block), int(word), max(1, len(value) // 2))
        if got != value:
            raise Fail(f"{name}: {got.hex(' ').upper()}, known is {value.hex(' ').upper()}", value.hex(" ").upper(), got.hex(" ").upper())
    if not found:
        raise NotApplicable("[known] names no data word")


@PAS.case(
    "BV_04",
    "SEND of one word: reaction of four bytes, 00",
    "SEND eines Worts: Reaktion aus vier Bytes, 00",
    condition=WRITE,
    clause="serial-protocols 2.2",
)
def send(t: LineTester) -> None:
    db = db_of(t)
    before = saved(t, db, 0, 1)
    write(t, db, 0, before)


def compared(got: bytes, wanted: bytes, what: str) -> None:
    if got == wanted:
        return
    why = ""
    if got == b"".join(wanted[at + 1 : at + 2] + wanted[at : at + 1] for at in range(0, len(wanted), 2)):
        why = ": the bytes of each word are exchanged"
    elif got == wanted[::-1]:
        why = ": in reverse order"
    raise Fail(f"{what} reads back differently{why}", wanted[:64].hex(" ").upper(), got[:64].hex(" ").upper())


@PAS.case(
    "BV_05",
    "what SEND wrote FETCH reads, asymmetric words",
    "was SEND schrieb, liest FETCH, unsymmetrische Wörter",
    condition=WRITE,
    preamble=(BASIC, WRITES),
)
def read_back(t: LineTester) -> None:
    words = room(t, 16)
    with borrowed(t, words) as db:
        for start, count in ((0x0103, words), (0x8001, words - (words > 2))):  # an even and an odd number
            write(t, db, 0, pattern(count, start))
            compared(read(t, db, 0, count), pattern(count, start), f"DB{db}.DW0, {count} words")


@PAS.case(
    "BV_06",
    "SEND of 64 words reads back whole",
    "SEND von 64 Wörtern kommt ganz zurück",
    condition=WRITE,
    preamble=(BASIC, WRITES, READ_BACK),
)
def read_back_long(t: LineTester) -> None:
    words = room(t, 64)
    with borrowed(t, words) as db:
        found = ask(t, header(SEND, DB, db, 0, words) + pattern(words), judge_link=True)
        if found.number or found.data:
            raise Fail(f"SEND of {words} words: {found.words()}", "00h, 0 data bytes", found.words())
        compared(read(t, db, 0, words), pattern(words), f"DB{db}.DW0, {words} words")


@PAS.case(
    "BV_07",
    "one word by several addresses: DW n is word n of a longer job",
    "ein Wort unter mehreren Adressen: DW n ist Wort n eines längeren Auftrags",
    condition=WRITE,
    preamble=(BASIC, WRITES, READ_BACK),
)
def by_address(t: LineTester) -> None:
    words = room(t, 8)
    with borrowed(t, words) as db:
        write(t, db, 0, pattern(words))
        for word in range(words):
            compared(read(t, db, word, 1), pattern(words)[2 * word : 2 * word + 2], f"DB{db}.DW{word} alone")
        if words >= 4:
            write(t, db, 2, b"\xa5\x3c")
            wanted = pattern(words)[:4] + b"\xa5\x3c" + pattern(words)[6:]
            compared(read(t, db, 0, words), wanted, f"DB{db}.DW0, {words} words after SEND of DW2 alone")


@PAS.case(
    "BV_08",
    "the last word of the block is its own: numbers are not cut to fewer bits",
    "das letzte Wort ist ein eigenes: Nummern werden nicht gekürzt",
    condition=WRITE,
    preamble=(BASIC, WRITES, READ_BACK),
)
def aliased_words(t: LineTester) -> None:
    last = t.setup.words - 1
    places = sorted({0, *(place for place in (1, 2, 16, 32, 64, last) if place <= last)})
    db = db_of(t)
    before = {place: saved(t, db, place, 1) for place in places}
    try:
        for place in places:
            write(t, db, place, bytes((0x40 + place % 64, place)))
        for place in places:
            compared(read(t, db, place, 1), bytes((0x40 + place % 64, place)), f"DB{db}.DW{place}")
    finally:
        with suppress(Ended):
            for place, data in before.items():
                restored(t, db, place, data)


@PAS.case(
    "BV_09",
    "a SEND to one block leaves the others alone",
    "ein SEND in einen Baustein lässt die anderen unberührt",
    condition=WRITE,
    preamble=(BASIC, WRITES),
)
def aliased_blocks(t: LineTester) -> None:
    db = db_of(t)
    others: dict[int, bytes] = {}
    for number in sorted({*t.setup.write, 5, 11, 16, (db + 1) % 256, db ^ 0x80, db ^ 0x10} - {db}):
        found = ask(t, fetch(number, 0, 1))
        if found.number == 0 and len(found.data) == 2:
            others[number] = found.data
    if not others:
        raise NotApplicable("no other data block can be read")
    with borrowed(t, 1):
        write(t, db, 0, b"\x5a\x0f" if b"\x5a\x0f" not in others.values() else b"\x2d\x96")
        for number, before in others.items():
            compared(read(t, number, 0, 1), before, f"DB{number}.DW0 after a SEND to DB{db}")


@PAS.case(
    "BV_10",
    "10h in the data comes back whole, alone and in pairs",
    "10h in den Daten kommt unverändert zurück, einzeln und in Paaren",
    condition=WRITE,
    preamble=(BASIC, FORM, WRITES, READ_BACK),
    clause="serial-protocols 1.2",
)
def planted(t: LineTester) -> None:
    words = room(t, 8)
    with borrowed(t, words) as db:
        write(t, db, 0, PLANTED[: 2 * words])
        compared(read(t, db, 0, words), PLANTED[: 2 * words], f"DB{db}.DW0 with 10h in it")


@PAS.case(
    "BV_11",
    "reactions whose block check is 10h, 03h, 15h and 02h are whole",
    "Reaktionen mit der Blockprüfung 10h, 03h, 15h und 02h sind vollständig",
    condition=WRITE,
    preamble=(BASIC, FORM, WRITES, READ_BACK),
    clause="serial-protocols 1.2",
)
def check_of_reaction(t: LineTester) -> None:
    with borrowed(t, 1) as db:
        for value in (0x10, 0x03, 0x15, 0x02):
            data = bytes((0x40, 0x40 ^ value ^ 0x13))
            write(t, db, 0, data)
            compared(read(t, db, 0, 1), data, f"a word whose reaction has the block check {value:02X}h")
            got = t.answer(t.tolerance)
            if got not in (None, Char.STX):
                t.fail(f"a reaction whose block check is {value:02X}h", got, "nothing")


# ---- capabilities
def _type(number: int, kind: int) -> None:
    what = chr(kind)

    @PAS.case(
        f"CA_{number:02}",
        f"FETCH of type {what}: served with as many bytes as asked, or refused with a number",
        f"FETCH vom Typ {what}: bedient mit der verlangten Länge, oder mit Nummer abgelehnt",
        clause="serial-protocols 2.1",
        preamble=(BASIC, REFUSES),
        beside=Particulars(early=True),  # it judges an error number
    )
    def body(t: LineTester) -> None:
        unit = 2 if kind in b"TZX" else 1
        block = t.setup.db if kind == 0x58 else 0
        for amount in (1, 3):
            found = ask(t, header(FETCH, kind, block, 0, amount))
            if found.number == 0 and len(found.data) != unit * amount:
                wanted = f"{unit * amount} {'byte' if unit * amount == 1 else 'bytes'}"
                raise Fail(f"{amount} of type {what}: {len(found.data)} data bytes, expected {unit * amount}", wanted, found.words())
            if found.number == 0 and t.setup.pics.get(f"type_{what}") is False:
                raise Fail(f"type {what} is served although the PICS excludes it", "a refusal", found.words())
            if found.number:
                _number_of_type(t, f"RK512_PAS_CA_{number:02}", what, found)


def _number_of_type(t: LineTester, case: str, what: str, found: Reaction) -> None:
    number, size, words = found.number, len(found.data), found.words()
    if size:
        raise Fail(f"{size} data bytes after error {number:02X}h", "4 bytes", words)
    if t.setup.pics.get(f"type_{what}") is True:
        raise Fail(f"type {what} is refused with {number_words(number)} although the PICS lists it as served", "00h: no error", words)
    if number not in (0x0A, 0x0C, 0x10, 0x12, 0x14) and not _own_number(t, "type", number):
        reason = f"type {what} is refused with a misleading number: {number_words(number)}"
        raise misleading(t, case, number, reason, "12h: type not supported", words)
    t.remark(f"not served: {number_words(number)}")


def _own_number(t: LineTester, name: str, number: int) -> bool:
    stated = t.setup.pics.get("errors")
    own = stated.get(name) if isinstance(stated, dict) else None
    return isinstance(own, str) and int(own, 16) == number


for _number, _kind in enumerate(b"EAMTZX", 1):
    _type(_number, _kind)


@PAS.case("CA_07", "a coordination flag: served, or 32h", "ein Koordinierungsmerker: bedient, oder 32h", clause="serial-protocols 2.5")
def flag(t: LineTester) -> None:
    found = ask(t, header(FETCH, DB, t.setup.db, 0, 1, b"\x06\x04"))
    stated = t.setup.pics.get("errors")
    if found.number == 0x2A and not (isinstance(stated, dict) and "2A" in stated.values()):
        raise Fail(f"refused with a misleading number: {number_words(found.number)}", "00h or 32h", found.words())
    if found.number not in (0, 0x32):
        raise Warn(f"{number_words(found.number)}, expected 00h or 32h", "00h or 32h", found.words())
    if found.number == 0 and len(found.data) != 2:
        raise Fail(f"{len(found.data)} data bytes, expected 2", "2 data bytes", found.words())


NO_FOLLOW_ON = (0x10, 0x12, 0x34)


def _long(t: LineTester, words: int) -> bytes:
    """A FETCH with follow-on telegrams."""
    if words > t.setup.words:
        raise NotApplicable(f"DB{t.setup.db} has {t.setup.words} words for this bench (words in [link])")
    found = ask(t, fetch(t.setup.db, 0, words))
    if found.number in NO_FOLLOW_ON and not found.data:
        raise NotApplicable(f"refused with {number_words(found.number)}: no follow-on telegrams, at most 128 bytes in a job")
    content = b""
    while True:
        due = min(128, 2 * words - len(content))
        if found.number or len(found.data) != due:
            raise Fail(f"piece of {len(found.data)} bytes with {found.number:02X}h, expected {due}", f"00h and {due} bytes", found.words())
        content += found.data
        if len(content) == 2 * words:
            return content
        found = ask(t, bytes((0xFF, 0, FETCH, DB)))


def _follow_on(number: int, words: int) -> None:
    @PAS.case(
        f"BV_{number}",
        f"FETCH of {2 * words} bytes in follow-on telegrams, the same as in single jobs",
        f"FETCH von {2 * words} Bytes in Folgetelegrammen, gleich wie in Einzelaufträgen",
        clause="serial-protocols 2.3",
        preamble=(BASIC,) if words == 65 else (BASIC, LONG),
    )
    def body(t: LineTester) -> None:
        content = _long(t, words)
        compared(content, saved(t, t.setup.db, 0, words), f"{2 * words} bytes in follow-on telegrams")


for _number, _words in ((14, 65), (15, 100), (16, 128)):
    _follow_on(_number, _words)


def send_in_pieces(t: LineTester, db: int, content: bytes, first_only: bool = False) -> None:
    found = ask(t, header(SEND, DB, db, 0, len(content) // 2) + content[:128])
    if found.number in NO_FOLLOW_ON and not found.data:
        raise NotApplicable(f"refused with {number_words(found.number)}: no follow-on telegrams")
    for at in range(128, len(content), 128):
        if found.number or found.data:
            raise Fail(f"piece of a long SEND: {found.words()}", "00 00 00 00", found.words())
        if first_only:
            return
        found = ask(t, bytes((0xFF, 0, SEND, DB)) + content[at : at + 128])
    if found.number or found.data:
        raise Fail(f"last piece of a long SEND: {found.words()}", "FF 00 00 00", found.words())


@PAS.case(
    "BV_17",
    "SEND in follow-on telegrams reads back whole",
    "SEND in Folgetelegrammen kommt ganz zurück",
    condition=WRITE,
    preamble=(BASIC, WRITES, READ_BACK),
    clause="serial-protocols 2.3",
)
def send_long(t: LineTester) -> None:
    words = room(t, 100)
    if words <= 64:
        raise NotApplicable(f"the block has {words} words for this bench")
    with borrowed(t, words) as db:
        send_in_pieces(t, db, pattern(words))
        compared(saved(t, db, 0, words), pattern(words), f"{2 * words} bytes sent in follow-on telegrams")


@PAS.case(
    "RC_01",
    "a SEND whose follow-on never comes does not lock the station",
    "ein SEND ohne Folgetelegramm sperrt den Teilnehmer nicht",
    condition=WRITE,
    preamble=(BASIC, WRITES),
    clause="serial-protocols 2.3",
)
def abandoned_send(t: LineTester) -> None:
    words = room(t, 100)
    if words <= 64:
        raise NotApplicable(f"the block has {words} words for this bench")
    with borrowed(t, words) as db:
        send_in_pieces(t, db, saved(t, db, 0, words), first_only=True)
        served_again(t, "a SEND that was abandoned")


def served_again(t: LineTester, after: str) -> None:
    """The next job is served, at the latest the second one: the first may be refused with 36h."""
    for attempt in range(2):
        found = ask(t, fetch(t.setup.db, 0, 1))
        if found.number == 0 and len(found.data) == 2:
            return
        if attempt or found.number != 0x36:
            raise Fail(f"after {after}: {found.words()}", "00h, or 36h once", found.words())
    raise Fail(f"after {after}: no job is served", "00h", "36h twice")


@PAS.case(
    "RC_02",
    "a FETCH whose follow-on is not asked for does not lock the station",
    "ein FETCH ohne Abruf der Folgetelegramme sperrt den Teilnehmer nicht",
    clause="serial-protocols 2.3",
)
def abandoned_fetch(t: LineTester) -> None:
    if t.setup.words < 100 or t.setup.job < 64:
        raise NotApplicable(f"the block has {t.setup.words} words for this bench")
    found = ask(t, fetch(t.setup.db, 0, 100))
    if found.number:
        raise NotApplicable(f"refused with {number_words(found.number)}: no follow-on telegrams")
    served_again(t, "a FETCH that was abandoned")
