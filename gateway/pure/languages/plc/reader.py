"""Reads the steps of a program: head, commands, end.  Source: robotstar 1.2, 5.3, L1480-1482, L2332-2335."""

import re
from dataclasses import dataclass

from gateway.pure.languages.base.faults import Faults, also_at, hints
from gateway.pure.languages.base.near import nearest
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.plc.commands import Code, Command, Routine
from gateway.pure.languages.plc.slips import meant, of_step5
from gateway.pure.languages.plc.steps import Wrong, step_of

OPENED = re.compile(r"(?:U|O|XO)N? ?\([^)]*$", re.IGNORECASE)
LABEL = re.compile(r"M\s+([^;,'\"]+)[;,]", re.IGNORECASE)
NUMBERED = re.compile(r"\s*(?:S?\d+(?:\s*[.:])?\s+)?")
HEAD = re.compile(r"(MPR|MP|SPR|MAC|PAL|PLC|DIR)\b\s*(.*)$", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Line:
    """A line that holds a step: number of the line in the file, number of the step, text, whether it is valid."""

    line: int
    step: int
    text: str
    valid: bool


def lines_of(text: str) -> list[Line]:
    """The steps of a text.  The head is step 1; a printed step number is left out, `\\` makes a step invalid."""
    found: list[Line] = []
    for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), 1):
        body = line[match.end() :].strip() if (match := NUMBERED.match(line)) else line.strip()
        valid = not body.startswith("\\")
        if body.lstrip("\\"):
            found.append(Line(number, len(found) + 1, body.lstrip("\\").strip(), valid))
    return found


def body_of(lines: list[Line], name: str, faults: Faults) -> tuple[list[Line], Line | None]:
    """The steps between head and end, and the end."""
    if lines and (head := HEAD.match(lines[0].text)):
        own = name.rpartition("/")[2]
        if head[1].upper() != "PLC":
            faults.error("no-plc-command", Position(name, lines[0].line), "No PLC-command", "a PLC program begins with PLC and its name")
        elif (named := _named(head[2])).rpartition("/")[2].upper() != own.upper():
            text = f"the head names {named or 'nothing'}, the file {own}"
            faults.error("head", Position(name, lines[0].line), text, f"step 1 is PLC {own}")
        lines = lines[1:]
    for at, line in enumerate(lines):
        if line.text.split(";")[0].strip().upper() in ("END", "ENDE"):
            if rest := lines[at + 1 :]:
                hint = hints("END is the last step", also_at(each.step for each in rest[1:]))
                faults.error("after-end", Position(name, rest[0].line), f"{rest[0].text[:60]!r} after END", hint)
            return lines[:at], line
    last = lines[-1].line if lines else 1
    faults.error("no-end", Position(name, last), "END is missing", "END is the last step of a program")
    misspelt = bool(lines) and bool(nearest(lines[-1].text, ("END", "ENDE")) or of_step5(lines[-1].text) == "END")
    return lines[:-1] if misspelt else lines, None


def _named(text: str) -> str:
    """The name in a head: without quotation marks (L2332) and comment."""
    return text.split(";", maxsplit=1)[0].strip().strip("'\"").strip().replace("\\", "/")


def read_routine(name: str, text: str, faults: Faults) -> tuple[Routine, dict[int, int]]:
    """The routine, and the line of each step in the file; faults name the line."""
    lines = lines_of(text)
    commands: list[Command] = []
    body, end = body_of(lines, name, faults)
    for line in body:
        if not line.valid:
            continue
        found = step_of(line.text, line.step)
        if isinstance(found, Wrong):
            kind = "no-plc-command" if found.text == "No PLC-command" else "operand"
            faults.error(kind, Position(name, line.line), found.text, _hint(line.text) or found.hint)
            commands += _intended(line)
        elif found is not None:
            commands.append(found)
    last = end.step if end else len(lines) + 1
    return Routine(name, tuple(commands), last), {line.step: line.line for line in lines}


def _hint(text: str) -> str:
    """What a faulty step was meant to be; "" where nothing fits."""
    if step := of_step5(text):
        return f"a statement of STEP 5; here it is {step}"
    return f"did you mean {step}?" if (step := meant(text)) else ""


def _intended(line: Line) -> list[Command]:
    """Return the bracket or label of a faulty step, so that the bracket's end and jumps to the label are not reported as well."""
    if OPENED.match(line.text):
        return [Command(Code.OPEN_AND, line.step), Command(Code.AND, line.step)]
    label = LABEL.match(line.text)
    return [Command(Code.LABEL, line.step, name=label[1].strip().upper())] if label else []
