"""rho 3 Releases part 5, 6.2 to 6.14.1: how much digital I/O fits beside axes, which bit rates and clocks the control starts with."""

import pathlib
import re

import pytest

from gateway.cell_file.load import CellFaults, load_cell
from gateway.commands import check
from gateway.files.find import find_config, read_text
from gateway.pure.controllers.rho3.can.rules import Block, BusSetup, Finding, Setup, judge
from gateway.pure.controllers.rho3.can.tables import RATES, fits, kbit_s


def block(number: int, length: int = 8, first: int = 541) -> Block:
    return Block(64 + 8 * number, length, first + number)


def found(setup: Setup) -> list[tuple[int, int, str, str]]:
    """(code, system error, PHG text, parameter) of everything wrong."""
    return [(each.code, each.system_error, each.text, each.parameter) for each in judge(setup)]


def bus(axes: int, inputs: int, outputs: int, baud: int = 0) -> BusSetup:
    ins, outs = tuple(block(n) for n in range(inputs)), tuple(block(n, first=471) for n in range(outputs))
    return BusSetup(axes, inputs, outputs, baud, ins, outs)


@pytest.mark.requirement("RHO-CAN-03", by="gateway.pure.controllers.rho3.can.tables:fits")
def test_bytes_of_inputs_and_outputs_by_number_of_axes() -> None:
    table = {6: (0, 0), 5: (8, 8), 4: (8, 8), 3: (16, 16), 2: (24, 24), 1: (32, 32), 0: (40, 32)}  # L7263-7268, typed by hand
    for axes, (inputs, outputs) in table.items():
        assert fits(axes, inputs, outputs) is True, axes
        assert fits(axes, inputs + 1, outputs) is False, axes
        assert fits(axes, inputs, outputs + 1) is False, axes


@pytest.mark.requirement(
    "RHO-CAN-03", "RHO-CAN-06", by=("gateway.pure.controllers.rho3.can.rules:judge", "gateway.pure.controllers.rho3.can.rules:_overflow")
)
def test_too_many_blocks_are_3732_can_dp_overflow() -> None:
    overflow = (3732, 149, "CAN DP overflow", "P30")
    assert found(Setup(8, (bus(6, 1, 0),))) == [overflow]
    assert found(Setup(8, (bus(6, 0, 1),))) == [overflow]
    assert found(Setup(8, (bus(3, 2, 2),))) == []
    assert found(Setup(8, (bus(3, 3, 2),))) == [overflow]
    assert found(Setup(8, (bus(0, 5, 4),))) == []
    assert found(Setup(8, (bus(7, 0, 0),))) == [(3732, 149, "CAN DP overflow", "P401")]


@pytest.mark.requirement("RHO-CAN-05", by="gateway.pure.controllers.rho3.can.tables:kbit_s")
def test_baud_codes_0_to_3_and_nothing_beyond() -> None:
    assert [kbit_s(code) for code in range(-1, 5)] == [0, 1000, 500, 250, 125, 0]
    assert [RATES[code].cable_m for code in range(4)] == [20, 40, 80, 160]


@pytest.mark.requirement(
    "RHO-CAN-05", by=("gateway.pure.controllers.rho3.can.rules:_overflow", "gateway.pure.controllers.rho3.can.rules:_rate")
)
def test_blocks_beyond_five_and_four_and_unknown_baud_codes_are_rejected() -> None:
    assert found(Setup(8, (bus(0, 6, 0),))) == [(3732, 149, "CAN DP overflow", "P30")]
    assert found(Setup(8, (bus(0, 0, 5),))) == [(3732, 149, "CAN DP overflow", "P30")]
    assert found(Setup(8, (bus(0, 5, 4, baud=3),))) == []
    assert found(Setup(8, (bus(0, 5, 4, baud=4),))) == [(0, 0, "no such bit rate", "P30")]


@pytest.mark.requirement("RHO-CAN-04", by="gateway.pure.controllers.rho3.can.rules:_rate")
def test_a_bus_with_axes_runs_at_1_mbaud_or_not_at_all() -> None:
    assert found(Setup(8, (bus(1, 0, 0, baud=1),))) == [(3733, 150, "CAN incorr. BAUDR.", "P30")]
    assert found(Setup(8, (bus(0, 0, 0, baud=1), bus(1, 0, 0, baud=0)))) == []


@pytest.mark.requirement("RHO-CAN-07", by="gateway.pure.controllers.rho3.can.rules:_undefined")
def test_a_block_announced_and_not_defined_is_3734() -> None:
    undefined = (3734, 151, "CAN I/O block undef.", "P31")
    assert found(Setup(8, (BusSetup(0, 2, 0, 0, (block(0),)),))) == [undefined]
    assert found(Setup(8, (BusSetup(0, 1, 0, 0, (block(0, length=0),)),))) == [undefined]
    assert found(Setup(8, (BusSetup(0, 1, 0, 0, (Block(124, 8, 541),)),))) == [undefined]
    assert found(Setup(8, (BusSetup(0, 0, 2, 0, (), (block(0, first=471),)),))) == [(3734, 151, "CAN I/O block undef.", "P32")]


@pytest.mark.requirement("RHO-CAN-12", by="gateway.pure.controllers.rho3.can.rules:_clock")
def test_clock_limits_with_can_axes() -> None:
    with_axes, without = (bus(1, 0, 0),), (bus(0, 1, 0),)
    slow, watchdog = [(0, 0, "clock too slow for the boosters", "P5")], [(0, 0, "clock too slow without SERVO-i", "P5")]
    assert found(Setup(33, with_axes, (3, 4))) == slow
    assert found(Setup(32, with_axes, (3, 4))) == []  # type 4 stands for a servo board with intelligence
    assert found(Setup(27, with_axes, (3,))) == watchdog
    assert found(Setup(27, with_axes)) == watchdog
    assert found(Setup(26, with_axes, (3,))) == []
    assert found(Setup(33, without, (3,))) == []


def test_boards_identifiers_and_bytes_that_cannot_be() -> None:
    assert found(Setup(8, (), (3, 3))) == [(0, 0, "two CAN modules", "P15")]
    assert found(Setup(8, (), (0, 5))) == [(0, 0, "board on the wrong place", "P15")]
    own = BusSetup(0, 1, 1, 0, (Block(92, 4, 471),), (Block(92, 4, 471),))
    assert found(Setup(8, (own,))) == [(0, 0, "identifier twice", "P32")]
    assert found(Setup(8, (BusSetup(0, 1, 0, 0, (Block(92, 4, 500),)),))) == [(3734, 151, "CAN I/O block undef.", "P31")]
    over = BusSetup(0, 2, 0, 0, (Block(92, 4, 541), Block(95, 1, 542)))
    assert found(Setup(8, (over,))) == [(0, 0, "bytes twice", "P31")]


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        ("{ inputs = 0, outputs = 0, baud = 0 }", "{ inputs = 1, outputs = 0, baud = 0 }", "rho3.P30", "3732 CAN DP overflow"),
        ("{ inputs = 0, outputs = 0, baud = 0 }", "{ inputs = 1, outputs = 0, baud = 0 }", "rho3.P30", "3 -> 16, 2 -> 24, 1 -> 32"),
        ("{ inputs = 0, outputs = 0, baud = 0 }", "{ inputs = 0, outputs = 0, baud = 1 }", "rho3.P30", "3733 CAN incorr. BAUDR."),
        ("inputs = 2, outputs = 2", "inputs = 3, outputs = 2", "rho3.P31", "3734 CAN I/O block undef."),
        ("P5   = 8 ", "P5   = 30", "rho3.P5", "at most 26 ms without an additional SERVO-i"),
        ("P15  = [3] ", "P15  = [3, 3]", "rho3.P15", "two CAN modules are not possible"),
    ],
)
def test_check_explains_with_the_table_and_the_old_number(old: str, new: str, key: str, said: str) -> None:
    text = read_text(find_config("rho3-servodyn", "cells"))
    assert old in text
    try:
        load_cell("cell.toml", text.replace(old, new, 1))
        told: list[str] = []
    except CellFaults as faults:
        told = [str(fault) for fault in faults.faults if fault.key == key]
    assert any(said in line for line in told), told


BUS_2 = "{ inputs = 2, outputs = 2, baud = 1 }"
BUS_1 = "{ inputs = 0, outputs = 0, baud = 0 }"
REFUSED = [  # what is typed instead of what, and what `axisgate check` prints: number, text and system error of the manual (L7489-7500)
    (BUS_1, "{ inputs = 0, outputs = 1, baud = 0 }", "rho3.P30", "the rho 3 shows 3732 CAN DP overflow, system error 149"),
    (BUS_2, "{ inputs = 6, outputs = 2, baud = 1 }", "rho3.P30[1].inputs", "3732 CAN DP overflow, system error 149"),
    (BUS_2, "{ inputs = 2, outputs = 5, baud = 1 }", "rho3.P30[1].outputs", "3732 CAN DP overflow, system error 149"),
    (BUS_1, "{ inputs = 0, outputs = 0, baud = 3 }", "rho3.P30", "the rho 3 shows 3733 CAN incorr. BAUDR., system error 150"),
    (BUS_2, "{ inputs = 2, outputs = 2, baud = 4 }", "rho3.P30[1].baud", "1 = 500 kbit/s, 2 = 250 kbit/s, 3 = 125 kbit/s"),
    (BUS_2, "{ inputs = 2, outputs = 3, baud = 1 }", "rho3.P32", "the rho 3 shows 3734 CAN I/O block undef., system error 151"),
    ("start = 88, length = 8, id = 541", "start = 124, length = 8, id = 541", "rho3.P31", "3734 CAN I/O block undef., system error 151"),
    ("P5   = 8 ", "P5   = 33", "rho3.P5", "boosters on CAN accept no cycle above 32 ms"),
    ("P5   = 8 ", "P5   = 27", "rho3.P5", "at most 26 ms without an additional SERVO-i in P15"),
]


def checked(capsys: pytest.CaptureFixture[str], tmp_path: pathlib.Path, *changes: tuple[str, str], language: str = "en") -> list[str]:
    """The errors that `axisgate check` prints of rho3-servodyn, changed so."""
    text = read_text(find_config("rho3-servodyn", "cells"))
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (tmp_path / "cell.toml").write_text(text)
    code = check.main([str(tmp_path / "cell.toml"), "--language", language])
    printed = capsys.readouterr().out
    assert code == (2 if changes else 0)
    return [line.partition("cell.toml:")[2] for line in printed.splitlines() if ": rho3." in line]


@pytest.mark.parametrize(("old", "new", "key", "said"), REFUSED)
def test_the_command_refuses_each_with_what_the_old_control_shows(
    old: str, new: str, key: str, said: str, capsys: pytest.CaptureFixture[str], tmp_path: pathlib.Path
) -> None:
    lines = checked(capsys, tmp_path, (old, new))
    assert [line for line in lines if f": {key} = " in line and said in line], lines
    assert len(lines) == 1 or new.startswith("{ inputs = 0, outputs = 1")  # whose block is not defined either


@pytest.mark.parametrize("old, new", [(old, new) for old, new, *_ in REFUSED])
def test_each_is_said_in_german(old: str, new: str, capsys: pytest.CaptureFixture[str], tmp_path: pathlib.Path) -> None:
    english, german = (checked(capsys, tmp_path, (old, new), language=language)[0] for language in ("en", "de"))
    assert english != german
    assert not re.search(r"\b(the|with|at most|leave|shows|announces|without|take|more|of)\b", german), german


@pytest.mark.parametrize("code, rate", [*enumerate(["1 Mbit/s", "500 kbit/s", "250 kbit/s", "125 kbit/s"])])
def test_the_bus_of_a_cell_runs_at_the_rate_of_p30(code: int, rate: str) -> None:
    text = read_text(find_config("rho3-servodyn", "cells")).replace(BUS_2, BUS_2.replace("baud = 1", f"baud = {code}"))
    assert [bus.bitrate for bus in load_cell("cell.toml", text).bus] == ["1 Mbit/s", rate]


def test_blocks_of_a_bus_that_the_cell_lacks_or_that_carries_none_are_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: pathlib.Path
) -> None:
    """Nothing would ever be exchanged there."""
    text = read_text(find_config("rho3-servodyn", "cells"))
    second = text[text.index('[[bus]]\nname     = "io"') : text.index("[robot]")]
    (line,) = checked(capsys, tmp_path, (second, ""))
    assert ": rho3.P31 = bus = 2: bus 2 of the P list is [[bus]] number 2 of this file, which has 1; add it" in line
    (line,) = checked(capsys, tmp_path, ('protocol = "rho3-io"', 'protocol = "canopen"'))
    assert 'rho3.P31 = bus = 2: bus io uses "canopen", which carries no blocks of P31 and P32; add a [[bus]]' in line
    assert checked(capsys, tmp_path) == []


def test_a_finding_without_a_number_has_no_system_error() -> None:
    assert Finding(0, "", "P5", "", "").system_error == 0
