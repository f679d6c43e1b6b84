"""The application of a cell with its disk and its channels, as the interpreter process hosts it (AX-930)."""

import pathlib
from collections.abc import Callable, Mapping

from gateway.assembly.program_memory import disk_folder
from gateway.assembly.run import RunPlan
from gateway.assembly.val3_application import channel_of, setup_of
from gateway.files.safe_file import write_whole
from gateway.files.val3_disk import read_disk
from gateway.links.serial.val3_cell_sio import CellSio
from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.val3.cell_run import CellRun


class Val3Programs:
    """The files are read before each start; libSave's data are written to the disk at the end of the turn."""

    def __init__(self, plan: RunPlan, port: Port) -> None:
        table = plan.cell.val3
        assert table is not None  # its language has no row otherwise
        self.folder = disk_folder(plan.cell, table)
        self._disk = read_disk(self.folder)
        self._kept = dict(self._disk.files)
        channels = [channel_of(row) for row in table.channel]
        self.language = CellRun(setup_of(plan.cell, table), port, lambda: self._disk, lambda: CellSio(channels))

    def read(self, alive: Callable[[], None]) -> list[str]:
        """The application with all its programs."""
        found = self.language.read()
        alive()
        return found

    def refresh(self, alive: Callable[[], None]) -> list[str] | None:
        """Files that were changed since."""
        if self.language.machine is not None:
            return None
        fresh = read_disk(self.folder)
        if fresh.files == self._kept:
            return None
        self._disk, self._kept = fresh, dict(fresh.files)
        return self.read(alive)

    def seen(self, now: int) -> Mapping[str, object]:
        """State, variables, user page, popups, text page."""
        return self.language.seen(now)

    def write_back(self) -> list[str]:
        """Files changed by libSave and libDelete."""
        files, faults = self._disk.files, []
        if files == self._kept:
            return []
        for name in files.keys() | self._kept.keys():
            if files.get(name) != self._kept.get(name):
                faults += self._written(self.folder / name, files.get(name))
        self._kept = dict(files)
        return faults

    @staticmethod
    def _written(path: pathlib.Path, data: bytes | None) -> list[str]:
        try:
            if data is None:
                path.unlink(missing_ok=True)
            else:
                path.parent.mkdir(parents=True, exist_ok=True)
                write_whole(path, data)
        except OSError as error:
            return [f"{path}: {error.strerror}; what the application has written there is lost with this run"]
        return []
