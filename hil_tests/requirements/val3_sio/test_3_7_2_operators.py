"""VAL 3 manual, 3.7.2: reading and writing strings and numbers with `=`."""

import pytest

from gateway.pure.controllers.val3.sio.channel import READ_BUFFER
from hil_tests.lab.virtual.val3_sio import WAITS, SioBench, error
from hil_tests.requirements.val3_sio.stations import CLIENT, SERIAL, SERVER

CALLS = "gateway.pure.controllers.val3.sio.calls:"
TEXT = "gateway.pure.controllers.val3.sio.text:"


@pytest.mark.requirement("VAL-SIO-07", by=(TEXT + "encode_text", CALLS + "WriteText.complete"))
@pytest.mark.parametrize("channel", [SERIAL, CLIENT], ids=lambda channel: channel.name)
def test_a_string_is_written_with_the_end_character(channel: object) -> None:
    bench = SioBench(SERIAL, CLIENT)
    sio = bench.variable(getattr(channel, "name", None))
    assert bench.outcome(bench.write_text(sio, "ab")) == "ab"
    assert bench.datagrams == [bytes((97, 98, 13))]
    assert bench.outcome(bench.write_text(sio, "ä€")) == "ä€"
    assert bench.outcome(bench.write_text(sio, "")) == ""
    assert bench.datagrams[1:] == ["ä€\r".encode(), b"\r"]
    assert bench.outcome(bench.write_text(sio, "x" * 128)) == "x" * 128
    assert bench.code(lambda: bench.core.write_text(sio, "x" * 127 + "ä", 0)) == 70, "129 bytes are no string"


def test_the_end_character_is_the_one_set_when_the_instruction_begins() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    call = bench.read_text(sio)
    assert bench.control(sio, "endOfString", 10) == 0
    bench.hears(1, b"a\nb\rc\nd")
    assert bench.outcome(call) == "a\nb"
    assert bench.outcome(bench.read_text(sio)) == "c"
    assert bench.outcome(bench.write_text(sio, "e")) == "e" and bench.datagrams == [b"e\n"]


@pytest.mark.requirement(
    "VAL-SIO-08", by=(CALLS + "ReadText.advance", "gateway.pure.controllers.val3.sio.inbox:Inbox.line", TEXT + "TextScan.run")
)
def test_a_string_is_read_up_to_the_end_character_which_is_taken_and_not_given() -> None:
    bench = SioBench(SERIAL)
    sio, data = bench.variable(SERIAL.name), [0.0] * 3
    bench.hears(1, bytes((97, 98, 13, 99)))
    assert bench.outcome(bench.read_text(sio)) == "ab"
    assert bench.outcome(bench.get(sio, data)) == 1 and data[0] == 99.0


@pytest.mark.requirement("VAL-SIO-08", by=(TEXT + "TextScan._character", TEXT + "char_size"))
def test_128_bytes_without_an_end_character_are_a_string() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    call = bench.read_text(sio)
    bench.hears(1, b"x" * 127)
    assert bench.outcome(call) == WAITS
    bench.hears(1, b"y\rz\r")
    assert bench.outcome(call) == "x" * 127 + "y"
    assert bench.outcome(bench.read_text(sio)) == ""  # its end character came too late to belong to it
    assert bench.outcome(bench.read_text(sio)) == "z"
    call = bench.read_text(sio)
    bench.hears(1, b"x" * 126 + "ä".encode()[:1])
    assert bench.outcome(call) == WAITS, "half a character"
    bench.hears(1, "ä".encode()[1:] + b"\r" + b"x" * 127 + "ä\r".encode())
    assert bench.outcome(call) == "x" * 126 + "ä" and bench.outcome(bench.read_text(sio)) == ""
    assert bench.outcome(bench.read_text(sio)) == "x" * 127, "a character stays whole for the next string"
    assert bench.outcome(bench.read_text(sio)) == "ä"


def test_a_character_that_does_not_fit_whole_begins_the_next_string() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    bench.hears(1, b"x" * 127 + "ä!\r".encode())
    assert bench.outcome(bench.read_text(sio)) == "x" * 127
    assert bench.outcome(bench.read_text(sio)) == "ä!"
    bench.hears(1, ("字" * 43 + "\r").encode())
    assert bench.outcome(bench.read_text(sio)) == "字" * 42  # 42 CJK characters, as the manual says of the type
    assert bench.outcome(bench.read_text(sio)) == "字"


@pytest.mark.parametrize(
    "raw, text",
    [
        (b"a\xffb\r", "ab"),
        (b"a\xc3b\r", "ab"),
        (b"a\xc3\r", "a"),
        (b"\x80\x80a\r", "a"),
        (b"\xed\xa0\x80a\r", "a"),
        (b"\xe0\x80\x80a\r", "a"),
        (b"\xf4\x90\x80\x80a\r", "a"),
        ("ä€😀\r".encode(), "ä€😀"),
    ],
)
@pytest.mark.parametrize("pieces", [False, True], ids=["whole", "byte by byte"])
def test_characters_that_are_no_utf_8_are_passed_over(raw: bytes, text: str, pieces: bool) -> None:
    bench = SioBench(SERIAL)
    call = bench.read_text(bench.variable(SERIAL.name))
    for piece in [raw[at : at + 1] for at in range(len(raw))] if pieces else [raw]:
        assert bench.outcome(call) == WAITS
        bench.hears(1, piece)
    assert bench.outcome(call) == text


def test_a_buffer_full_of_such_characters_does_not_stop_the_string() -> None:
    bench = SioBench(CLIENT)
    call = bench.read_text(bench.variable(CLIENT.name))
    bench.hears(1, b"a" + b"\xff" * (READ_BUFFER - 1))
    assert bench.core.room(1) == READ_BUFFER - 1
    bench.hears(1, b"b\r")
    assert bench.outcome(call) == "ab"


@pytest.mark.requirement("VAL-SIO-09", by=(CALLS + "WriteNum.complete", TEXT + "nearest_byte"))
@pytest.mark.parametrize("value, byte", [(65.4, 65), (65.5, 66), (256.4, 0), (-1, 255), (-0.5, 0), (1e9 + 0.2, 0)])
def test_a_number_is_written_as_its_nearest_integer_modulo_256(value: float, byte: int) -> None:
    bench = SioBench(CLIENT)
    assert bench.outcome(bench.write_num(bench.variable(CLIENT.name), value)) == byte
    assert bench.datagrams == [bytes((byte,))]


@pytest.mark.requirement("VAL-SIO-09", by=(CALLS + "ReadNum.advance", "gateway.pure.controllers.val3.sio.inbox:Inbox.take"))
def test_a_number_is_read_as_the_next_byte() -> None:
    bench = SioBench(SERVER)
    sio = bench.variable(SERVER.name)
    call = bench.read_num(sio)
    number = bench.client_comes(SERVER.name)
    assert number is not None and bench.outcome(call) == WAITS
    bench.hears(number, b"\x00\xff\r")
    assert [bench.outcome(one) for one in (call, bench.read_num(sio), bench.read_num(sio))] == [0.0, 255.0, 13.0]


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_what_is_no_number_and_what_no_string_holds_is_error_70(value: float) -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    assert bench.code(lambda: bench.core.write_num(sio, value, 0)) == 70
    assert bench.code(lambda: bench.core.write_text(sio, "x" * 129, 0)) == 70
    assert bench.code(lambda: bench.core.write_text(sio, "\udc80", 0)) == 70
    assert bench.datagrams == []


def test_a_damaged_string_is_taken_to_its_end_and_reported_once() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    call = bench.read_text(sio)
    bench.hears(1, b"12")
    bench.damaged(1)
    assert bench.outcome(call) == WAITS
    bench.hears(1, b"4\rnext\r")
    assert bench.outcome(call) == error(125)
    assert bench.outcome(bench.read_text(sio)) == "next"


def test_a_damage_between_two_strings_spoils_the_second_only() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    bench.hears(1, b"a\r")
    bench.damaged(1)
    bench.hears(1, b"b\rc\r")
    assert [bench.outcome(bench.read_text(sio)) for _ in range(3)] == ["a", error(125), "c"]


def test_two_tasks_at_one_line_are_served_in_their_order() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    text, number = bench.read_text(sio), bench.read_num(bench.variable(SERIAL.name))
    bench.hears(1, b"ab")
    assert (bench.outcome(text), bench.outcome(number)) == (WAITS, WAITS)
    bench.hears(1, b"\rc")
    assert (bench.outcome(text), bench.outcome(number)) == ("ab", 99.0)


def test_a_killed_task_takes_nothing_with_it() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    text, number = bench.read_text(sio), bench.read_num(sio)
    bench.hears(1, b"ab")
    assert bench.core.cancel(text) == [number]
    assert bench.outcome(number) == 97.0
