"""Links, brackets, writes and branches as the manual's tables have them."""

import pytest

from hil_tests.unit.languages.plc.rig import Rig, result_of


@pytest.mark.requirement("RSV-PLC-06", by="gateway.pure.languages.plc.chains:linked")
def test_and_and_or_have_one_priority() -> None:
    assert not result_of("U E0.0\nO E0.1\nU E0.2", "E0.0")
    assert result_of("U E0.0\nO E0.1\nU E0.2", "E0.0", "E0.2")


@pytest.mark.requirement("RSV-PLC-07", by="gateway.pure.languages.plc.chains:Chain.close")
@pytest.mark.parametrize("opened", ["O(", "O (", "O ()", "o("])
def test_a_bracket_is_linked_as_a_whole(opened: str) -> None:
    text = f"U E0.2\n{opened}\nU E0.0\nU E0.1\n)"
    assert result_of(text, "E0.0", "E0.1")
    assert result_of(text, "E0.2")
    assert not result_of(text, "E0.0")
    first = f"{opened}\nU E0.0\nU E0.1\n)\nO E0.2"
    assert result_of(first, "E0.0", "E0.1")
    assert not result_of(first, "E0.1")
    nested = f"U E0.2\n{opened}\nU E0.0\nU(\nO E0.1\nO E0.3\n)\n)"
    assert result_of(nested, "E0.0", "E0.3")
    assert not result_of(nested, "E0.3")
    stored = f"U E0.2\n{opened}\nU E0.0\n= A1.0\nU E0.1\n)"
    assert result_of(stored, "E0.1")
    assert not result_of(stored, "E0.0")


@pytest.mark.requirement("RSV-PLC-08", by="gateway.pure.languages.plc.chains:linked")
def test_exclusive_or() -> None:
    assert not result_of("U E0.0\nXO E0.1", "E0.0", "E0.1")
    assert result_of("U E0.0\nXO E0.1", "E0.1")
    assert result_of("U E0.0\nXON E0.1", "E0.0", "E0.1")
    assert not result_of("U E0.0\nXON E0.1", "E0.0")


def test_brackets_nest_without_a_limit() -> None:
    depth = 60
    text = "U E0.0\n" + "U(\nO E0.1\n" * depth + "O E0.2\n" + ")\n" * depth
    assert result_of(text, "E0.0", "E0.1")
    assert not result_of(text, "E0.1")


def test_a_long_chain_is_linked_from_the_left() -> None:
    text = "U E0.0\n" + "O E0.1\nU E0.2\nXON E0.3\n" * 200
    value = True
    for _ in range(200):
        value = not ((value or False) and True)
    assert result_of(text, "E0.0", "E0.2") == value


@pytest.mark.requirement("RSV-PLC-10", by="gateway.pure.languages.plc.generated:Writer._write")
def test_writes_depend_on_the_result_and_the_next_link_begins_a_chain() -> None:
    rig = Rig("U E0.0\nS M1.0\nU E0.1\nR M1.0\nU E0.2\n= A1.0\nO E0.3\n= A1.1")
    assert (rig.scan().plc.bit(1, 0), rig.scan("E0.0").plc.bit(1, 0), rig.scan().plc.bit(1, 0)) == (False, True, True)
    assert not rig.scan("E0.1", "E0.2").plc.bit(1, 0)
    assert (rig.output("A1.0"), rig.output("A1.1")) == (True, False)
    assert rig.scan("E0.3").outputs[1] == 2


def test_one_result_serves_several_writes() -> None:
    rig = Rig("U E0.0\nS A0.0\nR M5.0\n= A0.1\nS M6.7").scan("E0.0")
    assert (rig.outputs[0], rig.plc.marker(6)) == (3, 0x80)


def test_a_result_is_that_of_the_moment_of_its_chain() -> None:
    rig = Rig("U M1.0\nL 0\nT M1\n= A0.0\nU M1.1\nO(\nU E0.0\n)\n= A0.1")
    rig.plc.set_marker(1, 3)
    rig.scan()
    assert (rig.output("A0.0"), rig.output("A0.1"), rig.plc.marker(1)) == (True, False, 0)


def test_operands_may_be_written_as_the_text_of_the_manual_does() -> None:
    assert result_of("U I 0.0\nU E 0 . 1\nUN O 3.4", "E0.0", "E0.1")


@pytest.mark.requirement("RSV-PLC-26", by="gateway.pure.languages.plc.generated:Writer._jump")
def test_jumps() -> None:
    rig = Rig("U E0.0\nSP L1,1\nU E1.0\nON E1.0\n= A0.0\nM L1\nU E0.0\nSP L2,0\nU E1.0\nON E1.0\n= A0.1\nM L2\nSP Ende\n= A0.2\nM Ende")
    assert rig.scan().outputs[0] == 1
    assert Rig(rig.sources["MAIN"].removeprefix("PLC MAIN\n").removesuffix("\nEND")).scan("E0.0").outputs[0] == 2
    into = "U E0.0\nSP L1,1\nU E0.1\nM L1\nU E0.2"  # a chain begins anew where the jump came from, else it goes on
    assert result_of(into, "E0.0", "E0.2")
    assert result_of(into, "E0.1", "E0.2")
    assert not result_of(into, "E0.2")
    back = "U E0.1\nM L1\nU E0.2\n= A0.0\nU M5.0\nSP L2,1\nUN M5.0\nS M5.0\nU M6.0\nSP L1,0\nM L2"
    assert Rig(back).scan("E0.2").output("A0.0"), "the second time the chain begins at L1"


def test_a_loop_counts() -> None:
    rig = Rig("L 0\nT M10\nM AGAIN\nL M10\nZV ACCU,1\nT M10\nL 200\n<\nSP AGAIN,1").scan()
    assert rig.plc.marker(10) == 200


def test_a_label_met_from_two_sides_goes_on_or_begins() -> None:
    rig = Rig("U E0.0\nSP L,1\nU E0.1\nM L\nO E0.2\n= A0.0")
    assert rig.scan("E0.1").output("A0.0")  # falls in: E0.1 or E0.2
    assert not rig.scan("E0.0", "E0.1").output("A0.0")  # jumps in: E0.2 alone


@pytest.mark.requirement("RSV-PLC-27", by="gateway.pure.languages.plc.generated:Writer._call")
def test_calls_return_behind_the_call() -> None:
    sources = {"MAIN": "PLC MAIN\nU E0.0\nSU P1,1\nU E0.0\nSU P2,0\nSU P3\nL M20\nT A1\nEND", "P1": "PLC P1\nL 7\nT M20\nEND"}
    sources |= {"P2": "PLC P2\nL 9\nT M20\nEND", "P3": "PLC P3\nU E0.1\n= A0.0\nEND"}
    rig = Rig(sources=sources)
    assert rig.scan("E0.0").outputs[:2] == bytes([0, 7])
    assert rig.scan("E0.1").outputs[:2] == bytes([1, 9])


def test_an_invalid_step_is_not_executed_and_numbers_may_be_printed() -> None:
    rig = Rig("2 U E0.0\n3 \\UN E0.0\n4 = A0.0 ; lamp\n; 5 nothing\n\\robot command").scan("E0.0")
    assert (rig.refused, rig.output("A0.0")) == ([], True)


def test_a_subprogram_begins_with_the_result_of_its_caller() -> None:
    sources = {"MAIN": "PLC MAIN\nU E0.0\nSU P\nEND", "P": "PLC P\nS A0.0\nEND"}
    assert not Rig(sources=sources).scan().output("A0.0")
    assert Rig(sources=sources).scan("E0.0").output("A0.0")


@pytest.mark.requirement("RSV-PLC-03", by="gateway.pure.languages.plc.plc:Plc.power_on")
def test_the_power_on_bit_is_there_in_the_first_scan_and_the_result_begins_as_1() -> None:
    rig = Rig("U M1020.4\n= A0.0\nSP GO\nM GO\nU E0.7\nSP X,1\nM X\nR M1020.4")
    assert rig.scan().output("A0.0")
    rig = Rig("R M1020.4")
    assert rig.plc.bit(1020, 4)
    assert not rig.scan().plc.bit(1020, 4)
    kept = rig.plc.retained(0)
    with pytest.raises(ValueError, match=f"{len(kept) - 1} bytes of retained data, {len(kept)} expected"):
        rig.plc.power_on(kept[1:], 0)
    rig.plc.set_marker(20, 0x80)
    for bit in range(4):
        rig.plc.set_bit(1021, bit, bit != 2)  # in error, acknowledged
    rig.plc.set_number(944, 7001)
    rig.plc.power_on(kept, 0)
    assert (rig.plc.bit(1020, 4), rig.runs, rig.plc.marker(20)) == (True, False, 0)
    assert ([rig.plc.bit(1021, bit) for bit in range(3)], rig.plc.number(944)) == ([False, False, True], 0)


def test_inputs_are_written_until_they_are_read_again() -> None:
    rig = Rig("U E0.1\nS E0.0\nU E0.0\n= A0.0\nL 255\nT E39\nL E39\nT A39")
    assert rig.scan("E0.1").outputs[0] == 1
    assert rig.outputs[39] == 255
    assert rig.scan().outputs[0] == 0


def test_inputs_and_outputs_are_markers_too() -> None:
    rig = Rig("U M1968.3\n= M2008.2\nLD M2004\nTD M200").scan("E0.3")
    assert (rig.outputs[0], rig.plc.outputs_written[0]) == (4, 4)
