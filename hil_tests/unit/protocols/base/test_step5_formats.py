"""STEP 5 number formats: vectors by hand, both ends of each range and one step beyond, wrong lengths, NaN (AX-010, AX-056)."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.base.errors import DecodeError, EncodeError
from protocols.base.step5 import Step5Type, Value, decode, encode, get_bit, range_of, with_bit

T = Step5Type
KG = [  # value = mantissa / 2^23 x 2^exponent, computed by hand
    (0.0, "80 00 00 00"), (0.5, "00 40 00 00"), (1.0, "01 40 00 00"), (-1.0, "01 C0 00 00"), (-0.005, "F9 AE 14 7B"),
    (12.34567, "04 62 C3 EF"), (100.0, "07 64 00 00"), (-100.0, "07 9C 00 00"), (1200.5, "0B 4B 08 00"),
    ((2**23 - 1) * 2.0**104, "7F 7F FF FF"),  # 0.1701412E+39
]  # fmt: skip
VECTORS: list[tuple[Step5Type, Value, str]] = [
    (T.BIT, True, "00 01"), (T.BIT, False, "00 00"),
    (T.KF, 0, "00 00"), (T.KF, 1, "00 01"), (T.KF, -1, "FF FF"), (T.KF, 32767, "7F FF"), (T.KF, -32768, "80 00"),
    (T.DH, -1, "FF FF FF FF"), (T.DH, 2147483647, "7F FF FF FF"), (T.DH, -2147483648, "80 00 00 00"), (T.DH, 65536, "00 01 00 00"),
    (T.KH, 0, "00 00"), (T.KH, 0xABCD, "AB CD"), (T.KH, 0xFFFF, "FF FF"),
    (T.KM, 0b1000_0000_0000_0001, "80 01"),
    (T.KY, (0, 255), "00 FF"), (T.KY, (100, 200), "64 C8"),
    (T.KC, "AB", "41 42"), (T.KC, "ö ", "F6 20"),
    (T.KT, (100, 1), "11 00"), (T.KT, (999, 3), "39 99"), (T.KT, (0, 0), "00 00"),
    (T.KZ, 0, "00 00"), (T.KZ, 999, "09 99"),
    (T.BCD, 0, "00 00"), (T.BCD, 1234, "12 34"), (T.BCD, 9999, "99 99"),
    (T.REAL, 1.0, "3F 80 00 00"), (T.REAL, 1200.5, "44 96 10 00"), (T.REAL, -100.0, "C2 C8 00 00"), (T.REAL, 0.0, "00 00 00 00"),
]  # fmt: skip
BEYOND: list[tuple[Step5Type, Value]] = [
    (T.BIT, 2), (T.BIT, -1), (T.KF, 32768), (T.KF, -32769), (T.KF, 1.5), (T.KF, "1"), (T.DH, 2147483648), (T.DH, -2147483649),
    (T.KH, 65536), (T.KH, -1), (T.KM, 65536), (T.KM, -1), (T.KY, (256, 0)), (T.KY, (0, 256)), (T.KY, (-1, 0)), (T.KY, 5),
    (T.KC, "A"), (T.KC, "ABC"), (T.KC, "\u20ac "), (T.KC, 65), (T.KT, (1000, 0)), (T.KT, (0, 4)), (T.KT, (-1, 0)), (T.KT, 100),
    (T.KZ, 1000), (T.KZ, -1), (T.BCD, 10000), (T.BCD, -1),
    (T.KG, math.nan), (T.KG, math.inf), (T.KG, -math.inf), (T.KG, 2.0**127), (T.KG, -(2.0**127)), (T.KG, "1.0"), (T.KG, True),
    (T.REAL, math.nan), (T.REAL, math.inf), (T.REAL, -math.inf), (T.REAL, 2.0**128), (T.REAL, -(2.0**128)), (T.REAL, 3.5e38),
]  # fmt: skip


@pytest.mark.parametrize("kind, value, text", VECTORS)
def test_vector(kind: Step5Type, value: Value, text: str) -> None:
    assert encode(kind, value) == bytes.fromhex(text)
    assert decode(kind, bytes.fromhex(text)) == value and type(decode(kind, bytes.fromhex(text))) is type(value)


@pytest.mark.parametrize("value, text", KG)
def test_kg_vector(value: float, text: str) -> None:
    assert encode(T.KG, value) == bytes.fromhex(text)
    read = decode(T.KG, bytes.fromhex(text))
    assert isinstance(read, float) and read == pytest.approx(value, rel=2.0**-22, abs=0)


def test_both_forms_of_minus_one_are_read() -> None:
    assert decode(T.KG, bytes.fromhex("01 C0 00 00")) == decode(T.KG, bytes.fromhex("00 80 00 00")) == -1.0


def test_the_ends_of_kg() -> None:
    low, high = range_of(T.KG)
    assert encode(T.KG, high).hex() == "7f7fffff" and decode(T.KG, encode(T.KG, low)) == low == -high
    assert decode(T.KG, bytes.fromhex("80 40 00 00")) == pytest.approx(0.1469368e-38, rel=1e-6)
    assert encode(T.KG, 0.1469368e-38 / 3).hex() == "80000000"  # nearer to zero than the smallest number
    assert encode(T.KG, math.nextafter(1.0, 0.0)).hex() == "01400000"  # rounds up into the next exponent
    assert encode(T.KG, -math.nextafter(1.0, 0.0)).hex() == "01c00000"


def test_a_kg_target_read_as_real_is_a_tiny_number() -> None:
    assert decode(T.REAL, bytes.fromhex("0B 4B 08 00")) == pytest.approx(3.9e-32, rel=0.01)


@pytest.mark.parametrize("kind, value", BEYOND)
def test_beyond_the_range_is_refused_with_its_name(kind: Step5Type, value: Value) -> None:
    with pytest.raises(EncodeError, match=f"{kind.value} = .*range"):
        encode(kind, value)


@pytest.mark.parametrize("kind", list(Step5Type))
def test_a_byte_too_few_or_too_many(kind: Step5Type) -> None:
    for length in (0, kind.size - 1, kind.size + 1):
        with pytest.raises(DecodeError, match=f"{kind.size} bytes expected, {length} received"):
            decode(kind, bytes(length))


@pytest.mark.parametrize(
    "kind, text",
    [(T.BIT, "00 02"), (T.KT, "40 00"), (T.KT, "0A 00"), (T.KZ, "10 00"), (T.KZ, "00 0A"), (T.BCD, "A0 00"), (T.BCD, "00 0F"),
     (T.REAL, "7F C0 00 00"), (T.REAL, "7F 80 00 00"), (T.REAL, "FF 80 00 00")],
)  # fmt: skip
def test_patterns_that_are_no_value(kind: Step5Type, text: str) -> None:
    with pytest.raises(DecodeError):
        decode(kind, bytes.fromhex(text))


def test_low_word_first() -> None:
    for kind, value in ((T.DH, 0x12345678), (T.KG, 1200.5), (T.REAL, 1.0)):
        data = encode(kind, value)
        assert encode(kind, value, low_word_first=True) == data[2:] + data[:2]
        assert decode(kind, data[2:] + data[:2], low_word_first=True) == value
    assert encode(T.KF, -2, low_word_first=True) == b"\xff\xfe" and decode(T.KF, b"\xff\xfe", low_word_first=True) == -2


def test_bits_of_a_word() -> None:
    assert [bit for bit in range(16) if get_bit(b"\x81\x02", bit)] == [1, 8, 15]
    assert with_bit(b"\x00\x00", 15, True) == b"\x80\x00" and with_bit(b"\xff\xff", 0, False) == b"\xff\xfe"
    for bit in (-1, 16):
        with pytest.raises(EncodeError):
            with_bit(b"\x00\x00", bit, True)
    with pytest.raises(DecodeError):
        get_bit(b"\x00", 0)


def test_ranges() -> None:
    for kind in Step5Type:
        if kind in (T.KY, T.KC, T.KT):
            with pytest.raises(EncodeError):
                range_of(kind)
            continue
        low, high = range_of(kind)
        whole = kind not in (T.KG, T.REAL)
        for end in (low, high):
            value: Value = int(end) if whole else end
            assert decode(kind, encode(kind, value)) == value


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_every_single_precision_number_comes_back_from_real(value: float) -> None:
    assert encode(T.REAL, value) == struct.pack(">f", value) and decode(T.REAL, encode(T.REAL, value)) == value


@given(st.floats(min_value=-(2.0**126), max_value=2.0**126))
def test_kg_is_off_by_half_a_step_at_most(value: float) -> None:
    read = decode(T.KG, encode(T.KG, value))
    assert isinstance(read, float) and abs(read - value) <= max(abs(value) * 2.0**-23, 0.5 * 0.1469368e-38)


@given(st.sampled_from(list(Step5Type)), st.binary(max_size=6))
def test_any_bytes_are_a_value_or_a_decode_error(kind: Step5Type, data: bytes) -> None:
    try:
        value = decode(kind, data)
    except DecodeError:
        return
    assert decode(kind, encode(kind, value)) == value


@pytest.mark.parametrize("text", ["40 00 00 00", "3F 00 00 00", "C0 00 00 00", "7F 00 00 00"])
def test_a_power_of_two_in_ieee_is_no_kg_zero(text: str) -> None:
    with pytest.raises(DecodeError, match="not KG"):
        decode(T.KG, bytes.fromhex(text))
    assert decode(T.KG, bytes.fromhex("80 00 00 00")) == decode(T.KG, bytes(4)) == 0.0
