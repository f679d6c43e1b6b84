"""Reads one program of the memory: a step a line, `[number] [\\]WORD parameters`, as the control prints it.  Never an exception.

All faults of the text are collected; a step that cannot be read keeps its number, so that the steps after it keep their numbers.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from gateway.pure.languages.base.faults import Faults, also_at, hints
from gateway.pure.languages.base.near import MOST_HINTS, hint_for_print, hint_with, meant, nearest
from gateway.pure.languages.base.source import SourceFile
from gateway.pure.languages.robotstar.grammar import GRAMMAR, NOT_BUILT, Place, fits, typed
from gateway.pure.languages.robotstar.operands import HIGHEST, Blank, Equate, Number, Operand, OperandFault, Ref, Text, operand
from gateway.pure.languages.robotstar.program import DEFINITIONS, HEADS, Parameter, Program, Step, definition_late
from gateway.pure.languages.robotstar.words import Words

_NUMBERED = re.compile(r"\s*S?\s*\d+\s*[.:)]?\s+(?=\S)", re.IGNORECASE)
_WORD = re.compile(r"(?P<word>[^\W\d][\w$-]*|\d[\w$-]*)\s*(?P<unit>\[[^\]\d]*\])?\s*(?P<rest>.*)", re.DOTALL)
_DESCRIPTOR = re.compile(r"([^\W\d][\w-]*)\s*(?:\[[^\]]*\])?\s*:(?!/)\s*")
_ASSIGNED = re.compile(r"(_[A-Z]\w*(?:\s*\[\w+\])?)\s*=\s*(\S+)", re.IGNORECASE)
_AXIS = re.compile(r"A\d+")
_REMARK = re.compile(r"/\*.*?\*/")
_TOKEN = re.compile(
    r'"[^"]*"?|<(?![=>])[^>]*>|\#(?:<>|<=|>=|=>|=<|<|>|=[01](?![\d.])|=|\w+)?|,|:(?!/)'
    r"|[+-]?\d+(?:\.\d*)?[eE][+-]\d+(?![\w.])|[+-]?\d[\w.]*|(?:[^\s,:\"#\[(]|:/)+(?:\s*\[[^,\"]*\]*)?(?:\s*\([^,\"]*\)?)?(?:\.\w+)?|\S"
)
SETS = {"UEBER_CP": "_IV_FLYBY_S", "ÜBER_CP": "_IV_FLYBY_S"}  # commands of the RSIV that are system variables (L1803)
POSITION_ELEMENTS = ("X", "Y", "Z", "A", "B", "C")


@dataclass(slots=True)
class _Reading:
    words: Words
    source: SourceFile
    faults: Faults
    program: Program
    # What was read before, by its text: lines and their parts repeat in a program, and the objects made of them are never changed.
    steps: dict[str, Step] = field(default_factory=dict)  # without a fault
    parameters: dict[tuple[str, str, int], Parameter] = field(default_factory=dict)
    descriptors: dict[str, str] = field(default_factory=dict)

    def descriptor(self, text: str) -> str:
        """The descriptor a text is; "" for none."""
        found = self.descriptors.get(text)
        if found is None:
            found = self.descriptors[text] = self.words.descriptor(text)
        return found

    def parameter(self, text: str, descriptor: str, column: int) -> Parameter:
        """One parameter; OperandFault with a sentence."""
        key = text, descriptor, column
        found = self.parameters.get(key)
        if found is None:
            found = self.parameters[key] = Parameter(operand(text, self.words.equates), descriptor, column, text)
        return found

    def fault(self, id: str, line: int, text: str, hint: str = "", step: int = 0) -> None:
        """A fault of one line; the program does not run.  `step`: put in front where a START shows the manual's text alone."""
        self.faults.error(id, self.source.at(line), f"step {step}: {text}" if step else text, hint)
        self.program.refused.append((line, text))


def read_program(source: SourceFile, name: str, kind: str, words: Words, faults: Faults, directory: str = "") -> Program:
    """Reads a program; its name and kind are the file's."""
    program = Program(name, kind, directory=directory, file=source.name)
    reading = _Reading(words, source, faults, program)
    number = 0
    for line, text in enumerate(source.text.splitlines(), 1):
        text = text.replace("\ufeff", "").strip("\0")  # a block of the disk is filled up with zeros
        text = (_REMARK.sub("", text) if "/*" in text else text).strip()
        if text:
            number += 1
            program.steps.append(_step(reading, number, line, text))
    _frame(reading)
    return program


def _step(reading: _Reading, number: int, line: int, text: str) -> Step:
    text = unnumbered(text)
    known = reading.steps.get(text)
    if known is not None:
        return Step(number, known.word, known.parameters, line, text=known.text, slots=known.slots)
    step = _read_step(reading, number, line, text)
    if step.valid and not step.macro and step.word not in NOT_BUILT:
        reading.steps[text] = step
    return step


def _read_step(reading: _Reading, number: int, line: int, text: str) -> Step:
    valid = not text.startswith("\\")
    text = text.lstrip("\\").strip()
    assigned = _ASSIGNED.fullmatch(text)
    if assigned:
        text = f"COPY {assigned[2]}, {assigned[1]}"
    found = _WORD.match(text)
    if found and (variable := SETS.get(found[1].upper())):
        text = f"COPY {found['rest'].lstrip(': ')}, {variable}"
        found = _WORD.match(text)
    if not found:
        reading.fault("rsv.step", line, f"step {number}: {text[:40]!r} does not begin with a command")
        return Step(number, "", line=line, valid=False, text=text)
    spelling, unit, rest = found.groups()
    spelling = spelling.upper()
    if unit and unit[1:-1].strip().lower() not in reading.words.units:
        rest = unit + rest
    word, rest = _command(reading.words.words, spelling, rest)
    step = Step(number, word or spelling, line=line, valid=valid, macro=not word, text=text)
    if word == "C":
        return step
    return _with_parameters(reading, step, rest[1:] if rest.startswith(":") else rest)


def _command(words: Mapping[str, str], spelling: str, rest: str) -> tuple[str, str]:
    """Return the command and the text after it; "" where there is none.  Some are printed in two words, BAHN RADIUS (L1774), and PALLET as
    PAL (L4532).
    """
    word = words.get(spelling, "")
    if word == "PAL" and "#" in rest:
        return "PALLET", rest
    if not word and (second := re.match(r"[^\W\d]\w*", rest)):
        word = words.get(f"{spelling}_{second[0].upper()}", "")
        rest = rest[second.end() :].strip() if word else rest
        if word and (unit := re.match(r"\[[^\]\d]*\]\s*", rest)):
            rest = rest[unit.end() :]
    return word, rest


def unnumbered(text: str) -> str:
    """Without the step number, the cursor marks and the table bars of a print."""
    text = text.lstrip("->").strip() if text.startswith(("->", "- ")) else text.strip()
    found = _NUMBERED.match(text)
    return text[found.end() :].strip() if found else text


def _with_parameters(reading: _Reading, step: Step, rest: str) -> Step:
    if step.word in HEADS and not step.macro:
        return replace(step, slots={"name": Text(_head_name(rest))})
    if step.word == "LABEL" and rest.strip() and '"' not in rest and not _DESCRIPTOR.match(rest.strip()):
        return replace(step, slots={"label": Text(rest.strip().upper())})
    if step.word in NOT_BUILT:
        if step.valid:
            reading.fault(
                "rsv.not_built", step.line, f"step {step.number}: {NOT_BUILT[step.word]}", "mark the step invalid with a backslash"
            )
        return step
    try:
        parameters = _parameters(rest, reading)
    except OperandFault as fault:
        if step.valid:
            reading.fault("rsv.operand", step.line, str(fault), fault.hint, step=step.number)
        return replace(step, word="" if step.valid else step.word, valid=False, slots={})
    if not step.valid or step.macro:
        return step.given(parameters, step.slots)
    if step.word == "POSITION":
        return _position(reading, step, parameters)
    return _placed(reading, step, parameters, GRAMMAR[step.word])


def _head_name(rest: str) -> str:
    """The name in a head: in quotes of either kind, or the rest of the line."""
    rest = rest.strip()
    quoted = re.match(r"[\"']([^\"']*)[\"']|(?:name|Name)\s*:\s*\"?([^\"]*)\"?", rest)
    return (quoted[1] or quoted[2] or "").strip() if quoted else rest


def _parameters(rest: str, reading: _Reading) -> tuple[Parameter, ...]:
    """Parameters in their order: separated by commas, or by spaces where none is missing."""
    parameters: list[Parameter] = []
    descriptor, expected, at = "", False, 0
    tokens = [(found.group(), found.start() + 1) for found in _TOKEN.finditer(rest)]
    while at < len(tokens):
        text, column = tokens[at]
        at += 1
        if text == ",":
            if not expected:
                raise OperandFault("a parameter is missing in front of a comma")
            expected = False
            continue
        following = tokens[at][0] if at < len(tokens) else ""
        known = reading.descriptor(text)
        if at + 1 < len(tokens) and tokens[at + 1][0] == ":" and reading.descriptor(f"{text}_{following}"):
            text, at = f"{text}_{following}", at + 1  # `Control word:`, printed in two words (L3251)
            known, following = reading.descriptor(text), ":"
        if following == ":" and not text.startswith(('"', "#")):
            if not known:
                near = meant(text, reading.words.descriptors)
                raise OperandFault(f"{text}: no such descriptor", hint_with([each.title() for each in near]))
            descriptor, at = known, at + 1
            continue
        if known.startswith("OP_") and following and following != ",":
            descriptor = known  # the colon is missing in the print (L754)
            continue
        if text == ":":
            raise OperandFault("a colon without a descriptor in front of it")
        parameters.append(reading.parameter(text, descriptor, column))
        descriptor, expected = "", True
    if descriptor:
        raise OperandFault(f"{descriptor}: a value is missing after the colon")
    if tokens and tokens[-1][0] == ",":
        raise OperandFault("a parameter is missing after the last comma")
    return tuple(parameters)


def _placed(reading: _Reading, step: Step, parameters: tuple[Parameter, ...], places: tuple[Place, ...]) -> Step:
    """Each parameter in its place: by its descriptor, an equate by its value, the rest in order."""
    slots: dict[str, Operand] = {}
    for parameter in parameters:
        place, given = _place_of(parameter, places, slots, step.word), parameter.operand
        if place is None:
            if step.word in DEFINITIONS and "name" in slots:
                slots[parameter.descriptor or f"V{len(slots)}"] = given  # values of a structure, by element
                continue
            return _wrong(reading, step, *_without_place(reading, step, parameter, places, slots))
        if place.kind == "text" and isinstance(given, Number):
            given = Text(parameter.text)  # a name of digits, or one that looks hexadecimal: 0815, FACH
        hint = _lost_hash(reading, given, places)
        if wrong := fits(place, given):
            return _wrong(reading, step, f"{place.name} must be {wrong}", hint)
        if wrong := typed(place, given):
            return _wrong(reading, step, wrong, hint, id="rsv.range")
        slots[place.name] = given
    missing = [place.name for place in places if not place.optional and place.name not in slots]
    if missing:
        return _wrong(reading, step, f"{', '.join(missing)} missing")
    return step.given(parameters, slots)


def _lost_hash(reading: _Reading, given: Operand, places: tuple[Place, ...]) -> str:
    """The hint for a system equate without its #; "" for other operands."""
    name = given.name if isinstance(given, Ref) and not given.element else ""
    wanted = [place for place in places if place.kind == "equate" and reading.words.equates.get(name) in place.equates]
    return f"did you mean #{name}?" if wanted else ""


def _wrong(reading: _Reading, step: Step, text: str, hint: str = "", id: str = "rsv.parameters") -> Step:
    """The step with wrong parameters, reported."""
    reading.fault(id, step.line, f"step {step.number}: {spelled(step, reading.words)}: {text}", hint)
    return replace(step, valid=False, word="")


def _without_place(
    reading: _Reading, step: Step, parameter: Parameter, places: tuple[Place, ...], slots: Mapping[str, Operand]
) -> tuple[str, str]:
    """What is wrong with a parameter that has no place, and the remedy."""
    if parameter.descriptor and not any(parameter.descriptor in place.descriptors for place in places):
        return f"{parameter.descriptor} does not belong to this command", ""
    for place in places:
        if place.kind == "equate" and place.name not in slots:  # `BEWEG_ART LINEAR`
            return f"{place.name} must be {fits(place, parameter.operand)}", _lost_hash(reading, parameter.operand, places)
    return "there are too many parameters", "numbers have a decimal point" if re.search(r"\d,\d", step.text) else ""


def spelled(step: Step, words: Words) -> str:
    """The command of a step as it is written there."""
    found = _WORD.match(step.text)
    written = found["word"].upper() if found else ""
    return written if words.words.get(written) == step.word else step.word


def _place_of(parameter: Parameter, places: tuple[Place, ...], slots: Mapping[str, Operand], word: str) -> Place | None:
    if parameter.descriptor:
        return _place_named(parameter.descriptor, places, slots)
    equate = isinstance(parameter.operand, Equate)
    if word in DEFINITIONS and isinstance(parameter.operand, Ref) and slots:
        return None
    for place in places:
        if (place.kind == "equate") is equate and place.name not in slots:
            return place
    return None


def _place_named(descriptor: str, places: tuple[Place, ...], slots: Mapping[str, Operand]) -> Place | None:
    """The free place with this descriptor: rather the one that has it first."""
    other: Place | None = None
    for place in places:
        if descriptor in place.descriptors and place.name not in slots:
            if descriptor == place.descriptors[0]:
                return place
            other = other or place
    return other


def _position(reading: _Reading, step: Step, parameters: tuple[Parameter, ...]) -> Step:
    """POSITION #N, X:.., Y:.., ..: the six values, or those of the axes; or the name of a position variable."""
    slots: dict[str, Operand] = {}
    plain = list(POSITION_ELEMENTS)
    for parameter in parameters:
        name = parameter.descriptor
        if isinstance(parameter.operand, Equate) and parameter.operand.name in ("N", "P"):
            name = "kind"
        elif isinstance(parameter.operand, Ref | Text | Blank) and name in ("", "NAME", "VARIABLE"):
            name = "variable" if isinstance(parameter.operand, Ref) else "name"
        elif not name:
            name = plain.pop(0) if plain else "?"
        if wrong := _misfit(name, parameter, slots):
            return _wrong(reading, step, wrong, id="rsv.position")
        slots[name] = parameter.operand
    if wrong := _lacking(slots):
        return _wrong(reading, step, wrong, "robotstar import --points fills in named positions", "rsv.position")
    return step.given(parameters, slots)


def _misfit(name: str, parameter: Parameter, slots: Mapping[str, Operand]) -> str:
    """Return why a position does not accept a value; "" where it does."""
    if name in slots:
        return f"{name} is given twice" if name not in ("kind", "variable", "name") else f"{parameter.text} does not belong here"
    if name in ("kind", "variable", "name"):
        return ""
    given = parameter.operand
    if not (name in ("MA", "AA", "PT", "FRAME", *POSITION_ELEMENTS) or _AXIS.fullmatch(name)):
        return f"{parameter.text} does not belong here"
    if not isinstance(given, Number):
        return f"{name} must be a number, not {parameter.text}"
    if name == "FRAME" and not (isinstance(given.value, int) and 0 <= given.value <= HIGHEST):
        return f"Frame {given.value:g} is not the number of a station: a whole number from 0 on"
    return ""


def _lacking(slots: Mapping[str, Operand]) -> str:
    cartesian = [name for name in POSITION_ELEMENTS if name in slots]
    if cartesian:
        missing = [name for name in POSITION_ELEMENTS if name not in slots]
        return f"{', '.join(missing)} missing" if missing else ""
    if any(_AXIS.fullmatch(name) for name in slots) or ("variable" in slots and isinstance(slots["variable"], Ref)):
        return ""
    return "it has no values"


def _frame(reading: _Reading) -> None:
    """Head, END, labels, place of the definitions."""
    program = reading.program
    if not program.steps:
        reading.fault("rsv.empty", 1, "the program is empty; it needs a head and END")
        return
    head, last = program.steps[0], program.steps[-1]
    if head.word not in HEADS or head.macro or not head.valid:
        reading.fault("rsv.head", head.line, f"the first step is the head of the program: {program.kind} and the name", step=1)
        _misspelt(reading, head, HEADS)
    else:
        _head(reading, head)
    ends = [step for step in program.steps[1:-1] if step.valid and not step.macro and step.word == "END"]
    if not ends and (last.word != "END" or last.macro or not last.valid):
        reading.fault("rsv.end", last.line, f"step {last.number}: the last step is END")
        _misspelt(reading, last, ("END", "ENDE"))
    for step in program.steps[1:-1]:
        if step.valid and not step.macro and (step.word in HEADS or step.word == "END"):
            reading.fault(
                "rsv.order",
                step.line,
                f"step {step.number}: {step.word} is allowed only at the {'end' if step.word == 'END' else 'beginning'}",
            )
    _labels(reading)
    if program.kind != "PAL":
        _definitions_first(reading)


def _misspelt(reading: _Reading, step: Step, words: Iterable[str]) -> None:
    """Do not report a misspelt word of the frame a second time as an unknown command."""
    if step.macro and nearest(step.word, words):
        reading.faults.spoilt(reading.source.at(step.line))


def _head(reading: _Reading, head: Step) -> None:
    program = reading.program
    name = head.slots.get("name")
    if (
        head.word != program.kind
        and not (head.word == "PAL" and program.kind == "MPR")
        and not (head.word == "MPR" and program.kind == "PAL")
    ):
        reading.fault("rsv.head", head.line, f"the head names {head.word}, the file {program.kind}", step=1)
    if isinstance(name, Text) and name.value.split("(")[0].strip().upper() != program.name.upper():
        reading.fault("rsv.head", head.line, f"the head names {name.value or 'nothing'}, the file {program.name}", step=1)


def _labels(reading: _Reading) -> None:
    program = reading.program
    for step in program.steps:
        if step.word == "LABEL" and step.valid and not step.macro:
            name = label_of(step)
            if name in program.labels:
                reading.fault("rsv.label_twice", step.line, f"step {step.number}: label {name} is at step {program.labels[name]}, too")
            else:
                program.labels[name] = step.number
    lost: dict[str, list[Step]] = {}
    for step in program.steps:
        needed = needed_label(step)
        if needed == NO_LABEL:
            reading.fault("rsv.parameters", step.line, f"step {step.number}: {spelled(step, reading.words)}: label missing")
        elif needed and needed not in program.labels:
            lost.setdefault(needed, []).append(step)
    for place, (name, steps) in enumerate(lost.items()):
        near = hint_for_print(name, [*program.labels]) if place < MOST_HINTS else ""
        hint = hints(near, also_at(step.number for step in steps[1:]))
        reading.fault("rsv.label_lost", steps[0].line, f"step {steps[0].number}: label {name} is not in this program", hint)


NO_LABEL = "(none)"  # of a WAIT_BIT with a time, which branches when it is over


def label_of(step: Step) -> str:
    """The name of a label in a step, upper case; "" for none."""
    found = step.slots.get("label")
    if isinstance(found, Text):
        return found.value.strip().upper()
    return found.name if isinstance(found, Ref) else ""


def needed_label(step: Step) -> str:
    """The label a step may branch to.  WAIT_BIT without a time never does (L543)."""
    if not step.valid or step.macro or step.word not in ("BRANCH", "TEST", "TEST_BIT", "WAIT_BIT"):
        return ""
    time = step.slots.get("time")
    if step.word == "WAIT_BIT" and (time is None or getattr(time, "value", 1) == 0):
        return ""
    return label_of(step) or NO_LABEL


def _definitions_first(reading: _Reading) -> None:
    """Check that definitions precede all other steps but comments (L803); a pallet pattern may end with constants (L4582)."""
    began: Step | None = None
    late: list[Step] = []
    pattern = _looks_like_pattern(reading.program)
    for step in reading.program.steps[1:]:
        if not step.valid or step.word in ("C", "END"):
            continue
        if step.macro:
            continue  # the checker knows whether it is a macro or a misspelt definition
        if step.word not in DEFINITIONS:
            began = began or step
        elif began is not None and not (pattern and step.word in ("LOC_CONST", "CONST")):
            late.append(step)
    if began is not None and late:
        text = f"step {late[0].number}: {definition_late(began.number)}"
        reading.fault("rsv.definition_late", late[0].line, text, also_at(step.number for step in late[1:]))


def _looks_like_pattern(program: Program) -> bool:
    """The steps of a pallet pattern and no others."""
    words = [step.word for step in program.steps[1:-1] if step.valid and step.word != "C"]
    rest = [word for word in words if word not in DEFINITIONS]
    return len(rest) == 5 and rest[0] == "TOOL" and all(word in ("POSITION", "VAR_POS") for word in rest[1:])
