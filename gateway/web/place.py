"""Where users, sessions and audit of a cell's page lie; the page and `axisgate web user` agree on it here."""

import pathlib

from drivers.ports.base import runtime_dir
from gateway.cell import Cell
from gateway.cell_web import Web
from gateway.statefolder import place


def data_file(cell: Cell, web: Web, *, simulated: bool) -> pathlib.Path:
    """Where [web] data says, else beside the cell file; of a simulated cell in the runtime folder (gateway.statefolder)."""
    file = pathlib.Path(cell.file).resolve()
    if web.data:
        return file.parent / web.data / f"{file.stem}.sqlite"
    name = f"{file.stem}.sqlite"
    return runtime_dir() / "web" / name if simulated else place(cell.file, "web", name)
