"""AX-396: number forms and byte orders at both ends of a route, and the addresses they stand at."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.image.addresses import AddressFault, Direction, RcBit
from gateway.pure.routes.addresses import Place, World, octets_of, place_of
from gateway.pure.routes.forms import FORMS, ORDERS, bytes_of, number_of, size_of, span_of
from gateway.pure.routes.judge import Joined, Span, rings, two_writers
from protocols.base.errors import DecodeError, EncodeError

SYMBOLS = {"K01_A_MN_RCI": RcBit(Direction.INPUT, 38)}
LINES = {10: "plc", 30: "host"}
DEVICES = {"tank": "coupler.tank", "coupler.tank": "coupler.tank"}


def place(text: str, form: str = "", order: str = "ABCD") -> Place:
    return place_of(text, form, order, SYMBOLS, LINES, DEVICES)


@pytest.mark.parametrize(
    ("form", "order", "value", "raw"),
    [
        ("KF", "ABCD", -2.0, "ff fe"), ("u16", "CDAB", 0x1234, "12 34"), ("u16", "DCBA", 0x1234, "34 12"), ("s16", "BADC", -2, "fe ff"),
        ("u32", "ABCD", 0x12345678, "12 34 56 78"), ("u32", "CDAB", 0x12345678, "56 78 12 34"), ("u32", "BADC", 0x12345678, "34 12 78 56"),
        ("s32", "DCBA", 0x12345678, "78 56 34 12"), ("REAL", "ABCD", 1200.5, "44 96 10 00"), ("REAL", "CDAB", 1200.5, "10 00 44 96"),
        ("KG", "ABCD", 1200.5, "0b 4b 08 00"), ("BCD", "ABCD", 1234, "12 34"), ("u8", "DCBA", 200, "c8"), ("s8", "ABCD", -56, "c8"),
    ],
)  # fmt: skip
def test_every_form_in_its_order(form: str, order: str, value: float, raw: str) -> None:
    assert bytes_of(form, order, value) == bytes.fromhex(raw)
    assert number_of(form, order, bytes.fromhex(raw)) == value


@given(st.sampled_from([form for form in FORMS if size_of(form) and form not in ("KG", "REAL")]), st.sampled_from(ORDERS), st.data())
def test_whole_numbers_survive_the_round_trip(form: str, order: str, data: st.DataObject) -> None:
    low, high = span_of(form)
    value = data.draw(st.integers(int(low), int(high)))
    assert number_of(form, order, bytes_of(form, order, value)) == value


@pytest.mark.parametrize(
    ("form", "value"), [("KF", 32768), ("u8", -1), ("BCD", 10000), ("REAL", 1e39), ("s32", 2**31), ("u16", float("nan"))]
)
def test_what_does_not_fit_is_refused(form: str, value: float) -> None:
    with pytest.raises((EncodeError, ValueError)):
        bytes_of(form, "ABCD", value)


@pytest.mark.parametrize(("form", "raw"), [("BCD", "12 3a"), ("REAL", "7f c0 00 00"), ("u16", "00"), ("u16", "00 00 00")])
def test_bytes_that_are_no_number_are_refused(form: str, raw: str) -> None:
    with pytest.raises(DecodeError):
        number_of(form, "ABCD", bytes.fromhex(raw))


@pytest.mark.parametrize(
    ("text", "form", "found"),
    [
        ("DB10.DW2", "KF", Place(World.BLOCK, "plc", 10, 4, 0, "KF")),
        ("DB10.DL2", "u8", Place(World.BLOCK, "plc", 10, 4, 0, "u8")),
        ("DB10.DR2", "u8", Place(World.BLOCK, "plc", 10, 5, 0, "u8")),
        ("DB30.DD4", "REAL", Place(World.BLOCK, "host", 30, 8, 0, "REAL")),
        ("other:DB7.DW0", "KF", Place(World.BLOCK, "other", 7, 0, 0, "KF")),
        ("DB10.D0.8", "", Place(World.BLOCK, "plc", 10, 0, 0)),
        ("DB10.D1.7", "bit", Place(World.BLOCK, "plc", 10, 3, 7)),
        ("K01_A_MN_RCI", "", Place(World.RC_INPUT, byte=4, bit=6)),
        ("AW 92", "u16", Place(World.RC_INPUT, byte=92, form="u16")),
        ("QB 11", "u8", Place(World.RC_INPUT, byte=11, form="u8")),
        ("ED 88", "s32", Place(World.RC_OUTPUT, byte=88, form="s32")),
        ("E 8.0", "", Place(World.RC_OUTPUT, byte=8, bit=0)),
        ("axis.X.actual", "", Place(World.NAME, "axis.X.actual")),
        ("io.lamp", "", Place(World.CONTACT, "lamp")),
    ],
)
def test_places(text: str, form: str, found: Place) -> None:
    assert place(text, form) == found


@pytest.mark.parametrize(
    ("text", "form", "words"),
    [
        ("DB10.DW2", "", "the number format is missing"), ("DB10.DW2", "REAL", "has 2 bytes"), ("DB10.D0.8", "KF", "is a bit"),
        ("E 8.0", "u8", "is a bit"),
        ("DB99.DW0", "KF", "no [[db]]"), ("MW 10", "u16", "a route joins"), ("40001", "u16", "a route joins"),
        ("DB10.DW2", "f64", "not a number form"),
        ("T 5", "u16", "a route joins"),
    ],
)  # fmt: skip
def test_no_places(text: str, form: str, words: str) -> None:
    with pytest.raises(AddressFault) as fault:
        place(text, form)
    assert words in str(fault.value)


def test_bits_of_a_word_and_the_word_itself_meet_and_neighbours_do_not() -> None:
    word = place("DB10.DW2", "KF").span
    assert all(word.meets(place(f"DB10.D2.{bit}").span) for bit in (0, 7, 8, 15))
    assert (
        not word.meets(place("DB10.D1.0").span)
        and not word.meets(place("DB10.D3.15").span)
        and not word.meets(place("x:DB10.DW2", "KF").span)
    )
    assert place("AW 92", "u16").span.meets(place("A 93.7").span) and not place("AW 92", "u16").span.meets(place("A 94.0").span)
    assert not place("AB 8", "u8").span.meets(place("EB 8", "u8").span)


def test_two_writers_and_rings_are_found_once() -> None:
    a, b, c = (Span("RC input", 8 * n, 8) for n in range(3))
    assert two_writers([Joined("one", a, b), Joined("two", c, Span("RC input", 15, 1))]) == [("one", "two", Span("RC input", 15, 1))]
    assert two_writers([Joined("one", a, b, (b,))]) == [("one", "one", b)]
    assert two_writers([Joined("one", a, b), Joined("two", a, c)]) == []
    assert rings([Joined("one", a, b), Joined("two", b, c), Joined("three", c, a)]) == [("one", "two", "three")]
    assert rings([Joined("one", a, a)]) == [("one",)]
    assert rings([Joined("one", a, b), Joined("two", b, c)]) == []
    assert rings([Joined("one", a, c, (b,)), Joined("two", b, a)]) == [("one", "two")], "a mark feeds as well"


@pytest.mark.parametrize(
    ("text", "form", "found"),
    [
        ("tank:40001", "REAL", Place(World.REGISTER, "coupler.tank", 4, 0, 0, "REAL")),
        ("coupler.tank:30065", "s16", Place(World.REGISTER, "coupler.tank", 3, 64, 0, "s16")),
        ("tank:00007", "", Place(World.REGISTER, "coupler.tank", 0, 6, 0, "bit")),
        ("tank:465536", "u16", Place(World.REGISTER, "coupler.tank", 4, 65535, 0, "u16")),
    ],
)
def test_registers_of_a_device_are_ends_of_routes(text: str, form: str, found: Place) -> None:
    """AX-407."""
    assert place(text, form) == found


@pytest.mark.parametrize(
    ("text", "form", "order"),
    [
        ("tonk:40001", "u16", "ABCD"), ("40001", "u16", "ABCD"), ("tank:40001", "", "ABCD"), ("tank:40001", "KG", "ABCD"),
        ("tank:00001", "u16", "ABCD"), ("tank:40001", "u32", "CDAB"), ("tank:465536", "u32", "ABCD"),
    ],
)  # fmt: skip
def test_registers_that_are_no_end_are_refused(text: str, form: str, order: str) -> None:
    with pytest.raises(AddressFault):
        place(text, form, order)


def test_registers_meet_where_their_words_meet() -> None:
    wide, second, coil = place("tank:40001", "REAL"), place("tank:40002", "u16"), place("tank:00002")
    assert wide.span.meets(second.span) and not second.span.meets(place("tank:40003", "u16").span) and not second.span.meets(coil.span)
    assert coil.span.meets(coil.span) and not coil.span.meets(place("tank:00001").span)


@pytest.mark.parametrize(
    ("text", "form", "words"),
    [
        ("6081h:00", "u32", "AXIS:6081h:00"), ("X:6081h", "u32", "AXIS:6081h:00"), ("X:6081h:00", "", "to_type = one of"),
        ("X:6081h:00", "KF", "to_type = one of"), ("tonk:0", "", "before the colon"), ("plc:A 3.2", "", "before the colon"),
        ("rc:66", "", "before the colon"), ("tank:K01_A_MN_RCI", "", "before the colon"), ("X:io.lamp", "", "before the colon"),
        ("cell:axis.X.actual", "", "before the colon"), ("dev:AW 92", "u16", "before the colon"), ("6081:00", "", "before the colon"),
    ],
)  # fmt: skip
def test_what_is_before_a_colon_belongs_to_an_address_that_has_one(text: str, form: str, words: str) -> None:
    """`6081h:00` was bit 0 of the RC inputs once, and wrote 0.0 there."""
    with pytest.raises(AddressFault) as fault:
        place(text, form)
    assert words in str(fault.value) and text in str(fault.value)


def test_a_parameter_of_a_drive_is_a_target() -> None:
    """AX-680."""
    there = place("X:6081h:00", "u32")
    assert there == Place(World.PARAMETER, "X", 0x6081, 0, 0, "u32") and octets_of(there, 0x12345678) == bytes.fromhex("78563412")
    assert octets_of(place("X:2003h:0A", "s16"), -2.0) == bytes.fromhex("feff") and octets_of(place("X:2003h:0a", "u8"), 200) == b"\xc8"
    assert there.span.meets(place("X:6081h:00", "s32").span) and not there.span.meets(place("Y:6081h:00", "u32").span)
    assert not there.span.meets(place("X:6083h:00", "u32").span)
    with pytest.raises(EncodeError):
        octets_of(there, -1.0)
