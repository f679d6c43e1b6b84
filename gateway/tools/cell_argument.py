"""The cell file argument of a command, with a report of its faults.  Commands that need no cell do not load the checks."""

import sys

from gateway.files.find import ConfigNotFound, find_config
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults
from gateway.runtime.apart import apart
from gateway.tools.command_support import USAGE
from gateway.tools.usage_language import usage_text


def load(name: str) -> Cell | int:
    """The checked cell, or the exit code after its faults were printed."""
    from gateway.cell_file.load import load_cell  # pydantic and the checks: not for a command that has the cell loaded apart

    try:
        return load_cell(str(find_config(name, "cells")))
    except ConfigNotFound as error:
        print(f"axisgate: {usage_text(str(error))}", file=sys.stderr)
        return USAGE
    except CellFaults as faults:
        for fault in faults.faults:
            print(fault, file=sys.stderr)
        count = len(faults.faults)
        said = f"{count} faults; axisgate check {name} explains them" if count > 1 else f"1 fault; axisgate check {name} explains it"
        print(f"axisgate: {usage_text(said)}", file=sys.stderr)
        return USAGE


def load_apart(name: str) -> Cell | int:
    """Like `load`; memory used by the check is not left in this process (AX-1740)."""
    return apart(lambda: load(name))
