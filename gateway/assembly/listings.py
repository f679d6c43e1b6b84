"""The text of a program of a cell with its faults, as the page shows it."""

from dataclasses import dataclass

from gateway.assembly.program_memory import memory_folder
from gateway.files.program_memory import baps2_words, folder_memory
from gateway.files.robotstar import FolderFault, sources, with_system, words
from gateway.pure.cell.cell import Cell
from gateway.pure.languages.baps2.cell_debugger import shown_value, taught_in
from gateway.pure.languages.baps2.inspection import lines_of
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.memory import Memory as RobotstarMemory
from gateway.pure.languages.robotstar.memory import Source


@dataclass(frozen=True, slots=True)
class Listing:
    """A program as its file has it.  `faults`: line, severity and text of each; `points`: name and value, "": not defined; `statements`:
    lines with a statement, where it can be tested."""

    file: str
    lines: tuple[str, ...]
    faults: tuple[tuple[int, str, str], ...] = ()
    points: tuple[tuple[str, str], ...] = ()
    statements: tuple[int, ...] = ()


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
    unit, faults = Library(baps2_words(), memory).check(file, text)
    rows = tuple((each.position.line, each.severity.value, each.text) for each in faults if each.position.file == file)
    stored = memory.points(program.upper(), Faults())
    points = tuple((name, shown_value(stored.get(name))) for name in dict.fromkeys([*taught_in(unit), *stored]))
    return Listing(file, tuple(text.splitlines()), rows, points, tuple(lines_of(unit)))


def robotstar_listing(cell: Cell, program: str) -> Listing | None:
    """A program of the memory by its key, a step a line as the control shows it; None: there is none.  OSError.

    Lines are numbers of steps here, as those of processes and breakpoints are: a file may have empty lines and comments between them.
    """
    folder = memory_folder(cell)
    if folder is None:
        return None
    faults = Faults()
    try:
        files = {source.path: source.text for source in with_system(sources(str(folder)))}
    except FolderFault as fault:
        raise OSError(str(fault)) from fault
    memory = RobotstarMemory.read((Source(path, text) for path, text in files.items()), words(), faults)
    found = memory.find(program)
    if found is None:
        return None
    numbers = {step.line: step.number for step in found.steps}
    own = (each for each in faults if each.position.file == found.file)
    rows = tuple((numbers.get(each.position.line, 1), each.severity.value, each.text) for each in own)
    stops = tuple(step.number for step in found.steps[1:] if step.valid and step.word != "C")
    lines = files[found.file].splitlines()
    return Listing(found.file, tuple(lines[step.line - 1].strip() for step in found.steps), rows, statements=stops)
