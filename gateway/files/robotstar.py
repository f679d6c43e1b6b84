"""Reads the user memory of a ROBOTstar V from a folder, and the language's table of words."""

import importlib.resources
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path

from gateway.files.old_text import decoded
from gateway.files.safe_file import write_whole
from gateway.pure.languages.robotstar.memory import Source
from gateway.pure.languages.robotstar.program import KINDS
from gateway.pure.languages.robotstar.protection import Protected, letters_of
from gateway.pure.languages.robotstar.words import Words

MOST_BYTES = 4_000_000  # of a program
LOCKS = ".protection"  # file with the locked letters of programs
KEPT = ".VAL"  # suffix of a file with values that outlive power-off


_NAMES = re.compile(r"SYVARINI|(?:MOUSE|MAUS)_(?:KAL[12]|PHG|DAT)|AKTI_K(?:AL[12]|PHG)|V_KAL(?:[12]|PHG)", re.IGNORECASE)
_DATA = re.compile(r"^\W*\d*\W*VAR\b.*\bV_KAL(?:[12]|PHG)\b", re.IGNORECASE | re.MULTILINE)


class FolderFault(ValueError):
    """The folder cannot be read."""


def words() -> Words:
    """The table shipped."""
    table = importlib.resources.files("configs") / "languages" / "robotstar.toml"
    return Words.from_data(tomllib.loads(table.read_text(encoding="utf-8")))


def sources(folder: str) -> list[Source]:
    """All files of a memory, sorted, without hidden ones.  FolderFault if there is no folder."""
    root = Path(folder)
    if not root.is_dir():
        raise FolderFault(f"{folder} is not a folder; name the folder that holds the programs (NAME.MPR, NAME.SPR, ..)")
    locks = locks_of(root)
    files = [(path.relative_to(root).as_posix(), path) for path in _files(root)]
    return [Source(name, text_of(path) if _is_program(path) else "", locks.get(name, "")) for name, path in files]


def _is_program(path: Path) -> bool:
    """Other files are not read: a manual or a picture has any size."""
    return path.suffix.upper()[1:] in KINDS


def shipped() -> list[Source]:
    """System programs of the control: default allocation, calibration of the 6D mouse (AX-1766)."""
    root = importlib.resources.files("configs") / "languages" / "robotstar"
    return [
        Source(f"$SYSTEM/{folder.name}/{file.name}", file.read_text(encoding="utf-8"))
        for folder in sorted((root / "$SYSTEM").iterdir(), key=lambda each: each.name)
        for file in sorted(folder.iterdir(), key=lambda each: each.name)
    ]


def with_system(found: list[Source]) -> list[Source]:
    """A memory with the system programs it lacks, by name in any directory; MAUS_ is MOUSE_ (D-41), and data are defined once."""
    there = {_plain(source.path) for source in found}
    data = any(_DATA.search(source.text) for source in found)
    return [*found, *(each for each in shipped() if _plain(each.path) not in there and not (data and _plain(each.path) == "MOUSE_DAT"))]


def with_system_used(found: list[Source], program: str) -> list[Source]:
    """The same where a program of the memory, or the one that is to run, names one of them."""
    used = _NAMES.search(program) or any(_NAMES.search(source.text) for source in found)
    return with_system(found) if used else found


def _plain(path: str) -> str:
    """Name of a program without directory and kind."""
    return path.rpartition("/")[2].rpartition(".")[0].upper().replace("MAUS_", "MOUSE_")


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
    """Write the complete file."""
    text = "".join(f"{name} = {letters}\n" for name, letters in sorted(locks.items()) if letters)
    replace(root / LOCKS, text.encode())


def replace(path: Path, octets: bytes) -> None:
    """Replace the complete file: the old or the new one.  FolderFault: the old one."""
    try:
        write_whole(path, octets)
    except OSError as error:
        raise FolderFault(f"{path}: {error.strerror}") from None


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
    """Write programs; FolderFault if one exists already: nothing is overwritten."""
    there = [name for name in files if (folder / name).exists()]
    if there:
        raise FolderFault(f"{folder} already contains {', '.join(there)}; name an empty folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise FolderFault(f"{folder}: {error.strerror}") from None
