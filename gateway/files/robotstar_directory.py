"""The directory of a ROBOTstar memory on disk: its display, and its keys: protect, delete, rename, copy.  Source: robotstar 1.2,
1.3, L1033-1146; AX-1001."""

import datetime
from dataclasses import dataclass
from pathlib import Path

from gateway.files.robotstar import KEPT, FolderFault, locks_of, replace, sources, text_of, words, write_locks
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import SourceFile
from gateway.pure.languages.plc.steps import Wrong, step_of
from gateway.pure.languages.robotstar.memory import Memory
from gateway.pure.languages.robotstar.program import DEFINITIONS
from gateway.pure.languages.robotstar.protection import DELETE, EDIT, RENAME, STRUCTURE, demand, letters_of, shown
from gateway.pure.languages.robotstar.reader import read_program, unnumbered


@dataclass(frozen=True, slots=True)
class Entry:
    """One program or directory.  `variables`: definitions are in it."""

    name: str
    kind: str
    length: int
    changed: str
    protection: str
    variables: bool


def entries(folder: Path) -> list[Entry]:
    """All of a memory, by name, digits before letters; directories as <DIR>.  FolderFault."""
    locks, found = locks_of(folder), []
    memory = Memory.read(sources(str(folder)), words(), Faults())
    defining = {each.file for each in memory.all() if any(step.valid and step.word in DEFINITIONS for step in each.steps)}
    for source in sources(str(folder)):
        path, (name, _, kind) = folder / source.path, source.path.rpartition(".")
        found.append(
            Entry(name, kind.upper(), path.stat().st_size, _time(path), shown(locks.get(source.path, "")), source.path in defining)
        )
    for path in folder.rglob("*"):
        relative = path.relative_to(folder).as_posix()
        if path.is_dir() and not any(part.startswith(".") for part in relative.split("/")):
            found.append(Entry(relative, "<DIR>", 0, _time(path), shown(""), any(each.startswith(f"{relative}/") for each in defining)))
    return sorted(found, key=lambda each: (each.name.upper(), each.kind))


def _time(path: Path) -> str:
    return datetime.datetime.fromtimestamp(path.stat().st_mtime).strftime("%d.%m.%Y %H:%M")


def protect(folder: Path, name: str, letters: str) -> str:
    """Lock these letters of a program and release the others; return the directory's new display.  FolderFault, Protected."""
    file, locked = _file(folder, name), letters_of(letters)
    write_locks(folder, {**locks_of(folder), file: locked})
    return shown(locked)


def delete(folder: Path, name: str) -> None:
    """A program with its values.  FolderFault, Protected."""
    file, locks = _file(folder, name), locks_of(folder)
    demand(file, locks.pop(file, ""), DELETE)
    (folder / file).unlink()
    (folder / f"{file}{KEPT}").unlink(missing_ok=True)
    write_locks(folder, locks)


def rename(folder: Path, name: str, to: str) -> str:
    """Its head and its values go along; the file it has then.  FolderFault, Protected."""
    file, locks = _file(folder, name), locks_of(folder)
    demand(file, locks.get(file, ""), RENAME)
    new = _copied(folder, file, to)
    write_locks(folder, {**{each: letters for each, letters in locks.items() if each != file}, new: locks.get(file, "")})
    (folder / file).unlink()
    (folder / f"{file}{KEPT}").unlink(missing_ok=True)
    return new


def copy(folder: Path, name: str, to: str) -> str:
    """With its values; always allowed (L1064), the copy is not protected.  FolderFault."""
    return _copied(folder, _file(folder, name), to)


def change_step(folder: Path, name: str, what: str, number: int, text: str = "") -> int:
    """Change one step (L1496-1510): `what` is edit (`text`), delete or invert (valid, invalid); return the new cursor position.
    FolderFault, Protected.
    """
    file = _file(folder, name)
    demand(file, locks_of(folder).get(file, ""), EDIT if what == "edit" else STRUCTURE)
    lines = text_of(folder / file).splitlines()
    places = [at for at, line in enumerate(lines) if unnumbered(line)]
    if not 1 <= number <= len(places):
        raise FolderFault(f"{file} has no step {number}")
    if what != "edit" and number in (1, len(places)):
        raise FolderFault("the first and the last step of a program stay")
    at = places[number - 1]
    old, numbered = unnumbered(lines[at]), unnumbered(lines[at]) != lines[at].strip()
    invalid = old.startswith("\\")
    if what == "edit":
        if text.split()[:1] != old.lstrip("\\").split()[:1]:
            raise FolderFault("the command word of a step is not edited")
        new = f"\\{text}" if invalid else text
    else:
        new = old[1:] if invalid else f"\\{old}"
    lines[at : at + 1] = [] if what == "delete" else [new]
    if what != "delete" and (wrong := _wrong_step(file, lines, at)):
        raise FolderFault(wrong)
    if numbered:
        shown_lines = iter(range(1, len(lines) + 1))
        lines = [f"{next(shown_lines)} {unnumbered(line)}" if unnumbered(line) else line for line in lines]
    replace(folder / file, ("\n".join(lines) + "\n").encode())
    return number - (what == "delete")


def _wrong_step(file: str, lines: list[str], at: int) -> str:
    """Fault that keeps a line from being a step; "" for none."""
    name, _, kind = file.rpartition("/")[2].rpartition(".")
    if kind.upper() == "PLC":
        found = step_of(unnumbered(lines[at]), at + 1) if 0 < at < len(lines) - 1 else None
        return found.text if isinstance(found, Wrong) else ""
    faults = Faults()
    read_program(SourceFile(file, "\n".join(lines)), name, kind.upper(), words(), faults)
    return next((fault.text for fault in faults if fault.position.line == at + 1), "")


def _copied(folder: Path, file: str, to: str) -> str:
    directory, _, old = file.rpartition("/")
    plain, _, kind = old.rpartition(".")
    name = to.strip().removesuffix(f".{kind}")
    new = f"{directory}/{name}.{kind}" if directory else f"{name}.{kind}"
    if not name or "/" in name or name.startswith(".") or any(each.path.upper() == new.upper() for each in sources(str(folder))):
        raise FolderFault(f"{to}: the name is taken, is empty or contains a '/'")
    text = next(each.text for each in sources(str(folder)) if each.path == file)
    head, line, rest = text.partition("\n")
    before, found, behind = head.rpartition(plain)  # the last one: P is also a letter of MPR
    if (folder / f"{file}{KEPT}").exists():  # first: a program without its values would begin with others
        replace(folder / f"{new}{KEPT}", (folder / f"{file}{KEPT}").read_bytes())
    replace(folder / new, ((before + name + behind if found else head) + line + rest).encode())
    return new


def _file(folder: Path, name: str) -> str:
    """The file of a program by its name, with or without its kind."""
    wanted = name.upper()
    found = [each.path for each in sources(str(folder)) if wanted in (each.path.upper(), each.path.upper().rpartition(".")[0])]
    if len(found) != 1:
        why = "several programs have this name: add .MPR, .SPR .." if found else f"there is no such program in {folder}"
        raise FolderFault(f"{name}: {why}")
    return found[0]
