"""The integrated PLC of a Reis as a cell sets it up: folder of its programs, file of what outlives power-off."""

import pathlib
from typing import TYPE_CHECKING

from gateway.pure.cell.cell import Cell
from gateway.runtime.state_folder import place

if TYPE_CHECKING:
    from gateway.assembly.run import RunPlan


def plc_folder(cell: Cell) -> pathlib.Path | None:
    """Where the programs of [controller.plc] are; None: the cell has no such table."""
    if cell.controller is None or cell.controller.plc is None:
        return None
    return pathlib.Path(cell.file).parent / cell.controller.plc.path


def kept_file(plan: "RunPlan") -> pathlib.Path | None:
    """Where markers, timers and counters outlive power-off; None: a simulation without [retain]."""
    if plan.simulated:
        return plan.folder / "plc.kept" if plan.cell.retain else None
    return place(plan.cell.file, "retain", f"{pathlib.Path(plan.cell.file).resolve().stem}.plc")
