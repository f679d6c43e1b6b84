"""RK512 telegrams over the line tester: commands, reactions, error numbers."""

import contextlib
from dataclasses import dataclass

from gateway.conformance.framework.base import hexed
from gateway.conformance.serial.cases_rk512 import words_of
from gateway.conformance.suites.line import DLE, Block, LineTester
from gateway.pure.conformance.verdict import Ended, Fail, Inconclusive, NotApplicable, Warn
from protocols.base.machine import ms
from protocols.p3964r.characters import Char, wire_block

SEND, FETCH, DX_SEND = 0x41, 0x45, 0x4F
DB = 0x44
TYPES = b"DXEAMTZPBS"
NO_FLAG = b"\xff\xff"
WELL_FORMED = "each DLE doubled, DLE ETX, the exclusive or of all characters"
PIECE = 128  # data bytes of one telegram
MOST_FOREIGN = 6  # blocks that are not a reaction, before one counts as missing


@dataclass(frozen=True, slots=True)
class Reaction:
    """A reaction telegram; number: byte 4."""

    raw: bytes

    @property
    def number(self) -> int:
        return self.raw[3]

    @property
    def data(self) -> bytes:
        return self.raw[4:]

    def words(self) -> str:
        return f"{self.raw[:20].hex(' ').upper()} ({number_words(self.number)}, {len(self.data)} data bytes)"


def number_words(number: int) -> str:
    """An error number in hex and words."""
    return f"{number:02X}h: {words_of(number)}"


def header(command: int, kind: int, db: int, word: int, amount: int, flag: bytes = NO_FLAG) -> bytes:
    """A command telegram's ten bytes, right or wrong."""
    return bytes((0, 0, command, kind, db, word)) + amount.to_bytes(2, "big") + flag


def fetch(db: int, word: int, words: int) -> bytes:
    return header(FETCH, DB, db, word, words)


def is_command(block: bytes) -> bool:
    return len(block) >= 4 and block[0] in (0, 0xFF) and block[2] in (SEND, FETCH, DX_SEND)


def meant_as_command(block: bytes) -> bool:
    """Built like one, whatever its first two bytes are."""
    return is_command(block) or (len(block) >= 10 and block[2] in (SEND, FETCH, DX_SEND) and block[3] in TYPES)


def right_reaction(command: bytes) -> bytes:
    """The reaction of a good passive station, with zeros for data."""
    size = size_of(command) if command[2] == FETCH else 0
    return bytes((command[0], 0, 0, 0)) + bytes(min(size, PIECE))


def size_of(command: bytes) -> int:
    """Bytes of the complete job, which a command telegram announces; 0 without a complete header."""
    if len(command) < 10:
        return 0
    amount = int.from_bytes(command[6:8], "big")
    return amount if command[3] in b"EAM" else 2 * amount


def finish(t: LineTester, command: bytes) -> None:
    """Continue a job longer than one telegram after the right reaction: each follow-on telegram gets its own (serial-protocols 2.1)."""
    left = size_of(command) - PIECE
    while left > 0 and t.answer(t.setup.reaction_wait) == Char.STX:
        with t.given():
            piece = t.take().data
            if piece[:1] != b"\xff" and is_command(piece):  # it gave this job up
                t.good(right_reaction(piece), "the right reaction")
                return
            data = bytes(min(left, PIECE)) if command[2] == FETCH else b""
            t.good(b"\xff\0\0\0" + data, "the right reaction to a follow-on telegram")
        left -= PIECE


def ask(t: LineTester, telegram: bytes, judge_link: bool = False) -> Reaction:
    """The reaction to a command.  The link below is judged by its own suite: its failures are INCONC here."""
    if judge_link:
        t.open()
        t.say(wire_block(telegram, t.profile.block_check))
        t.expect(Char.DLE, t.profile.ack_delay, "a command telegram")
    else:
        with t.given():
            t.good(telegram, "a command telegram")
    return reaction(t, judge_link)


class NoReaction(Fail):
    """Nothing, or blocks of its own only."""


def reaction(t: LineTester, judge_link: bool = True) -> Reaction:
    """The reaction that is due; other blocks are served and named."""
    foreign: list[bytes] = []
    for _ in range(MOST_FOREIGN):
        start = t.mark
        got = t.answer(t.setup.reaction_wait + t.tolerance)
        if got is None:
            break
        if got != Char.STX:
            with contextlib.nullcontext() if judge_link else t.given():
                t.fail("an acknowledged command telegram", got, "STX (02h) of the reaction")
        t.timed("STX of the reaction", t.mark - start, None, None)
        block = well_formed(t)
        if looks_like_reaction(block.data):
            return Reaction(block.data)
        if is_command(block.data):
            serve_command(t, block.data)
        foreign.append(block.data)
    said = "; ".join(block[:12].hex(" ").upper() for block in foreign) or "nothing"
    raise NoReaction(
        f"no reaction telegram within {t.setup.reaction_wait / 1e9:.1f} s; the station reported: {said}",
        "a reaction: 00 or FF, 00 00, error number",
        said,
    )


def well_formed(t: LineTester) -> Block:
    """The block whose STX was received.  A wrong form is one FAIL: the finding of the case for the form is the cause of the others."""
    if not t.judges_form:
        return t.take()
    t.say(DLE)
    block = t.read()
    if block is None:
        raise malformed(t, "it breaks off", t.last(24))
    t.say(DLE)
    if block.fault:
        raise malformed(t, block.fault, hexed(block.raw))
    return block


def malformed(t: LineTester, fault: str, got: str) -> Ended:
    reason = f"the block of its reaction is not well formed: {fault}"
    if t.setup.form_fault:
        return Inconclusive(reason, WELL_FORMED, got, t.setup.form_fault)
    return Fail(reason, WELL_FORMED, got)


def looks_like_reaction(block: bytes) -> bool:
    """00 or FF, then 00 00: the rest is judged."""
    return len(block) >= 4 and block[0] in (0, 0xFF) and block[1] == 0 and block[2] == 0


def serve_command(t: LineTester, command: bytes) -> None:
    """Answer a command of the station with its reaction."""
    t.notes.unasked += 1
    with t.given():
        t.good(right_reaction(command), "the reaction to its own command")
    finish(t, command)


def normal(t: LineTester, telegram: bytes, size: int, what: str) -> bytes:
    """Executed, with that many data bytes."""
    found = ask(t, telegram)
    if found.number:
        raise Fail(f"{what}: refused with {number_words(found.number)}", "00h: no error", found.words())
    if len(found.data) != size:
        raise Fail(f"{what}: {len(found.data)} data bytes, expected {size}", f"{size} data bytes", found.words())
    return found.data


def read(t: LineTester, db: int, word: int, words: int) -> bytes:
    return normal(t, fetch(db, word, words), 2 * words, f"FETCH DB{db}.DW{word}, {words} {'word' if words == 1 else 'words'}")


def write(t: LineTester, db: int, word: int, data: bytes) -> None:
    words = len(data) // 2
    normal(t, header(SEND, DB, db, word, words) + data, 0, f"SEND DB{db}.DW{word}, {words} {'word' if words == 1 else 'words'}")


def stated_numbers(t: LineTester) -> dict[str, int]:
    """The device's own error numbers by name, as stated in the PICS."""
    stated = t.setup.pics.get("errors")
    return {name: int(own, 16) for name, own in stated.items() if isinstance(own, str)} if isinstance(stated, dict) else {}


def own_numbers(t: LineTester) -> set[int]:
    """All of them."""
    return set(stated_numbers(t).values())


def misleading(t: LineTester, case: str, number: int, reason: str, wanted: str, got: str) -> Ended:
    """One misleading number is one FAIL, in the first case that meets it; the others name that case."""
    first = t.setup.misleading.setdefault(number, case)
    return Fail(reason, wanted, got) if first == case else Inconclusive(reason, wanted, got, first)


def refused(t: LineTester, case: str, name: str, telegram: bytes, number: int, others: tuple[int, ...] = ()) -> None:
    """The command is refused; another number of the same meaning is WARN, a misleading one FAIL unless the PICS names it."""
    found = ask(t, telegram)
    own = stated_numbers(t).get(name)
    wanted = f"{number_words(number)}"
    if found.number == 0:
        raise Fail(f"executed, expected refusal with {wanted}", wanted, found.words())
    if found.data:
        raise Fail(f"{len(found.data)} data bytes after error {found.number:02X}h, none may follow", "4 bytes", found.words())
    if found.number in (number, own):
        return
    if found.number in others:
        raise Warn(f"refused with {number_words(found.number)}; the tables of the makers differ", wanted, found.words())
    raise misleading(t, case, found.number, f"refused with a misleading number: {number_words(found.number)}", wanted, found.words())


def db_of(t: LineTester) -> int:
    """A block that may be written."""
    if not t.setup.write:
        raise NotApplicable("no data block may be written ([touch] db)")
    return t.setup.write[0]


def room(t: LineTester, words: int) -> int:
    """So many words, or as many as the block has."""
    return min(words, t.setup.words, t.setup.job if words <= 64 or t.setup.job < 64 else words)


def restored(t: LineTester, db: int, word: int, before: bytes) -> None:
    """Write the former content back, 64 words at a time, as long as the station accepts it."""
    t.settle(ms(100))
    for at in range(0, len(before), 2 * t.setup.job):
        with t.given():
            write(t, db, word + at // 2, before[at : at + 2 * t.setup.job])


def saved(t: LineTester, db: int, word: int, words: int) -> bytes:
    """The present content."""
    if db == t.setup.db and word + words > t.setup.words:
        raise NotApplicable(f"DB{db} has {t.setup.words} words; {words} from DW{word} on are needed")
    with t.given():
        step = t.setup.job
        return b"".join(read(t, db, word + at, min(step, words - at)) for at in range(0, words, step))
