"""BAPS2 programs as a cell sets them up: those of its memory, its robots, its parameters; the files they write."""

import contextlib
import pathlib
import time
from collections.abc import Callable, Mapping
from itertools import accumulate
from typing import TYPE_CHECKING

from gateway.assembly.controllers import installation
from gateway.assembly.data_block_signals import signals_of
from gateway.assembly.eeprom import is_protected, load_eeprom, save_eeprom
from gateway.assembly.lanes import move_apart
from gateway.assembly.pic import pic_bytes
from gateway.assembly.printer import print_text
from gateway.assembly.program_memory import memory_folder
from gateway.assembly.programs import numbers_of
from gateway.assembly.run import RunPlan
from gateway.assembly.sram_card import DEFECTIVE, card_refused, format_card, in_place, in_use, without_card
from gateway.files.program_memory import baps2_words, folder_memory
from gateway.files.safe_file import write_whole
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.rho3.pendant.user_memory import SIZES
from gateway.pure.controllers.rho3.signals.timers import TimersAndCounters
from gateway.pure.languages.baps2.cell_belts import CellBelt, CellSetup
from gateway.pure.languages.baps2.cell_eeprom import (
    BACKUP,
    INIT,
    NO_INTERFACE,
    NOT_VALID,
    OTHER_SIZE,
    PRINT,
    PROTECTED,
    SAVE,
    Wanted,
    backup_refused,
    card_not_now,
    refused,
    save_refused,
)
from gateway.pure.languages.baps2.cell_run import CellRun, changed
from gateway.pure.languages.baps2.feed import UnitFeed
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory, decoded
from gateway.pure.languages.baps2.robots import CellRobot
from gateway.pure.languages.baps2.units import Device
from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.pic.cell_pic import CellPic
from gateway.pure.languages.pic.symbols import named_in
from gateway.runtime.kept_aside import kept_aside
from gateway.runtime.unwritten import UnwrittenFiles, stamp_of
from protocols.base.machine import ms

CARD_GONE, CARD_MISSING = 39, 300  # system errors (L11431-11436)

if TYPE_CHECKING:
    from motion.program.passing import Presets

CARD_LOOKED_AT_NS = ms(200)  # an operator pulls the card: looking takes a call to the file system


def robots_of_cell(cell: Cell) -> tuple[CellRobot, ...]:
    """Every robot on its axes; MotionError: a model that does not fit."""
    from gateway.assembly.programs import machines_of_cell

    machines = machines_of_cell(cell)
    firsts = accumulate((machine.axes for machine in machines), initial=0)
    return tuple(CellRobot(number, first, machine) for number, (machine, first) in enumerate(zip(machines, firsts, strict=False), 1))


def presets_of(cell: Cell) -> "list[Presets]":
    """R and R_PTP of each robot: P212 radius and factor, P213 distances, P214 for each axis (0) or in space (1).  Lists in lists: a row for
    each kinematic; a plain list is that of the first one."""
    from motion.program.passing import Criterion, Presets

    found = []
    for number in range(len(cell.robot)):
        radius, factor = (*_row(cell, "P212", number), 0.0, 0.0)[:2]
        ways, space = _row(cell, "P213", number), _row(cell, "P214", number)[:1] == (1.0,)
        if space:
            found.append(Presets(radius, factor, (), ways[0] if ways else 0.0, Criterion.SPACE))
        else:
            found.append(Presets(radius, factor, ways))
    return found


def _row(cell: Cell, name: str, place: int) -> tuple[float, ...]:
    """Numbers of a parameter for a kinematic, from 0."""
    given = cell.rho3.others.get(name, ()) if cell.rho3 else ()
    rows = given if isinstance(given, list | tuple) else (given,)
    nested = any(isinstance(each, list | tuple) for each in rows)
    row = rows[place : place + 1] if nested or name == "P214" else rows if place == 0 else ()
    own = row[0] if nested and row else row
    return tuple(float(each) for each in own if isinstance(each, int | float)) if isinstance(own, list | tuple) else ()


def belts_in(cell: Cell) -> tuple[CellBelt, ...]:
    """[[belt]] tables as programs number them."""
    return tuple(CellBelt(belt.name, belt.unit, frozenset(numbers_of(cell, belt.robot))) for belt in cell.belt)


def language_of(cell: Cell, memory: Memory, port: Port, p5_ms: int) -> CellRun:
    """Programs of a checked cell."""
    language = CellRun(
        Library(baps2_words(), memory),
        memory,
        port,
        robots_of_cell(cell),
        ms(p5_ms),
        setup=CellSetup(presets_of(cell), belts_in(cell), {each.channel: each.input for each in cell.measuring}),
        one=not move_apart(cell),
    )
    if cell.controller is not None and cell.controller.phg_unit:
        language.devices[cell.controller.phg_unit] = Device(UnitFeed())
    language.pic = pic_of(cell, memory, port)
    return language


def pic_of(cell: Cell, memory: Memory, port: Port) -> CellPic | None:
    """The PIC program of a cell, with timers and counters of its parameters."""
    controller = cell.controller
    if controller is None or not controller.pic:
        return None
    facts = installation(cell, controller)
    timers = TimersAndCounters(facts.p3, facts.p13, facts.p14, facts.unit)
    return CellPic(memory, controller.pic, named_in(signals_of(cell)), port, timers, facts.unit, pic_bytes(cell))


def days_of(stamps: Mapping[str, tuple[int, int]]) -> dict[str, tuple[str, str]]:
    """Day and time of each file, as the pendant shows them."""
    found = {name.upper(): time.localtime(changed // 1_000_000_000) for name, (changed, _) in stamps.items()}
    return {name: (time.strftime("%d.%m.%y", at), time.strftime("%H:%M", at)) for name, at in found.items()}


class Baps2Programs:
    """The memory of a cell and its folder."""

    def __init__(self, plan: RunPlan, port: Port) -> None:
        folder = memory_folder(plan.cell)
        assert folder is not None  # its language has no row otherwise
        self.folder = folder
        controller = plan.cell.controller
        self._port, self._unwritten = port, UnwrittenFiles()
        self._eeprom = pathlib.Path(plan.cell.file).parent / controller.eeprom if controller is not None and controller.eeprom else None
        self._printer = pathlib.Path(plan.cell.file).parent / controller.printer if controller is not None and controller.printer else None
        self._card = pathlib.Path(plan.cell.file).parent / controller.sram_card if controller is not None and controller.sram_card else None
        self._cards = controller is not None and controller.hardware == "rho3.0"
        self._internal = self._size = SIZES[controller.hardware] if controller is not None else 0
        self._pic = (controller.pic or "").upper() if controller is not None else ""
        self._stamps = self._stamped()
        self.memory = folder_memory(folder)
        self.language = language_of(plan.cell, self.memory, port, plan.p5_ms)
        self._kept = dict(self.memory.files)
        self.language.pendant.files.stamps.update(days_of(self._stamps))
        self._look_at_card(CARD_MISSING)
        self._card_next = 0

    def _look_at_card(self, error: int) -> None:
        """A card that was initialised stays where it is: gone at the start is another system error than while it runs."""
        files = self.language.pendant.files
        if not in_use(self.folder) or files.card[0]:
            return
        if in_place(self._card, self.folder) and self._card is not None:
            self._size = self._card.stat().st_size
            files.card = 0, self._size
        else:
            files.card = error, self._size

    def _initialise_card(self, wanted: Wanted) -> str:
        """Mode 9.8: the memory is empty afterwards, and as big as the card."""
        card, language = self._card, self.language
        why = card_not_now(wanted, option=card is not None and self._cards, running=bool(language.tasks))
        if not why and card is not None:
            why = card_refused(card)
        if why or card is None:
            return why
        format_card(card, self.folder)
        self._replace(self._pic_files())
        self._look_at_card(CARD_GONE)
        return ""

    def _pic_files(self) -> dict[str, bytes]:
        """Files of the PIC program, which is retained (L11565)."""
        return {name: self.memory.files[name] for name in (f"{self._pic}.QLS", f"{self._pic}.SYM") if name in self.memory.files}

    def _replace(self, files: Mapping[str, bytes]) -> None:
        """Replace the complete memory."""
        for name in self.memory.files.keys() | files.keys():
            self.memory.files.pop(name, None)
            self.language.file_changed(name)
        self.memory.files.update(files)

    def _back_up(self, wanted: Wanted) -> str:
        """The keys of the EPROM backup: clear the memory, or restore it from the EEPROM (L4901, L11546-11576; AX-1732)."""
        shown = self.language.pendant.files
        why = backup_refused(wanted, error=bool(shown.card[0]), running=bool(self.language.tasks))
        if why:
            return why
        if in_use(self.folder) and self._card is not None and not card_refused(self._card):
            format_card(self._card, self.folder)
        else:
            without_card(self.folder)
            self._size = self._internal
        kept = load_eeprom(self._eeprom) if self._eeprom is not None and wanted.stop else None
        self._replace(self._pic_files() | (kept[1] if kept is not None and kept[0] == self._size else {}))
        shown.card = 0, 0
        self._look_at_card(CARD_GONE)
        return ""

    def _stamped(self) -> dict[str, tuple[int, int]]:
        found = {path.name: stamp_of(path) for path in self.folder.iterdir() if not path.name.startswith(".")}
        return {name: stamp for name, stamp in found.items() if stamp is not None}

    def read(self, alive: Callable[[], None]) -> list[str]:
        """Read the memory; a large one takes seconds."""
        found = []
        for name in list(self.language.library.names()):
            _, faults = self.language.library.unit(name)
            alive()
            found += [f"{fault}" for fault in faults if fault.severity.value == "error"]
        return found

    def refresh(self, alive: Callable[[], None]) -> list[str] | None:
        """Files that were put into the memory since the last start of a program."""
        stamps = self._stamped()
        if stamps == self._stamps:
            return None
        before, self._stamps = self._stamps, stamps
        self.language.pendant.files.stamps.update(days_of(stamps))
        fresh = folder_memory(self.folder).files
        for name in {path.upper() for path in stamps.keys() | before.keys() if stamps.get(path) != before.get(path)}:
            if fresh.get(name) == self._kept.get(name):
                continue
            if name in fresh:
                self.memory.files[name] = self._kept[name] = fresh[name]
            else:
                self.memory.files.pop(name, None), self._kept.pop(name, None)
            self.language.file_changed(name)
        return self.read(alive)

    def seen(self, now: int) -> dict[str, object]:
        """The test system."""
        return self.language.test.shown(now)

    def _save_or_load(self, wanted: Wanted) -> str:
        """Modes 9.6 and 9.7 of the pendant: why it is refused, empty: done."""
        language, path = self.language, self._eeprom
        why = refused(wanted, option=path is not None, open_files=language.filing.any_open(), running=bool(language.tasks))
        if why or path is None:
            return why
        files = self.memory.files
        if wanted.what == SAVE:
            why = save_refused(files, self._size, protected=is_protected(path))
            if not why:
                save_eeprom(path, files, self._size)
            return why
        found = load_eeprom(path)
        if found is None:
            return NOT_VALID
        if found[0] != self._size:
            return OTHER_SIZE
        self._replace(found[1])
        return ""

    def _done(self, wanted: Wanted) -> str:
        """An order of the pendant: why it is refused, empty: done."""
        match wanted.what:
            case "print":
                return self._print(wanted.file)
            case "init":
                return self._initialise_card(wanted)
            case "backup":
                return self._back_up(wanted)
        return self._save_or_load(wanted)

    def _print(self, file: str) -> str:
        """Mode 9.4.2 of the pendant: append the complete file to the printed text."""
        if self._printer is None or file not in self.memory.files:
            return NO_INTERFACE
        print_text(self._printer, file, decoded(self.memory.files[file]))
        return ""

    def write_back(self) -> list[str]:
        """Points and files that programs have written are on the disk before anything else happens."""
        faults = []
        if (now := time.monotonic_ns()) >= self._card_next:
            self._card_next = now + CARD_LOOKED_AT_NS
            self._look_at_card(CARD_GONE)
        for wanted in self.language.pendant.eeprom.take():
            try:
                answer = self._done(wanted)
            except OSError as error:
                path, answer, lost = {
                    PRINT: (self._printer, NO_INTERFACE, "it is not printed"),
                    INIT: (self._card, DEFECTIVE, "it is not initialised"),
                    BACKUP: (self._card, DEFECTIVE, "the user memory is as it was"),
                }.get(wanted.what, (self._eeprom, PROTECTED, "the user memory is not saved"))
                faults.append(f"{path}: {error.strerror}; {lost}")
            self._port.send("answered", ticket=wanted.ticket, error=answer)
        return [*faults, *self._written()]

    def _written(self) -> list[str]:
        for path in self._unwritten.again():
            self._stamp(path)
            self._port.report(str(path), 0, "is written now, nothing in it is lost")
        faults = []
        for name, data in changed(self._kept, self.memory.files).items():
            path = self._path(name)
            self._unwritten.written(path)
            aside = None
            try:
                if aside := self._aside(path, self._kept.get(name), data):
                    write_whole(aside, path.read_bytes())
                    faults.append(f"{path}: it was changed on the disk, then a program wrote it; the changed file is kept as {aside.name}")
                    aside = None
                if data is None:
                    path.unlink(missing_ok=True)
                else:
                    write_whole(path, data)
            except OSError as error:
                self._unwritten.failed(path, data, aside)
                faults.append(f"{path}: {error.strerror}; what programs have written there is lost when this run ends")
            if data is None:
                self._kept.pop(name, None)
            else:
                self._kept[name] = data
            self._stamp(path)
        return faults

    def _aside(self, path: pathlib.Path, *known: bytes | None) -> pathlib.Path | None:
        """Name for a file that was changed on the disk after it was read, and that a program overwrites now; None: it was not.  OSError."""
        stamp = stamp_of(path)
        unchanged = stamp is None or stamp == self._stamps.get(path.name) or path.read_bytes() in known
        return None if unchanged else kept_aside(path)

    def _stamp(self, path: pathlib.Path) -> None:
        """What programs have written is no change from outside."""
        if (stamp := stamp_of(path)) is not None:
            self._stamps[path.name] = stamp
            self.language.pendant.files.stamps.update(days_of({path.name: stamp}))

    def _path(self, name: str) -> pathlib.Path:
        """The file of that name in any case of letters, or a new one."""
        with contextlib.suppress(OSError):
            for path in self.folder.iterdir():
                if path.name.upper() == name:
                    return path
        return self.folder / name
