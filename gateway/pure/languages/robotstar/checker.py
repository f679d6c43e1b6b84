"""What is wrong with the programs of a memory beyond the form of their steps.  Faults that are certain are found before a start;
those marked late stop a program only at the step (the texts of COPY, missing programs), so that the rest of it runs as on the control.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from gateway.pure.languages.base.faults import Faults, also_at, hints
from gateway.pure.languages.base.near import MOST_HINTS, hint_for_print, hint_with, meant, nearest
from gateway.pure.languages.base.source import SourceFile
from gateway.pure.languages.robotstar.access import of_one_group
from gateway.pure.languages.robotstar.circles import wrong_circles
from gateway.pure.languages.robotstar.control_steps import BYTES
from gateway.pure.languages.robotstar.faults import (
    INDEX_NOT_FOUND,
    INDEX_RANGE,
    IS_ARRAY,
    NO_ARRAY,
    NO_VARIABLE,
    NO_WRITING,
    NOT_FOUND,
    WRONG_TYPES,
    StepFault,
)
from gateway.pure.languages.robotstar.literals import wrong_kind, wrong_literal
from gateway.pure.languages.robotstar.memory import DEFAULT_TOOL, Memory
from gateway.pure.languages.robotstar.nesting import TOO_DEEP, too_deep
from gateway.pure.languages.robotstar.operands import HIGHEST, LOWEST, Equate, Number, Operand, Ref, Text
from gateway.pure.languages.robotstar.pallet import PatternFault, pattern_of
from gateway.pure.languages.robotstar.program import DEFINITIONS, HEADS, Program, Step, definition_late
from gateway.pure.languages.robotstar.reader import spelled
from gateway.pure.languages.robotstar.values import Array, Names, Structure, SystemCell, Variable

POSITIONS = ("POSITION", "VAR_POS")
WRITTEN = ("destination", "control")  # places a step writes to
WRITTEN_BY = (("ACT_POS", "position"), ("CALC_REL", "vector"))
TARGETS = {"CALL": ("SPR",), "PROGRAM": ("MPR",), "PALLET": ("PAL", "MPR")}
TAKE_PROGRAMS = ("CALL", "PROGRAM", "PALLET", "TRAFO_6D")
CARTESIAN_PARTS = ("Frame", "X", "Y", "Z", "A", "B", "C", "A1..A24")
PARTS = {"V": CARTESIAN_PARTS, "P": ("MA", "AA", "PT", *CARTESIAN_PARTS), "T": ("X", "Y", "Z", "RX", "RY", "RZ")}
NAMES_OF_PROGRAMS = frozenset(("program", "ref_source", "ref_destination", "source", "destination"))


@dataclass(slots=True)
class _Check:
    memory: Memory
    faults: Faults
    system: Names
    known: dict[str, list[Variable]] = field(default_factory=dict)
    made: set[str] = field(default_factory=set)  # programs that a TRAFO_6D of this memory makes, callable after it (L3267-3273)
    intended: set[str] = field(default_factory=set)  # names that misspelt definitions would define
    lost: dict[str, list[Step]] = field(default_factory=dict)  # names defined nowhere, and the steps of this program with them
    unreached: dict[str, list[Step]] = field(default_factory=dict)  # faults of calls, and the steps of this program with them
    spellings: dict[str, str] = field(default_factory=dict)  # of commands, and names of macros, with what they mean
    patterns: dict[str, Program] = field(default_factory=dict)  # pallet patterns by their files

    def structural(self, program: Program, step: Step, id: str, text: str, hint: str = "") -> None:
        """A fault that keeps the program from starting."""
        self.late(program, step, id, text, hint)
        program.refused.append((step.line, f"step {step.number}: {text}"))

    def late(self, program: Program, step: Step, id: str, text: str, hint: str = "") -> None:
        """A fault that stops the program at the step."""
        self.faults.error(id, SourceFile(program.file, "").at(step.line), f"step {step.number}: {text}", hint)

    def miss(self, name: str, step: Step) -> None:
        """A name that is defined nowhere."""
        if name not in self.intended and (not self.lost.get(name) or self.lost[name][-1] is not step):
            self.lost.setdefault(name, []).append(step)

    def like(self, word: str, words: Iterable[str]) -> str:
        """The hint with the one or two of these words that a word was meant to be; "": of none."""
        return hint_for_print(word, [*words]) if len(self.faults) < MOST_HINTS else ""


def check(memory: Memory, faults: Faults, system: Names) -> None:
    """All programs of the memory; the faults go to `faults`, those that refuse a start to the programs."""
    checking = _Check(memory, faults, system)
    for table in (memory.globals, *memory.locals.values()):
        for name, variable in table.items():
            checking.known.setdefault(name, []).append(variable)
    macros = {program.name.upper(): program.name.upper() for program in memory.all() if program.kind == "MAC"}
    commands = {spelling: word for spelling, word in memory.words.words.items() if spelling not in HEADS}
    checking.spellings = dict(sorted((macros | commands).items()))
    definitions = [spelling for spelling, word in memory.words.words.items() if word in DEFINITIONS]
    for program in memory.all():
        checking.made.update(_destinations(program))
        checking.intended.update(name for name in _intended(program, definitions) if name not in checking.known)
    for program in memory.all():
        if program.kind != "PLC":
            _program(checking, program)
    for pattern in checking.patterns.values():
        _format(checking, pattern)
    for deep in too_deep(memory):
        checking.late(deep.program, deep.step, "rsv.nesting", TOO_DEEP, f"{deep.again} calls itself" if deep.again else "")


def _destinations(program: Program) -> Iterator[str]:
    """Names of the programs that TRAFO_6D makes, in capitals without a path; those in string variables are known at the step alone."""
    for step in program.steps:
        if step.valid and not step.macro and step.word == "TRAFO_6D" and (name := _name_of(step.slots["destination"])):
            yield name.replace("\\", "/").rpartition("/")[2].strip().upper()


def _intended(program: Program, definitions: Sequence[str]) -> Iterator[str]:
    """Yield names in misspelt definitions: their uses are not separate mistakes."""
    for step in program.steps:
        if step.valid and step.word in DEFINITIONS and isinstance(name := step.slots.get("name"), Ref):
            yield name.name
        if step.macro and step.parameters and nearest(step.word, definitions):
            yield from (each.operand.name for each in step.parameters[:1] if isinstance(each.operand, Ref))


def _name_of(operand: Operand) -> str:
    """Return the name of a program in the step; "" where a string variable holds it."""
    if isinstance(operand, Ref) and operand.name[0] in "S_":
        return ""
    return str(operand.value if isinstance(operand, Text) else getattr(operand, "name", ""))


def _program(checking: _Check, program: Program) -> None:
    if program.kind == "PAL":
        checking.patterns[program.file] = program
    if program.kind == "MAC" and program.steps and program.name.upper() in checking.memory.words.words:
        text = f"{program.name} is a command of the control: a macro of this name is never called"
        checking.late(program, program.steps[0], "rsv.macro_name", text)
    for step, wrong in wrong_circles(program):
        checking.late(program, step, "rsv.circle", wrong)
    tool, began, late = False, 0, []
    for step in program.steps:
        if not step.valid or step.word == "C":
            tool = tool or _is_faulty_tool(checking, step)
            continue
        if step.macro:
            tool = True
            called = _macro(checking, program, step)
            began = began or called
            continue
        if began and step.word in DEFINITIONS:
            late.append(step)
        tool = tool or step.word in ("TOOL", "CALL")
        if step.word in POSITIONS:
            _position(checking, program, step, tool)
            tool = True  # once named
        if step.word not in HEADS and step.word not in DEFINITIONS:
            _step(checking, program, step)
    if late:
        checking.structural(program, late[0], "rsv.definition_late", definition_late(began), also_at(step.number for step in late[1:]))
    _lost(checking, program)


def _is_faulty_tool(checking: _Check, step: Step) -> bool:
    """Whether a step with a fault was meant to name the tool: the positions after it are not a second mistake."""
    return not step.word and checking.memory.words.words.get(step.text.partition(" ")[0].rstrip(":").upper()) == "TOOL"


def _lost(checking: _Check, program: Program) -> None:
    """One fault for each name in a program that is defined nowhere, and for each program that it cannot call."""
    for name, steps in checking.lost.items():
        near = checking.like(name, (each for each in (*checking.known, *checking.system) if each[:1] == name[:1]))
        remedy = near or ("" if name.startswith("_") else "define it with VAR or LOC_VAR")
        checking.late(program, steps[0], "rsv.operand", f"{name}: {NOT_FOUND}", hints(remedy, also_at(step.number for step in steps[1:])))
    for text, steps in checking.unreached.items():
        kinds = TARGETS[steps[0].word]
        names = (each.name for each in checking.memory.all() if each.kind in kinds)
        near = checking.like(_name_of(steps[0].slots["program"]), names) if text.endswith("not found") else ""
        checking.late(program, steps[0], "rsv.program", text, hints(near, also_at(step.number for step in steps[1:])))
    checking.lost.clear()
    checking.unreached.clear()


def _macro(checking: _Check, program: Program, step: Step) -> int:
    """Return the number of a step that calls a macro; 0: an unknown word, which may be a misspelt definition."""
    if checking.memory.find(step.word, program.directory, ("MAC",)) is None:
        text = f"{step.word} is neither a command nor a macro of this memory"
        hint = hint_with(meant(step.word, checking.spellings)) if len(checking.faults) < MOST_HINTS else ""
        hint = hint or f"a macro is a file {step.word}.MAC"
        checking.structural(program, step, "rsv.word", text, hint)
        return 0
    if step.parameters:
        checking.structural(program, step, "rsv.parameters", f"macro {step.word} has no parameters")
    return step.number


def _position(checking: _Check, program: Program, step: Step, tool: bool) -> None:
    if program.kind == "MAC":
        checking.structural(program, step, "rsv.macro_position", f"{step.word}: a macro contains no positions")
    elif not tool and program.kind == "MPR":
        checking.structural(program, step, "rsv.no_tool", f"{step.word}: TOOL is needed in front of the first position")


def _step(checking: _Check, program: Program, step: Step) -> None:
    ranges = list(_ranges(step))
    for text in ranges:
        checking.structural(program, step, "rsv.range", f"{spelled(step, checking.memory.words)}: {text}")
    if step.word in ("CALL", "PROGRAM", "PALLET"):
        if wrong := _target(checking, program, step):
            checking.unreached.setdefault(wrong, []).append(step)
    for place, operand in step.slots.items():
        named = step.word in TAKE_PROGRAMS and place in NAMES_OF_PROGRAMS
        if isinstance(operand, Ref) and place != "label" and not named:
            wrong = _reference(checking, operand, written=place in WRITTEN or (step.word, place) in WRITTEN_BY)
            if step.word == "MOUSE_CALIBRATION":
                wrong = _whole_array(_meant(checking, operand), operand, wrong)
            if wrong == NOT_FOUND:
                checking.miss(operand.name, step)
            elif wrong:
                checking.late(program, step, "rsv.operand", f"{operand.name}: {wrong}", _elements(checking, operand, wrong))
    if step.word == "COPY" and (_types_differ(checking.memory, step) or _groups_differ(checking.memory, step)):
        checking.late(program, step, "rsv.operand", WRONG_TYPES)
    elif not ranges and (wrong := wrong_kind(step, checking.memory.kind_of) or wrong_literal(step, lambda ref: _meant(checking, ref))):
        checking.late(program, step, "rsv.operand", wrong)


def _ranges(step: Step) -> Iterator[str]:
    """Byte and bit numbers, and integers too large for the variable they go to."""
    area = step.slots.get("area")
    if isinstance(area, Equate) and area.name in BYTES:
        byte = step.slots.get("second" if step.word == "TEST" else "byte")
        if isinstance(byte, Number) and not (isinstance(byte.value, int) and 0 <= byte.value < BYTES[area.name]):
            yield f"byte {byte.value:g} is outside 0 .. {BYTES[area.name] - 1}"
        bit = step.slots.get("bit")
        if isinstance(bit, Number) and not (isinstance(bit.value, int) and 0 <= bit.value <= 7):
            yield f"bit {bit.value:g} is outside 0 .. 7"
    source, destination = step.slots.get("source"), step.slots.get("destination")
    if step.word in ("COPY", "ADD", "SUB", "MUL", "DIV", "MODULO") and isinstance(source, Number) and isinstance(destination, Ref):
        integer = destination.name.lstrip("_")[:1] == "I" and not destination.element
        if integer and not LOWEST <= source.value <= HIGHEST:
            yield f"{source.value:.10g} is outside the range of an integer, {LOWEST} .. {HIGHEST}"


def _target(checking: _Check, program: Program, step: Step) -> str:
    if step.word == "PROGRAM" and program.kind not in ("MPR", "PAL"):
        return "PROGRAM is allowed in a main program only"
    text = _name_of(step.slots["program"])
    if not text:
        return ""
    if step.word == "PALLET":
        return _pattern(checking, program, text)
    if checking.memory.find(text, program.directory, TARGETS[step.word]) is not None:
        return ""
    if text.replace("\\", "/").rpartition("/")[2].strip().upper() in checking.made:
        return ""
    if checking.memory.find(text, program.directory) is not None:
        return f"program {text} is not a {'sub-program' if step.word == 'CALL' else 'main program'}"
    return f"program {text} not found"


def _pattern(checking: _Check, program: Program, text: str) -> str:
    """What is wrong with the name of a pattern; the pattern itself is checked once, however many steps name it."""
    found = checking.memory.find(text, program.directory, TARGETS["PALLET"])
    if found is None and checking.memory.find(text, program.directory) is None:
        return f"pallet program {text} not found"
    if found is None:
        return f"program {text} is not a pallet program"
    if found.kind == "PAL" or _has_vectors(checking, found):
        checking.patterns[found.file] = found
        return ""
    return f"program {text} is not a pallet program"


def _has_vectors(checking: _Check, program: Program) -> bool:
    """Whether a main program may be meant as a pattern: it defines vectors, as many as a pattern or one fewer."""
    names = [step.slots.get("name") for step in program.steps if step.word in DEFINITIONS]
    return sum(isinstance(name, Ref) and checking.memory.kind_of(name.name) == "V" for name in names) >= 2


def _format(checking: _Check, pattern: Program) -> None:
    """One fault for what a pattern program does not keep to; those that its steps have already keep it from running."""
    try:
        pattern_of(pattern, checking.memory.kind_of)
    except PatternFault as fault:
        checking.late(pattern, fault.step, "rsv.pallet", f"pallet program {pattern.name}: syntax error: {fault.mistake}")
    except StepFault:
        return


def _meant(checking: _Check, ref: Ref) -> list[Variable]:
    """Variables of this name."""
    if ref.name.startswith("_"):
        return [checking.system[ref.name]] if ref.name in checking.system else []
    return checking.known.get(ref.name, [])


def _reference(checking: _Check, ref: Ref, written: bool) -> str:
    """A fault that is certain whatever program calls this one; "" for none."""
    found = _meant(checking, ref)
    if not found:
        return "" if ref.name == DEFAULT_TOOL else NOT_FOUND
    if len(found) > 1:
        return ""
    variable = found[0]
    if ref.index is None and isinstance(variable, Array):
        return IS_ARRAY
    if ref.index is not None and not isinstance(variable, Array):
        return NO_ARRAY
    if isinstance(variable, Array):
        return _element_of(checking, ref, variable, written)
    if ref.element and not (isinstance(variable, Structure) and ref.element in variable.parts):
        return WRONG_TYPES
    if written and variable.constant:
        return NO_VARIABLE
    return NO_WRITING if written and _read_only(variable) else ""


def _whole_array(found: list[Variable], ref: Ref, wrong: str) -> str:
    """Return the fault of an array for MAUS_KALIB, which accepts a complete one (L3104)."""
    if len(found) != 1 or not isinstance(found[0], Array) or ref.index is not None:
        return NO_ARRAY if len(found) == 1 else wrong
    return ""


def _elements(checking: _Check, ref: Ref, wrong: str) -> str:
    """The elements an array or a structure has, where one of them is needed; "" for other faults."""
    found = _meant(checking, ref)
    if wrong == WRONG_TYPES and len(found) == 1 and isinstance(found[0], Structure) and ref.element not in found[0].parts:
        return f"elements: {' '.join(PARTS[found[0].kind])}"
    if wrong not in (IS_ARRAY, INDEX_RANGE) or len(found) != 1 or not isinstance(found[0], Array):
        return ""
    return f"{ref.name}[1] .. {ref.name}[{len(found[0].items)}]"


def _element_of(checking: _Check, ref: Ref, array: Array, written: bool) -> str:
    """A fault of an array's element: its index, an element of an element (L3973), a value the control keeps."""
    if isinstance(ref.index, int):
        if not 1 <= ref.index <= len(array.items):
            return INDEX_RANGE
    elif ref.index is not None and ref.index not in checking.intended and (wrong := _index(_meant(checking, Ref(ref.index)))):
        return wrong
    if ref.element:
        return WRONG_TYPES
    return NO_WRITING if written and _read_only(array.items[0]) else ""


def _index(found: list[Variable]) -> str:
    """Return the fault of the variable that holds an index."""
    if not found:
        return INDEX_NOT_FOUND
    if len(found) > 1:
        return ""
    if isinstance(found[0], Array):
        return IS_ARRAY
    return "" if getattr(found[0], "kind", "I") == "I" else WRONG_TYPES


def _read_only(variable: Variable) -> bool:
    return variable.put is None if isinstance(variable, SystemCell) else isinstance(variable, Structure) and not variable.writable


def _types_differ(memory: Memory, step: Step) -> bool:
    """Structures go only to their own type, numbers and texts to neither of them."""
    one, other = _kind(memory, step.slots["source"]), _kind(memory, step.slots["destination"])
    if not one or not other:
        return False
    return one != other and not {one, other} <= {"R"}


def _groups_differ(memory: Memory, step: Step) -> bool:
    """Elements of vectors and positions are copied inside their group alone (L4109-4146)."""
    source, destination = step.slots["source"], step.slots["destination"]
    if not isinstance(source, Ref) or not isinstance(destination, Ref) or not source.element or not destination.element:
        return False
    one, other = (memory.kind_of(ref.name.lstrip("_") or "?") for ref in (source, destination))
    if one == other or not {one, other} <= {"P", "V", "T"}:
        return False
    return "T" in (one, other) or not of_one_group(source.element, destination.element)


def _kind(memory: Memory, operand: Operand) -> str:
    """The type of an operand: I and R count as R; "" where it is not known."""
    if isinstance(operand, Text):
        return "S"
    if isinstance(operand, Number):
        return "R"
    if isinstance(operand, Ref):
        if operand.element:
            return "R"
        kind = memory.kind_of(operand.name.lstrip("_") or "?")
        return "R" if kind in ("I", "R") else kind if not operand.name.startswith("_") else ""
    return ""
