"""PHG 2000 variables by number.  Source: rho 3 Releases L9288-9470."""

from collections.abc import Callable
from typing import Any

import pytest

from gateway.pure.controllers.rho3.functions.processes import ProcessTable
from gateway.pure.controllers.rho3.functions.system_variables import SystemVariables, VariableError
from gateway.pure.controllers.rho3.pendant.catalogue import TABLE, TEXT_LISTS, Access, coded_index, split_index
from gateway.pure.controllers.rho3.pendant.variables import (
    AxisView,
    KinematicView,
    Machine,
    Message,
    SetBits,
    SetClock,
    SetFactor,
    Value,
    Variables,
)
from motion.program.factors import Factors

ARM = KinematicView(
    axes=(AxisView("A1", 10.0, 10.5, 0.5), AxisView("A2", 20.0, 20.5), AxisView("A3", 30.0, 30.5, in_position=True)),
    coordinates=("X", "Y", "Z"),
    base_position=(1.0, 2.0, 3.0),
    limits=((100.0, -100.0), (200.0, -200.0)),
    tool_name="GRIPPER",
    tool=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
)
PORTAL = KinematicView(
    axes=(AxisView("B1", 110.0, 110.5), AxisView("B2", 120.0, 120.5), AxisView("B3", 130.0, 130.5, positive=900.0)),
    belts=(("BELT_1", 12.5),),
    factors=Factors(0.5, 0.6, 0.7),
)


def bits(*numbers: int) -> bytes:
    area = bytearray(128)
    for number in numbers:
        area[number // 8] |= 1 << number % 8
    return bytes(area)


def machine(**changes: Any) -> Machine:
    return Machine(rci=bits(85, 1023), pic_inputs=bits(64, 640), flags=bits(0), kinematics=(ARM, PORTAL), **changes)


def variables(**changes: Any) -> Variables:
    return Variables(machine(**changes), SystemVariables(ProcessTable()))


def attempt(function: Callable[..., Any], *arguments: Any) -> Any:
    """Its result, or what it raised: an exception nobody expected must not look like one that was."""
    try:
        return function(*arguments)
    except (VariableError, ValueError) as error:
        return f"{type(error).__name__}: {error}"


def read(code: int, index: int = 0, **changes: Any) -> Value:
    value: Value = attempt(variables(**changes).read, code, index)
    return value


@pytest.mark.requirement("RHO-PHG-01", by="gateway.pure.controllers.rho3.pendant.variables:Variables.read")
def test_signals_are_read_as_bits_bytes_words_and_doubles() -> None:
    assert [read(33026, 85), read(33026, 84), read(33026, 1023)] == [1, 0, 1]
    assert [read(33029, 10), read(33032, 10), read(33035, 124)] == [32, 32, 128 << 24]
    assert [read(33025, 64), read(33027, 0), read(33037, 64), read(33041, 640)] == [1, 1, 1, 1]
    assert str(read(33026, 1024)).startswith("VariableError: 33026 PIC outputs (RCI) bit: index 1024; 0 to 1023")


@pytest.mark.requirement("RHO-PHG-01", by="gateway.pure.controllers.rho3.pendant.variables:Variables._of_kinematic")
def test_positions_are_read_by_axis_of_the_system_or_by_kinematic_and_axis() -> None:
    assert read(33282, 2) == 20.5 and read(33282, 4) == 110.5, "a simple index counts the axes of the whole system"
    assert read(33282, coded_index(2, 3)) == 130.5 and read(33281, coded_index(1, 1)) == 10.0
    assert [read(33291, 5), read(33294, 3), read(33294, 1), read(33293, 1), read(33289, 6)] == ["B2", "*", " ", 0.5, 900.0]
    assert [read(33297), read(33298), read(33537, 2), read(33300, 1), read(33299, coded_index(2, 1))] == [6, 1, 3, "BELT_1", 12.5]
    assert [read(33286, coded_index(1, 2)), read(33287, 2), read(33288, 2), read(33292, 3)] == [2.0, 200.0, -200.0, "Z"]
    assert [read(33539, 1), read(33540, coded_index(1, 6)), read(33541, coded_index(2, 6))] == ["GRIPPER", 6.0, 0.0]


@pytest.mark.parametrize(
    "code, index", [(33282, 7), (33282, coded_index(3, 1)), (33282, coded_index(2, 4)), (33540, 1), (33284, 1), (33537, 3)]
)
def test_what_is_not_there_is_reported_with_what_is(code: int, index: int) -> None:
    assert str(read(code, index)).startswith("VariableError: ")


@pytest.mark.requirement("RHO-PHG-02", by="gateway.pure.controllers.rho3.pendant.catalogue:coded_index")
def test_a_coded_index_holds_kinematic_and_component() -> None:
    assert [attempt(coded_index, *pair) for pair in ((2, 3), (1, 1), (127, 255))] == [32768 + 515, 33025, 0xFFFF]
    for pair in ((0, 1), (128, 1), (1, 0), (1, 256)):
        assert attempt(coded_index, *pair) == f"ValueError: kinematic {pair[0]}, component {pair[1]}: 1..127 and 1..255"


@pytest.mark.requirement("RHO-PHG-02", by="gateway.pure.controllers.rho3.pendant.catalogue:split_index")
def test_an_index_is_taken_apart_again() -> None:
    assert [attempt(split_index, index) for index in (33283, 7, 0xFFFF)] == [(2, 3), (0, 7), (127, 255)]


@pytest.mark.requirement("RHO-PHG-03", by="gateway.pure.controllers.rho3.pendant.variables:Variables.write")
def test_what_may_be_written_becomes_an_order() -> None:
    some = variables()
    assert attempt(some.write, 33793, 0.5) == SetFactor(0, "velocity", 0.5)
    assert attempt(some.write, 33795, 1) == SetFactor(0, "deceleration", 1.0)
    assert attempt(some.write, 33803, 0.25, 2) == SetFactor(2, "acceleration", 0.25)
    assert attempt(some.write, 33037, 1, 64) == SetBits(64, (True,))
    assert attempt(some.write, 33038, 0x81, 8) == SetBits(64, (True, *[False] * 6, True))
    assert attempt(some.write, 34050, "09:40") == SetClock(34050, "09:40")


@pytest.mark.requirement("RHO-PHG-03", by="gateway.pure.controllers.rho3.pendant.variables:Variables._variable")
@pytest.mark.parametrize(
    "code, value, index, words",
    [
        (33028, 1, 0, "is only read"),
        (33793, 1.01, 0, "0 to 1"),
        (33793, -0.01, 0, "0 to 1"),
        (33793, float("nan"), 0, "0 to 1"),
        (33793, "fast", 0, "0 to 1"),
        (33802, 0.5, 3, "kinematic 3: 1 to 2"),
        (33037, 1, 63, "64 to 511"),
        (33037, 2, 64, "0 to 1"),
        (33038, 256, 8, "0 to 255"),
        (33000, 1, 0, "no such variable"),
    ],
)
def test_what_may_not_be_written_is_refused_in_words(code: int, value: Value, index: int, words: str) -> None:
    said = str(attempt(variables().write, code, value, index))
    assert said.startswith("VariableError: ") and words in said


def test_stop_process_is_written_and_not_read() -> None:
    assert "is only written" in str(read(34322))


def test_factors_and_their_limits() -> None:
    assert [read(33793), read(33802, 2), read(33803, 2), read(33804, 2)] == [1.0, 0.5, 0.6, 0.7]
    assert [read(33796), read(33797), read(33800), read(33801), read(33805, 1), read(33806, 1), read(33810, 16)] == [0, 1, 0, 1, 0, 1, 1]


def test_messages_clock_and_text_lists() -> None:
    known: dict[str, Any] = {
        "errors": (Message(647, 5, "position error"), Message(13, 0, "stack")),
        "clock_ms": 70_000,
        "texts": {34053: "TO07"},
    }
    lists: dict[str, Any] = {"text_lists": {5: ["one", "two"]}}
    assert [read(34061, **known), read(34060, **known), read(34049, **known), read(34053, **known)] == [2, 0, 70_000 - 65_536, "TO07"]
    assert [read(code, 1, **known) for code in range(34067, 34072)] == [
        "position error 0005h 647",
        "position error 0005h",
        "position error",
        5,
        647,
    ]
    assert [read(34067, 2, **known), read(34071, 3, **known), read(34069, 3, **known)] == ["stack 13", 0, ""]
    assert [read(34821, 2, **lists), read(34821, 3, **lists), read(34820, 1, **lists)] == ["two", "", ""]


def test_the_table_has_every_row_of_the_manual() -> None:
    groups = [sum(base < code < base + 256 for code in TABLE) for base in (33024, 33280, 33536, 33792, 34048, 34304, 34560)]
    assert groups == [36, 19, 5, 18, 23, 18, 10]
    assert [code for code, variable in TABLE.items() if variable.access is Access.WRITE] == [34322]
    assert len(TEXT_LISTS) == 256 and TABLE[35071].name == "VTL255"
