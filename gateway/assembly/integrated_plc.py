"""The integrated PLC of a Reis as set up by a cell: folder of its programs, its start program, file of its retained data."""

import json
import pathlib
from typing import TYPE_CHECKING

from gateway.assembly.program_memory import memory_folder, plc_folder
from gateway.pure.cell.cell import Cell
from gateway.pure.languages.plc.translation import start_in_folder, start_name
from gateway.runtime.state_folder import place

if TYPE_CHECKING:
    from gateway.assembly.run import RunPlan

SYSTEM_VALUES = "$SYSTEM.VAL"  # system variables, written by the interpreter


def start_program(cell: Cell) -> str:
    """Start program in that folder: _SPLC_PATH and _SSTARTPLC as set by a robot program, else the one of the table; empty: none is
    required.  ValueError: the path is not that of the folder.
    """
    assert cell.controller is not None and cell.controller.plc is not None
    kept = _system_values(memory_folder(cell))
    path, start = kept.get("_SPLC_PATH", "S:/PLC"), kept.get("_SSTARTPLC", cell.controller.plc.start)
    return start_in_folder(start_name(path, start))


def _system_values(memory: pathlib.Path | None) -> dict[str, str]:
    """Texts among the system variables that robot programs have written."""
    if memory is None or not (file := memory / SYSTEM_VALUES).exists():
        return {}
    found = {}
    for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
        name, _, value = line.partition(" = ")
        if value.startswith('"'):
            found[name] = str(json.loads(value))
    return found


def kept_file(plan: "RunPlan") -> pathlib.Path | None:
    """Where markers, timers and counters outlive power-off; None: a simulation without [retain]."""
    if plan.simulated:
        return plan.folder / "plc.kept" if plan.cell.retain else None
    return kept_of(plan.cell)


def kept_of(cell: Cell) -> pathlib.Path | None:
    """This file of a cell on a machine; None: the cell has no PLC."""
    if plc_folder(cell) is None:
        return None
    return place(cell.file, "retain", f"{pathlib.Path(cell.file).resolve().stem}.plc")
