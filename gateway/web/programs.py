"""Programs of the old controller on the page: list, running ones with their lines, the text of one."""

import asyncio
from typing import Any

from gateway.observer.tool_link import ServicesLink
from gateway.pure.cell.cell import Cell
from gateway.registry import language_in

Row = dict[str, Any]
SHOWN = ("programs", "processes", "id", "test", "variables", "looked", "breaks", "value")


class ProgramView:
    """Programs and processes of a cell."""

    def __init__(self, cell: Cell, services_link: ServicesLink) -> None:
        self._cell, self._services_link = cell, services_link
        self._language = language_in(cell)

    async def look(self) -> Row:
        """The programs and the running ones.  Gone, Refused."""
        if self._language is None:
            return {"programs": [], "processes": [], "id": 0}
        found = await self._services_link.ask("process", do="list")
        return {key: found[key] for key in SHOWN if key in found}

    async def text(self, name: str) -> Row:
        """The listing of a program.  KeyError: there is none; OSError: it cannot be read."""
        if self._language is None or self._language.listing is None:
            raise KeyError("this cell has no programs with a listing")
        found = await asyncio.to_thread(self._language.listing, self._cell, name)
        if found is None:
            raise KeyError(f"there is no listing of {name}")
        return {
            "name": name, "file": found.file, "lines": found.lines, "faults": found.faults,
            "points": found.points, "statements": found.statements,
        }  # fmt: skip
