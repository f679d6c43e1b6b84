"""Checks of the programs of a Reis: its memory can be read, and which of its programs have errors (AX-940)."""

import pathlib
from collections import Counter
from collections.abc import Iterator

from gateway.files.robotstar import FolderFault, sources, with_system, words
from gateway.pure.cell.cell import Notice
from gateway.pure.languages.base.faults import Faults, Severity
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.memory import Memory
from gateway.pure.languages.robotstar.program import KINDS
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.virtual import VirtualCell


def unreadable(folder: pathlib.Path) -> str:
    """Fault that keeps the programs from being read; "": none."""
    try:
        sources(str(folder))
    except (FolderFault, OSError) as fault:
        return str(fault)
    return ""


def programs_with_errors(folder: pathlib.Path, shown: str) -> Iterator[Notice]:
    """A warning for each; `shown`: the folder as the cell names it."""
    faults = Faults()
    try:
        memory = Memory.read(with_system(sources(str(folder))), words(), faults)
    except (FolderFault, OSError):
        return  # refused by `controller`
    check(memory, faults, VirtualCell(memory, MODES["auto"]).system.names())
    errors = Counter(fault.position.file for fault in faults if fault.severity is Severity.ERROR)
    for file, found in sorted(errors.items()):
        if file.upper().rpartition(".")[2] in KINDS:
            yield Notice(
                "warning", f"{shown}/{file}", f"{found} error{'s' * (found > 1)}, it does not run: axisgate robotstar check names them"
            )
