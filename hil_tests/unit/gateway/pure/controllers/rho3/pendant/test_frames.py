"""Transparent output to a PHG 2000, byte by byte.  Source: rho 3 Releases L9519-9530, L9636-9886."""

import math

import pytest

from gateway.pure.controllers.rho3.pendant import frames
from gateway.pure.controllers.rho3.pendant.frames import Command, FrameError, Part


def made(what: str, *arguments: object) -> bytes:
    data: bytes = getattr(frames, what)(*arguments)
    return data


@pytest.mark.requirement(
    "RHO-PHG-07", by=("gateway.pure.controllers.rho3.pendant.frames:sc_gotoxy", "gateway.pure.controllers.rho3.pendant.frames:sc_ende")
)
@pytest.mark.parametrize(
    "what, arguments, expected",
    [
        ("sc_gotoxy", (30, 40), "02 04 1E 00 28 00"),
        ("sc_ende", (), "08 00"),
        ("sc_cls", (), "01 00"),
        ("sc_fuer_mask", (-1,), "FF FF"),
        ("sc_neue_mask", (2,), "0F 02 02 00"),
        ("sc_linie", (0, 0, 255, 127), "0C 08 00 00 00 00 FF 00 7F 00"),
        ("sc_charset", (1,), "12 01 01"),
        ("sc_attrib", (3,), "03 01 03"),
        ("sc_refresh", (34821, 3), "07 04 05 88 03 00"),
        ("sc_zei_rel", (-1, 0), "16 02 FF 00"),
        ("sc_zeichen", (":",), "05 02 3A 00"),
    ],
)
def test_each_command_is_number_length_and_words_low_byte_first(what: str, arguments: tuple[object, ...], expected: str) -> None:
    assert made(what, *arguments).hex(" ").upper() == expected


@pytest.mark.requirement("RHO-PHG-09", by="gateway.pure.controllers.rho3.pendant.frames:sc_text")
def test_a_text_says_81_whatever_its_length_and_ends_with_nul() -> None:
    assert made("sc_text", "HALLO WORLD") == b"\x05\x51HALLO WORLD\0"
    assert made("sc_text", "x" * 80) == b"\x05\x51" + b"x" * 80 + b"\0"
    with pytest.raises(FrameError, match="81 characters: at most 80"):
        made("sc_text", "x" * 81)


@pytest.mark.requirement(
    "RHO-PHG-09", by=("gateway.pure.controllers.rho3.pendant.frames:sc_ganz", "gateway.pure.controllers.rho3.pendant.frames:int_asc")
)
def test_an_integer_is_right_aligned_and_hyphens_mean_an_error() -> None:
    assert made("sc_ganz", 1234, 8) == b"\x05\x51    1234\0"
    assert made("sc_ganz", 123456, 5) == b"\x05\x51-----\0"
    assert made("sc_ganz", -1234, 5) == b"\x05\x51-1234\0"
    assert made("sc_ganz", -1234, 4) == b"\x05\x51----\0"


@pytest.mark.requirement("RHO-PHG-09", by="gateway.pure.controllers.rho3.pendant.frames:real_text")
@pytest.mark.parametrize(
    "value, text", [(-1234.45, "-1234.45"), (0.5, "0.500000"), (1e9, "--------"), (math.nan, "--------"), (1e7, "10000000")]
)
def test_a_real_has_eight_places(value: float, text: str) -> None:
    assert made("sc_dez", value) == b"\x05\x09" + text.encode() + b"\0"


@pytest.mark.parametrize(
    "what, arguments",
    [("sc_gotoxy", (256, 0)), ("sc_gotoxy", (0, 128)), ("sc_linie", (0, 0, -1, 0)), ("sc_attrib", (16,)), ("sc_charset", (2,)),
     ("sc_zei_rel", (128, 0)), ("sc_zeichen", ("ab",)), ("sc_ganz", (1, 81)), ("sc_text", ("a\0b",))],
)  # fmt: skip
def test_what_no_pendant_takes_is_refused(what: str, arguments: tuple[object, ...]) -> None:
    with pytest.raises(FrameError):
        made(what, *arguments)


@pytest.mark.requirement("RHO-PHG-07", by="gateway.pure.controllers.rho3.pendant.frames:parse")
def test_an_output_is_read_back_command_by_command() -> None:
    output = frames.sc_fuer_mask(-1) + frames.sc_gotoxy(30, 40) + frames.sc_text("HALLO") + frames.sc_ende()
    expected = [Part(Command.GOTOXY, b"\x1e\0\x28\0"), Part(Command.TEXT, b"HALLO\0"), Part(Command.ENDE, b"")]
    found = frames.parse(output)
    assert found == (-1, expected)


@pytest.mark.parametrize(
    "output, words",
    [
        (b"\xff", "1 bytes"),
        (b"\xff\xff\x01\x00", "byte 4: the output ends before SC_ENDE"),
        (b"\xff\xff\x63\x00", "byte 2: 99 is not a command"),
        (b"\xff\xff\x02\x04\x00", "GOTOXY ends before its 4 bytes"),
        (b"\xff\xff\x05\x51abc", "TEXT ends before its 81 bytes"),
        (b"\xff\xff\x08\x00\x00", "1 bytes after SC_ENDE"),
    ],
)
def test_half_outputs_are_named_by_their_byte(output: bytes, words: str) -> None:
    with pytest.raises(FrameError, match=words):
        frames.parse(output)
