"""rho 3 Releases part 1, section 7.1: the bytes of BAPS values (rho3 1.3), written by hand; and what does not fit."""

import math

import pytest

from protocols.base.errors import DecodeError, EncodeError
from protocols.telegrams.fields import Field, Kind, Order, Value, decode, encode

BIG = Order.BIG

VECTORS: list[tuple[Field, Value, str]] = [
    (Field(Kind.BINARY, "v", 0), True, "01"),
    (Field(Kind.BINARY, "v", 0), False, "00"),
    (Field(Kind.BINARY, "v", 0, count=3), (True, False, True), "01 00 01"),
    (Field(Kind.CHARACTER, "v", 0), "A", "41"),
    (Field(Kind.CHARACTER, "v", 0, count=2), "\xff\x00", "ff 00"),
    (Field(Kind.BYTE, "v", 0), 200, "c8"),
    (Field(Kind.WORD, "v", 0), 0x1234, "34 12"),
    (Field(Kind.WORD, "v", 0, order=BIG), 0x1234, "12 34"),
    (Field(Kind.KF, "v", 0, order=BIG), -2, "ff fe"),
    (Field(Kind.INTEGER, "v", 0), 1, "01 00 00 00"),  # normal order: low byte first
    (Field(Kind.INTEGER, "v", 0), -(2**31), "00 00 00 80"),
    (Field(Kind.INTEGER, "v", 0, order=BIG), 2**31 - 1, "7f ff ff ff"),
    (Field(Kind.INTEGER, "v", 0, scale=0.1), -0.5, "fb ff ff ff"),
    (Field(Kind.REAL, "v", 0), 1.5, "00 00 c0 3f"),
    (Field(Kind.REAL, "v", 0, order=BIG), 1200.5, "44 96 10 00"),
    (Field(Kind.REAL, "v", 0, scale=1000.0, order=BIG), 1500.0, "3f c0 00 00"),
    (Field(Kind.POINT, "v", 0), (1.0,), "00 00 80 3f"),
    (Field(Kind.JC_POINT, "v", 0, count=2, order=BIG), (1.0, -1.0), "3f 80 00 00 bf 80 00 00"),
    (Field(Kind.TEXT, "v", 0), "PAL 7", "50 41 4c 20 37" + " 00" * 75),
    (Field(Kind.TEXT, "v", 0), "x" * 80, "78" * 80),
]


@pytest.mark.parametrize("field, value, wire", VECTORS)
def test_values_and_their_bytes(field: Field, value: Value, wire: str) -> None:
    data = bytes.fromhex(wire)
    assert encode(field, value) == data
    assert decode(field, data) == value
    assert type(decode(field, data)) is type(value)


def test_1_3_integer_and_real_low_byte_first_unless_the_option_says_otherwise() -> None:
    assert encode(Field(Kind.INTEGER, "v", 0), 258).hex() == "02010000"
    assert encode(Field(Kind.INTEGER, "v", 0, order=BIG), 258).hex() == "00000102"
    assert encode(Field(Kind.REAL, "v", 0), 1.0).hex() == "0000803f"


def test_a_field_reads_only_its_own_bytes() -> None:
    assert decode(Field(Kind.WORD, "v", 2, order=BIG), bytes.fromhex("ffff 0102 ffff")) == 0x0102
    assert decode(Field(Kind.CHARACTER, "v", 1, count=2), b"xABx") == "AB"


@pytest.mark.parametrize(
    "field, wire, words",
    [
        (Field(Kind.INTEGER, "order.number", 4), "00 00 00 00 01 02 03", "order.number: bytes 4..7 expected, the block has 7"),
        (Field(Kind.BINARY, "v", 0), "02", "BINARY is 0 or 1, 02h received"),
        (Field(Kind.REAL, "v", 0, order=BIG), "7f c0 00 00", "is not a number"),
        (Field(Kind.REAL, "v", 0, order=BIG), "ff 80 00 00", "is not a number"),
        (Field(Kind.REAL, "v", 0, scale=1e300, order=BIG), "7f 7f ff ff", "is not a number"),
        (Field(Kind.KF, "v", 0, order=BIG, low=0.0, high=10.0, unit="mm"), "00 0b", "v = 11 is outside 0..10 mm: 00 0b"),
        (Field(Kind.KF, "v", 0, order=BIG, low=0.0), "ff ff", "v = -1 is outside 0..32767"),
    ],
)
def test_what_is_no_value_is_refused_with_its_bytes(field: Field, wire: str, words: str) -> None:
    with pytest.raises(DecodeError) as refusal:
        decode(field, bytes.fromhex(wire))
    assert words in str(refusal.value)


@pytest.mark.parametrize(
    "field, value, words",
    [
        (Field(Kind.BINARY, "v", 0), 2, "v = 2, range 0..1"),
        (Field(Kind.BYTE, "v", 0), 256, "v = 256, range 0..255"),
        (Field(Kind.BYTE, "v", 0), -1, "v = -1, range 0..255"),
        (Field(Kind.INTEGER, "order.number", 0), 2**31, "order.number = 2147483648, range -2147483648..2147483647"),
        (Field(Kind.INTEGER, "v", 0), -(2**31) - 1, "range"),
        (Field(Kind.INTEGER, "v", 0), math.nan, "v = nan"),
        (Field(Kind.KF, "v", 0, scale=0.1, unit="mm"), 3276.8, "v = 3276.8, range -3276.8..3276.7 mm"),
        (Field(Kind.KF, "v", 0, scale=-1.0), 32769.0, "range -32767..32768"),
        (Field(Kind.KF, "v", 0, high=10.0), 11, "range -32768..10"),
        (Field(Kind.REAL, "v", 0), math.nan, "v = nan"),
        (Field(Kind.REAL, "v", 0), math.inf, "v = inf"),
        (Field(Kind.REAL, "v", 0), 3.5e38, "range -3.402823466e+38..3.402823466e+38"),
        (Field(Kind.INTEGER, "v", 0), "1", "one INTEGER expected"),
        (Field(Kind.INTEGER, "v", 0), (1, 2), "one INTEGER expected"),
        (Field(Kind.INTEGER, "v", 0, count=2), (1,), "2 values of INTEGER expected"),
        (Field(Kind.INTEGER, "v", 0, count=2), 1, "2 values of INTEGER expected"),
        (Field(Kind.POINT, "v", 0), 1.0, "1 values of POINT expected"),
        (Field(Kind.CHARACTER, "v", 0, count=2), "A", "2 characters expected"),
        (Field(Kind.CHARACTER, "v", 0), 65, "a text expected"),
        (Field(Kind.CHARACTER, "v", 0), "\u20ac", "Latin-1"),
        (Field(Kind.TEXT, "v", 0), "x" * 81, "at most 80 characters"),
    ],
)
def test_what_does_not_fit_is_our_callers_mistake(field: Field, value: Value, words: str) -> None:
    with pytest.raises(EncodeError) as refusal:
        encode(field, value)
    assert field.name in str(refusal.value) and words in str(refusal.value)


def test_both_ends_of_a_range_fit_and_counts_are_rounded() -> None:
    assert encode(Field(Kind.KF, "v", 0, scale=0.1, order=BIG), 3276.7).hex() == "7fff"
    assert encode(Field(Kind.KF, "v", 0, scale=0.1, order=BIG), -3276.8).hex() == "8000"
    assert encode(Field(Kind.KF, "v", 0, scale=0.1, order=BIG), 1.26).hex() == "000d"
    assert encode(Field(Kind.INTEGER, "v", 0), True).hex() == "01000000"
    assert encode(Field(Kind.REAL, "v", 0, order=BIG), 3.4028234663852886e38).hex() == "7f7fffff"
