"""rho 3 Releases part 1, sections 7.2 and 7.3: BAPS values as bytes of a 3964R block, and several of them in one."""

import pytest

from gateway.pure.controllers.rho3.serial.baps import (
    BINARY,
    CHARACTER,
    INTEGER,
    REAL,
    TEXT,
    BapsType,
    ItemError,
    Kind,
    Value,
    array,
    as_text,
    jc_point,
    pack,
    point,
    unpack,
)
from gateway.pure.controllers.rho3.serial.setup import Condition, Setup
from hil_tests.lab.virtual.rho3_line import ONE, STX, InterfaceBench, done, failed, v24_1

LINK = Setup((v24_1(8),))
HIGH_FIRST = Setup((v24_1(8),), low_byte_first=False)
EVERY: tuple[tuple[BapsType, Value, bytes], ...] = (
    (BINARY, True, b"\x01"),
    (CHARACTER, 255, b"\xff"),
    (INTEGER, -2, b"\xfe\xff\xff\xff"),
    (REAL, -2.5, b"\x00\x00\x20\xc0"),
    (point(2, 1), (1.0, 2.0, -0.0), bytes.fromhex("0000803f 00000040 00000080")),
    (jc_point(1), (0.5,), bytes.fromhex("0000003f")),
    (TEXT, b"AB" + bytes(78), b"AB" + bytes(78)),
    (array(CHARACTER, 3), (1, 2, 3), b"\x01\x02\x03"),
    (array(point(1), 2), ((1.0,), (2.0,)), bytes.fromhex("0000803f 00000040")),
)


@pytest.mark.requirement("RHO-SER-16", by="gateway.pure.controllers.rho3.serial.baps:pack")
@pytest.mark.parametrize(
    "kind, value, data",
    [
        (BINARY, True, b"\1"),
        (CHARACTER, 65, b"A"),
        (INTEGER, 1, b"\1\0\0\0"),
        (REAL, 1.0, b"\0\0\x80\x3f"),
        (TEXT, b"A", b"A" + bytes(79)),
        (array(INTEGER, 2), (1, 2), b"\1\0\0\0\2\0\0\0"),
    ],
    ids=str,
)
def test_each_type_has_its_width_on_the_line(kind: BapsType, value: Value, data: bytes) -> None:
    bench = InterfaceBench(LINK).write(ONE, "V24_1", (kind, value)).says(STX).hears(b"\x10")
    said = bench.heard_from()
    assert (len(said), said[:-3]) == (len(data) + 3, data), said.hex(" ")


@pytest.mark.requirement("RHO-SER-17", by="gateway.pure.controllers.rho3.serial.baps:pack")
def test_integer_258_is_02_01_00_00_and_the_other_way_round_with_the_option() -> None:
    InterfaceBench(LINK).write(ONE, "V24_1", (INTEGER, 258)).acknowledges(b"\x02\x01\x00\x00").finds(done(1))
    InterfaceBench(HIGH_FIRST).write(ONE, "V24_1", (INTEGER, 258)).acknowledges(b"\x00\x00\x01\x02").finds(done(1))
    InterfaceBench(HIGH_FIRST).read(ONE, "V24_1", INTEGER).gets(b"\x00\x00\x01\x02").finds(done(1, 258))


@pytest.mark.requirement("RHO-SER-18", by="gateway.pure.controllers.rho3.serial.baps:pack")
def test_real_1_is_00_00_80_3f() -> None:
    InterfaceBench(LINK).write(ONE, "V24_1", (REAL, 1.0)).acknowledges(b"\x00\x00\x80\x3f").finds(done(1))


@pytest.mark.requirement(
    "RHO-SER-19", by=("gateway.pure.controllers.rho3.serial.baps:point", "gateway.pure.controllers.rho3.serial.baps:pack")
)
def test_a_point_of_four_axes_and_a_belt_has_20_bytes_without_separators() -> None:
    kind = point(4, belts=1)
    data = bytes.fromhex("0000803f 00000040 00004040 00008040 0000a040")
    InterfaceBench(LINK).write(ONE, "V24_1", (kind, (1.0, 2.0, 3.0, 4.0, 5.0))).acknowledges(data).finds(done(1))


@pytest.mark.requirement("RHO-SER-25", by="gateway.pure.controllers.rho3.serial.baps:unpack")
def test_a_field_of_three_integers_takes_12_bytes_in_order() -> None:
    bench = InterfaceBench(LINK).read(ONE, "V24_1", array(INTEGER, 3))
    bench.gets(bytes.fromhex("01000000 02000000 03000000")).finds(done(1, (1, 2, 3)))


@pytest.mark.requirement("RHO-SER-20", by="gateway.pure.controllers.rho3.serial.manager:LineManager.write")
def test_7_3_a_comma_list_is_one_block() -> None:
    bench = InterfaceBench(LINK).write(ONE, "V24_1", (INTEGER, 1), (INTEGER, 2))
    bench.acknowledges(b"\x01\x00\x00\x00\x02\x00\x00\x00").says(b"").finds(done(1))


def test_a_write_that_ends_in_dots_waits_for_the_rest_of_its_block() -> None:
    bench = InterfaceBench(LINK).write(ONE, "V24_1", (CHARACTER, 1), hold=True).says(b"")
    assert bench.condition(ONE, "V24_1") == Condition.NO_ERROR
    bench.write(ONE, "V24_1", (CHARACTER, 2)).acknowledges(b"\x01\x02").finds(done(1))


def test_139_characters_are_a_wrong_string_length_and_nothing_is_sent() -> None:
    bench = (
        InterfaceBench(LINK).write(ONE, "V24_1", (array(CHARACTER, 139), tuple(range(139)))).says(b"").finds(failed(1, Condition.LENGTH))
    )
    bench.write(ONE, "V24_1", (array(CHARACTER, 138), (0,) * 138)).acknowledges(bytes(138)).finds(done(2))


@pytest.mark.parametrize("kind, value, data", EVERY, ids=lambda one: one.kind.name if isinstance(one, BapsType) else "")
def test_every_type_goes_both_ways_and_in_both_byte_orders(kind: BapsType, value: Value, data: bytes) -> None:
    assert (pack(kind, value), kind.size) == (data, len(data))
    assert unpack(kind, data) == value
    assert unpack(kind, pack(kind, value, low_byte_first=False), low_byte_first=False) == value


@pytest.mark.parametrize(
    "kind, value, condition",
    [
        (BINARY, 2, Condition.PROTOCOL),
        (CHARACTER, 256, Condition.PROTOCOL),
        (INTEGER, 2**31, Condition.PROTOCOL),
        (INTEGER, 1.5, Condition.PROTOCOL),
        (REAL, float("nan"), Condition.DEC_VALUE),
        (REAL, 3.5e38, Condition.DEC_VALUE),
        (TEXT, bytes(81), Condition.LENGTH),
        (point(2), None, Condition.POINT),
        (point(2), (1.0, None), Condition.POINT),
        (point(2), (1.0,), Condition.POINT),
        (array(INTEGER, 2), (1,), Condition.PROTOCOL),
    ],
)
def test_a_value_that_cannot_be_written_has_its_condition(kind: BapsType, value: Value, condition: Condition) -> None:
    with pytest.raises(ItemError) as caught:
        pack(kind, value)
    assert caught.value.condition == condition
    InterfaceBench(LINK).write(ONE, "V24_1", (kind, value)).says(b"").finds(failed(1, condition))


def test_both_ends_of_the_ranges() -> None:
    assert pack(INTEGER, -(2**31)) == b"\x00\x00\x00\x80"
    assert pack(INTEGER, 2**31 - 1) == b"\xff\xff\xff\x7f"
    assert pack(REAL, 3.4028234663852886e38) == b"\xff\xff\x7f\x7f"


def test_a_field_has_one_dimension_and_no_texts() -> None:
    for element in (TEXT, array(INTEGER, 2)):
        with pytest.raises(ItemError):
            array(element, 3)
    with pytest.raises(ItemError):
        array(INTEGER, 0)


def test_nul_ends_a_text_for_baps_but_not_on_the_line() -> None:
    assert as_text(b"\0\0AD") == b""
    assert unpack(BapsType(Kind.TEXT), b"\0\0AD".ljust(80, b" ")) == b"\0\0AD".ljust(80, b" ")
