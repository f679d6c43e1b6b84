"""[signals]: axisgate's own numbers may be moved, the manual's may not (AX-002)."""

import pytest

from gateway.assembly.axis_signals import rc_numbers
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.cell.faults import CellFaults

DEMO = read_text(find_config("demo", "cells"))


def with_signals(lines: str) -> str:
    return DEMO.replace("[rc_inputs]", f"[signals]\n{lines}\n\n[rc_inputs]", 1)


def test_a_moved_signal_has_its_new_number_and_a_row_moves_as_a_whole() -> None:
    numbers = rc_numbers(load_cell("demo.toml", with_signals("EMSTOP_OK_RCI = 600\nINPOS_1_RCO = 300")))
    assert (numbers.chain, numbers.in_position, numbers.control) == (600, 300, 25)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("K01_A_MN_RCI = 600", "only axisgate's own"),
        ("READY_RCO = 72", "already used by PHG_ACTV_RCO"),
        ("EMSTOP_OK_RCI = 600\nFEED_ALLOW_RCI = 600", "already used by EMSTOP_OK_RCI"),
        ("READY_RCO = 1024", "1023"),
    ],
)
def test_what_cannot_be_moved_is_refused_with_its_reason(lines: str, words: str) -> None:
    with pytest.raises(CellFaults) as faults:
        load_cell("demo.toml", with_signals(lines))
    assert words in str(faults.value.faults[0])


def test_a_number_the_manual_itself_prints_is_allowed() -> None:
    assert load_cell("demo.toml", with_signals("MSD_ACTI_RCO = 135")).signals == {"MSD_ACTI_RCO": 135}
    with pytest.raises(CellFaults, match="only axisgate's own"):
        load_cell("demo.toml", with_signals("MSD_ACTI_RCO = 134"))
