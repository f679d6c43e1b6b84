"""Where the programs of a cell are: the folders of [controller] and [val3]."""

import pathlib

from gateway.pure.cell.cell import Cell
from gateway.pure.cell.val3 import Val3


def memory_folder(cell: Cell) -> pathlib.Path | None:
    """Where the programs of [controller] are; None: it names no memory."""
    if cell.controller is None or not cell.controller.memory:
        return None
    return pathlib.Path(cell.file).parent / cell.controller.memory


def plc_folder(cell: Cell) -> pathlib.Path | None:
    """Where the programs of [controller.plc] are; None: the cell has no such table."""
    if cell.controller is None or cell.controller.plc is None:
        return None
    return pathlib.Path(cell.file).parent / cell.controller.plc.path


def data_folder(cell: Cell) -> pathlib.Path | None:
    """Where the DAT files of [controller] are; None: it names none."""
    if cell.controller is None or not cell.controller.files:
        return None
    return pathlib.Path(cell.file).parent / cell.controller.files


def disk_folder(cell: Cell, table: Val3) -> pathlib.Path:
    """Return the folder that is Disk://."""
    return pathlib.Path(cell.file).parent / table.disk


def program_folders(cell: Cell) -> list[pathlib.Path]:
    """Return the folders of all programs of a cell and of their DAT files; a program may be in a folder below."""
    disk = None if cell.val3 is None else disk_folder(cell, cell.val3)
    return [folder.resolve() for folder in (memory_folder(cell), plc_folder(cell), data_folder(cell), disk) if folder is not None]


def in_memory(folder: pathlib.Path, name: str) -> pathlib.Path:
    """A file of the memory by its name in any case of letters; where there is none, as named."""
    found = (path for path in folder.iterdir() if path.name.upper() == name.upper()) if folder.is_dir() else iter(())
    return next(found, folder / name)
