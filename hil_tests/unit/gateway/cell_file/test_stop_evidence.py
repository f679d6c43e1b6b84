"""Drives without 6007h: the report of a loss test on real drives stands for it, `check` names it, everything else is refused."""

import json
import pathlib
from typing import Any

import pytest

import configs
from drivers.drives.cia402_boot import boot
from gateway.assembly.canopen_nodes import node_plans
from gateway.cell_file.load import CellFaults, load_cell
from gateway.tools.drives.loss_test import Stop, write
from hil_tests.lab.virtual.one_node import NODE, OneNode
from protocols.canopen import sdo

FOLDER = pathlib.Path(configs.__path__[0])
DEMO_402 = (FOLDER / "cells" / "demo-402.toml").read_text()
REPORT = "loss-test-demo-402.json"


def stop(*, good: bool = True) -> Stop:
    return Stop("gateway", "A3", "deg", 90.0, 152.0, 240.0, 12.5, 166.0, good)


def own_cell(folder: pathlib.Path, evidence: str) -> pathlib.Path:
    """A cell in `folder` whose axis A3 names the evidence."""
    file = folder / "own.toml"
    file.write_text(DEMO_402.replace('name   = "A3"', f'name   = "A3"\nstop_evidence = "{evidence}"'))
    return file


def reported(folder: pathlib.Path, *stops: Stop, evidence: str = "bus", **changed: Any) -> None:
    """The report of a loss test on a cell with the drives of demo-402."""
    written, _ = write(load_cell("demo-402"), list(stops), folder, evidence)
    written.replace(folder / REPORT)
    if changed:
        (folder / REPORT).write_text(json.dumps(json.loads((folder / REPORT).read_text()) | changed))


def hints(file: pathlib.Path) -> list[str]:
    with pytest.raises(CellFaults) as caught:
        load_cell(str(file))
    return [f"{fault.key}: {fault.hint}" for fault in caught.value.faults]


def test_a_drive_of_the_type_that_was_measured_is_accepted_and_named(tmp_path: pathlib.Path) -> None:
    reported(tmp_path, stop())
    cell = load_cell(str(own_cell(tmp_path, REPORT)))
    said = [notice for notice in (*cell.warnings, *cell.notes) if notice.where == "axis A3" and "6007h" in notice.text]
    assert len(said) == 1 and REPORT in said[0].text and "152 ms" in said[0].text
    plan = dict(node_plans(cell, cell.bus[0], 4, simulated=False))["A3"]
    rig = OneNode()
    dialogue = rig.dialogue()
    dialogue.refuse[0x6007, 0] = sdo.Abort.NO_OBJECT
    dialogue.absent.add((0x6007, 0))
    booted = dialogue.carry(boot(plan))
    assert rig.slave.seat(NODE).node.state.name == "OPERATIONAL"
    assert any("6007h" in note and REPORT in note and "150 ms" in note for note in booted.notes)


@pytest.mark.parametrize(
    ("evidence", "good", "changed", "words"),
    [
        ("bus", False, {}, "the drive of A3 did not stop as required"),
        ("emulator", True, {}, "measured on emulated drives"),
        ("bus", True, {"data_sheets": {"A3": "another"}}, "no drive with the data sheet axisgate_402.eds"),
        ("bus", True, {"data_sheets": 7}, "no drive with the data sheet"),
        ("bus", True, {"stops": []}, "no drive with the data sheet"),
    ],
)
def test_a_report_that_proves_nothing_is_refused_with_its_reason(
    tmp_path: pathlib.Path, evidence: str, good: bool, changed: dict[str, object], words: str
) -> None:
    reported(tmp_path, stop(good=good), evidence=evidence, **changed)
    assert any("axis.A3.stop_evidence" in hint and words in hint for hint in hints(own_cell(tmp_path, REPORT)))


def test_a_report_that_is_missing_or_torn_is_refused_with_what_to_do(tmp_path: pathlib.Path) -> None:
    file = own_cell(tmp_path, REPORT)
    assert any("No such file" in hint and "loss-test CELL --running" in hint for hint in hints(file))
    for text in ('{"evidence": "bus', "[]", "\ufeff", "[" * 100_000):
        (tmp_path / REPORT).write_text(text)
        assert any("is not a report of axisgate drive loss-test" in hint for hint in hints(file))


def test_the_cell_of_the_test_itself_is_warned_of() -> None:
    text = DEMO_402.replace("[defaults.axis]", '[defaults.axis]\nstop_evidence = "untested"', 1)
    cell = load_cell("cell.toml", text)
    said = [notice for notice in cell.warnings if "untested" in notice.text]
    assert [notice.where for notice in said] == [f"axis A{n}" for n in range(1, 7)]
