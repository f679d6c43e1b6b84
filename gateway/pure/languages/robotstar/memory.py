"""The user memory: programs by directory and name, their definitions, global and local variables.  Source: robotstar 1.2, 2.3.

A variable lives with the program that defines it; local ones, too: they keep their values from call to call.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from gateway.pure.languages.base.collecting import uncollected
from gateway.pure.languages.base.faults import Faults, also_at
from gateway.pure.languages.base.source import SourceFile
from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.operands import Number, Operand, Ref, Text
from gateway.pure.languages.robotstar.program import DEFINITIONS, KINDS, Program, Step
from gateway.pure.languages.robotstar.protection import DELETE, EXECUTE, shown
from gateway.pure.languages.robotstar.reader import read_program
from gateway.pure.languages.robotstar.values import ELEMENTS, Cell, Structure, Variable, made
from gateway.pure.languages.robotstar.words import Words

NO_LETTERS = '\0\n\r/:\\"'  # in a name of a program or directory
LONGEST = 128  # characters of a program's name; 20 of a directory's (D-45)
DIRECTORY_LONGEST, DEEPEST = 20, 6
MOST_ELEMENTS = 100_000
MESSAGES = "PLCMSG_CNF"  # texts of the PLC, read with it
DEFAULT_TOOL = "T"  # printed everywhere without a definition


def wrong_name(name: str, directory: str) -> bool:
    """No file of the memory can have this name, or no directory that path."""
    parts = directory.split("/") if directory else []
    letters = any(not part.strip() or part.startswith(".") or set(part) & set(NO_LETTERS) for part in (name, *parts))
    return letters or len(name) > LONGEST or len(parts) > DEEPEST or any(len(part) > DIRECTORY_LONGEST for part in parts)


@dataclass(frozen=True, slots=True)
class Source:
    """One file of the memory: path below the root with `/`, its text, the letters of its protection that are locked."""

    path: str
    text: str
    locked: str = ""


@dataclass(slots=True)
class Memory:
    """All programs.  `globals` and `locals` hold the variables; `locals` by key of the program."""

    words: Words
    programs: dict[str, list[Program]] = field(default_factory=dict)  # upper-case name -> programs
    globals: dict[str, Variable] = field(default_factory=dict)
    owners: dict[str, Program] = field(default_factory=dict)  # of global names
    locals: dict[str, dict[str, Variable]] = field(default_factory=dict)
    plc: dict[str, str] = field(default_factory=dict)  # path -> text of the integrated PLC's programs
    plc_files: dict[str, str] = field(default_factory=dict)
    gone: set[str] = field(default_factory=set)  # files of programs that a program has deleted
    version: int = 0  # grows whenever programs change

    @classmethod
    def read(cls, sources: Iterable[Source], words: Words, faults: Faults) -> "Memory":
        """Read all sources; unreadable parts are in `faults`."""
        memory = cls(words)
        with uncollected():
            for source in sources:
                memory._take(source, faults)
        return memory

    def _take(self, source: Source, faults: Faults) -> None:
        directory, _, file = source.path.rpartition("/")
        name, dot, kind = file.rpartition(".")
        place = SourceFile(source.path, source.text)
        parts = [part for part in directory.split("/") if part]
        if not dot or kind.upper() not in KINDS:
            faults.error("rsv.file", place.at(1), f"{file} is not a program: the name ends with {' '.join('.' + each for each in KINDS)}")
            return
        if len(name) > LONGEST or any(len(part) > DIRECTORY_LONGEST for part in parts):
            faults.error(
                "rsv.name", place.at(1), f"{source.path}: names have at most {LONGEST} characters, of directories {DIRECTORY_LONGEST}"
            )
        if len(parts) > DEEPEST:
            faults.error("rsv.depth", place.at(1), f"{source.path}: directories nest at most {DEEPEST} deep")
        if kind.upper() == "PLC" or name.upper() == MESSAGES:
            self.plc[f"{directory}/{name}" if directory else name] = source.text
            self.plc_files[f"{directory}/{name}" if directory else name] = source.path
            return
        program = read_program(place, name, kind.upper(), self.words, faults, directory)
        if any(each.key == program.key and each.kind != "PLC" for each in self.programs.get(name.upper(), [])):
            faults.error("rsv.program_twice", place.at(1), f"{program.key}: there are two programs of this name")
        program.locked = source.locked
        if EXECUTE in source.locked:
            program.refused.append((1, f"{program.name} is protected against execution ({shown(source.locked)})"))
        self.add(program, faults)

    def add(self, program: Program, faults: Faults | None = None) -> None:
        """Takes a program into the memory with its definitions."""
        self.version += 1
        self.programs.setdefault(program.name.upper(), []).append(program)
        self.locals.setdefault(program.key, {})
        if program.kind == "PLC":
            return
        twice: dict[tuple[str, str], list[Step]] = {}
        for step in program.steps:
            if step.valid and step.word in DEFINITIONS and "name" in step.slots:
                self._define(program, step, faults, twice)
        for (name, where), steps in twice.items():
            text = f"step {steps[0].number}: {name or _name(steps[0])} is defined twice in {where}"
            program.refused.append((steps[0].line, text.partition(": ")[2]))
            if faults is not None:
                place = SourceFile(program.file, "").at(steps[0].line)
                faults.error("rsv.definition", place, text, also_at(step.number for step in steps[1:]))

    def remove(self, program: Program) -> None:
        """Delete a program and its definitions.  Raise StepFault where it is protected."""
        if DELETE in program.locked:
            raise StepFault(f"program {program.name} is protected against deletion")
        self.version += 1
        self.gone.add(program.own_file)
        self.programs[program.name.upper()].remove(program)
        self.locals.pop(program.key, None)
        for name in [name for name, owner in self.owners.items() if owner is program]:
            del self.owners[name], self.globals[name]

    def all(self) -> Iterator[Program]:
        """All programs in the order of their names."""
        for name in sorted(self.programs):
            yield from sorted(self.programs[name], key=lambda program: program.key)

    def find(self, name: str, near: str = "", kinds: tuple[str, ...] = ("MPR", "SPR", "MAC", "PAL")) -> Program | None:
        """A program by name or path: first in the directory `near`, then in the root, then anywhere."""
        path = name.replace("\\", "/").upper()
        path = path.partition(":")[2] if ":" in path else path
        directory, _, plain = path.strip().lstrip("/").rpartition("/")
        for kind in kinds:
            plain = plain.removesuffix("." + kind)
        found = [program for program in self.programs.get(plain, []) if program.kind in kinds]
        if directory:
            found = [program for program in found if program.directory.upper() == directory]
        order = sorted(
            found, key=lambda each: (each.directory.upper() != near.upper(), each.directory != "", kinds.index(each.kind), each.key)
        )
        return order[0] if order else None

    def directory(self, path: str) -> str:
        """A directory in the letters it has already."""
        return next((each.directory for each in self.all() if each.directory.upper() == path.upper()), path)

    # ---- definitions ---------------------------------------------------------------------------------------------------
    def _define(self, program: Program, step: Step, faults: Faults | None, twice: dict[tuple[str, str], list[Step]]) -> None:
        """Defines a variable.  `twice`: steps of names that are there, by the name or, in a copy of a program, by its original."""
        name = step.slots["name"]
        assert isinstance(name, Ref)
        place = SourceFile(program.file, "").at(step.line)
        kind = self.kind_of(name.name)
        wrong = self._wrong(name, kind, step)
        local = step.word.startswith("LOC_")
        table = self.locals[program.key] if local else self.globals
        if not wrong and name.name in table:
            owner = program if local else self.owners[name.name]
            where = "this program" if local else f"the memory (in {owner.key})"
            twice.setdefault((name.name if owner is program else "", where), []).append(step)
            return
        if not wrong:
            variable = made(name.name, name.index if isinstance(name.index, int) else None, name.length or 0, kind)
            wrong = self._filled(variable, step)
        if wrong:
            if faults is not None:
                faults.error("rsv.definition", place, f"step {step.number}: {wrong}")
            program.refused.append((step.line, wrong))
            return
        table[name.name] = variable
        if not local:
            self.owners[name.name] = program

    def kind_of(self, name: str) -> str:
        """Return the type of a name: its first letter; "" where that is not a type (L764-771)."""
        if name in self.words.integers:
            return "I"
        return name[0] if name[0] in "IRVPTS" else ""

    def _wrong(self, name: Ref, kind: str, step: Step) -> str:
        if not kind:
            return f"{name.name}: the first letter of a variable is its type: I R V P T S"
        if name.element or isinstance(name.index, str):
            return f"{name.name}: a definition has the name and the number of elements"
        if isinstance(name.index, int) and not 1 <= name.index <= MOST_ELEMENTS:
            return f"{name.name}[{name.index}]: the number of elements is outside 1 .. {MOST_ELEMENTS}"
        if (kind == "S") != (name.length is not None) and not (kind == "S" and step.word.endswith("CONST")):
            return f"{name.name}: write the length of a string in round brackets" if kind == "S" else f"{name.name} has no length"
        if name.length is not None and not 1 <= name.length <= 256:
            return f"{name.name}({name.length}): the length is outside 1 .. 256"
        if step.word.endswith("CONST") and len(step.slots) < 2:
            return f"{name.name}: a constant has a value"
        return ""

    def _filled(self, variable: Variable, step: Step) -> str:
        """Gives a constant its value, a variable the one it was kept with; "" or a sentence."""
        values = {place: operand for place, operand in step.slots.items() if place != "name"}
        constant = step.word.endswith("CONST")
        try:
            if isinstance(variable, Cell):
                if values:
                    if list(values) != ["value"]:
                        return "one value is needed"
                    variable.write(_literal(values["value"]))
                variable.constant = constant
            elif isinstance(variable, Structure):
                for name, operand in zip(_elements(values, variable.kind), values.values(), strict=False):
                    number = _literal(operand)
                    if name not in variable.parts or isinstance(number, str):
                        return f"{name} is not an element of a variable of type {variable.kind}"
                    variable.put(name, number)
                variable.constant = constant
            elif values:
                return "an array has no value in its definition"
        except Exception as fault:  # a StepFault with COPY's text, or a value that is none
            return getattr(fault, "text", str(fault))
        return ""


def _name(step: Step) -> str:
    name = step.slots["name"]
    return name.name if isinstance(name, Ref) else ""


def _elements(values: dict[str, Operand], kind: str) -> list[str]:
    """The elements meant: by descriptor, else in the order of the type."""
    order = [name for name in ELEMENTS[kind] if kind != "P" or name not in ("MA", "AA", "PT", "FRAME")]
    return [order[at] if name == "value" or name.startswith("V") else name for at, name in enumerate(values)]


def _literal(operand: Operand) -> int | float | str:
    if isinstance(operand, Number | Text):
        return operand.value
    raise ValueError("the value of a definition is a number or a text")
