"""The pure forms of a byte line: formats, PARMRK marks (termios(3)), drain, record."""

import pytest

from drivers.ports.serial.line_format import Drain, LineFormat, MarkReader, Note, Run, escape, mark, parse_format, parse_record
from protocols.base.errors import DecodeError
from protocols.base.machine import Damage

STREAM = b"AB\xff\xffC\xff\x00\x00D\xff\x00E\xff\x01F\xff\x02G\xff\xff"
ITEMS = [b"AB\xffC", Damage.BREAK, b"D", Damage.PARITY, Damage.FRAMING, Damage.OVERRUN, b"\xff"]


def joined(items: list[bytes | Damage]) -> list[bytes | Damage]:
    """Good runs that stand next to each other as one; empty ones left out."""
    result: list[bytes | Damage] = []
    for item in items:
        if isinstance(item, bytes) and result and isinstance(result[-1], bytes):
            result[-1] += item
        elif item != b"":
            result.append(item)
    return result


def test_marks_are_taken_apart_in_line_order() -> None:
    assert MarkReader().read(STREAM) == ITEMS


@pytest.mark.parametrize("cut", range(1, len(STREAM)))
def test_a_mark_torn_over_two_reads_is_the_same_mark(cut: int) -> None:
    reader = MarkReader()
    assert joined(reader.read(STREAM[:cut]) + reader.read(STREAM[cut:])) == ITEMS


def test_byte_by_byte_is_the_same() -> None:
    reader = MarkReader()
    assert joined([item for byte in STREAM for item in reader.read(bytes((byte,)))]) == ITEMS


def test_ff_that_its_writer_did_not_double_loses_nothing() -> None:
    assert joined(MarkReader().read(b"A\xffB")) == [b"A\xffB"]


def test_every_good_character_survives() -> None:
    every = bytes(range(256))
    assert joined(MarkReader().read(escape(every))) == [every]


@pytest.mark.parametrize("kind", list(Damage))
def test_every_damage_survives(kind: Damage) -> None:
    assert MarkReader().read(b"x" + mark(kind, 0x41) + b"y") == [b"x", kind, b"y"]


@pytest.mark.parametrize(
    ("text", "found", "char_bits"),
    [
        ("9600 8E1", LineFormat(9600, 8, "E", 1), 11),
        ("1200 7o2", LineFormat(1200, 7, "O", 2), 11),
        ("19200 8N1", LineFormat(19200, 8, "N", 1), 10),
        ("9600", LineFormat(9600), 11),
        ("0", LineFormat(0), 11),
    ],
)
def test_formats(text: str, found: LineFormat, char_bits: int) -> None:
    assert parse_format(text) == found
    assert parse_format(text).char_bits == char_bits


def test_a_character_of_9600_8e1_takes_1_146_ms_rounded_up() -> None:
    assert parse_format("9600 8E1").char_ns == 1_145_834
    assert parse_format("0").char_ns == 0


@pytest.mark.parametrize("text", ["", "fast", "9600 9E1", "9600 8M1", "9600 8E3", "-1"])
def test_an_unreadable_format_is_named(text: str) -> None:
    with pytest.raises(ValueError, match=f'line format "{text}"'):
        parse_format(text)


def test_drain_counts_characters_that_are_still_on_the_line() -> None:
    drain = Drain(1000)
    drain.took(3, 0)
    assert [drain.left(now) for now in (0, 999, 1000, 2999, 3000, 9000)] == [3, 3, 2, 1, 0, 0]
    drain.took(1, 9000)
    drain.took(1, 9500)
    assert [drain.left(now) for now in (9500, 10_000, 11_000)] == [2, 1, 0]


def test_a_record_comes_back_as_it_was_written() -> None:
    runs = [Run(5, "A", b"\x02"), Run(9, "B", b"\x10\xff", "lost"), Run(12, "A", b"\x01", "flip=03")]
    notes = [Note(7, "unplug"), Note(11, "damage from=A kind=flip next=1")]
    record = parse_record([runs[0].line(), notes[0].line(), runs[1].line(), notes[1].line(), runs[2].line()])
    assert (record.runs, record.notes) == (runs, notes)
    assert record.sent_by("A") == b"\x02\x01"
    assert record.characters() == 4
    assert record.between(6, 9) == [runs[1]]


def test_the_torn_last_line_of_a_killed_writer_is_left_out() -> None:
    assert parse_record(["5 A 02\n", "9 B 10"]).runs == [Run(5, "A", b"\x02")]


@pytest.mark.parametrize("line", ["x A 02\n", "5 C 02\n", "5 A 0\n", "5 A\n", "\n", "5 A 02 lost more\n"])
def test_a_line_that_does_not_fit_is_named(line: str) -> None:
    with pytest.raises(DecodeError, match="line 1"):
        parse_record([line])
