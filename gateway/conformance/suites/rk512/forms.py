"""The form of the blocks of reactions: doubled DLE, block check, end; one case finds it, the others name that case as their cause."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.line import BETWEEN, DLE, LineTester, named
from gateway.conformance.suites.rk512.telegrams import fetch, malformed, read, write
from gateway.pure.conformance.verdict import Ended, Fail
from protocols.base.machine import ms
from protocols.p3964r.characters import Char

FOLLOW_ON = b"\xff\0AD"  # without a first telegram: its reaction FF 00 00 36 has a block check above 7Fh
READS = 12  # words at different addresses, until doubled DLE and all bits of a check have been there
PLANTED = bytes.fromhex("5510 4110 1003 1010 1055 0210 0010 10ff")
PATTERNS = (b"\x10\x41", b"\x41\x10", b"\x10\x10", PLANTED, b"\x40\x43")  # at both ends, in pairs, alone; a block check of 10h


def judge_forms(t: LineTester, case: str) -> None:
    """Judged: the blocks of reactions, short and long, with the number 10h, and with 10h in the data where data may be written."""
    size = min(t.setup.words, t.setup.job)
    for word in range(min(READS, t.setup.words)):
        _judge(t, fetch(t.setup.db, word, 1), case)
    for telegram in (fetch(t.setup.db, 0, size), b"U\0ED", FOLLOW_ON):
        _judge(t, telegram, case)
    if not t.setup.write:
        return
    db = t.setup.write[0]
    for pattern in PATTERNS:
        words = len(pattern) // 2
        with _planted(t, db, pattern) as there:
            if there:
                _judge(t, fetch(db, 0, words), case)


@contextmanager
def _planted(t: LineTester, db: int, pattern: bytes) -> Iterator[bool]:
    """The words from DW0 on within the block; False: they cannot be written, which other cases judge."""
    before = b""
    with _unjudged(t), suppress(Ended):
        before = read(t, db, 0, len(pattern) // 2)
        write(t, db, 0, pattern)
    try:
        yield bool(before)
    finally:
        with _unjudged(t), suppress(Ended):
            t.settle(BETWEEN)
            if before:
                write(t, db, 0, before)


@contextmanager
def _unjudged(t: LineTester) -> Iterator[None]:
    judges, t.judges_form = t.judges_form, False
    try:
        yield
    finally:
        t.judges_form = judges


def _judge(t: LineTester, telegram: bytes, case: str) -> None:
    with t.given():
        t.good(telegram, "a command telegram")
    if t.answer(t.setup.reaction_wait) != Char.STX:
        return  # another case judges that
    try:
        _read(t)
    except Fail:
        t.setup.form_fault = case
        raise
    t.settle(BETWEEN)


def _read(t: LineTester) -> None:
    t.say(DLE)
    block = t.read()
    if block is None:
        raise malformed(t, "it breaks off", t.last(24))
    extra = t.answer(3 * t.wire.char_ns + ms(5))
    t.say(DLE)
    if block.fault:
        raise malformed(t, block.fault, hexed(block.raw))
    if extra is not None:
        raise malformed(t, f"{named(extra)} follows the block check", hexed(block.raw))
