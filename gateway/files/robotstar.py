"""Reads the user memory of a ROBOTstar V from a folder, and the language's table of words."""

import importlib.resources
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path

from gateway.files.old_text import decoded
from gateway.pure.languages.robotstar.memory import Source
from gateway.pure.languages.robotstar.words import Words

MOST_BYTES = 4_000_000  # of a program
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
    return [Source(path.relative_to(root).as_posix(), text_of(path)) for path in _files(root)]


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
