"""PALLET: pattern programs, offsets, counters.  Source: robotstar 7 (L4242-4649), doubts D-30..D-32.

#ON computes the offset from the present counters, then counts (the first direction fastest).  A direction of no part or one counts
as one and has no delta; after the last part the slowest counter continues.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from gateway.pure.languages.robotstar.access import structure, text
from gateway.pure.languages.robotstar.control_steps import equate_of
from gateway.pure.languages.robotstar.faults import UNSET, WRONG_TYPES, StepFault
from gateway.pure.languages.robotstar.machine import Machine, Op
from gateway.pure.languages.robotstar.motion_steps import shift_of, target_from, target_of, write_position
from gateway.pure.languages.robotstar.operands import Number, Operand, Ref
from gateway.pure.languages.robotstar.path import CARTESIAN, Target
from gateway.pure.languages.robotstar.program import DEFINITIONS, Program, Step
from gateway.pure.languages.robotstar.values import Cell, Names, Structure

VectorXyz = tuple[float, float, float]
RECTANGULAR, DISTANCES = 1, 2  # bits of the control constant (L4530-4546)


@dataclass(frozen=True, slots=True)
class Pattern:
    """The names of a pattern program in their order."""

    program: Program
    counters: tuple[str, ...]  # total, actual values 1..3
    vectors: tuple[str, ...]
    parts: tuple[str, ...]
    positions: tuple[Step, ...]
    control: str = ""
    distances: tuple[str, ...] = ()


def pallet(machine: Machine, step: Step, following: int) -> Op:
    """PALLET <pattern>, #INIT / #ON / #OFF."""
    name, order = text(machine, step.slots["program"]), equate_of(step, "order")
    acts = {"INIT": _init, "ON": _on, "OFF": _off}

    def op() -> int:
        machine.effects += 1
        assert machine.frame is not None
        found = machine.memory.find(name(), machine.frame.program.directory, ("PAL", "MPR"))
        if found is None:
            raise StepFault(f"pallet program {name()} not found")
        pattern = pattern_of(found, machine.memory.kind_of)
        acts[order](machine, pattern, _names(machine, found))
        return following

    return op


def _names(machine: Machine, program: Program) -> Names:
    return {**machine.names, **machine.memory.locals.get(program.key, {})}


# ---- format ----------------------------------------------------------------------------------------------------------------
FRONT = "IIIIVVVIII"  # total, three actual values, three vectors, three part counts; then none or four positions


class PatternFault(StepFault):
    """A pattern program does not keep to the format.  `step`: the one that holds the mistake, or before which a step is missing."""

    def __init__(self, program: Program, step: Step, text: str) -> None:
        super().__init__(f"pallet program {program.name}: syntax error: step {step.number}: {text}")
        self.step, self.mistake = step, text


def pattern_of(program: Program, kind_of: Callable[[str], str]) -> Pattern:
    """The pattern a program is; PatternFault where it does not keep to the format (L4246-4256, L4526-4602)."""
    if program.refused:
        raise _whole(program, program.refused[0][1])
    steps = [step for step in program.steps[1:] if step.valid and step.word != "C"]
    positions = _places(program, steps)
    front = [step for step in steps if step.word in DEFINITIONS and step.number < positions[0].number]
    behind = [step for step in steps[:-1] if step.word in DEFINITIONS and step.number > positions[-1].number]
    _front(program, front, steps[len(front)], kind_of)
    names = [_name(step) for step in front]
    for step in positions:
        if (name := _position_variable(step)) and name not in names[10:]:
            raise PatternFault(program, step, f"position variable {name} is not one of four that are defined in the pattern itself")
    optional = "".join(kind_of(_name(step)) for step in behind)
    if optional not in ("", "I", "IRRR"):
        text = "the positions must be followed by no constant, one integer, or one integer and three reals"
        raise PatternFault(program, _odd(behind, optional, "IRRR", steps[-1]), text)
    extra = tuple(_name(step) for step in behind)
    return Pattern(program, tuple(names[:4]), tuple(names[4:7]), tuple(names[7:10]), positions, "".join(extra[:1]), extra[1:])


def _places(program: Program, steps: Sequence[Step]) -> tuple[Step, ...]:
    """The four positions, which follow TOOL and each other.  `steps` ends with END."""
    rest = [step for step in steps if step.word not in DEFINITIONS]
    for at, step in enumerate(rest[:-1]):
        if at > 4 or (step.word == "TOOL") != (at == 0):
            raise PatternFault(program, step, "one TOOL and four positions are needed")
        if at and step.word not in ("POSITION", "VAR_POS"):
            raise PatternFault(program, step, "TOOL must be followed by four positions")
    if len(rest) != 6:
        raise PatternFault(program, steps[steps.index(rest[-2]) + 1] if rest[:-1] else rest[-1], "one TOOL and four positions are needed")
    between = [step for step in steps if step.word in DEFINITIONS and rest[0].number < step.number < rest[4].number]
    if between:
        raise PatternFault(program, between[0], "no definition is allowed between the positions")
    return tuple(rest[1:5])


def _front(program: Program, front: Sequence[Step], tool: Step, kind_of: Callable[[str], str]) -> None:
    """Check the definitions before TOOL."""
    kinds = "".join(kind_of(_name(step)) for step in front)
    if kinds not in (FRONT, f"{FRONT}PPPP"):
        text = f"four integers, three vectors, three part counts and no or four position variables are needed, not {kinds}"
        raise PatternFault(program, _odd(front, kinds, f"{FRONT}PPPP", tool), text)
    for step in front[:7]:
        if step.word not in ("VAR", "LOC_VAR"):
            raise PatternFault(program, step, "counters and vectors are variables")


def _odd(steps: Sequence[Step], kinds: str, wanted: str, following: Step) -> Step:
    """The first definition that is not of the kind wanted or is one too many; with one missing, the step that comes in its place."""
    differ = [step for step, kind, right in zip(steps, kinds, wanted, strict=False) if kind != right]
    return differ[0] if differ else steps[len(wanted)] if len(steps) > len(wanted) else following


def _whole(program: Program, text: str) -> StepFault:
    """A fault that no single step holds."""
    return StepFault(f"pallet program {program.name}: syntax error: {text}")


def _position_variable(step: Step) -> str:
    """Return the variable that holds a position of the pattern; "" for programmed values."""
    source = step.slots.get("position" if step.word == "VAR_POS" else "variable")
    return source.name if isinstance(source, Ref) and "X" not in step.slots else ""


def _name(step: Step) -> str:
    name = step.slots.get("name")
    return name.name if isinstance(name, Ref) else ""


# ---- commands --------------------------------------------------------------------------------------------------------------
def _init(machine: Machine, pattern: Pattern, names: Names) -> None:
    """Totals, counters and delta vectors from the positions as they are now."""
    control = _integer(names, pattern.control) if pattern.control else 0
    if control & DISTANCES and not pattern.distances:
        raise _whole(pattern.program, "bit 1 of the control constant needs three distances")
    counts = [_integer(names, name) for name in pattern.parts]
    if any(count < 0 for count in counts):
        raise StepFault(f"pallet program {pattern.program.name}: a part count is below 0")
    corners = [_corner(machine, names, step) for step in pattern.positions]
    if any(not corner.pose for corner in corners) or len({corner.frame for corner in corners}) > 1:
        raise _whole(pattern.program, "its positions are Cartesian and in one frame")
    if control & RECTANGULAR:
        corners = _rectangular(machine, names, pattern, corners)
    total = math.prod(max(count, 1) for count in counts)
    for name, value in zip(pattern.counters, (total, 0, 0, 0), strict=True):
        _cell(names, name).write(value)
    lengths = [_real(names, name) for name in pattern.distances] if control & DISTANCES else []
    for at, (name, count) in enumerate(zip(pattern.vectors, counts, strict=True)):
        _write_delta(names, name, corners[0], corners[at + 1], count, lengths[at] if lengths else None)


def _write_delta(names: Names, name: str, first: Target, corner: Target, count: int, length: float | None) -> None:
    """Set the way from one part to the next; with `length` the corner only defines the direction."""
    vector = names.get(name)
    if not isinstance(vector, Structure):
        raise StepFault(WRONG_TYPES)
    way = [b - a for a, b in zip(first.pose, corner.pose, strict=True)]
    way[3:] = [(angle + 180) % 360 - 180 for angle in way[3:]]
    part = 1 / (count - 1) if count > 1 else 0.0
    if length is not None and count > 1:
        whole = math.hypot(*way[:3])
        part = length / whole if whole else 0.0
        way[3:] = [0.0, 0.0, 0.0]
    vector.check_writable()
    vector.put("FRAME", first.frame)
    for element, value in zip(CARTESIAN, way, strict=True):
        vector.put(element, value * part)


def _on(machine: Machine, pattern: Pattern, names: Names) -> None:
    """Set the offset of the current part; then advance the counters."""
    total, *actual = (_cell(names, name) for name in pattern.counters)
    left = total.read()
    assert isinstance(left, int)
    offset = [0.0] * 6
    for name, cell in zip(pattern.vectors, actual, strict=True):
        vector = names.get(name)
        if not isinstance(vector, Structure) or not vector.valid:
            raise StepFault(UNSET)
        count = cell.read()
        assert isinstance(count, int)
        offset = [value + count * by for value, by in zip(offset, shift_of(vector).pose, strict=True)]
    machine.path.pallet = Target(tuple(offset))
    total.write(left - 1)
    _count(actual, [max(_integer(names, name), 1) for name in pattern.parts])


def _count(actual: list[Cell], counts: list[int]) -> None:
    """Advance the first counter; a full one begins anew and the next one advances (D-31).  The slowest is never full."""
    for at, (cell, count) in enumerate(zip(actual, counts, strict=True)):
        value = cell.read()
        assert isinstance(value, int)
        last = at == len(counts) - 1 or all(each <= 1 for each in counts[at + 1 :])
        if value + 1 < count or last:
            cell.write(value + 1)
            return
        cell.write(0)


def _off(machine: Machine, pattern: Pattern, names: Names) -> None:
    """No offset."""
    del pattern, names
    machine.path.pallet = Target()


# ---- values ----------------------------------------------------------------------------------------------------------------
def _cell(names: Names, name: str) -> Cell:
    found = names.get(name)
    if not isinstance(found, Cell):
        raise StepFault(WRONG_TYPES)
    return found


def _integer(names: Names, name: str) -> int:
    value = _cell(names, name).read()
    assert isinstance(value, int)
    return value


def _real(names: Names, name: str) -> float:
    value = _cell(names, name).read()
    assert not isinstance(value, str)
    return float(value)


def _corner(machine: Machine, names: Names, step: Step) -> Target:
    """A position of the pattern: taught or variable."""
    source = _source(step)
    if source is None:
        return target_of(dict(step.slots), machine)
    found = names.get(source.name) if isinstance(source, Ref) and source.index is None else structure(machine, source, "P")
    if not isinstance(found, Structure):
        raise StepFault(WRONG_TYPES)
    return target_from(found)


def _source(step: Step) -> Operand | None:
    return step.slots["position"] if step.word == "VAR_POS" else (None if "X" in step.slots else step.slots.get("variable"))


def _rectangular(machine: Machine, names: Names, pattern: Pattern, corners: list[Target]) -> list[Target]:
    """Corners 2 and 3 so that all directions are at right angles; the pattern program is changed (L4533)."""
    base = corners[0].pose
    ways = [_xyz(b - a for a, b in zip(base, corner.pose, strict=True)) for corner in corners[1:]]
    first = _unit(ways[0])
    second = _off_axis(ways[1], first)
    third = _off_axis(_off_axis(ways[2], first), _unit(second))
    made = list(corners)
    for at, way in ((2, second), (3, third)):
        pose = tuple(a + b for a, b in zip(base[:3], way, strict=True)) + corners[at].pose[3:]
        made[at] = Target(pose, corners[at].frame, corners[at].axes)
        _store(machine, names, pattern, at, made[at])
    return made


def _xyz(values: Iterable[float]) -> VectorXyz:
    x, y, z, *_ = values
    return x, y, z


def _unit(way: VectorXyz) -> VectorXyz:
    length = math.hypot(*way)
    return (way[0] / length, way[1] / length, way[2] / length) if length else (0.0, 0.0, 0.0)


def _off_axis(way: VectorXyz, axis: VectorXyz) -> VectorXyz:
    """The part of a way at a right angle to an axis."""
    along = sum(a * b for a, b in zip(way, axis, strict=True))
    return way[0] - along * axis[0], way[1] - along * axis[1], way[2] - along * axis[2]


def _store(machine: Machine, names: Names, pattern: Pattern, at: int, target: Target) -> None:
    """Writes a corner back to its step or its variable."""
    step = pattern.positions[at]
    source = _source(step)
    if isinstance(source, Ref):
        found = names.get(source.name)
        if isinstance(found, Structure):
            write_position(found, target)
        return
    slots = dict(step.slots) | {name: Number(value) for name, value in zip(CARTESIAN, target.pose, strict=True)}
    index = pattern.program.steps.index(step)
    pattern.program.steps[index] = Step(step.number, step.word, step.parameters, step.line, text=step.text, slots=slots)
