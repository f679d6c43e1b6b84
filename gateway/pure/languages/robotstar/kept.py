"""Values of variables as text: what outlives power-off, one value a line, `NAME = value`.  Source: robotstar 2.3, L3115-3119."""

import json
import re
from collections.abc import Iterable, Mapping

from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.values import Array, Cell, Structure, Variable, flat

_LINE = re.compile(r"([A-Z_][A-Z0-9_ÄÖÜ]*)(?:\[(\d{1,6})\])?(?:\.([A-Za-z0-9]+))?", re.IGNORECASE)


def written(variables: Mapping[str, Variable]) -> str:
    """Return the text without constants and variables never written."""
    lines = []
    for name, variable in sorted(variables.items()):
        if not _constant(variable):
            lines += [f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in flat(name, variable) if value is not None]
    return "\n".join(lines) + "\n" if lines else ""


def _constant(variable: Variable) -> bool:
    return not isinstance(variable, Array) and variable.constant


def restore(text: str, variables: Mapping[str, Variable]) -> list[str]:
    """Gives variables their values; lines that fit none of them come back."""
    return [line for line in text.splitlines() if line.strip() and not _taken(line, variables)]


def _taken(line: str, variables: Mapping[str, Variable]) -> bool:
    key, _, value = line.partition(" = ")
    found = _LINE.fullmatch(key.strip())
    if found is None:
        return False
    variable = variables.get(found[1].upper())
    try:
        given = json.loads(value)
        if isinstance(given, bool) or not isinstance(given, int | float | str):
            return False
        if isinstance(variable, Array) and found[2]:
            variable = variable.at(int(found[2]))
        elif found[2]:
            return False
        if isinstance(variable, Cell) and not found[3]:
            if not variable.constant:
                variable.write(given)
            return True
        if isinstance(variable, Structure) and found[3] and found[3].upper() in variable.parts and not isinstance(given, str):
            if not variable.constant:
                variable.put(found[3].upper(), given)
            return True
    except (ValueError, StepFault):
        return False
    return False


def system_values(names: Mapping[str, Variable], kept: Iterable[str]) -> dict[str, Variable]:
    """Plain copies of system variables, to be written."""
    found: dict[str, Variable] = {}
    for name in kept:
        cell = names.get(name)
        if isinstance(cell, Cell):
            found[name] = Cell(cell.kind, cell.read(), length=cell.length)
    return found
