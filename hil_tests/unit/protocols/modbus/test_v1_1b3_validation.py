"""V1.1b3, sections 6.1 to 6.12: which requests are refused, by which exception, in the order of the flow charts."""

import pytest

from protocols.modbus.validate import refusal
from protocols.modbus.view import ExceptionCode

FUNCTION, ADDRESS, VALUE = ExceptionCode.ILLEGAL_FUNCTION, ExceptionCode.ILLEGAL_DATA_ADDRESS, ExceptionCode.ILLEGAL_DATA_VALUE

ROWS = [  # (section, request PDU, what the specification demands)
    ("6.1 quantity 1..07D0h", "01 0000 0000", VALUE),
    ("6.1", "01 0000 0001", None),
    ("6.1", "01 0000 07D0", None),
    ("6.1", "01 0000 07D1", VALUE),
    ("6.1 end of the table", "01 FFFF 0001", None),
    ("6.1", "01 FFFF 0002", ADDRESS),
    ("6.1", "01 F830 07D0", None),
    ("6.1", "01 F831 07D0", ADDRESS),
    ("6.2 quantity 1..07D0h", "02 0000 0000", VALUE),
    ("6.2", "02 0000 0001", None),
    ("6.2", "02 0000 07D0", None),
    ("6.2", "02 0000 07D1", VALUE),
    ("6.2", "02 F831 07D0", ADDRESS),
    ("6.3 quantity 1..007Dh", "03 0000 0000", VALUE),
    ("6.3", "03 0000 0001", None),
    ("6.3", "03 0000 007D", None),
    ("6.3", "03 0000 007E", VALUE),
    ("6.3", "03 0000 FFFF", VALUE),
    ("6.3 end of the table", "03 FFFF 0001", None),
    ("6.3", "03 FF83 007D", None),
    ("6.3", "03 FF84 007D", ADDRESS),
    ("6.4 quantity 1..007Dh", "04 0000 0000", VALUE),
    ("6.4", "04 0000 0001", None),
    ("6.4", "04 0000 007D", None),
    ("6.4", "04 0000 007E", VALUE),
    ("6.4", "04 FF84 007D", ADDRESS),
    ("6.5 value 0000h or FF00h", "05 0000 0000", None),
    ("6.5", "05 0000 FF00", None),
    ("6.5", "05 0000 0001", VALUE),
    ("6.5", "05 0000 00FF", VALUE),
    ("6.5", "05 0000 FF01", VALUE),
    ("6.5", "05 0000 FFFF", VALUE),
    ("6.5 every address is one coil", "05 FFFF FF00", None),
    ("6.6 any value", "06 0000 0000", None),
    ("6.6", "06 FFFF FFFF", None),
    ("6.11 quantity 1..07B0h and byte count", "0F 0000 0000 00", VALUE),
    ("6.11", "0F 0000 0001 01 01", None),
    ("6.11", "0F 0000 0008 01 FF", None),
    ("6.11", "0F 0000 0009 02 FF 01", None),
    ("6.11", "0F 0000 0009 01 FF", VALUE),
    ("6.11 byte count is not what came", "0F 0000 0009 02 FF", VALUE),
    ("6.11", "0F 0000 0008 02 FF 00", VALUE),
    ("6.11", "0F 0000 07B0 F6" + "00" * 246, None),
    ("6.11", "0F 0000 07B1 F7" + "00" * 247, VALUE),
    ("6.11", "0F F850 07B0 F6" + "00" * 246, None),
    ("6.11", "0F F851 07B0 F6" + "00" * 246, ADDRESS),
    ("6.12 quantity 1..007Bh and byte count", "10 0000 0000 00", VALUE),
    ("6.12", "10 0000 0001 02 0000", None),
    ("6.12", "10 0000 0001 01 00", VALUE),
    ("6.12", "10 0000 0001 04 0000 0000", VALUE),
    ("6.12 byte count is not what came", "10 0000 0002 04 0000 00", VALUE),
    ("6.12", "10 0000 0001 02 0000 00", VALUE),
    ("6.12", "10 0000 007B F6" + "00" * 246, None),
    ("6.12 a PDU of 254 bytes", "10 0000 007C F8" + "00" * 248, VALUE),
    ("6.12", "10 FF85 007B F6" + "00" * 246, None),
    ("6.12", "10 FF86 007B F6" + "00" * 246, ADDRESS),
    ("7 function before all", "41 0000 0000", FUNCTION),
    ("7 value before address", "03 FFFF 007E", VALUE),
    ("7", "05 FFFF 1234", VALUE),
]


@pytest.mark.parametrize("section, pdu, demanded", ROWS)
def test_a_row_of_the_flow_charts(section: str, pdu: str, demanded: ExceptionCode | None) -> None:
    assert refusal(bytes.fromhex(pdu)) == demanded


@pytest.mark.parametrize("function", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("size", [1, 2, 3, 4, 6, 253])
def test_a_byte_too_few_or_too_many_is_03(function: int, size: int) -> None:
    """V1.1b3, section 7, code 03: "the implied length is incorrect"."""
    assert refusal(_request(function, size)) is VALUE


def _request(function: int, size: int) -> bytes:
    legal = bytes((function, 0, 0)) + (b"\xff\x00" if function == 5 else b"\x00\x01")
    return (legal + bytes(253))[:size]


@pytest.mark.parametrize("function", [15, 16])
def test_writing_several_cut_anywhere_or_one_byte_longer_is_03(function: int) -> None:
    legal = bytes.fromhex("0F 0000 0010 02 0102" if function == 15 else "10 0000 0002 04 0102 0304")
    assert refusal(legal) is None
    assert {refusal(legal[:size]) for size in range(1, len(legal))} == {VALUE}
    assert refusal(legal + b"\x00") is VALUE


def test_every_function_code_but_ours_is_01() -> None:
    served = {function for function in range(256) if refusal(_request(function, 1)) is not FUNCTION}
    assert served == {1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 15, 16, 17, 20, 21, 22, 23, 24, 43}


@pytest.mark.parametrize("function, largest", [(1, 2000), (2, 2000), (3, 125), (4, 125)])
def test_over_all_65536_quantities_just_these_are_legal(function: int, largest: int) -> None:
    legal = [count for count in range(0x10000) if refusal(bytes((function, 0, 0, count >> 8, count & 255))) is None]
    assert legal == list(range(1, largest + 1))


def test_over_all_65536_values_a_coil_takes_just_two() -> None:
    assert [value for value in range(0x10000) if refusal(bytes((5, 0, 0, value >> 8, value & 255))) is None] == [0x0000, 0xFF00]


@pytest.mark.parametrize("pdu", ["05 0000 FF00", "06 0000 0001", "0F 0000 0001 01 01", "10 0000 0001 02 0000", "06 00"])
def test_who_may_only_read_gets_01_for_any_write(pdu: str) -> None:
    """AX-070."""
    assert refusal(bytes.fromhex(pdu), may_write=False) is FUNCTION
    assert refusal(bytes.fromhex("03 0000 0001"), may_write=False) is None
