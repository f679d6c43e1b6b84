"""Values as text in protocols 2, 5 and 6 (AX-164); REAL in eight characters as part 3, section 3.4 counts them."""

import pytest

from gateway.pure.controllers.rho3.serial.baps import (
    BINARY,
    CHARACTER,
    INTEGER,
    REAL,
    TEXT,
    BapsType,
    ItemError,
    Value,
    array,
    jc_point,
    point,
)
from gateway.pure.controllers.rho3.serial.setup import Condition
from gateway.pure.controllers.rho3.serial.textual import ItemReader, to_text


def read(kind: BapsType, data: bytes) -> Value:
    """All of data is one variable."""
    reader = ItemReader(kind)
    ends = [reader.feed(byte) for byte in data]
    assert ends == [False] * (len(data) - 1) + [True]
    return reader.value


@pytest.mark.parametrize(
    "kind, value, text",
    [
        (BINARY, True, b"1"),
        (CHARACTER, 0, b"\0"),
        (INTEGER, -1234, b"-1234"),
        (REAL, -1234.45, b"-1234.45"),
        (REAL, 1.0, b"     1.0"),
        (REAL, 123456.7, b"123456.7"),
        (REAL, -2.5e9, b"-2.5E+09"),
        (TEXT, b"HALLO\0WORLD", b"HALLO"),
        (point(1, 1), (1.0, 2.0), b"     1.0,     2.0"),
        (jc_point(1), (0.25,), b"    0.25"),
        (array(CHARACTER, 2), (65, 66), b"AB"),
        (array(INTEGER, 2), (1, 2), b"1,2"),
    ],
)
def test_written(kind: BapsType, value: Value, text: bytes) -> None:
    assert to_text(kind, value) == text


@pytest.mark.parametrize(
    "kind, text, value",
    [
        (BINARY, b"0\r", False),
        (CHARACTER, b"\r", 13),
        (INTEGER, b" +17 ,", 17),
        (INTEGER, b"\n-5\r", -5),
        (REAL, b"-1.5e3\r", -1500.0),
        (TEXT, b"\na,b\r", b"a,b"),
        (point(2), b"1,.5\r", (1.0, 0.5)),
        (array(point(1), 2), b"1,2\r", ((1.0,), (2.0,))),
        (array(CHARACTER, 2), b"AB", (65, 66)),
        (array(BINARY, 2), b"1\x2c0\r", (True, False)),
    ],
)
def test_read(kind: BapsType, text: bytes, value: Value) -> None:
    assert read(kind, text) == value


@pytest.mark.parametrize(
    "kind, text, condition",
    [
        (BINARY, b"2\r", Condition.PROTOCOL),
        (INTEGER, b"1.0\r", Condition.PROTOCOL),
        (INTEGER, b"2147483648\r", Condition.PROTOCOL),
        (INTEGER, b"\r", Condition.PROTOCOL),
        (INTEGER, b"1" * 21, Condition.LENGTH),
        (REAL, b"nan\r", Condition.DEC_VALUE),
        (REAL, b"1e400\r", Condition.DEC_VALUE),
        (TEXT, b"x" * 81, Condition.LENGTH),
        (point(2), b"1\r", Condition.POINT),
        (array(INTEGER, 2), b"1\r", Condition.PROTOCOL),
    ],
)
def test_refused(kind: BapsType, text: bytes, condition: Condition) -> None:
    with pytest.raises(ItemError) as caught:
        read(kind, text)
    assert caught.value.condition == condition


@pytest.mark.parametrize("kind, value", [(array(INTEGER, 2), (1,)), (INTEGER, "1"), (CHARACTER, -1)])
def test_what_cannot_be_written(kind: BapsType, value: Value) -> None:
    with pytest.raises(ItemError):
        to_text(kind, value)
