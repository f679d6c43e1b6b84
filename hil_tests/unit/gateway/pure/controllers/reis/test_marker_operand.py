"""Markers as a person writes them."""

import pytest

from gateway.pure.controllers.reis.marker_operand import MarkerFault, marker_of


@pytest.mark.parametrize(
    ("text", "byte", "bit", "size"), [("M10.0", 10, 0, 1), ("m 511", 511, None, 1), ("MB 20", 20, None, 1), ("MD1436", 1436, None, 4)]
)
def test_a_bit_a_byte_a_double_word(text: str, byte: int, bit: int | None, size: int) -> None:
    found = marker_of(text)
    assert (found.byte, found.bit, found.size) == (byte, bit, size)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("M10.8", "0 to 7"),
        ("MB10.1", "is written as"),
        ("M1968", "M0 to M1967"),
        ("MD1965", "M0 to M1964"),
        ("A0.0", "is written as"),
        ("M944", "error number"),
        ("MD1021", "the robot writes it"),
        ("M1021.5", "robot moves"),
    ],
)
def test_what_cannot_be_written_is_named(text: str, said: str) -> None:
    with pytest.raises(MarkerFault, match=said):
        marker_of(text)


def test_the_power_on_bit_and_the_robots_free_bits_can() -> None:
    assert marker_of("M1020.4").bit == 4 and marker_of("M1020.7").bit == 7


@pytest.mark.parametrize(
    ("operand", "value", "number"), [("M5.1", "1", 1), ("M5", "0FFH", 255), ("MD8", "-1", -1), ("MD8", "FFFFFFFFH", 0xFFFFFFFF)]
)
def test_values(operand: str, value: str, number: int) -> None:
    assert marker_of(operand).number(value) == number


@pytest.mark.parametrize(
    ("operand", "value"), [("M5.1", "2"), ("M5", "256"), ("M5", "-1"), ("MD8", "4294967296"), ("M5", "12G"), ("M5", "")]
)
def test_a_value_outside_is_refused(operand: str, value: str) -> None:
    with pytest.raises(MarkerFault):
        marker_of(operand).number(value)
