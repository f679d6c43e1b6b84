"""Where users, sessions and audit of a cell's page lie; the page and `axisgate web user` agree on it here."""

import os
import pathlib

from drivers.ports.base import runtime_dir
from gateway.cell import Cell
from gateway.cell_web import Web
from gateway.files import PACKAGED


def data_file(cell: Cell, web: Web, *, simulated: bool) -> pathlib.Path:
    """Where [web] data says, else beside the cell file; of a shipped or simulated cell in the runtime folder."""
    file = pathlib.Path(cell.file).resolve()
    if web.data:
        return file.parent / web.data / f"{file.stem}.sqlite"
    ours = file.is_relative_to(PACKAGED) or simulated or not os.access(file.parent, os.W_OK)
    return (runtime_dir() if ours else file.parent) / "web" / f"{file.stem}.sqlite"
