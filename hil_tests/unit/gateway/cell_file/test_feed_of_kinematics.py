"""[rc_inputs] wired: feed inputs of single kinematics, and entries for the override of one (AX-1787)."""

import pytest

from gateway.assembly.axis_signals import rc_numbers
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.records.cell import Permit
from hil_tests.lab.cells.arm_and_scara import cell_text
from hil_tests.lab.cells.carried_cell import ARM

HOLD = 'wired = ["KIN_2_FEED_HOLD_N_RCI"]'
OWNER = 'owner = { "3" = "plc" }'


def two_robots(lines: str, *, owner: str = OWNER) -> str:
    return cell_text().replace(f"[rc_inputs]\n{OWNER}", f"[rc_inputs]\n{owner}\n{lines}", 1)


def warnings(text: str) -> list[str]:
    return [notice.text for notice in load_cell(str(ARM), text).warnings if "KIN_" in notice.text]


def test_the_inputs_that_are_named_are_read_where_they_lie() -> None:
    wired = 'wired = ["KIN_2_FEED_HOLD_N_RCI", "KIN_1_FEED_ALLOW_RCE"]\n[signals]\nKIN_1_FEED_ALLOW_RCI = 700'
    assert rc_numbers(load_cell(str(ARM), two_robots(wired))).kinematics == ((2, Permit.RUN, 161), (1, Permit.FEED, 700))
    assert rc_numbers(load_cell(str(ARM), cell_text())).kinematics == ()


def test_one_without_a_writer_is_a_warning_and_one_in_an_owned_byte_is_none() -> None:
    assert warnings(two_robots(HOLD)) == ["KIN_2_FEED_HOLD_N_RCI has no writer: it reads 0 and kinematic 2 will not move"]
    assert warnings(two_robots(HOLD, owner='owner = { "3" = "plc", "20" = "plc" }')) == []


def test_one_that_is_written_and_not_named_is_a_warning() -> None:
    route = '[[route]]\nname = "held"\nfrom = "cell.ready"\nto = "KIN_2_FEED_HOLD_N_RCI"\n\n[[modbus]]'
    assert warnings(cell_text().replace("[[modbus]]", route, 1)) == [
        "KIN_2_FEED_HOLD_N_RCI written and not read: name them in [rc_inputs] wired"
    ]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (two_robots('wired = ["FEED_HOLD_N_RCI"]'), "names feed inputs of single kinematics"),
        (two_robots('wired = ["KIN_3_FEED_HOLD_N_RCI"]'), "the cell has 2 kinematics"),
        (ARM.read_text().replace("[rc_inputs]", '[rc_inputs]\nwired = ["KIN_1_FEED_HOLD_N_RCI"]', 1), "has one kinematic only"),
    ],
)
def test_what_cannot_be_wired_is_refused_with_its_reason(text: str, words: str) -> None:
    with pytest.raises(CellFaults) as faults:
        load_cell(str(ARM), text)
    assert [words in str(fault) and fault.key == "rc_inputs.wired" for fault in faults.value.faults] == [True]


def test_an_override_entry_needs_a_robot_that_moves_for_itself() -> None:
    demo = read_text(find_config("demo", "cells"))
    with pytest.raises(CellFaults) as faults:
        load_cell("demo.toml", demo.replace('to = "cell.override", ', 'to = "robot.portal.override",', 1))
    assert "no such robot" in str(faults.value.faults[0])
