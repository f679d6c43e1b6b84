"""RK512 on the link: FETCH, SEND, follow-on telegrams and every error number a passive station must show (serial-protocols 2 and 6).

It writes only where --write allows it, and writes the former values back.  A number that another source uses for the same fault is a WARN,
not a FAIL: the tables of the makers differ (AX-053).
"""

from dataclasses import dataclass

from gateway.conformance.case import Case, Cases
from gateway.conformance.serial.bench import Bench, Fail, NotRun, Warn, named
from gateway.pure.lines.texts import said
from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char
from protocols.rk512.header import REACTION_BYTES, ErrorNumber

SEND, FETCH, DX_SEND = 0x41, 0x45, 0x4F
TYPE_DB = 0x44
NO_FLAG = b"\xff\xff"
WORDS_OF_A_TELEGRAM = 64
PLANTED = bytes.fromhex("5510 4110 1003 1010 1055 0210 0010 10ff")  # 10h alone, in pairs, before 41h, ETX and 00h


@dataclass(frozen=True, slots=True)
class Place:
    """The permitted area: a data block that exists, from which word on, how many words; missing: one that does not exist."""

    db: int = 10
    word: int = 0
    words: int = 128
    missing: int = 99
    write: bool = False
    reaction: Ns = ms(5000)


def header(command: int, kind: int, db: int, word: int, amount: int, flag: bytes = NO_FLAG) -> bytes:
    """A command telegram's ten bytes, right or wrong."""
    return bytes((0, 0, command, kind, db, word)) + amount.to_bytes(2, "big") + flag


def ask(bench: Bench, place: Place, telegram: bytes) -> bytes:
    """The reaction telegram to a command."""
    bench.give_good(telegram, "a command telegram")
    start, got = bench.mark, bench.answer(place.reaction)
    if got is None:
        raise Fail(said("no reaction telegram within {:.0f} s", place.reaction / 1e9))
    if got != Char.STX:
        raise Fail(said("after a command telegram: {}, expected the STX of the reaction", named(got)))
    bench.measured("STX of the reaction", bench.mark - start, None)
    reaction = bench.take()
    if len(reaction) < 4 or reaction[0] not in (0x00, 0xFF) or reaction[1:3] != b"\x00\x00":
        raise Fail(said("reaction {}: 00 (or FF) 00 00 and an error number expected", reaction.hex(" ")))
    return reaction


def number_expected(bench: Bench, place: Place, telegram: bytes, number: int, others: tuple[int, ...] = ()) -> None:
    """The command is refused with this number."""
    reaction = ask(bench, place, telegram)
    found = reaction[3]
    if found == 0:
        raise Fail(said("executed (00h), expected refusal {:02X}h", number))
    if len(reaction) > 4:
        raise Fail(said("error {:02X}h with {} data bytes after it, none may follow", found, len(reaction) - 4))
    if found != number:
        text = said("refused with {:02X}h ({}), expected {:02X}h ({})", found, words_of(found), number, words_of(number))
        raise Warn(text) if found in others or found in known_numbers() else Fail(said("{}; {:02X}h is in no table", text, found))


def known_numbers() -> tuple[int, ...]:
    """Numbers some maker's table has."""
    return tuple(number.value for number in list(ErrorNumber) if number)


def words_of(number: int) -> str:
    """An error number in words."""
    return ERROR_WORDS.get(number, "a number outside the tables")


ERROR_WORDS = {
    0x00: "no error",
    0x0A: "access to the area not possible or not allowed",
    0x0C: "data type not valid",
    0x10: "header error, or follow-on telegrams not supported",
    0x12: "type not supported",
    0x14: "block missing or too short",
    0x16: "command (byte 3) wrong",
    0x2A: "partner CPU in STOP",
    0x32: "locked by coordination flag",
    0x34: "length wrong",
    0x36: "sequence: follow-on without a first telegram",
}


def cases(place: Place) -> list[Case]:
    """The list for a station at which `place` may be touched."""
    found = Cases("rk512")
    _jobs(found, place)
    _planted(found, place)
    _refusals(found, place)
    _amounts(found, place)
    return found.all


def _fetch(place: Place, words: int) -> bytes:
    return header(FETCH, TYPE_DB, place.db, place.word, words)


def _jobs(found: Cases, place: Place) -> None:
    most = min(place.words, WORDS_OF_A_TELEGRAM)

    @found.case("fetch", said("FETCH of one word and of {} words ({} bytes): error number 00 and as many bytes", most, 2 * most))
    def fetch(bench: Bench) -> None:
        for words in sorted({1, most}):
            reaction = ask(bench, place, _fetch(place, words))
            if reaction[3]:
                raise Fail(
                    said("FETCH DB {} DW {}, {} words: {:02X}h ({})", place.db, place.word, words, reaction[3], words_of(reaction[3]))
                )
            if len(reaction) != 4 + 2 * words:
                raise Fail(said("FETCH of {} words brought {} bytes, expected {}", words, len(reaction) - 4, 2 * words))

    @found.case("send", "SEND writes back what FETCH read; the reaction is 4 bytes with 00")
    def send(bench: Bench) -> None:
        _need_write(place)
        read = ask(bench, place, _fetch(place, most))
        if read[3] or len(read) != REACTION_BYTES + 2 * most:
            raise NotRun(said("nothing is written: FETCH of the same {} words was answered {}", most, read[:16].hex(" ")))
        reaction = ask(bench, place, header(SEND, TYPE_DB, place.db, place.word, most) + read[REACTION_BYTES:])
        if reaction[3] or len(reaction) != REACTION_BYTES:
            raise Fail(said("SEND of {} words: reaction {}, expected 00 00 00 00", most, reaction.hex(" ")))

    @found.case("header-with-10h", "a header that holds 10h three times (FETCH DB 16 DW 16, 16 words)")
    def header_with_dle(bench: Bench) -> None:
        reaction = ask(bench, place, header(FETCH, TYPE_DB, 16, 16, 16))
        if reaction[3] == 0 and len(reaction) != 4 + 32:
            raise Fail(said("{} bytes, expected 32", len(reaction) - 4))
        if reaction[3] not in (0, ErrorNumber.BLOCK, ErrorNumber.NOT_ALLOWED):
            raise Fail(said("{:02X}h ({}): the header was not read as it was sent", reaction[3], words_of(reaction[3])))

    @found.case("flag", "a coordination flag in bytes 9 and 10")
    def flag(bench: Bench) -> None:
        reaction = ask(bench, place, header(FETCH, TYPE_DB, place.db, place.word, 1, b"\x06\x04"))
        if reaction[3] not in (0, ErrorNumber.LOCKED):
            raise Warn(said("{:02X}h ({}), expected 00h or 32h", reaction[3], words_of(reaction[3])))
        bench.remark("executed: the flag was free or is not checked" if not reaction[3] else "32h: locked, or flags are not served")


def _planted(found: Cases, place: Place) -> None:
    @found.case("send-10h", "10h written into the block comes back whole: the station doubles every DLE it sends")
    def send_dle(bench: Bench) -> None:
        _need_write(place)
        words = min(place.words, len(PLANTED) // 2)
        before = ask(bench, place, _fetch(place, words))[4:]
        if len(before) != 2 * words:
            raise Fail(said("FETCH of {} words brought {} bytes, expected {}", words, len(before), 2 * words))
        try:
            _write(bench, place, PLANTED[: 2 * words])
            back = ask(bench, place, _fetch(place, words))[4:]
            if back != PLANTED[: 2 * words]:
                raise Fail(said("{} was written, {} came back", PLANTED[: 2 * words].hex(" "), back.hex(" ")))
        finally:
            bench.swallow(bench.profile.ack_delay + ms(300))
            _write(bench, place, before)


def _write(bench: Bench, place: Place, content: bytes) -> None:
    """Words that only this case may place there."""
    reaction = ask(bench, place, header(SEND, TYPE_DB, place.db, place.word, len(content) // 2) + content)
    if reaction[3] or len(reaction) != 4:
        raise Fail(said("SEND of {} words: reaction {}, expected 00 00 00 00", len(content) // 2, reaction.hex(" ")))


def _need_write(place: Place) -> None:
    if not place.write:
        raise NotRun("writes into the station; allowed with --write")


def _refusals(found: Cases, place: Place) -> None:
    numbers = (
        ("missing-block", "a block that does not exist", header(FETCH, TYPE_DB, place.missing, 0, 1), 0x14, (0x0A,)),
        ("missing-block-send", "SEND to a block that does not exist", header(SEND, TYPE_DB, place.missing, 0, 1) + b"\0\0", 0x14, (0x0A,)),
        ("behind-the-end", "words beyond the end of the block", header(FETCH, TYPE_DB, place.db, 255, 2), 0x14, (0x0A, 0x34)),
        ("wrong-command", "byte 3 is not one of A, O, E", header(0x51, TYPE_DB, place.db, 0, 1), 0x16, (0x10,)),
        ("wrong-type", "byte 4 names no type", header(FETCH, 0x71, place.db, 0, 1), 0x0C, (0x10, 0x12)),
        ("wrong-byte-1", "byte 1 is neither 00 nor FF", b"\x55" + header(FETCH, TYPE_DB, place.db, 0, 1)[1:], 0x10, (0x36,)),
        ("follow-on-alone", "a follow-on telegram without a first one", b"\xff\x00\x45\x44", 0x36, (0x10,)),
        ("short-header", "a header of 9 bytes", header(FETCH, TYPE_DB, place.db, 0, 1)[:9], 0x34, (0x10,)),
        ("data-behind-fetch", "FETCH with data after the header", header(FETCH, TYPE_DB, place.db, 0, 1) + b"\0\0", 0x34, (0x10,)),
        ("send-too-short", "SEND that brings less than it announces", header(SEND, TYPE_DB, place.missing, 0, 2) + b"\0\0", 0x34, (0x14,)),
        ("send-too-long", "SEND that brings more than it announces", header(SEND, TYPE_DB, place.missing, 0, 1) + bytes(4), 0x34, (0x14,)),
        ("send-odd", "SEND with an odd number of bytes", header(SEND, TYPE_DB, place.missing, 0, 1) + b"\0", 0x34, (0x14,)),
        ("amount-0", "an amount of 0", header(FETCH, TYPE_DB, place.db, 0, 0), 0x34, (0x10, 0x14)),
    )
    for name, title, telegram, number, others in numbers:
        _refusal(found, place, name, said("{}: {:02X}h", title, number), telegram, number, others)


def _refusal(found: Cases, place: Place, name: str, title: str, telegram: bytes, number: int, others: tuple[int, ...]) -> None:
    def run(bench: Bench) -> None:
        if telegram[2] == SEND and not ask(bench, place, header(FETCH, TYPE_DB, place.missing, 0, 1))[3]:
            raise NotRun(said("DB {} is there, a SEND would write into it; --missing-db names one that is not", place.missing))
        number_expected(bench, place, telegram, number, others)

    found.add(name, title, run)


def _amounts(found: Cases, place: Place) -> None:
    for words in (65, 128, 129):
        _follow_on(found, place, words)
    for kind in b"EAMTZX":
        _other_type(found, place, kind)


def _follow_on(found: Cases, place: Place, words: int) -> None:
    def run(bench: Bench) -> None:
        if words > place.words:
            raise NotRun(said("DB {} has {} words for the probe (--words)", place.db, place.words))
        reaction = ask(bench, place, _fetch(place, words))
        if reaction[3] in (ErrorNumber.HEADER, ErrorNumber.LENGTH, ErrorNumber.TYPE_NOT_SERVED) and len(reaction) == 4:
            bench.remark(said("refused with {:02X}h: no follow-on telegrams here, at most 128 bytes in a job", reaction[3]))
            return
        content = reaction[4:]
        while not reaction[3] and len(content) < 2 * words:
            if len(reaction) - 4 not in (min(128, 2 * words - len(content) + len(reaction) - 4),):
                raise Fail(said("a piece of {} bytes, expected 128", len(reaction) - 4))
            reaction = ask(bench, place, bytes((0xFF, 0, FETCH, TYPE_DB)))
            content += reaction[4:]
        if reaction[3] or len(content) != 2 * words:
            raise Fail(said("{} of {} bytes, last reaction {}", len(content), 2 * words, reaction[:4].hex(" ")))

    found.add(f"follow-on-{2 * words}", said("FETCH of {} bytes: follow-on telegrams, or refused as a whole", 2 * words), run)


def _other_type(found: Cases, place: Place, kind: int) -> None:
    def run(bench: Bench) -> None:
        amount = 1 if kind in b"TZX" else 3  # bytes: an odd count
        reaction = ask(bench, place, header(FETCH, kind, 0, 1, amount))
        expected = 4 + (2 * amount if kind in b"TZX" else amount)
        if reaction[3] == 0 and len(reaction) != expected:
            raise Fail(said("{} bytes, expected {}", len(reaction) - 4, expected - 4))
        if reaction[3] and (len(reaction) != 4 or reaction[3] not in known_numbers()):
            raise Fail(said("refused with {:02X}h and {} data bytes", reaction[3], len(reaction) - 4))
        bench.remark("served" if not reaction[3] else said("not served: {:02X}h ({})", reaction[3], words_of(reaction[3])))

    found.add(f"type-{chr(kind)}", said("FETCH of type {}: served, or refused with a number", chr(kind)), run)
