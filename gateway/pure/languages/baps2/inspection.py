"""Position and variables of a process: its routines, the innermost first, with names of the program instead of those of its translation."""

import bisect
import re
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from types import GeneratorType

from gateway.pure.languages.baps2.tasks import Task
from gateway.pure.languages.baps2.translation import LINE, Unit
from gateway.pure.languages.baps2.values import Ref

_VARIABLE = re.compile(r"v(\d+)_(.+)")
_SIGN = re.compile(r"_([0-9a-f]+)_")
UnitOf = Callable[[str], Unit | None]


@dataclass(frozen=True, slots=True)
class Frame:
    """One routine of a process, the innermost first."""

    routine: str
    program: str
    line: int
    own: dict[str, object]  # its parameters and variables
    program_wide: dict[str, object]  # variables of the program that it uses


def frames_of(task: Task | None, unit_of: UnitOf) -> list[Frame]:
    """The calls of a process, the innermost first; none where it is gone."""
    found: list[Frame] = []
    for body in _chain(task.process.body if task is not None else None):
        unit = unit_of(body.gi_code.co_filename[1:-1])
        if unit is not None and body.gi_frame is not None and body.gi_code.co_filename == f"<{unit.name}>":
            line = _line(unit.text, body.gi_frame.f_lineno)
            own, wide = _variables(body.gi_frame.f_locals)
            found.append(Frame(_routine(body.gi_code.co_name, unit.name), unit.name, line, own, wide))
    found.reverse()
    if found and task is not None:
        found[0] = Frame(found[0].routine, found[0].program, task.process.line, found[0].own, found[0].program_wide)
    return found


def lines_of(unit: Unit | None) -> list[int]:
    """Return the lines with a statement; none for an unknown program or one with errors."""
    return sorted({int(found[2]) for found in LINE.finditer(unit.text)}) if unit is not None else []


def _chain(body: Generator[object, object, object] | None) -> "Iterator[GeneratorType[object, object, object]]":
    """Generators a process is in, the outermost first."""
    while isinstance(body, GeneratorType):
        yield body
        body = body.gi_yieldfrom if isinstance(body.gi_yieldfrom, GeneratorType) else None


def _line(text: str, row: int) -> int:
    """Line of the program that a row of its translation belongs to."""
    rows = [(text.count("\n", 0, found.start()) + 1, int(found[2])) for found in LINE.finditer(text)]
    at = bisect.bisect_right(rows, (row, 1 << 30)) - 1
    return rows[at][1] if at >= 0 else 1


def _routine(name: str, program: str) -> str:
    """Its name in the program."""
    return program if name == "main" else plain_name(name.removeprefix("s_")) if name.startswith("s_") else f"branch of {program}"


def plain_name(python: str) -> str:
    """Return the name in the program for one of its translation."""
    found = _VARIABLE.fullmatch(python)
    return _SIGN.sub(_sign, found[2]) if found is not None else python


def _sign(found: re.Match[str]) -> str:
    """What python_name replaced: @ and letters beyond ASCII."""
    number = int(found[1], 16)
    return chr(number) if number == ord("@") or 0x80 <= number <= 0x10FFFF else found[0]


def _variables(space: dict[str, object]) -> tuple[dict[str, object], dict[str, object]]:
    own: dict[str, object] = {}
    wide: dict[str, object] = {}
    for name, value in sorted(space.items()):
        if (found := _VARIABLE.fullmatch(name)) is not None:
            (wide if found[1] == "0" else own)[plain_name(name)] = value.get() if isinstance(value, Ref) else value
    return own, wide
