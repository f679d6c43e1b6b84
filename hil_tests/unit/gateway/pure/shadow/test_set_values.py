"""Set values of a bus as a shadow compares them: commands as bits, positions within a tolerance, whatever the family (AX-512)."""

from collections.abc import Callable

import pytest

from drivers.drives.cia402_family import Cia402Family
from drivers.drives.servodyn_family import ServodynFamily
from gateway.pure.shadow.compare import Answer, Comparison, as_data
from gateway.pure.shadow.set_values import SetValues
from hil_tests.lab.virtual.servodyn_bus import CODEC
from protocols.base.machine import Frame, ms
from protocols.servodyn.codec import SetValue

SERVODYN = SetValues(ServodynFamily(CODEC, [(0, 1)]))
CANOPEN = SetValues(Cia402Family([(0, 3)], 10, 10))


def servodyn(position: int, *, on: bool = True) -> Frame:
    return CODEC.writer(1)(SetValue(enable=on, drive_on=on, position_inc=position))


def canopen(position: int, word: int = 0x0F) -> Frame:
    return Frame(0x203, word.to_bytes(2, "little") + position.to_bytes(4, "little", signed=True))


def judged(sets: SetValues, there: Frame, here: Frame, tolerance: float = 0.5) -> list[dict[str, object]]:
    """1000 increments are 1 mm."""
    comparison = Comparison()
    comparison.declare("it", "it", sets.places("A1", 1000.0, tolerance))
    comparison.ours("it", sets.content(here), 0)
    comparison.theirs(Answer("it", ms(50), ms(50), 0, sets.content(there)))
    comparison.finish()
    (block,) = as_data(comparison, 0, ms(50))
    places = block["places"]
    assert isinstance(places, list)
    return places


@pytest.mark.parametrize(("sets", "frame"), [(SERVODYN, servodyn), (CANOPEN, canopen)], ids=["servodyn", "canopen"])
def test_positions_near_one_another_are_equal_and_others_are_reported_in_units(sets: SetValues, frame: Callable[[int], Frame]) -> None:
    assert judged(sets, frame(-7000), frame(-7400)) == []
    (place,) = judged(sets, frame(-7000), frame(-7600))
    assert (place["place"], place["name"], place["largest"]) == ("position", "A1", pytest.approx(0.6))
    first = place["first"]
    assert isinstance(first, dict) and (first["there"], first["here"]) == (-7, -7.6)


def test_commands_are_compared_bit_by_bit() -> None:
    assert {place["place"] for place in judged(SERVODYN, servodyn(0), servodyn(0, on=False))} == {"enable", "drive_on"}
    assert [place["place"] for place in judged(CANOPEN, canopen(0, 0x0F), canopen(0, 0x07))] == ["enable operation"]
    assert judged(CANOPEN, canopen(0, 0x1F), canopen(0, 0x0F)) == [], "bit 4 belongs to the mode"


def test_whose_set_value_it_is() -> None:
    assert SERVODYN.drive(servodyn(0)) == 1 and SERVODYN.drive(canopen(0)) is None
    assert CANOPEN.drive(canopen(0)) == 3 and CANOPEN.drive(Frame(0x183)) is None
    assert (SERVODYN.sync, CANOPEN.sync) == (100, 0x80) and SERVODYN.whole and not CANOPEN.whole


def test_a_telegram_that_is_too_short_says_nothing() -> None:
    assert CANOPEN.content(Frame(0x203, b"\x0f\x00")) == b"" and SERVODYN.content(Frame(210, b"\x01")) == b""


def test_a_node_that_answers_was_started_up_by_its_master_and_one_that_boots_was_not() -> None:
    family = Cia402Family([(0, 3)], 10, 10)
    actual = Frame(0x183, bytes.fromhex("3702 10270000"))
    assert family.hear(actual) is None
    family.answers(3, 8)
    family.answers(4, 8)
    heard = family.hear(actual)
    assert heard is not None and heard.axis == 0 and heard.actual.position_inc == 10_000 and family.expected == 1
    family.hear(Frame(0x703, b"\x00"))
    assert family.hear(actual) is None and family.expected == 0
