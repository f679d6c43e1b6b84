"""V1.1b3, section 6: the examples printed there, and what a view's answer turns into."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_tests.lab.virtual.modbus_view import MemoryView
from protocols.modbus.answering import answer
from protocols.modbus.view import ExceptionCode, Kind, home_unit

SERVED = (1, 2, 3, 4, 5, 6, 15, 16)
LEGAL = [
    "01 0000 0001",
    "02 0000 0001",
    "03 0000 0001",
    "04 0000 0001",
    "05 0000 FF00",
    "06 0000 0001",
    "0F 0000 0001 01 01",
    "10 0000 0001 02 0001",
]


def says(view: MemoryView | None, request: str, may_write: bool = True) -> str:
    return answer(bytes.fromhex(request), view, may_write).hex(" ").upper()


def bits_of(text: str) -> list[bool]:
    return [bool(byte >> n & 1) for byte in bytes.fromhex(text) for n in range(8)]


def test_6_1_coils_20_to_38() -> None:
    view = MemoryView()
    view.bits[Kind.COILS][0x13 : 0x13 + 19] = bits_of("CD 6B 05")[:19]
    assert says(view, "01 0013 0013") == "01 03 CD 6B 05"


def test_6_2_discrete_inputs_197_to_218() -> None:
    view = MemoryView(size=300)
    view.bits[Kind.DISCRETE_INPUTS][0xC4 : 0xC4 + 22] = bits_of("AC DB 35")[:22]
    assert says(view, "02 00C4 0016") == "02 03 AC DB 35"


def test_6_3_registers_108_to_110() -> None:
    view = MemoryView()
    view.words[Kind.HOLDING_REGISTERS][0x6B : 0x6B + 3] = [0x022B, 0x0000, 0x0064]
    assert says(view, "03 006B 0003") == "03 06 02 2B 00 00 00 64"


def test_6_4_input_register_9() -> None:
    view = MemoryView()
    view.words[Kind.INPUT_REGISTERS][8] = 10
    assert says(view, "04 0008 0001") == "04 02 00 0A"


def test_6_5_coil_173_on_and_off_again() -> None:
    view = MemoryView()
    assert says(view, "05 00AC FF00") == "05 00 AC FF 00" and view.bits[Kind.COILS][0xAC]
    assert says(view, "05 00AC 0000") == "05 00 AC 00 00" and not any(view.bits[Kind.COILS])


def test_6_6_register_2() -> None:
    view = MemoryView()
    assert says(view, "06 0001 0003") == "06 00 01 00 03"
    assert view.words[Kind.HOLDING_REGISTERS][:3] == [0, 3, 0]


def test_6_11_ten_coils_from_20() -> None:
    view = MemoryView()
    assert says(view, "0F 0013 000A 02 CD 01") == "0F 00 13 00 0A"
    assert view.bits[Kind.COILS][0x13 : 0x13 + 10] == bits_of("CD 01")[:10] and sum(view.bits[Kind.COILS]) == 6


def test_6_12_two_registers_from_2() -> None:
    view = MemoryView()
    assert says(view, "10 0001 0002 04 000A 0102") == "10 00 01 00 02"
    assert view.words[Kind.HOLDING_REGISTERS][:4] == [0, 10, 0x0102, 0]


@pytest.mark.parametrize("request_pdu, size", [("01 0000 07D0", 252), ("02 0000 07D0", 252), ("03 0000 007D", 252), ("04 0000 007D", 252)])
def test_the_longest_answers(request_pdu: str, size: int) -> None:
    result = answer(bytes.fromhex(request_pdu), MemoryView(size=2000))
    assert len(result) == size and result[1] == size - 2


def test_the_longest_writes() -> None:
    view = MemoryView(size=2000)
    assert says(view, "0F 0000 07B0 F6" + "FF" * 246) == "0F 00 00 07 B0" and sum(view.bits[Kind.COILS]) == 1968
    assert says(view, "10 0000 007B F6" + "FFFF" * 123) == "10 00 00 00 7B" and view.words[Kind.HOLDING_REGISTERS].count(0xFFFF) == 123


def test_the_same_request_gets_what_is_there_now_and_never_an_old_answer() -> None:
    view = MemoryView()
    for value in range(3):
        view.words[Kind.INPUT_REGISTERS][5] = value
        view.bits[Kind.DISCRETE_INPUTS][5] = bool(value)
        assert says(view, "04 0005 0001") == f"04 02 00 0{value}"
        assert says(view, "02 0005 0001") == f"02 01 0{int(bool(value))}"


@pytest.mark.parametrize("request_pdu", [*LEGAL, "03 0000 007D", "10 0000 0003 06 0001 0002 0003"])
def test_each_request_is_exactly_one_call(request_pdu: str) -> None:
    view = MemoryView()
    assert not answer(bytes.fromhex(request_pdu), view)[0] & 0x80
    assert view.calls == 1


@pytest.mark.parametrize("request_pdu", ["03 0000 0000", "05 0000 0001", "41", "10 0000 0002 04 0001", "04 FFFF 0002"])
def test_a_refused_request_never_reaches_the_view(request_pdu: str) -> None:
    view = MemoryView()
    assert answer(bytes.fromhex(request_pdu), view)[0] & 0x80
    assert view.calls == 0


@pytest.mark.parametrize("code", list(ExceptionCode))
@pytest.mark.parametrize("request_pdu", LEGAL)
def test_what_the_view_refuses_is_the_answer_with_the_requests_function_code(request_pdu: str, code: ExceptionCode) -> None:
    view = MemoryView()
    view.fails = code
    assert answer(bytes.fromhex(request_pdu), view) == bytes((int(request_pdu[:2], 16) | 0x80, code))


@pytest.mark.parametrize("request_pdu", LEGAL)
def test_a_unit_that_is_not_there_is_0b_for_every_function(request_pdu: str) -> None:
    assert answer(bytes.fromhex(request_pdu), None) == bytes((int(request_pdu[:2], 16) | 0x80, 0x0B))


@pytest.mark.parametrize(
    "request_pdu, answer_pdu", [("0F 00C7 0002 01 03", "8F 02"), ("10 00C7 0002 04 0001 0002", "90 02"), ("03 00C7 0002", "83 02")]
)
def test_a_partly_missing_range_is_02_and_nothing_of_it_is_written(request_pdu: str, answer_pdu: str) -> None:
    view = MemoryView(size=200)
    assert says(view, request_pdu) == answer_pdu
    assert not any(view.bits[Kind.COILS]) and not any(view.words[Kind.HOLDING_REGISTERS])


@pytest.mark.parametrize("request_pdu", [request for request in LEGAL if request[:2] in ("05", "06", "0F", "10")])
def test_who_may_only_read_cannot_write(request_pdu: str) -> None:
    view = MemoryView()
    assert answer(bytes.fromhex(request_pdu), view, may_write=False) == bytes((int(request_pdu[:2], 16) | 0x80, 0x01))
    assert view.calls == 0
    assert says(view, "03 0000 0001", may_write=False) == "03 02 00 00"


class WrongView(MemoryView):
    """A view with a mistake: too few values, or values that are no registers."""

    def __init__(self, words: list[int]) -> None:
        super().__init__()
        self.wrong = words

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        return self.wrong

    def read_bits(self, kind: Kind, address: int, count: int) -> Sequence[bool] | ExceptionCode:
        return [bool(word) for word in self.wrong]


@pytest.mark.parametrize("words", [[], [1], [1, 2, 3], [0x10000, 0], [0, -1]])
def test_a_view_that_gives_wrong_values_is_04_and_never_a_wrong_number(words: list[int]) -> None:
    assert says(WrongView(words), "03 0000 0002") == "83 04"
    assert says(WrongView(words), "01 0000 0002") == ("81 04" if len(words) != 2 else f"01 01 0{bool(words[0]) + 2 * bool(words[1])}")


def test_nothing_is_answered_to_nothing() -> None:
    assert answer(b"", MemoryView()) == b""


@pytest.mark.parametrize("unit, meant", [(0, 1), (1, 1), (255, 1), (2, 2), (254, 254)])
def test_units_0_and_255_mean_the_server_itself(unit: int, meant: int) -> None:
    assert home_unit(unit, 1) == meant


def well_formed(request: bytes, result: bytes) -> bool:
    """Judged from the sections' tables alone: an exception of this function, or the answer this function and quantity must have."""
    if result[0] & 0x80:
        return result[0] == request[0] | 0x80 and len(result) == 2 and result[1] in (1, 2, 3, 4)
    count = int.from_bytes(request[3:5], "big")
    if request[0] in (1, 2):
        return result[:2] == bytes((request[0], (count + 7) // 8)) and len(result) == 2 + result[1]
    if request[0] in (3, 4):
        return result[:2] == bytes((request[0], 2 * count)) and len(result) == 2 + result[1]
    return result == request[:5]


@given(st.binary(min_size=1, max_size=300), st.booleans())
def test_any_bytes_get_a_well_formed_answer(request: bytes, may_write: bool) -> None:
    assert well_formed(request, answer(request, MemoryView(), may_write))


@given(st.sampled_from(SERVED), st.integers(0, 250), st.integers(0, 140), st.binary(max_size=250), st.booleans())
def test_nearly_legal_bytes_get_a_well_formed_answer(function: int, address: int, count: int, rest: bytes, data: bool) -> None:
    head = bytes((function, address >> 8, address & 255, count >> 8, count & 255))
    request = head + bytes((len(rest),)) + rest if data else head
    assert well_formed(request, answer(request, MemoryView()))
