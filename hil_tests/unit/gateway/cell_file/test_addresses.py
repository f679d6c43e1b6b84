"""rho 3 release manual, signal addresses (rho3 0.2, 3.1, 3.2): one bit in four worlds, and every other form the parser takes."""

import csv
import io
import pathlib

import pytest

from gateway.files.find import read_signals
from gateway.pure.image.addresses import (
    Address,
    AddressFault,
    CellName,
    DataBit,
    DataWord,
    Direction,
    Part,
    RcBit,
    Register,
    Table,
    bits_of,
    cl300,
    from_cl300,
    from_pic,
    from_rc,
    parse,
    pic,
    rc,
)
from gateway.pure.image.signals import from_tables

VECTORS = pathlib.Path(__file__).parents[3] / "vectors" / "rho3_signals.csv"
IN, OUT = Direction.INPUT, Direction.OUTPUT


def printed() -> list[dict[str, str]]:
    """The rows of the manual."""
    text = VECTORS.read_text(encoding="utf-8").split("\n", 1)[1]
    return list(csv.DictReader(io.StringIO(text)))


def place(row: dict[str, str]) -> RcBit:
    return RcBit(Direction.INPUT if row["direction"] == "input" else Direction.OUTPUT, int(row["bit"]))


def both_ways(row: dict[str, str]) -> list[object]:
    """The row's addresses as we tell them, then the bit numbers we find at them."""
    bit = place(row)
    told: list[object] = [pic(bit), cl300(bit), rc(bit)]
    byte, number = (int(part) for part in row["pic"][1:].split("."))
    coupled, _ = (int(part) for part in row["cl300"][1:].split("."))
    rc_byte, rc_bit = (int(part) for part in row["rc"].split("."))
    found = (
        from_pic(row["pic"][0], byte, number),
        from_cl300(row["cl300"][0], coupled, number),
        from_rc(bit.direction, rc_byte, rc_bit),
    )
    return told + list(found)


@pytest.mark.requirement("RHO-PLC-01", by="gateway.pure.image.addresses:_shifted")
def test_0_2_rc_inputs_in_all_four_worlds() -> None:
    for row in (row for row in printed() if row["direction"] == "input"):
        assert both_ways(row) == [row["pic"], row["cl300"], row["rc"], place(row), place(row), place(row)], row
    assert rc(RcBit(IN, 399)) == "48.8"
    assert cl300(RcBit(IN, 399)) == "O48.7"
    assert rc(RcBit(IN, 85)) == "9.6"


@pytest.mark.requirement("RHO-PLC-02", by="gateway.pure.image.addresses:_shifted")
def test_0_2_rc_outputs_in_all_four_worlds() -> None:
    for row in (row for row in printed() if row["direction"] == "output"):
        assert both_ways(row) == [row["pic"], row["cl300"], row["rc"], place(row), place(row), place(row)], row
    assert cl300(RcBit(OUT, 108)) == "I11.4"
    assert rc(RcBit(OUT, 167)) == "13.8"


@pytest.mark.requirement("RHO-PLC-01", "RHO-PLC-02", by="gateway.pure.image.addresses:parse")
def test_0_2_addresses_are_read_as_they_are_written() -> None:
    for row in printed():
        bit = place(row)
        side = "in" if bit.direction is IN else "out"
        for text in (
            row["pic"],
            f"CL300 {row['cl300']}",
            f"RC {side} {row['rc']}",
            f"{'RCI' if bit.direction is IN else 'RCO'} {row['bit']}",
        ):
            assert parse(text) == bit, (text, row)
        assert parse("cell.ready", {"CELL.READY": bit}) == bit, "a symbol of the program goes before the names of the cell"


def test_every_bit_survives_every_world() -> None:
    for direction, first in ((IN, 16), (OUT, 64)):
        for number in range(first, 1024):
            bit = RcBit(direction, number)
            assert parse(pic(bit)) == bit
            assert parse(f"CL300 {cl300(bit)}") == bit
            assert parse(f"RC {'out ' if direction is OUT else ''}{rc(bit)}") == bit


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("DB10.DW2", DataWord(10, 2, Part.WORD)),
        ("db 10, dw 2", DataWord(10, 2, Part.WORD)),
        ("DB10.DL2", DataWord(10, 2, Part.LEFT)),
        ("DR 2", DataWord(7, 2, Part.RIGHT)),
        ("DB255.DD255", DataWord(255, 255, Part.DOUBLE)),
        ("D 10.3", DataBit(7, 10, 3)),
        ("DB10.D0.15", DataBit(10, 0, 15)),
        ("E 1.0", RcBit(OUT, 8)),
        ("I8.4", RcBit(OUT, 68)),
        ("A 2.3", RcBit(IN, 19)),
        ("Q24.0", RcBit(IN, 192)),
        ("RC 7.3", RcBit(IN, 66)),
        ("66", RcBit(IN, 66)),
        ("RCO 66", RcBit(OUT, 66)),
        ("k01_a_mn_rci", RcBit(IN, 38)),
        ("INPOS_3_RCO", RcBit(OUT, 194)),
        ("DISCOUPL_RCI", RcBit(IN, 112)),
        ("00001", Register(Table.COIL, 0)),
        ("10001", Register(Table.DISCRETE, 0)),
        ("30001", Register(Table.INPUT, 0)),
        ("40001", Register(Table.HOLDING, 0)),
        ("465536", Register(Table.HOLDING, 65535)),
        ("axis.X.actual", CellName("axis.X.actual")),
        ("axis.*.referenced", CellName("axis.*.referenced")),
    ],
)
def test_forms(text: str, address: Address) -> None:
    assert parse(text, from_tables(read_signals()).symbols(), db=7) == address


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("DW 2", "which data block?"),
        ("DB0.DW2", "DB 1..DB 255"),
        ("DB256.DW2", "DB 1..DB 255"),
        ("DB10.DW256", "data words are 0..255"),
        ("DB10.D0.16", "bits 0..15"),
        ("I8.8", "a PLC bit is 0..7"),
        ("O128.0", "bit numbers are 0..1023"),
        ("RC 7.0", "bits from 1 to 8"),
        ("RC 7.9", "bits from 1 to 8"),
        ("RC 0.1", "RC bytes count from 1"),
        ("1024", "bit numbers are 0..1023"),
        ("40000", "register numbers count from 40001"),
        ("MW 10", "flag words, timers, counters"),
        ("T5", "flag words, timers, counters"),
        ("K01_A_MN_RCI", "expected DB10.DW2"),  # no symbols handed in
        ("", "expected DB10.DW2"),
        ("DB10", "expected DB10.DW2"),
        ("-5", "expected DB10.DW2"),
    ],
)
def test_refusals_say_what_was_expected(text: str, expected: str) -> None:
    with pytest.raises(AddressFault) as refused:
        parse(text)
    assert expected in str(refused.value)


def test_bits_below_the_first_rc_byte_have_no_such_address() -> None:
    with pytest.raises(AddressFault, match="begin at bit 64"):
        rc(RcBit(OUT, 63))
    with pytest.raises(AddressFault, match="begin at bit 16"):
        rc(RcBit(IN, 15))
    with pytest.raises(AddressFault, match="begin at bit 16"):
        cl300(RcBit(OUT, 15))


def test_bits_an_address_covers() -> None:
    assert bits_of(DataWord(1, 2, Part.WORD)) == range(32, 48)
    assert bits_of(DataWord(1, 2, Part.LEFT)) == range(40, 48)
    assert bits_of(DataWord(1, 2, Part.RIGHT)) == range(32, 40)
    assert bits_of(DataWord(1, 2, Part.DOUBLE)) == range(32, 64)
    assert bits_of(DataBit(1, 2, 15)) == range(47, 48)


def test_the_signal_list_agrees_with_the_manual() -> None:
    signals = from_tables(read_signals())
    for row in printed():
        found = signals.named(row["symbol"]) if row["symbol"] else signals.at(place(row))
        assert found is not None and found.at == place(row), row
        assert found.source == "rho3" and found.de and found.en


def test_no_signal_name_or_number_occurs_twice() -> None:
    signals = [signal for signal in from_tables(read_signals()).all if not signal.until]
    assert len({signal.name for signal in signals}) == len(signals)
    assert len({signal.at for signal in signals}) == len(signals)
    ours = [signal for signal in signals if signal.source == "axisgate" and signal.at.direction is IN]
    assert {signal.at.number for signal in ours if not signal.lines} == {24, 25, 26, 27, 28}  # AX-002
    assert {signal.lines for signal in ours if signal.lines} == {"AX-503", "AX-509", "AX-531", "AX-1787"}
