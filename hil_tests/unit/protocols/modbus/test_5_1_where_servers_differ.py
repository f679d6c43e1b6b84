"""serial-protocols 5.1: the points where widely used servers differ; ours does what the column "required" says."""

import pytest

from hil_tests.lab.virtual.modbus_view import MemoryView
from hil_tests.unit.protocols.modbus.wire import exchange, frame


def says(request: str) -> str:
    answer, closed = exchange(frame(request), MemoryView())
    assert not closed and answer[:7] == bytes((0, 1, 0, 0, 0, len(answer) - 6, 1))
    return answer[7:].hex(" ").upper()


@pytest.mark.parametrize("function, answer", [(1, "81 03"), (2, "82 03"), (3, "83 03"), (4, "84 03")])
def test_amount_0_or_above_the_limit_is_03_with_the_function_and_80h(function: int, answer: str) -> None:
    above = "07D1" if function < 3 else "007E"
    assert says(f"{function:02X} 0000 0000") == answer
    assert says(f"{function:02X} 0000 {above}") == answer
    assert says(f"{function:02X} 0000 FFFF") == answer


@pytest.mark.parametrize("value", ["0001", "00FF", "FF01", "FFFF", "AA55"])
def test_fc5_with_another_value_is_03(value: str) -> None:
    assert says(f"05 0000 {value}") == "85 03"


@pytest.mark.parametrize("count", ["00", "01", "03", "FF"])
def test_fc15_and_fc16_with_a_wrong_byte_count_are_03(count: str) -> None:
    assert says(f"0F 0000 000A {count} FF 03") == "8F 03"
    assert says(f"10 0000 0001 {count} 12 34") == "90 03"


def test_fc16_with_124_registers_a_pdu_of_254_bytes_closes() -> None:
    """ "3 or close": its MBAP length of 255 cannot be (AX-071)."""
    assert exchange(frame("10 0000 007C F8" + "00" * 248), MemoryView()) == (b"", True)


def test_an_unknown_function_41h_is_01_with_c1h() -> None:
    assert says("41 00 00") == "C1 01"
    assert says("41") == "C1 01"


@pytest.mark.parametrize("unit", [2, 17, 247, 254])
def test_a_unit_not_present_is_0b(unit: int) -> None:
    view = MemoryView()
    answer, _ = exchange(frame("03 0000 0001", unit=unit), view)
    assert answer == bytes((0, 1, 0, 0, 0, 3, unit, 0x83, 0x0B)) and view.calls == 0


@pytest.mark.parametrize("unit", [0, 1, 255])
def test_units_0_and_255_are_unit_1_and_are_answered_with_their_own_number(unit: int) -> None:
    """AX-012; on TCP nothing is a broadcast, so 0 is answered too."""
    assert exchange(frame("06 0000 1234", unit=unit), MemoryView())[0] == bytes((0, 1, 0, 0, 0, 6, unit)) + bytes.fromhex("06 0000 1234")


def test_another_mbap_protocol_identifier_is_ignored() -> None:
    assert exchange(frame("03 0000 0001", protocol=1), MemoryView()) == (b"", False)


@pytest.mark.parametrize("length", [0, 1, 255, 300, 0xFFFF])
def test_a_wrong_mbap_length_closes(length: int) -> None:
    assert exchange(frame("03 0000 0001", length=length), MemoryView()) == (b"", True)


def test_an_mbap_length_shorter_than_the_request_is_03_and_what_is_left_over_closes_or_waits() -> None:
    answer, closed = exchange(frame("03 0000 0001", length=4), MemoryView())
    assert answer == bytes.fromhex("0001 0000 0003 01 83 03") and not closed  # 2 bytes wait: the half frame's deadline ends it


def test_ten_requests_in_one_segment_are_ten_answers_with_their_ids() -> None:
    answer, _ = exchange(b"".join(frame("03 0000 0001", transaction=100 + n) for n in range(10)), MemoryView())
    assert answer == b"".join(frame("03 02 0000", transaction=100 + n) for n in range(10))


@pytest.mark.parametrize(
    "request_pdu, answer",
    [
        ("08 0000 1234", "08 00 00 12 34"),
        ("16 0000 00F2 0025", "16 00 00 00 F2 00 25"),
        ("17 0000 0001 0000 0001 02 0001", "17 02 00 01"),
        ("11", "11 13 01 FF 61 78 69 73 67 61 74 65 20 61 78 69 73 67 61 74 65"),
        ("2B 0E 04 00", "2B 0E 04 83 00 00 01 00 08 61 78 69 73 67 61 74 65"),
    ],
)
def test_fc_8_17_22_23_and_43_14_are_answered(request_pdu: str, answer: str) -> None:
    assert says(request_pdu) == answer
