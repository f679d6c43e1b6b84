"""send and fetch: number types, addresses, telegrams, refusals in words."""

import pytest

from gateway.conformance.serial.partners import Station, make
from gateway.links.serial.tool_wire import VirtualWire
from gateway.tools.line.client import Client, Refused
from gateway.tools.line.transfer import BadInput, decoded, encoded, kinds, place, words_needed
from protocols.p3964r.profiles import RHO3, Priority

CHAR = 11_000_000_000 // 9600


def client(partner: str = "good", priority: Priority = Priority.LOW) -> tuple[Client, Station]:
    station = make(partner, RHO3, priority)
    return Client(VirtualWire(station, CHAR), RHO3, Priority.HIGH), station


def test_what_is_sent_is_what_is_fetched() -> None:
    line, station = client()
    data = encoded(kinds("KF,KH,KG"), ["1200", "0A1F", "1200.5"])
    assert data.hex() == "04b00a1f0b4b0800"  # users.md 1: KG of 1200.5
    assert line.send(10, 2, data) == 1
    assert station.blocks.content[10][4:12] == data
    values = decoded(kinds("KF,KH,KG"), 10, 2, line.fetch(10, 2, words_needed(kinds("KF,KH,KG"), 3)))
    assert [(one.address, one.text) for one in values] == [("DB10.DW2", "1200"), ("DB10.DW3", "0A1F"), ("DB10.DD4", "1200.5")]


def test_more_than_128_bytes_are_several_telegrams() -> None:
    line, station = client()
    data = bytes(range(200))
    assert line.send(11, 0, data) == 2
    assert station.blocks.content[11][:200] == data
    assert line.fetch(11, 0, 100) == data


@pytest.mark.parametrize(
    "partner, words",
    [
        ("silent", "no answer to STX within QVZ/ADT 550 ms, 6 attempts"),
        ("includes-stx", "refused (NAK): block check, parity, ZVZ/CDT 220 ms"),
        ("raw", "no reaction telegram within 5 s: does the partner speak RK512"),
    ],
)
def test_what_went_wrong_is_told_in_words(partner: str, words: str) -> None:
    line, _ = client(partner)
    with pytest.raises(Refused) as fault:
        line.fetch(10, 0, 1)
    assert words in str(fault.value)


def test_a_refusal_carries_number_and_words() -> None:
    line, _ = client()
    with pytest.raises(Refused, match="14h, block missing or too short"):
        line.fetch(99, 0, 1)
    assert [(one.ours, one.data.hex()) for one in line.traffic] == [(True, "00004544630000 01ffff".replace(" ", "")), (False, "00000014")]


@pytest.mark.parametrize(
    "kind, text, data",
    [
        ("KF", "-350", "fea2"),
        ("DH", "70000", "00011170"),
        ("KM", "0000000100000001", "0101"),
        ("KY", "12,34", "0c22"),
        ("KC", "AB", "4142"),
        ("KT", "500,1", "1500"),
        ("KZ", "123", "0123"),
        ("BCD", "1234", "1234"),
        ("KG", "-0.005", "f9ae147b"),
        ("REAL", "1,5", "3fc00000"),
        ("bit", "1", "0001"),
    ],
)
def test_every_number_type_is_written_as_a_person_writes_it(kind: str, text: str, data: str) -> None:
    assert encoded(kinds(kind), [text]).hex() == data
    assert encoded(kinds(kind), [decoded(kinds(kind), 1, 0, bytes.fromhex(data))[0].text.strip("'").replace("True", "1")]).hex() == data


@pytest.mark.parametrize(
    "types, values, words",
    [
        ("KF", ["40000"], "range -32768..32767"),
        ("KX", ["1"], "an S5 float is KG, an IEEE one REAL"),
        ("KY", ["12"], "as in 12,34"),
        ("KF", ["abc"], "'abc' is no KF"),
        ("KF", [], "no value"),
    ],
)
def test_a_wrong_value_is_refused_before_anything_is_sent(types: str, values: list[str], words: str) -> None:
    with pytest.raises(BadInput) as fault:
        encoded(kinds(types), values)
    assert words in str(fault.value)


@pytest.mark.parametrize("text", ["DB10.DL2", "DB10.D2.3", "E 1.0", "axis.X.actual", "DB300.DW0"])
def test_only_whole_words_of_a_block_can_be_moved(text: str) -> None:
    with pytest.raises(BadInput):
        place(text)
    assert place("DB10.DD4") == (10, 4)


def test_a_pattern_that_is_no_number_is_shown_with_its_bytes() -> None:
    (one,) = decoded(kinds("BCD"), 1, 0, b"\x12\x3f")
    assert one.value is None
    assert "no BCD" in one.text and one.data == b"\x12\x3f"
