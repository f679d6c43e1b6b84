"""Where users, sessions and audit of a cell's page lie; the page and `axisgate web user` agree on it here."""

import pathlib

from drivers.ports.base import runtime_dir
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.web import Web
from gateway.runtime.state_folder import place


def data_file(cell: Cell, web: Web, *, simulated: bool) -> pathlib.Path:
    """The path in [web] data, else next to the cell file; for a simulated cell in the runtime folder (gateway.runtime.state_folder)."""
    file = pathlib.Path(cell.file).resolve()
    if web.data:
        return file.parent / web.data / f"{file.stem}.sqlite"
    name = f"{file.stem}.sqlite"
    return runtime_dir() / "web" / name if simulated else place(cell.file, "web", name)
