"""BAPS2 in an editor: the folder of a file is its memory."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path

from gateway.files.program_memory import baps2_words, folder_memory
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.tree import Constant, Declared, External, Label, Program, Routine, SpecialFunction
from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.source import Position
from gateway.tools.editor.symbols import Look, PlacedFault, Symbol, Texts, decorated

LANGUAGES = {"en": "English", "de": "German"}


class Baps2:
    """Programs of the rho 3."""

    name: str = "baps2"
    suffixes: tuple[str, ...] = (".qll",)

    def look(self, path: Path, texts: Texts, root: Path) -> Look:
        folder = path.resolve().parent
        memory = folder_memory(folder)
        for each, text in texts.items():
            if each.parent == folder:
                memory.files[each.name.upper()] = text.encode()
        library = Library(_words(), memory)
        own = path.name.upper()
        stem = own.removesuffix(".QLL")
        text = memory.text(own) or ""
        program, _, faults = library.examined(own, text)
        if program is None:  # a file that others include
            _, faults = library.check(own, text)
        files = _Files(folder, path)
        placed = tuple(PlacedFault(files.of(each.position), each.position.line, each.position.column, each) for each in faults)
        lines = text.count("\n") + 1
        return Look(
            placed, lambda: () if program is None else _symbols(program, files, lines), lambda: _others(library, folder, stem), _hover()
        )


@cache
def _words() -> Words:
    return baps2_words()


@cache
def _hover() -> dict[str, str]:
    return decorated(
        (spelling.text, f"{token} of BAPS2, {LANGUAGES.get(spelling.language, spelling.language)}; source {spelling.source}")
        for token, spellings in _words().spellings.items()
        for spelling in spellings
    )


class _Files:
    """The files of a memory by the names in positions, which are in capitals."""

    def __init__(self, folder: Path, own: Path) -> None:
        self._folder, self._found = folder, {own.name.upper(): own}

    def of(self, at: Position) -> Path:
        """The file of a position."""
        name = at.file.upper()
        if name not in self._found:
            there = (each for each in self._folder.iterdir() if each.name.upper() == name)
            self._found[name] = next(there, self._folder / at.file)
        return self._found[name]


def _others(library: Library, folder: Path, own: str) -> Iterator[Symbol]:
    """Programs of the memory and their public names."""
    for name in library.names():
        if name != own and (program := library.tree(name)) is not None:
            files = _Files(folder, folder / f"{name}.QLL")
            yield from (each for each in _symbols(program, files, 0) if each.kind == "module" or "PUBLIC" in each.detail)


def _symbols(program: Program, files: _Files, end: int) -> Iterator[Symbol]:
    main = program.main
    if not program.external_subroutine:
        yield Symbol(main.name, "module", files.of(main.at), main.at.line, main.at.column, "permanent" if program.head.permanent else "")
        yield from _inside(main, files, "")
    for number, each in enumerate(program.subroutines):
        last = program.subroutines[number + 1].at.line - 1 if number + 1 < len(program.subroutines) else end
        shown = ", ".join(f"{'VALUE ' if one.by_value else ''}{one.type.base}: {one.name}" for one in each.parameters)
        yield Symbol(each.name, "routine", files.of(each.at), each.at.line, each.at.column, f"({shown})" if shown else "", "", last)
        for one in each.parameters:
            yield Symbol(one.name, "variable", files.of(one.at), one.at.line, one.at.column, f"{one.type.base}, parameter", each.name)
        yield from _inside(each, files, each.name)


def _inside(routine: Routine, files: _Files, inside: str) -> Iterator[Symbol]:
    for each in routine.declarations:
        at = each.at
        match each:
            case Declared():
                kind = "channel" if each.channel is not None else "point" if each.teach or "POINT" in each.type.base else "variable"
                words = [each.type.base, *(["PUBLIC"] if each.public else []), *(["DEF"] if each.teach else [])]
                yield Symbol(each.name, kind, files.of(at), at.line, at.column, " ".join(words), inside)
            case Constant():
                yield Symbol(each.name, "constant", files.of(at), at.line, at.column, "", inside)
            case SpecialFunction():
                yield Symbol(each.name, "routine", files.of(at), at.line, at.column, "special function", inside)
            case External():
                pass  # declared where it is public
    yield from (Symbol(each.name, "label", files.of(each.at), each.at.line, each.at.column, "", inside) for each in _labels(routine.body))


def _labels(node: object) -> Iterator[Label]:
    """All labels of statements, however deep."""
    if isinstance(node, Label):
        yield node
    elif isinstance(node, tuple):
        for each in node:
            yield from _labels(each)
    elif is_dataclass(node):
        for one in fields(node):
            yield from _labels(getattr(node, one.name))
