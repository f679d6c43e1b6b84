"""The integrated PLC on the page: state, programs, listing with its test display (robotstar 5.7), markers written by hand."""

import asyncio
import zlib
from typing import Any

from gateway.assembly.program_memory import plc_folder
from gateway.files.plc_programs import ProgramFileFault, read_programs
from gateway.observer.tool_link import ServicesLink
from gateway.pure.cell.cell import Cell
from gateway.pure.languages.plc.reader import lines_of

Row = dict[str, Any]
ROWS = 500  # steps of a listing in one answer


class PlcView:
    """The PLC of a cell."""

    def __init__(self, cell: Cell, services_link: ServicesLink) -> None:
        self._cell, self._services_link = cell, services_link
        self._folder = plc_folder(cell)
        self._names: list[str] = []

    async def look(self) -> Row:
        """State, scans, message, programs.  Gone, Refused."""
        controller = self._cell.controller
        if self._folder is None or controller is None or controller.plc is None:
            return {"state": "", "programs": []}
        try:
            self._names = sorted(await asyncio.to_thread(read_programs, self._folder))
        except (ProgramFileFault, OSError):
            self._names = []
        table = controller.plc
        status = await self._services_link.ask("plc", do="status")
        return {**status, "programs": self._names, "start": table.start, "load": table.load, "first_byte": controller.first_byte}

    async def listing(self, name: str, first: int) -> Row:
        """Steps of a program from `first` on, with the check sum of its file.  KeyError: there is none."""
        if self._folder is None:
            raise KeyError("this cell has no integrated PLC")
        try:
            programs = await asyncio.to_thread(read_programs, self._folder)
        except (ProgramFileFault, OSError) as fault:
            raise KeyError(str(fault)) from None
        text = programs.get(name.upper())
        if text is None:
            raise KeyError(f"there is no PLC program {name}")
        steps = lines_of(text)
        rows = [[line.step, line.text, line.valid] for line in steps if line.step >= first][:ROWS]
        return {"name": name.upper(), "text": zlib.crc32(text.encode()), "steps": len(steps), "rows": rows}

    async def shown(self, name: str, first: int) -> Row:
        """The test display of a program.  Gone, Refused."""
        return await self._services_link.ask("plc", do="show", name=name, first=first)
