"""Loading, storing, comparing and calculating."""

import pytest

from hil_tests.unit.languages.plc.rig import Rig, accus_of, result_of

HIGH = 0x7FFFFFFF


@pytest.mark.requirement("RSV-PLC-09", by="gateway.pure.languages.plc.generated:Writer._accumulators")
def test_accumulator_logic() -> None:
    assert [accus_of(f"L 0CH\nL 0AH\n{word} ACCU") for word in ("U", "O", "XO")] == [(8, 12), (14, 12), (6, 12)]
    assert result_of("L 5\nL 3\n>\nXO ACCU"), "a comparison reads the accumulators as they were"


@pytest.mark.requirement("RSV-PLC-11", by="gateway.pure.languages.plc.generated:Writer._write")
def test_bytes_are_loaded_without_sign_and_stored_as_low_bytes() -> None:
    rig = Rig("L 5\nL M20\nTD M40\nTA\nTD M44\nL 1FFH\nT M30")
    rig.plc.set_marker(20, 0x80)
    rig.scan()
    assert (rig.plc.number(40), rig.plc.number(44), rig.plc.marker(30), rig.plc.marker(31)) == (128, 5, 255, 0)


@pytest.mark.requirement("RSV-PLC-12", "RSV-PLC-31", by="gateway.pure.languages.plc.plc:Plc.set_number")
def test_double_words_have_the_lowest_byte_first() -> None:
    rig = Rig("LD M20\nTD M24\nTD A0\nL A0\nT M30")
    rig.plc.set_number(4 * (6 - 1), 0x12345678)  # _SPS[6]
    rig.scan()
    assert (rig.plc.number(4 * (7 - 1)), rig.outputs[:4], rig.plc.marker(30)) == (0x12345678, bytes([0x78, 0x56, 0x34, 0x12]), 0x78)


@pytest.mark.requirement("RSV-PLC-13", by="gateway.pure.languages.plc.steps:constant")
def test_constants() -> None:
    assert accus_of("L 12ACH\nL BA12CD33H") == (0xBA12CD33 - 2**32, 0x12AC)
    assert accus_of("L 1000\nL -5") == (-5, 1000)
    assert Rig("L BA12CD33").refused != []
    assert Rig("L 100000000H").refused != []


@pytest.mark.requirement("RSV-PLC-20", by="gateway.pure.languages.plc.steps:_count")
def test_accumulator_counts() -> None:
    assert accus_of("L 10\nZV ACCU,5")[0] == 15
    assert accus_of("L 15\nZR ACCU, 5")[0] == 10
    assert accus_of(f"L {HIGH}\nZV ACCU,1")[0] == -HIGH - 1
    assert "0..255" in Rig("ZV ACCU,256").refused[0]


@pytest.mark.requirement("RSV-PLC-21", by="gateway.pure.languages.plc.generated:Writer._command")
@pytest.mark.parametrize(
    ("word", "holds"),
    [("=?", (0, 1, 0)), ("><", (1, 0, 1)), (">=", (1, 1, 0)), (">", (1, 0, 0)), ("<=", (0, 1, 1)), ("<", (0, 0, 1))],
)
def test_the_second_accumulator_is_compared_with_the_first(word: str, holds: tuple[int, int, int]) -> None:
    assert [result_of(f"L {two}\nL {one}\n{word}") for two, one in ((5, 3), (3, 3), (-3, 5))] == [bool(each) for each in holds]


def test_a_comparison_is_linked_on_and_is_that_of_its_moment() -> None:
    assert not result_of("L 5\nL 3\n>\nU E0.0")
    assert result_of("L 5\nL 3\n>\nTA\nL 9\nU E0.0", "E0.0")


@pytest.mark.requirement("RSV-PLC-22", by="gateway.pure.languages.plc.arithmetic:rotate_left")
def test_shift_and_rotate() -> None:
    assert accus_of("L 1\nSH L,31")[0] == -(2**31)
    assert accus_of("L 80000001H\nRO L,1")[0] == 3
    assert accus_of("L 80000000H\nSH R , 31")[0] == 1
    assert accus_of("L 1\nRO R,1")[0] == -(2**31)
    assert accus_of("L 5\nRO R,0\nSH L,0\nRO L,0")[0] == 5
    assert Rig("SH R,32").refused != []


@pytest.mark.requirement("RSV-PLC-23", by="gateway.pure.languages.plc.arithmetic:divide")
def test_order_of_the_operands() -> None:
    assert accus_of("L 10\nL 3\n-")[0] == 7
    assert accus_of("L 10\nL 3\n--")[0] == 7
    assert accus_of("L 10\nL 3\n+")[0] == 13
    assert accus_of("L 17\nL 5\nDI") == (3, 2)
    assert accus_of("L -17\nL 5\nDI") == (-3, -2)
    assert accus_of("L -3\nL 5\nMU")[0] == -15


@pytest.mark.requirement("RSV-PLC-24", by="gateway.pure.languages.plc.generated:Writer._dangerous")
@pytest.mark.parametrize("text", ["L 1\nL 0\nDI", "L 65536\nL 32768\nMU", "L 80000000H\nL -1\nDI"])
def test_the_error_marker_of_multiplication_and_division(text: str) -> None:
    assert Rig(text).scan().plc.bit(1020, 5)
    assert not Rig("L 6\nL 2\nDI\nL 3\nMU").scan().plc.bit(1020, 5)


@pytest.mark.requirement("RSV-PLC-25", by="gateway.pure.languages.plc.arithmetic:to_bcd")
def test_complements_exchange_and_bcd() -> None:
    assert accus_of("L 0\nK E")[0] == -1
    assert accus_of("L 5\nK Z")[0] == -5
    assert accus_of("L 1\nL 2\nTA") == (1, 2)
    assert accus_of("L 25\nHD")[0] == 0x25
    assert accus_of("L 25H\nDH")[0] == 25
    assert accus_of("L 99999999\nHD\nDH")[0] == 99999999
    assert accus_of("L 1AH\nDH")[0] == 0x1A
    assert accus_of("L 100000000\nHD")[0] == 100000000


def test_a_hexadecimal_number_may_have_zeros_in_front() -> None:
    """A letter in front is a name to many assemblers, so lists write 0FFFFFFFFH."""
    assert accus_of("L 0FFFFFFFFH\nL 00000000FH") == (15, -1)
