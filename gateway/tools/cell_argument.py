"""The cell file a command was given, with a report of its faults.  Commands that need no cell do not load what checks one."""

import sys

from gateway.cell_file.load import load_cell
from gateway.files.find import ConfigNotFound, find_config
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults
from gateway.tools.command_support import USAGE
from gateway.tools.usage_language import usage_text


def load(name: str) -> Cell | int:
    """The checked cell, or the exit code after its faults were printed."""
    try:
        return load_cell(str(find_config(name, "cells")))
    except ConfigNotFound as error:
        print(f"axisgate: {usage_text(str(error))}", file=sys.stderr)
        return USAGE
    except CellFaults as faults:
        for fault in faults.faults:
            print(fault, file=sys.stderr)
        print(f"axisgate: {usage_text(f'{len(faults.faults)} faults; axisgate check {name} explains them')}", file=sys.stderr)
        return USAGE
