"""ROBOTstar programs in an editor: the memory is the folder of the file, or the one above it that the editor has open."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path

from gateway.files.robotstar import sources, words
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.grammar import GRAMMAR
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.languages.robotstar.operands import Number, Operand, Ref, Text
from gateway.pure.languages.robotstar.plc_link import check_plc
from gateway.pure.languages.robotstar.program import DEFINITIONS, Program
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.virtual import VirtualCell
from gateway.pure.languages.robotstar.words import Words
from gateway.tools.editor.symbols import Look, PlacedFault, Symbol, Texts, column_of, decorated

TYPES = {"I": "integer", "R": "real", "S": "text", "P": "position", "V": "vector", "T": "tool"}


class Robotstar:
    """Programs of the ROBOTstar V and of its PLC."""

    name: str = "robotstar"
    suffixes: tuple[str, ...] = (".mpr", ".spr", ".mac", ".pal", ".plc")

    def look(self, path: Path, texts: Texts, root: Path) -> Look:
        path = path.resolve()
        folder = root if root in path.parents and (path.parent == root or _holds_programs(root)) else path.parent
        held = {each.relative_to(folder).as_posix(): text for each, text in texts.items() if folder in each.parents}
        found = [Source(each.path, held.pop(each.path, each.text)) for each in sources(str(folder)) if _is_program(each.path)]
        found += [Source(name, text) for name, text in held.items() if _is_program(name)]
        faults = Faults()
        memory = Memory.read(found, _words(), faults)
        check(memory, faults, VirtualCell(memory, MODES["auto"]).system.names())
        check_plc(memory.plc, memory.plc_files, faults)
        placed = [PlacedFault(folder / each.position.file, each.position.line, each.position.column, each) for each in faults]
        by_file = {each.path: each.text for each in found}
        return Look(
            tuple(each for each in placed if each.path == path),
            lambda: (
                one for each in memory.all() if folder / each.file == path for one in _symbols(each, folder, by_file.get(each.file, ""))
            ),
            lambda: (
                one
                for each in memory.all()
                if folder / each.file != path
                for one in _symbols(each, folder, by_file.get(each.file, ""))
                if one.kind != "label" and not one.inside
            ),
            _hover(),
        )


def _is_program(path: str) -> bool:
    return path.lower().endswith(Robotstar.suffixes)


def _holds_programs(folder: Path) -> bool:
    return any(_is_program(each.name) for each in folder.iterdir())


@cache
def _words() -> Words:
    return words()


@cache
def _hover() -> dict[str, str]:
    return decorated((text, _form(word)) for text, word in _words().words.items())


def _form(word: str) -> str:
    """The command with its parameters."""
    places = GRAMMAR.get(word, ())
    shown = [f"[{each.name}]" if each.optional else each.name for each in places]
    chosen = [f"{each.name}: {' '.join('#' + one for one in each.equates)}" for each in places if each.equates]
    return f"{word} {', '.join(shown)}".rstrip() + (f"; {'; '.join(chosen)}" if chosen else "")


def _symbols(program: Program, folder: Path, text: str) -> Iterator[Symbol]:
    path = folder / program.file
    kinds = {"MPR": "main program", "SPR": "sub-program", "MAC": "macro", "PAL": "pallet program", "PLC": "PLC program"}
    yield Symbol(program.name, "module", path, 1, 1, kinds.get(program.kind, program.kind))
    for step in program.steps:
        if step.word in DEFINITIONS and "name" in step.slots:
            name = _name(step.slots["name"])
            kind = "constant" if step.word.endswith("CONST") else "point" if name[:1] == "P" else "variable"
            local = program.name if step.word.startswith("LOC_") else ""
            detail = TYPES.get(name[:1], "") + (", local" if local else "")
            yield Symbol(name, kind, path, step.line, column_of(text, step.line, name), detail, local)
        elif step.word == "LABEL" and "label" in step.slots:
            name = _name(step.slots["label"])
            yield Symbol(name, "label", path, step.line, column_of(text, step.line, name), f"step {step.number}")


def _name(operand: Operand) -> str:
    match operand:
        case Ref():
            return operand.name
        case Text() | Number():
            return str(operand.value)
        case _:
            return operand.name if hasattr(operand, "name") else ""
