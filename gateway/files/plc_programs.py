"""PLC programs on disk: NAME.PLC in a folder and its subfolders, listings that are imported.  Nothing else of the languages opens them."""

import pathlib
from collections.abc import Mapping

from gateway.files.old_text import decoded

SUFFIX = ".PLC"
MOST = 4_000_000  # bytes of a file
MARKED = (b"\xff\xfe", b"\xfe\xff")  # UTF-16


class ProgramFileFault(ValueError):
    """A folder or file that cannot be used; the text names the remedy."""


def read_programs(folder: pathlib.Path) -> dict[str, str]:
    """All programs by name; those of a subfolder as FOLDER/NAME.  ProgramFileFault, OSError."""
    if not folder.is_dir():
        raise ProgramFileFault(f"{folder}: no such folder; name the folder that holds the NAME{SUFFIX} files")
    found: dict[str, str] = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix.upper() != SUFFIX or not path.is_file():
            continue
        name = path.relative_to(folder).with_suffix("").as_posix().upper()
        if name in found:
            raise ProgramFileFault(f"{path}: {name} exists twice; names must differ in more than their case")
        found[name] = read_listing(path)
    return found


def read_listing(path: pathlib.Path) -> str:
    """A text file of any usual encoding.  ProgramFileFault: too large, or no text."""
    if path.stat().st_size > MOST:
        raise ProgramFileFault(f"{path}: {path.stat().st_size} bytes, at most {MOST}")
    data = path.read_bytes()
    if data[:2] not in MARKED and (path.suffix.upper() == ".S5D" or b"\0" in data):
        raise ProgramFileFault(
            f"{path}: a program file of STEP 5 in its own binary form, or no text at all; "
            "in STEP 5 choose Documentation, Standard output, Blocks, print to a file (.LST) as statement list (AWL), and import that file"
        )
    return decoded(data)


def write_programs(folder: pathlib.Path, programs: Mapping[str, str]) -> list[pathlib.Path]:
    """Write NAME.PLC for each.  ProgramFileFault, before anything is written: a file exists already."""
    paths = {folder / f"{name}{SUFFIX}": text for name, text in programs.items()}
    there = [path for path in paths if path.exists()]
    if there:
        raise ProgramFileFault(f"{there[0]}: exists already; name an empty folder or remove it")
    folder.mkdir(parents=True, exist_ok=True)
    for path, text in paths.items():
        path.write_text(text, encoding="utf-8")
    return sorted(paths)
