"""Reads the user memory of a ROBOTstar V from a folder, and the language's table of words."""

import importlib.resources
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path

from gateway.files.old_text import decoded
from gateway.pure.languages.robotstar.memory import Source
from gateway.pure.languages.robotstar.protection import Protected, letters_of
from gateway.pure.languages.robotstar.words import Words

MOST_BYTES = 4_000_000  # of a program
LOCKS = ".protection"  # file with the locked letters of programs
KEPT = ".VAL"  # suffix of a file with values that outlive power-off


class FolderFault(ValueError):
    """The folder cannot be read."""


def words() -> Words:
    """The table shipped."""
    table = importlib.resources.files("configs") / "languages" / "robotstar.toml"
    return Words.from_data(tomllib.loads(table.read_text(encoding="utf-8")))


def sources(folder: str) -> list[Source]:
    """All files of a memory, sorted; hidden ones are left out.  FolderFault where there is no folder."""
    root = Path(folder)
    if not root.is_dir():
        raise FolderFault(f"{folder} is no folder; name the folder that holds the programs (NAME.MPR, NAME.SPR, ..)")
    locks = locks_of(root)
    files = [(path.relative_to(root).as_posix(), path) for path in _files(root)]
    return [Source(name, text_of(path), locks.get(name, "")) for name, path in files]


def locks_of(root: Path) -> dict[str, str]:
    """Locked letters by file, as the hidden file of the memory has them: a file a line.  FolderFault."""
    path = root / LOCKS
    if not path.exists():
        return {}
    found: dict[str, str] = {}
    for line in text_of(path).splitlines():
        name, equals, letters = line.rpartition("=")
        try:
            found[name.strip()] = letters_of(letters)
        except Protected as fault:
            raise FolderFault(f"{path}: {fault}") from fault
        if not equals:
            raise FolderFault(f"{path}: {line!r} has no '='; a line is NAME.MPR = LS")
    return found


def write_locks(root: Path, locks: Mapping[str, str]) -> None:
    """The file as a whole."""
    text = "".join(f"{name} = {letters}\n" for name, letters in sorted(locks.items()) if letters)
    fresh = root / f"{LOCKS}.new"
    try:
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(root / LOCKS)
    except OSError as error:
        raise FolderFault(f"{fresh}: {error.strerror}") from None


def _files(root: Path) -> Iterator[Path]:
    for path in sorted(root.rglob("*"), key=lambda each: each.relative_to(root).as_posix()):
        hidden = any(part.startswith(".") for part in path.relative_to(root).parts)
        if path.is_file() and not hidden and path.suffix.upper() != KEPT:
            yield path


def text_of(path: Path) -> str:
    """A file in any code page it may have been written with."""
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise FolderFault(f"{path}: {error.strerror}") from None
    if len(data) > MOST_BYTES:
        raise FolderFault(f"{path}: more than {MOST_BYTES} bytes; a program is smaller")
    return decoded(data)


def write(folder: Path, files: Mapping[str, str]) -> None:
    """Writes programs; FolderFault where one is there already: nothing is overwritten."""
    there = [name for name in files if (folder / name).exists()]
    if there:
        raise FolderFault(f"{folder} holds {', '.join(there)} already; name an empty folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise FolderFault(f"{folder}: {error.strerror}") from None
