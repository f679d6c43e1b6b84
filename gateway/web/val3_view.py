"""VAL 3 applications on the page: state, tasks, variables, user page, prompts (AX-993)."""

import asyncio
from typing import Any

from gateway.assembly.program_memory import disk_folder
from gateway.observer.tool_link import ServicesLink
from gateway.pure.cell.cell import Cell
from gateway.web.val3_pages import image_of, page_of

Row = dict[str, Any]


class Val3View:
    """The application of a cell."""

    def __init__(self, cell: Cell, services_link: ServicesLink) -> None:
        self._cell, self._services_link = cell, services_link

    async def look(self) -> Row:
        """State of the application in the services.  Gone, Refused."""
        if self._cell.val3 is None:
            return {"programs": [], "processes": [], "id": 0}
        return await self._services_link.ask("process", do="view")

    async def page(self, folder: str, name: str) -> Row:
        """A user page, cleaned.  KeyError: there is none; OSError."""
        table = self._cell.val3
        text = None if table is None else await asyncio.to_thread(page_of, disk_folder(self._cell, table), folder, name)
        if text is None:
            raise KeyError(f"there is no user page {name}")
        return {"name": name, "html": text}

    async def image(self, folder: str, name: str, file: str) -> Row:
        """An image next to a user page.  KeyError: no such image; OSError."""
        table = self._cell.val3
        data = None if table is None else await asyncio.to_thread(image_of, disk_folder(self._cell, table), folder, name, file)
        if data is None:
            raise KeyError(f"there is no image {file} next to the user page {name}")
        return {"name": file, "data": data}

    async def act(self, **facts: object) -> Row:
        """A click, an entry, an answer, a value.  Gone, Refused."""
        return await self._services_link.ask("process", do="act", **facts)
