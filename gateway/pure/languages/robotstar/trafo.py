"""TRAFO_6D: transforms the positions of a program into another program.  Source: robotstar 6 (L3228-3903), doubts D-36, D-37."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

from gateway.pure.languages.robotstar import trafo_geometry as geometry
from gateway.pure.languages.robotstar.access import structure, text, valid, variable, writer
from gateway.pure.languages.robotstar.faults import WRONG_TYPES, StepFault
from gateway.pure.languages.robotstar.kept import restore, written
from gateway.pure.languages.robotstar.machine import Machine, Op
from gateway.pure.languages.robotstar.memory import wrong_name
from gateway.pure.languages.robotstar.motion_steps import target_from, target_of
from gateway.pure.languages.robotstar.operands import Equate, Number, Operand, Ref, Text, signed
from gateway.pure.languages.robotstar.path import CARTESIAN, Target
from gateway.pure.languages.robotstar.program import Program, Step
from gateway.pure.languages.robotstar.trafo_geometry import Map, Unfit, Xyz
from gateway.pure.languages.robotstar.values import Array, Cell, Names, Structure

OVERWRITE, KEEP_ORIENTATION, SHOWN, FATAL_ONLY = 1, 2, 1 << 8, 1 << 9
UNUSED = 0b1111_1100_0000_0000  # bits 10..15
SHIFT, SCALE, MIRROR = 0, 1, 2
# number of positions in the reference programs: (mode, parameter, two programs) -> (source, destination)
POSITIONS = {
    (SHIFT, 0, True): (3, 3),
    (SHIFT, 0, False): (1, 1),
    (SCALE, 0, True): (4, 1),
    (SCALE, 0, False): (3, 3),
    (SCALE, 1, True): (3, 1),
    (SCALE, 1, False): (2, 2),
    (SCALE, 2, True): (2, 1),
    (SCALE, 2, False): (1, 1),
    (MIRROR, 0, True): (3, 3),
}


class TrafoFault(Exception):
    """An error number of the table; `step`: of the source, where the display goes (*)."""

    def __init__(self, number: int, step: int = 0) -> None:
        super().__init__(number)
        self.number, self.step = number, step


@dataclass(frozen=True, slots=True)
class Reference:
    """The result of a reference program."""

    positions: tuple[Target, ...]
    numbers: tuple[float, ...] = ()

    @property
    def points(self) -> tuple[Xyz, ...]:
        """The positions alone."""
        return tuple((target.pose[0], target.pose[1], target.pose[2]) for target in self.positions)

    @property
    def frame(self) -> int:
        """Of all its positions."""
        return self.positions[0].frame


def trafo(machine: Machine, step: Step, following: int) -> Op:
    """TRAFO_6D ref source, ref destination, source, destination, control."""
    names = [text(machine, step.slots[name]) for name in ("ref_source", "ref_destination", "source", "destination")]
    put = writer(machine, step.slots["control"])

    def op() -> int:
        machine.effects += 1
        assert machine.frame is not None
        control = _control(machine, step.slots["control"])
        put(control & 0xFFFF)
        ref_source, ref_destination, source, destination = (name() for name in names)
        machine.forbid_in_stack(machine.memory.find(destination, machine.frame.program.directory, ("MPR", "SPR")))
        try:
            _transform(machine, control & 0xFFFF, (ref_source, ref_destination), source, destination)
        except TrafoFault as fault:
            put(signed(control & 0xFFFF | fault.number << 16))
            if control & SHOWN:
                shown = StepFault(f"TRAFO_6D-error: {fault.number}", fault.number, "trafo")
                shown.display = (machine.memory.find(source, machine.frame.program.directory, ("MPR", "SPR")), fault.step)
                raise shown from None
        return following

    return op


def _control(machine: Machine, operand: Operand) -> int:
    assert isinstance(operand, Ref)
    found = variable(machine, operand)
    value = found.read() if isinstance(found, Cell) else None
    if not isinstance(value, int):
        raise StepFault(WRONG_TYPES)
    return value


def _transform(machine: Machine, control: int, references: tuple[str, str], source: str, destination: str) -> None:
    mode, parameter = control >> 2 & 7, control >> 5 & 7
    _check_control(control, mode, parameter)
    assert machine.frame is not None
    near = machine.frame.program.directory
    found = machine.memory.find(source, near, ("MPR", "SPR"))
    if found is None or found.refused:
        raise TrafoFault(201)
    same = references[0].strip().upper() == references[1].strip().upper()
    one, two = _references(machine, references, same, mode, parameter, near)
    mapping, k = _mapping(mode, parameter, one, two, same)
    axes = _axes(one, two, same, k if mode == SCALE else (-1.0 if mode == MIRROR else 1.0), mode)
    _write(machine, found, destination, control, Transformation(mapping, axes, one.frame, two.frame, bool(control & KEEP_ORIENTATION)))


def _check_control(control: int, mode: int, parameter: int) -> None:
    if control & UNUSED:
        raise TrafoFault(401)
    if mode > MIRROR:
        raise TrafoFault(402)
    if parameter > {SHIFT: 1, SCALE: 2, MIRROR: 0}[mode]:
        raise TrafoFault(403)


# ---- reference programs ----------------------------------------------------------------------------------------------------
def _references(machine: Machine, names: tuple[str, str], same: bool, mode: int, parameter: int, near: str) -> tuple[Reference, Reference]:
    if mode == MIRROR and same:
        raise TrafoFault(150)
    if mode == SHIFT and parameter == 1 and not same:
        raise TrafoFault(151)  # cylinder offsets are numbers: one program
    wanted = POSITIONS[mode, parameter if mode == SCALE else 0, not same]
    numeric = 6 if mode == SHIFT else 1
    one = _reference(machine, names[0], near, 0, wanted[0], numeric if same else 0)
    two = one if same else _reference(machine, names[1], near, 100, wanted[1], 0)
    if (one.frame == 0) != (two.frame == 0):
        raise TrafoFault(113)
    if len(one.positions[0].axes) != len(two.positions[0].axes):
        raise TrafoFault(112)
    return one, two


def _reference(machine: Machine, name: str, near: str, base: int, wanted: int, numeric: int) -> Reference:
    """Reads a reference program; TrafoFault with numbers from `base` on."""
    program = machine.memory.find(name, near, ("MPR", "SPR"))
    if program is None:
        raise TrafoFault(base + 1)
    steps = [step for step in program.steps[1:-1] if step.word != "C" or step.macro]
    if any(not step.valid for step in steps):
        raise TrafoFault(base + 2)
    if any(step.macro or step.word not in ("VAR", "CONST", "LOC_VAR", "LOC_CONST", "TOOL", "POSITION", "VAR_POS") for step in steps):
        raise TrafoFault(base + 7)
    words = ["D" if step.word.endswith(("VAR", "CONST")) else "T" if step.word == "TOOL" else "P" for step in steps]
    form = "".join(words)
    if form.lstrip("D")[:1] != "T" or form.count("T") != 1 or form.lstrip("D")[1:].strip("P"):
        raise TrafoFault(base + 6)
    if form.count("P") != wanted:
        raise TrafoFault(base + 3)
    names: Names = {**machine.names, **machine.memory.locals.get(program.key, {})}
    targets = tuple(_target(machine, names, step, base) for step in steps if step.word in ("POSITION", "VAR_POS"))
    if any(not target.pose for target in targets):
        raise TrafoFault(base + 4)
    if len(frames := {target.frame for target in targets}) > 1:
        raise TrafoFault(base + (13 if 0 in frames else 14))  # base system and station mixed, or two stations
    if any(dict(a.axes) != dict(b.axes) for a, b in pairwise(targets)):
        raise TrafoFault(base + 5)
    definitions = [step for step, word in zip(steps, words, strict=True) if word == "D"]
    numbers = _numbers(names, definitions, numeric, len(targets[0].axes), base) if numeric else ()
    return Reference(targets, numbers)


def _target(machine: Machine, names: Names, step: Step, base: int) -> Target:
    source = step.slots.get("position" if step.word == "VAR_POS" else "variable")
    if source is None or "X" in step.slots or "A1" in step.slots:
        return target_of(dict(step.slots), machine)
    assert isinstance(source, Ref)
    if source.name not in names:
        raise TrafoFault(base + 8)
    try:
        found = valid(structure(machine, source, "P")) if source.index is not None or source.name in machine.names else names[source.name]
        if not isinstance(found, Structure):
            raise StepFault(WRONG_TYPES)
        return target_from(found)
    except StepFault:
        raise TrafoFault(base + 9) from None


def _numbers(names: Names, definitions: list[Step], numeric: int, axes: int, base: int) -> tuple[float, ...]:
    """Return the values of RARR, or of RVAR without an additional axis."""
    reals = [step.slots["name"] for step in definitions]
    found = [(ref, names.get(ref.name)) for ref in reals if isinstance(ref, Ref) and ref.name.startswith("R")]
    if not found or found[0][1] is None:
        raise TrafoFault(base + 8)
    _, value = found[0]
    if isinstance(value, Array):
        if len(value.items) != numeric + axes:
            raise TrafoFault(51)
        cells = list(value.items)
    elif numeric > 1 or axes:
        raise TrafoFault(50)
    else:
        cells = [value] if isinstance(value, Cell) else []
    numbers = [cell.value for cell in cells if isinstance(cell, Cell)]
    if any(number is None or isinstance(number, str) for number in numbers):
        raise TrafoFault(base + 9)
    return tuple(float(number) for number in numbers if number is not None)


# ---- what the references make ----------------------------------------------------------------------------------------------
def _mapping(mode: int, parameter: int, one: Reference, two: Reference, same: bool) -> tuple[Map, float]:
    """The map, and the factor k."""
    a, b = one.points, two.points
    if mode == SHIFT and same:
        return geometry.offset(a[0], one.numbers, parameter == 1), 1.0
    if mode in (SHIFT, MIRROR):
        make = geometry.shift if mode == SHIFT else geometry.mirror_shift
        return make(a, b, _fitting(0, a), _fitting(100, b)), 1.0
    reference = a if same else a[1:]
    k = one.numbers[0] if same else _factor(parameter, reference, a[0], b[0])
    if parameter == 0:
        _checked_plane(reference)
        return geometry.plane(reference[0], reference[1], reference[2], k), k
    if parameter == 1:
        if math.dist(reference[0], reference[1]) < geometry.DISTANCE - geometry.ROUNDING:
            raise TrafoFault(10)
        return geometry.line(reference[0], reference[1], k), k
    return geometry.point(reference[0], k), k


def _fitting(base: int, points: tuple[Xyz, ...]) -> geometry.Rows:
    try:
        return geometry.frame(points[0], points[1], points[2])
    except Unfit as fault:
        raise TrafoFault(base + fault.number) from None


def _checked_plane(points: tuple[Xyz, ...]) -> None:
    try:
        geometry.check_triangle(points[0], points[1], points[2])
    except Unfit as fault:
        raise TrafoFault(fault.number) from None


def _factor(parameter: int, reference: tuple[Xyz, ...], source: Xyz, destination: Xyz) -> float:
    """k = distance of PDZ / distance of PDQ; with a sign for the plane alone (L3630-3634)."""
    if parameter == 0:
        _checked_plane(reference)
        plane = reference[0], reference[1], reference[2]
        distances = [geometry.plane_distance(*plane, at) for at in (source, destination)]
    elif parameter == 1:
        if math.dist(reference[0], reference[1]) < geometry.DISTANCE - geometry.ROUNDING:
            raise TrafoFault(10)
        distances = [geometry.line_distance(reference[0], reference[1], at) for at in (source, destination)]
    else:
        distances = [math.dist(reference[0], at) for at in (source, destination)]
    for base, distance in zip((0, 100), distances, strict=True):
        if abs(distance) < geometry.DISTANCE - geometry.ROUNDING:
            raise TrafoFault(base + 10)
    return distances[1] / distances[0]


@dataclass(frozen=True, slots=True)
class AxisMap:
    """Mapping of one additional axis: value * factor + offset, for the axis `name` of the destination's station."""

    name: str
    factor: float = 1.0
    offset: float = 0.0


def _axes(one: Reference, two: Reference, same: bool, k: float, mode: int) -> dict[str, AxisMap]:
    """Additional axes: offset by numbers or by difference; mirrored about their mean where k < 0 (L3451-3481)."""
    names = list(one.positions[0].axes)
    if same:
        given = one.numbers[6 if mode == SHIFT else 1 :]
        return {name: AxisMap(name, 1.0, value) for name, value in zip(names, given, strict=False)}
    here, there = one.positions[0].axes, two.positions[0].axes
    made: dict[str, AxisMap] = {}
    for name, other in zip(names, there, strict=True):
        a, b = here[name], there[other]
        mirrored = k < 0 and one.frame == two.frame
        if mirrored:
            made[name] = AxisMap(other) if a == b else AxisMap(other, -1.0, a + b)
        else:
            made[name] = AxisMap(other, 1.0, 0.0 if k < 0 else b - a)
    return made


# ---- destination -----------------------------------------------------------------------------------------------------------
@dataclass(frozen=True, slots=True)
class Transformation:
    """What happens to each position of the source."""

    mapping: Map
    axes: dict[str, AxisMap]
    frame_source: int
    frame_destination: int
    keeps_orientation: bool

    def step(self, step: Step) -> Step:
        """A POSITION step as it becomes; TrafoFault 202, 205, 206, 502."""
        if "X" not in step.slots:
            raise TrafoFault(206 if "variable" in step.slots else 202, step.number)
        values = {name: operand.value for name, operand in step.slots.items() if isinstance(operand, Number)}
        frame = int(values.get("FRAME", 0))
        if self.frame_source and frame not in (0, self.frame_source):
            raise TrafoFault(205, step.number)
        additional = [name for name in values if name[:1] == "A" and name[1:].isdecimal() and int(name[1:]) > 6]
        if set(additional) != set(self.axes):
            raise TrafoFault(202, step.number)
        pose = self.mapping.pose([values[name] for name in CARTESIAN], self.keeps_orientation)
        new = dict(zip(CARTESIAN, (round(value, 9) + 0.0 for value in pose), strict=True))
        if frame:
            new["FRAME"] = self.frame_destination if self.frame_source else frame
        for name, axis in self.axes.items():
            new[axis.name] = round(values[name] * axis.factor + axis.offset, 9) + 0.0
        return _with_values(step, new)


def _with_values(step: Step, values: dict[str, float]) -> Step:
    """The step with other numbers; positions of the main axes no longer fit and are dropped."""
    slots: dict[str, Operand] = {
        name: operand for name, operand in step.slots.items() if not (name[:1] == "A" and name[1:].isdecimal() and name not in values)
    }
    slots |= {name: Number(value) for name, value in values.items()}
    return replace(step, slots=slots, text=f"POSITION {', '.join(_shown(name, operand) for name, operand in _in_order(slots))}")


def _in_order(slots: dict[str, Operand]) -> list[tuple[str, Operand]]:
    """As the control prints them: kind, name, place, the rest."""
    order = ("kind", "name", *CARTESIAN, "FRAME")
    return sorted(slots.items(), key=lambda item: order.index(item[0]) if item[0] in order else len(order))


def _shown(name: str, operand: Operand) -> str:
    """Reads back as the same operand."""
    if isinstance(operand, Equate):
        return f"#{operand.name}"
    if isinstance(operand, Number):
        return f"{'Frame' if name == 'FRAME' else name}:{operand.value:.15g}"
    return f'Name: "{operand.value}"' if isinstance(operand, Text) else "Name: < >"


def _place(source: Program, destination: str) -> tuple[str, str]:
    """Name and directory of the destination: without a path that of the source."""
    path, _, name = destination.strip().replace("\\", "/").rpartition("/")
    name = name.strip().upper().removesuffix(f".{source.kind}")
    drive, _, within = path.rpartition(":")
    if wrong_name(name, within.strip("/")) or drive.upper() not in ("", "S"):
        raise TrafoFault(302)
    return name, within.strip("/") if path or destination.strip()[:1] in "/\\" else source.directory


def _write(machine: Machine, source: Program, destination: str, control: int, transformation: Transformation) -> None:
    """Makes the destination; global definitions are invalid in it unless it is the source itself (L3273)."""
    memory = machine.memory
    name, directory = _place(source, destination)
    existing = next((each for each in memory.programs.get(name, []) if each.directory.upper() == directory.upper()), None)
    itself = existing is source
    if existing is not None and not control & OVERWRITE:
        raise TrafoFault(301)
    if any(step.valid and step.word == "VAR_POS" and not step.macro for step in source.steps):
        number = next(step.number for step in source.steps if step.valid and step.word == "VAR_POS" and not step.macro)
        raise TrafoFault(206, number)
    steps = [_copied(step, transformation, name, itself) for step in source.steps]
    if itself:
        source.steps[:] = steps
        source.made = source.made or source.file
        memory.version += 1
    else:
        if existing is not None:
            memory.remove(existing)
        directory = memory.directory(directory)
        made = Program(name, source.kind, steps, directory, source.file, dict(source.labels))
        made.made = f"{directory}/{name}.{source.kind}".lstrip("/")
        memory.add(made)
        restore(written(memory.locals[source.key]), memory.locals[made.key])  # values go with a copy (L3115-3119)
    machine.refresh()


def _copied(step: Step, transformation: Transformation, name: str, itself: bool) -> Step:
    if step.valid and step.word == "POSITION" and not step.macro:
        return transformation.step(step)
    if step.number == 1 and not itself:
        return replace(step, text=f'{step.text.split()[0]} "{name}"', slots={"name": Text(name)})
    if step.word in ("VAR", "CONST") and not itself and not step.macro:
        return replace(step, valid=False)
    return step
