"""Records and journals are one trace; the journal's form is that of the test vectors; pcapng byte by byte."""

import struct

import pytest

from drivers.ports.serial.line_format import Run
from gateway.pure.lines.pcapng import payload, pcapng
from gateway.pure.lines.trace import Item, of_dialogue, of_runs, to_dialogue
from gateway.pure.lines.turns import Flag, Kind, Turn
from protocols.base.dialogue import Dialogue, Entry, parse, write
from protocols.base.errors import DecodeError
from protocols.base.machine import Damage, ms

RUNS = [
    Run(ms(1000), "A", b"\x02"),
    Run(ms(1005), "B", b"\x10"),
    Run(ms(1010), "A", b"AB"),
    Run(ms(1011), "A", b"C", "parity"),
    Run(ms(1012), "A", b"D", "lost"),
    Run(ms(1013), "A", b"\x10", "flip=11"),
    Run(ms(1014), "B", b"\x15", "drop"),
    Run(ms(1015), "A", b"\x00", "break"),
]
JOURNAL = """dialogue line-plc1
station side=B start_ns=1000000000
      0.000000  hears   02
      5.000000  says    10
     10.000000  hears   41 42
     11.000000  damaged PARITY
     13.000000  hears   11
     14.000000  says    15
     15.000000  damaged BREAK
"""


def test_a_record_becomes_the_journal_of_one_station() -> None:
    assert write([to_dialogue(of_runs(RUNS), "line-plc1")]) == JOURNAL


def test_the_other_station_said_what_this_one_heard() -> None:
    journal = to_dialogue(of_runs(RUNS), "line", side="A", settings={"profile": "rho3"})
    assert [(entry.verb, entry.what) for entry in journal.entries] == [
        ("says", "02"), ("hears", "10"), ("says", "41 42"), ("says", "43"), ("says", "44"), ("says", "10"), ("says", "00"),
    ]  # fmt: skip
    assert journal.station == {"profile": "rho3", "side": "A", "start_ns": "1000000000"}


def test_a_journal_is_read_back_as_written_and_as_a_trace() -> None:
    (dialogue,) = parse(JOURNAL)
    assert write([dialogue]) == JOURNAL
    assert of_dialogue(dialogue) == [
        Item(ms(1000), "A", b"\x02"),
        Item(ms(1005), "B", b"\x10"),
        Item(ms(1010), "A", b"AB"),
        Item(ms(1011), "A", b"", damage=Damage.PARITY),
        Item(ms(1013), "A", b"\x11"),
        Item(ms(1014), "B", b"\x15"),
        Item(ms(1015), "A", b"", damage=Damage.BREAK),
    ]


def test_reports_become_remarks_and_jobs_are_left_out() -> None:
    entries = [Entry(0, "reports", "Nothing before"), Entry(0, "does", "send 41"), Entry(0, "says", "02"), Entry(ms(1), "reports", "One"),
               Entry(ms(1), "reports", "Two")]  # fmt: skip
    assert of_dialogue(Dialogue("d", {"side": "A"}, entries), ms(7)) == [Item(ms(7), "A", b"\x02", remark="One; Two")]


def test_several_dialogues_in_one_file() -> None:
    text = write([Dialogue("one", {}, [Entry(0, "says", "02")]), Dialogue("two", {"profile": "rho3"})])
    assert [dialogue.name for dialogue in parse(text)] == ["one", "two"] and write(parse(text)) == text


def test_an_unknown_mark_is_refused() -> None:
    with pytest.raises(DecodeError, match="mark 'melted'"):
        of_runs([Run(0, "A", b"A", "melted")])
    assert to_dialogue([], "empty").entries == []


def test_pcapng_byte_by_byte() -> None:
    turn = Turn(ms(1), ms(3), "B", Kind.BLOCK, bytearray(b"A\x10\x03\x52"), Flag.PARITY, ["BlockSent job=1"])
    assert payload(turn) == bytes.fromhex("01 01 04 01 00 00 07 d0 41 10 03 52")
    file = pcapng([turn], "plc1", "why", offset_ns=5 << 32)
    blocks = []
    while file:
        kind, length = struct.unpack_from("<II", file)
        assert length % 4 == 0 and struct.unpack_from("<I", file, length - 4) == (length,)
        blocks.append((kind, file[8 : length - 4]))
        file = file[length:]
    assert [kind for kind, _ in blocks] == [0x0A0D0D0A, 1, 6]
    section, interface, packet = (body for _, body in blocks)
    assert section == bytes.fromhex("4d3c2b1a 0100 0000 ffffffffffffffff 0100 0300 77687900 0400 0800") + b"axisgate" + bytes(4)
    assert interface == bytes.fromhex("9300 0000 00000000 0200 0400") + b"plc1" + bytes.fromhex("0900 0100 09000000 00000000")
    assert packet[:20] == struct.pack("<IIIII", 0, 5, ms(1), 12, 12) and packet[20:32] == payload(turn)
    assert packet[32:] == bytes.fromhex("0100 0f00") + b"BlockSent job=1\0" + bytes(4)


def test_stamps_before_1970_and_long_blocks_are_held_at_the_limit() -> None:
    turn = Turn(ms(1), ms(1) + 10**16, "A", Kind.STRAY, bytearray())
    assert payload(turn)[4:] == b"\xff\xff\xff\xff"
    assert pcapng([turn], "x", offset_ns=-(10**18)).count(struct.pack("<IIIII", 0, 0, 0, 8, 8)) == 1
