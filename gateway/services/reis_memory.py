"""The memory of a Reis as its pendant reads and changes it: files, in a separate thread, so that the services do not wait."""

import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from gateway.files.robotstar import FolderFault, shipped, text_of
from gateway.files.robotstar_directory import Entry, change_step, copy, delete, entries, protect, rename
from gateway.pure.languages.robotstar.program import KINDS
from gateway.pure.languages.robotstar.protection import Protected
from gateway.pure.languages.robotstar.reader import unnumbered

MOST = 16  # orders that wait
Folders = dict[str, list[tuple[str, str]]]


@dataclass(frozen=True, slots=True)
class Answer:
    """Result of an order; words: the fault, or what was done."""

    do: str
    words: str = ""
    folders: Folders = field(default_factory=dict)
    path: str = ""
    rows: tuple[str, ...] = ()
    step: int = 0  # of a program that was changed: where the cursor is


class ReisMemory:
    """Call `ask` at any time; `take` returns the answers, one at a time."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._asked: queue.Queue[Callable[[], Answer]] = queue.Queue(MOST)
        self._answers: queue.SimpleQueue[Answer] = queue.SimpleQueue()
        threading.Thread(target=self._work, name="reis-memory", daemon=True).start()

    def ask(self, do: str, name: str = "", more: str = "") -> bool:
        """list, open (`name`), delete, copy, rename (`more`: the new name), protect (`more`: letters), change (`more`: what, step, text);
        False: too many wait."""
        try:
            self._asked.put_nowait(lambda: answered(self._folder, do, name, more))
        except queue.Full:
            return False
        return True

    def take(self) -> Answer | None:
        """The next answer; None: there is none yet."""
        try:
            return self._answers.get_nowait()
        except queue.Empty:
            return None

    def _work(self) -> None:
        while True:
            self._answers.put(self._asked.get()())


def answered(folder: Path, do: str, name: str, more: str) -> Answer:
    """One order, carried out."""
    try:
        match do:
            case "open":
                path, rows = program(folder, name)
                return Answer(do, path=path, rows=rows)
            case "change":
                what, number, text = (*more.split(" ", 2), "")[:3]
                step = change_step(folder, name, what, int(number), text)
                path, rows = program(folder, name)
                return Answer(do, path=path, rows=rows, step=step)
            case "delete":
                delete(folder, name)
            case "copy":
                copy(folder, name, more)
            case "rename":
                rename(folder, name, more)
            case "protect":
                protect(folder, name, more)
        return Answer(do, "" if do == "list" else "done", directories(folder))
    except (FolderFault, Protected, OSError) as fault:
        return Answer(do, str(fault))


def directories(folder: Path) -> Folders:
    """Name and line of each entry of each directory: type, bytes, date, protection, Var (L1039-1080).  FolderFault."""
    found: Folders = {"": []}
    for entry in entries(folder):
        directory, _, name = entry.name.rpartition("/")
        kind = "" if entry.kind == "<DIR>" else f".{entry.kind}"
        if not kind:
            found.setdefault(entry.name, [])
        found.setdefault(directory, []).append((f"{name}{kind}", _line(name, entry)))
    return found


def _line(name: str, entry: Entry) -> str:
    size = f"{entry.length:>7} " if entry.length else ""
    return f"{name:<12} {entry.kind:<5} {size}{entry.changed} {entry.protection}{' Var' if entry.variables else ''}"


def program(folder: Path, name: str) -> tuple[str, tuple[str, ...]]:
    """File below the memory and steps, as the display has them: a step a line, the backslash of an invalid one kept.  FolderFault."""
    wanted = name.replace("\\", "/").strip("/").upper()
    paths = (path for path in folder.rglob("*") if path.is_file() and path.suffix.upper()[1:] in KINDS)
    there = {path.relative_to(folder).as_posix(): path for path in paths}
    system = {source.path: source.text for source in shipped()}
    files = [*sorted(there), *system]
    fits = [file for file in files if wanted in (file.upper(), file.upper().rpartition(".")[0])]
    fits = fits or [file for file in files if wanted in (Path(file.upper()).name, Path(file.upper()).stem)]
    if not fits:
        raise FolderFault(f"there is no program {name}")
    text = text_of(there[fits[0]]) if fits[0] in there else system[fits[0]]
    rows = (unnumbered(line) for line in text.splitlines() if line.strip())
    return fits[0], tuple(row for row in rows if row)
