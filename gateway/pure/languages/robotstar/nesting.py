"""Calls of sub-programs and macros that certainly nest too deep: nothing before them branches.  Source: robotstar 1.1, L213, L223."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from gateway.pure.languages.robotstar.machine import DEEPEST
from gateway.pure.languages.robotstar.memory import Memory
from gateway.pure.languages.robotstar.operands import Ref, Text
from gateway.pure.languages.robotstar.program import Program, Step
from gateway.pure.languages.robotstar.reader import needed_label

LEAVES = ("PROGRAM", "STOP", "END")
TOO_DEEP = f"nesting depth too big: more than {DEEPEST} calls"


@dataclass(frozen=True, slots=True)
class Deep:
    """A call that the control refuses, and the program that calls itself there; "": none does."""

    program: Program
    step: Step
    again: str = ""


@dataclass(slots=True)
class _Walk:
    """From all main programs along the calls; each program once for each greater depth."""

    memory: Memory
    deepest: dict[str, int] = field(default_factory=dict)
    found: dict[tuple[str, int], Deep] = field(default_factory=dict)

    def visit(self, program: Program, path: tuple[str, ...]) -> None:
        if self.deepest.get(program.file, -1) >= len(path):
            return
        self.deepest[program.file] = len(path)
        path = (*path, program.file)
        for step, called in _calls(self.memory, program):
            if called.file in path:
                self.found.setdefault((program.file, step.line), Deep(program, step, called.name))
            elif len(path) > DEEPEST:
                self.found.setdefault((program.file, step.line), Deep(program, step))
            else:
                self.visit(called, path)


def too_deep(memory: Memory) -> list[Deep]:
    """All calls that nest too deep, in the order of the programs."""
    walk = _Walk(memory)
    for program in memory.all():
        if program.kind == "MPR":
            walk.visit(program, ())
    return [*walk.found.values()]


def _calls(memory: Memory, program: Program) -> Iterator[tuple[Step, Program]]:
    """The calls up to the first step that may lead elsewhere."""
    for step in program.steps[1:]:
        if not step.valid:
            continue
        if not step.macro and (step.word in LEAVES or needed_label(step)):
            return
        name = step.word if step.macro else _name(step)
        called = memory.find(name, program.directory, ("MAC",) if step.macro else ("SPR",)) if name else None
        if called is not None:
            yield step, called


def _name(step: Step) -> str:
    """The program that a CALL names; "" for other steps, and for one in a string variable."""
    operand = step.slots.get("program") if step.word == "CALL" else None
    if isinstance(operand, Text):
        return operand.value
    return operand.name if isinstance(operand, Ref) and operand.name[0] not in "S_" else ""
