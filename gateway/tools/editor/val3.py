"""VAL 3 in an editor: a program file (.pgx) belongs to the project above it, the folder above the project is the disk."""

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from gateway.files.val3_disk import DiskUnreadable, place_of, read_disk
from gateway.pure.languages.base.faults import Faults, SourceFault
from gateway.pure.languages.val3.loader import Loader, family_of_arm
from gateway.pure.languages.val3.model import Application, ProgramText
from gateway.pure.languages.val3.signatures import SIGNATURES
from gateway.pure.languages.val3.translate import ProgramTranslator
from gateway.tools.editor.symbols import Look, PlacedFault, Symbol, Texts, column_of, decorated

AXES = 6
KINDS = {**dict.fromkeys(("point", "joint"), "point"), **dict.fromkeys(("dio", "aio", "sio"), "channel")}  # of data, by type
OF_CODE = frozenset(("val3", "val3-add-on"))  # faults whose lines count from `begin`
CODE = re.compile(r"<Code[^>]*>\s*(?:<!\[CDATA\[)?\s*")


class Val3:
    """Applications of a CS8 or CS9."""

    name: str = "val3"
    suffixes: tuple[str, ...] = (".pgx", ".pjx", ".dtx")

    def look(self, path: Path, texts: Texts, root: Path) -> Look:
        path = path.resolve()
        project = next((each for each in path.parents if any(one.suffix.lower() == ".pjx" for one in each.iterdir())), None)
        if project is None:
            raise OSError(0, "no project file (.pjx) in its folder or above", str(path))
        try:
            disk_root, folder, name = place_of(project, None)
            disk = read_disk(disk_root)
        except DiskUnreadable as fault:
            raise OSError(0, str(fault), str(path)) from None
        for each, text in texts.items():
            if disk_root in each.parents:
                disk.write(each.relative_to(disk_root).as_posix(), text.encode())
        loader = Loader(disk, AXES, family=family_of_arm(AXES))
        loaded = loader.load(folder, name)
        assert loaded is not None  # the project file exists
        own = path.relative_to(disk_root).as_posix()
        text = (disk.read(own) or b"").decode("utf-8-sig", "replace")
        begins = {each.name: begin_of(text, each.line) for each in loaded.app.programs.values() if each.file == own}
        faults = [PlacedFault(path, line, fault.position.column, fault) for line, fault in _faults(loaded.app, loaded.faults, own, begins)]
        symbols = list(_symbols(loaded.app, disk_root, own, text, begins))
        return Look(
            tuple(faults),
            lambda: (each for each in symbols if each.path == path),
            lambda: (each for each in symbols if each.path != path),
            _hover(),
        )


@cache
def _hover() -> dict[str, str]:
    return decorated(
        (forms[0].name, "; ".join(f"{each.result} {each.name}({', '.join(each.parameters)})" for each in forms))
        for forms in SIGNATURES.values()
    )


def begin_of(text: str, line: int) -> int:
    """Line of the file that is line 1 of a program: its `begin`.  `line`: of the element of the program."""
    rows = text.splitlines(keepends=True)
    start = sum(map(len, rows[: line - 1]))
    found = CODE.search(text, start)
    return text.count("\n", 0, found.end()) + 1 if found else line


def _faults(app: Application, loaded: Faults, own: str, begins: dict[str, int]) -> Iterator[tuple[int, SourceFault]]:
    """Line in the file and fault: faults of programs count from their `begin`, the rest from the top of the file."""
    for fault in loaded:
        if fault.position.file == own and fault.id not in OF_CODE:
            yield fault.position.line, fault
    for name, begin in begins.items():
        found = Faults()
        ProgramTranslator(app, app.programs[name], found, AXES).translate()
        yield from ((begin + fault.position.line - 1, fault) for fault in found)


def _symbols(app: Application, disk: Path, own: str, text: str, begins: dict[str, int]) -> Iterator[Symbol]:
    for each in app.programs.values():
        begin = begins.get(each.name, each.line)
        yield Symbol(each.name, "routine", disk / each.file, begin, 1, _head(each), "", begin + len(each.lines) - 1)
        inner = [(one.name, one.line, one.type_name) for one in each.parameters]
        for name, line, kind in [*inner, *((one.name, one.line, one.type_name) for one in each.locals)]:
            column = column_of(text, line, name) if each.file == own else 1
            yield Symbol(name, "variable", disk / each.file, line, column, kind, each.name)
    for datum in app.data.values():
        kind = KINDS.get(datum.type_name.removesuffix("Rx").removesuffix("Rs"), "variable")
        yield Symbol(datum.name, kind, disk / datum.file, datum.line, 1, datum.type_name + (", public" if datum.public else ""))
    for use in app.libraries.values():
        yield Symbol(use.name, "type", disk / app.project, use.line, 1, f"library {use.path}")


def _head(program: ProgramText) -> str:
    return "(" + ", ".join(f"{each.type_name}{'&' if each.reference else ''} {each.name}" for each in program.parameters) + ")"
