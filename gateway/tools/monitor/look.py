"""Reads a running cell like the page: regions and the services' answers; it sends no sign of life (AX-494)."""

import asyncio
import os
from dataclasses import dataclass

from drivers.ports.base import PortError
from gateway.cell_file.load import load_cell
from gateway.files.find import ConfigNotFound
from gateway.observer.names import Names
from gateway.observer.regions import Regions
from gateway.observer.tool_link import GLANCE_S, Gone, Refused, Row, ServicesLink, supervisor
from gateway.observer.values import Watched
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults
from gateway.runtime.regions import ImageError, recv_fds
from gateway.runtime.supervisor_client import ask
from gateway.tools.monitor.shown import axes_table, errors_table, headline, sentences_table, signals_table, sources_table
from gateway.tools.monitor.tables import Table
from gateway.web.line_view import LineViews

TABS = ("axes", "signals", "lines", "errors")
FILTERS = ("all", "on", "forced", "old")
SILENT_MS = 1000.0  # a cycle silent for so long may be that of an ended run


class NoRun(Exception):
    """No such run, or one whose cell file is missing; in words."""


@dataclass(frozen=True, slots=True)
class Run:
    """Data of a run that the regions need."""

    cell: Cell
    p5_ms: int


class Look:
    """One run, seen by one terminal."""

    def __init__(self, name: str, language: str = "") -> None:
        self.name, self._wanted = name, language
        self.services_link = ServicesLink(name, GLANCE_S)
        self.regions: Regions | None = None
        self.search, self.filter = "", "all"
        self.found = 0  # signals that fit the search
        self.alarms: list[str] = []
        self.simulated = False
        self._inode = 0  # of the regions we read: a run that was started again has others

    async def attach(self) -> None:
        """Take the regions over (again); NoRun."""
        try:
            status = await supervisor(self.name, "status")
            fds = await asyncio.to_thread(_fds, self.name)
        except (Gone, PortError, OSError, ImageError) as error:
            raise NoRun(f"run {self.name!r} does not answer; axisgate run CELL --sim starts one") from error
        try:
            cell = await asyncio.to_thread(load_cell, str(status["file"]))
            run = Run(cell, int(status["p5_ms"]))
            self.regions = Regions(run, fds)
            self._inode = os.fstat(fds["axes"]).st_ino
        except (CellFaults, ConfigNotFound, OSError, ImageError) as error:
            raise NoRun(f"run {self.name!r}: {status['file']} cannot be read any more; axisgate check {status['file']}") from error
        finally:
            for fd in fds.values():
                os.close(fd)
        self.cell, self.language = cell, self._wanted or cell.cell.language
        self.simulated = bool(status["simulated"])
        self.names, self.watched = Names(cell), Watched(self.regions)
        self.lines = LineViews(cell, self.services_link)

    async def still(self) -> bool:
        """Whether the run is alive; one restarted under the same name is attached to.  NoRun: its cell is missing."""
        try:
            status = await supervisor(self.name, "status")
            self.alarms = [str(alarm) for alarm in status.get("alarms", [])]
            if self._regions().ages()[0] > SILENT_MS and await asyncio.to_thread(_inode, self.name) != self._inode:
                await self.attach()
        except (Gone, PortError, OSError, ImageError):
            return False
        return True

    async def table(self, tab: str) -> list[Table]:
        """Present content of a tab."""
        regions = self._regions()
        regions.look()
        match tab:
            case "axes":
                return [axes_table(self.cell, regions)]
            case "signals":
                return [await self._signals()]
            case "lines":
                return [sources_table(regions), sentences_table(await self._sentences(), self.language)]
            case _:
                return [errors_table(regions, self.alarms, self.language)]

    def head(self) -> str:
        """Readiness, motion, override, who has control: one line."""
        return headline(self.name, self._regions(), simulated=self.simulated)

    def figures(self) -> Row:
        """The same for a program."""
        regions = self._regions()
        return {"run": self.name, "cell": self.cell.cell.name, "simulated": self.simulated, **regions.head(), **regions.counters()}

    def _regions(self) -> Regions:
        if self.regions is None:
            raise NoRun(f"run {self.name!r} does not answer")
        return self.regions

    async def _signals(self) -> Table:
        self.found, entries = self.names.search(self.search)
        await self.watched.look(self.services_link)
        values = self.watched.values(entry.id for entry in entries)
        return signals_table(entries, values, self.filter, self.found, self.language)

    async def _sentences(self) -> Row:
        try:
            return dict(await self.lines.look())
        except (Gone, Refused):
            return {}

    def close(self) -> None:
        self.services_link.close()


def _fds(name: str) -> dict[str, int]:
    with ask(name, "regions") as connection:
        return recv_fds(connection)


def _inode(name: str) -> int:
    fds = _fds(name)
    try:
        return os.fstat(fds["axes"]).st_ino
    finally:
        for fd in fds.values():
            os.close(fd)
