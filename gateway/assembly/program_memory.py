"""Where the programs of a cell are: the folder of [controller]."""

import pathlib

from gateway.pure.cell.cell import Cell


def memory_folder(cell: Cell) -> pathlib.Path | None:
    """Where the programs of [controller] are; None: it names no memory."""
    if cell.controller is None or not cell.controller.memory:
        return None
    return pathlib.Path(cell.file).parent / cell.controller.memory


def in_memory(folder: pathlib.Path, name: str) -> pathlib.Path:
    """A file of the memory by its name in any case of letters; where there is none, as named."""
    found = (path for path in folder.iterdir() if path.name.upper() == name.upper()) if folder.is_dir() else iter(())
    return next(found, folder / name)
