"""ROBOTstar programs as a cell sets them up: those of its memory, its robot, the values they keep."""

import errno
import json
import time
from collections.abc import Callable, Set
from pathlib import Path

from gateway.assembly.program_memory import memory_folder
from gateway.assembly.programs import machines_of_cell
from gateway.assembly.run import RunPlan
from gateway.files.robotstar import KEPT, LOCKS, FolderFault, locks_of, sources, text_of, with_system, words, write_locks
from gateway.files.safe_file import write_whole
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.control import Control
from gateway.pure.controllers.reis.control import ReisControl
from gateway.pure.controllers.reis.programs import ReisPrograms
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.hosting import Port, as_reported
from gateway.pure.languages.robotstar.arm import REIS, Arm
from gateway.pure.languages.robotstar.cell_run import SYSTEM, CellRun
from gateway.pure.languages.robotstar.initial import NAME as INITIAL
from gateway.pure.languages.robotstar.initial import initialise
from gateway.pure.languages.robotstar.memory import Memory
from gateway.runtime.unwritten import UnwrittenFiles, stamp_of

KEEP_S, SHARE = 0.5, 20  # interval of writes while values change, and its least multiple of the duration of a write


def arm_of(cell: Cell) -> Arm:
    """The first robot of a checked cell; MotionError: a model that does not fit."""
    stations = cell.controller.station if cell.controller is not None else ()
    return Arm(0, machines_of_cell(cell)[0], {station.number: REIS.pose(station.at) for station in stations})


def programs_of_control(cell: Cell, control: Control, dispatcher: CommandDispatcher) -> ReisPrograms:
    """The robot programs of a Reis control; MotionError: as arm_of."""
    assert isinstance(control, ReisControl)  # as `check` has it
    programs = ReisPrograms(control, dispatcher, arm_of(cell), control.setup.source, control.robot.keys, cell.cell.language)
    control.robot.programs = programs
    return programs


class RobotstarPrograms:
    """The memory of a cell and its folder, root S:/."""

    def __init__(self, plan: RunPlan, port: Port) -> None:
        folder = memory_folder(plan.cell)
        assert folder is not None  # its language has no row otherwise
        self.folder = folder
        self._stamps = self._stamped()
        self._faults = Faults()
        try:
            found = with_system(sources(str(folder)))
        except FolderFault as fault:  # as every folder that cannot be read
            raise OSError(errno.EINVAL, str(fault), str(folder)) from fault
        self.language = CellRun(Memory.read(found, words(), self._faults), port, arm_of(plan.cell))
        table = plan.cell.controller.plc if plan.cell.controller is not None else None
        self._of_the_cell = "" if table is None else f"_SSTARTPLC = {json.dumps(table.start)}\n"
        self.language.restore(SYSTEM, self._of_the_cell)
        self._kept: dict[str, str] = {}
        self._port, self._unwritten = port, UnwrittenFiles()
        self._made: dict[str, str | None] = {}  # programs that programs have made, as they are on the disk
        self._listed = -1, [dict[str, object]()]  # version of the memory, its programs
        self._due = self._effects = 0.0
        there = {path.relative_to(folder).as_posix()[: -len(KEPT)] for path in self._there()}
        self._notes = [*self._restored(self.language.values().keys() | there), *self._initialised()]

    def _initialised(self) -> list[str]:
        """SYVARINI of the memory runs at the start, over kept values; the shipped one would change nothing useful."""
        if not any(each.name.upper() == INITIAL and (self.folder / each.file).exists() for each in self.language.memory.all()):
            return []
        wrong, step, program = initialise(self.language.machine)
        self.language.restore(SYSTEM, self._of_the_cell)
        return [f"{program} step {step}: {wrong}"] if wrong else []

    def _stamped(self) -> dict[str, tuple[int, int]]:
        found = {str(path): path.stat() for path in self.folder.rglob("*") if path.is_file() and path.suffix.upper() != KEPT}
        return {name: (stat.st_mtime_ns, stat.st_size) for name, stat in found.items()}

    def _file(self, program: str) -> Path:
        """Next to the program: NAME.MPR has NAME.MPR.VAL."""
        return self.folder / f"{program}{KEPT}"

    def _restored(self, names: Set[str]) -> list[str]:
        """Give variables the values in the files of these programs; lines that cannot be used."""
        lost = []
        for name in names:
            try:
                text = text_of(self._file(name)) if self._file(name).exists() else ""
            except FolderFault as fault:
                lost.append(str(fault))
                continue
            lost += [
                f"{self._file(name)}: {line}: no variable accepts this value; it is left out" for line in self.language.restore(name, text)
            ]
        values = self._values()
        self._kept |= {name: values[name] for name in names if name in values}
        return lost

    def _values(self) -> dict[str, str]:
        """Values to keep; the start program of the PLC as the cell names it stays the cell's."""
        found = self.language.values()
        return found | {SYSTEM: "".join(line for line in found[SYSTEM].splitlines(keepends=True) if line != self._of_the_cell)}

    def _there(self) -> list[Path]:
        return [path for path in self.folder.rglob(f"*{KEPT}") if path.is_file()]

    def read(self, alive: Callable[[], None]) -> list[str]:
        """Faults of the programs, and of the kept values."""
        alive()
        notes, self._notes = self._notes, []
        return [f"{fault}" for fault in (*self._faults, *self.language.faults) if fault.severity.value == "error"] + notes

    def refresh(self, alive: Callable[[], None]) -> list[str] | None:
        """Programs added to the memory since the last start; a stopped program then restarts from its beginning."""
        stamps = self._stamped()
        if stamps == self._stamps or self.language.runs:
            return None
        added = {Path(path).relative_to(self.folder).as_posix() for path in stamps.keys() - self._stamps.keys()}
        self._stamps, self._made = stamps, {}
        self._faults = Faults()
        try:
            found = with_system(sources(str(self.folder)))
        except FolderFault as fault:
            return [str(fault)]
        self.language.replaced(Memory.read(found, words(), self._faults))
        values = self._values()
        self._kept = {name: text for name, text in self._kept.items() if name in values}
        self._notes += self._restored(added & values.keys())  # a program that was renamed, copied or put here brings its values
        return self.read(alive)

    def seen(self, now: int) -> dict[str, object]:
        """The programs: TRAFO_6D makes some while others run."""
        version = self.language.memory.version
        if version != self._listed[0]:
            self._listed = version, [as_reported(row) for row in self.language.catalogue()]
        return {"programs": self._listed[1]}

    def write_back(self) -> list[str]:
        """Programs and values that have changed; each file is the old or the new one whatever happens."""
        now = time.monotonic()
        for path in self._unwritten.again():
            self._stamp(path)
            self._port.report(str(path), 0, "is written now, nothing in it is lost")
        if self._effects == self.language.effects or (now < self._due and self.language.runs):
            return []
        began, self._effects = now, self.language.effects
        faults = self._programs_back()
        values = self._values()
        for name, text in values.items():
            if self._kept.get(name, "") == text:
                continue
            self._unwritten.written(self._file(name))
            try:
                write_whole(self._file(name), text.encode())
            except OSError as error:
                self._unwritten.failed(self._file(name), text.encode())
                faults.append(f"{self._file(name)}: {error.strerror}; values of variables do not outlive power-off")
        self._kept = values
        self._due = time.monotonic() + max(KEEP_S, SHARE * (time.monotonic() - began))
        return faults

    def _programs_back(self) -> list[str]:
        """Write back files made by programs; a deleted file goes last, with its values.  Locks of former files are released."""
        made, faults = self.language.made(), []
        changed = sorted(
            (name for name, text in made.items() if name not in self._made or self._made[name] != text), key=lambda name: made[name] is None
        )
        for name in changed:
            path, text = self.folder / name, made[name]
            self._unwritten.written(path)
            try:
                if text is None:
                    path.unlink(missing_ok=True)
                    self._file(name).unlink(missing_ok=True)
                    self._stamps.pop(str(path), None)
                else:
                    write_whole(path, text.encode())
                    self._stamp(path)
                self._release(name)
            except (OSError, FolderFault) as error:
                self._unwritten.failed(path, None if text is None else text.encode())
                faults.append(f"{path}: {getattr(error, 'strerror', '') or error}; a program made by TRAFO_6D does not outlive power-off")
        self._made = made
        return faults

    def _release(self, name: str) -> None:
        """Letters that locked a program before it was deleted."""
        locks = locks_of(self.folder) if name in self.language.memory.gone else {}
        if locks.pop(name, ""):
            write_locks(self.folder, locks)
            self._stamp(self.folder / LOCKS)

    def _stamp(self, path: Path) -> None:
        """What programs have written is no change from outside."""
        if path.suffix.upper() != KEPT and (stamp := stamp_of(path)) is not None:
            self._stamps[str(path)] = stamp
