"""The text of a program of a cell with its faults, as the page shows it."""

from dataclasses import dataclass

from gateway.assembly.program_memory import memory_folder
from gateway.files.program_memory import baps2_words, folder_memory
from gateway.pure.cell.cell import Cell
from gateway.pure.languages.baps2.library import Library


@dataclass(frozen=True, slots=True)
class Listing:
    """A program as its file has it.  `faults`: line, severity and text of each."""

    file: str
    lines: tuple[str, ...]
    faults: tuple[tuple[int, str, str], ...] = ()


def baps2_listing(cell: Cell, program: str) -> Listing | None:
    """A source of the memory; None: there is none.  OSError."""
    folder = memory_folder(cell)
    if folder is None:
        return None
    memory = folder_memory(folder)
    file = f"{program.upper()}.QLL"
    text = memory.text(file)
    if text is None:
        return None
    _, faults = Library(baps2_words(), memory).check(file, text)
    rows = tuple((each.position.line, each.severity.value, each.text) for each in faults if each.position.file == file)
    return Listing(file, tuple(text.splitlines()), rows)
