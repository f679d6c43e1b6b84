"""Where the programs of a cell are: the folder of [controller]."""

import pathlib

from gateway.pure.cell.cell import Cell


def memory_folder(cell: Cell) -> pathlib.Path | None:
    """Where the programs of [controller] are; None: it names no memory."""
    if cell.controller is None or not cell.controller.memory:
        return None
    return pathlib.Path(cell.file).parent / cell.controller.memory
