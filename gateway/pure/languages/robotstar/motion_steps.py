"""Steps of motion: tool, mode and parameters, positions, displacement.  Source: robotstar 3; L260-422, L1686-1942."""

from collections.abc import Callable

from gateway.pure.languages.robotstar.access import number, structure, valid
from gateway.pure.languages.robotstar.control_steps import NS, equate_of
from gateway.pure.languages.robotstar.faults import NO_ARRAY, NOT_FOUND, UNSET, WRONG_TYPES, StepFault
from gateway.pure.languages.robotstar.machine import Go, Machine, Op
from gateway.pure.languages.robotstar.operands import Number, Operand, Ref
from gateway.pure.languages.robotstar.path import CARTESIAN, PathState, Target
from gateway.pure.languages.robotstar.program import Step
from gateway.pure.languages.robotstar.values import AXES, Array, Structure

NO_TOOL = "no valid tool: TOOL is needed in front of a position"
PARAMETERS = ("PTP_SPEED", "PTP_ACCEL", "PATH_SPEED", "PATH_ACCEL", "PATH_TIME", "PATH_RADIUS", "PATH_DISTANCE")


def _then(machine: Machine, act: Callable[[], None], following: int) -> Op:
    def op() -> int:
        machine.effects += 1
        act()
        return following

    return op


def target_of(slots: dict[str, Operand], machine: Machine) -> Target:
    """The values of a POSITION step."""
    values = {
        name: operand.value if isinstance(operand, Number) else number(machine, operand)()
        for name, operand in slots.items()
        if name in CARTESIAN or name in AXES
    }
    frame = number(machine, slots["FRAME"], 0, 2**31 - 1, "frame")() if "FRAME" in slots else 0
    pose = tuple(values[name] for name in CARTESIAN) if "X" in values else ()
    axes = {name: values[name] for name in sorted(values, key=_axis) if name in AXES}
    return Target(pose, int(frame), axes)


def _axis(name: str) -> int:
    return int(name[1:] or 0) if name[1:].isdecimal() else 0


def target_from(found: Structure) -> Target:
    """Value of a position variable; StepFault where a value was never written."""
    if found.kind != "P":
        raise StepFault(WRONG_TYPES)
    pose = tuple(found.parts[name] for name in CARTESIAN)
    given = tuple(value for value in pose if value is not None)
    axes = {name: value for name in AXES if (value := found.parts[name]) is not None}
    if (given and len(given) < 6) or (not given and not axes):
        raise StepFault(UNSET)
    return Target(given, int(found.number("FRAME")), axes)


def write_position(found: Structure, target: Target) -> None:
    """Writes a position into a variable of type P."""
    found.check_writable()
    values: dict[str, float] = dict(zip(CARTESIAN, target.pose, strict=False))
    additional = [name for name in target.axes if _axis(name) > 6]
    values |= {"FRAME": target.frame, "MA": 6, "AA": len(additional), "PT": 0, **target.axes}
    for name, value in values.items():
        found.put(name, value)


def shift_of(vector: Structure) -> Target:
    """What RELATIVE adds."""
    return Target(
        tuple(vector.number(name) for name in CARTESIAN), 0, {name: value for name in AXES if (value := vector.parts[name]) is not None}
    )


def position(machine: Machine, step: Step, following: int) -> Op:
    """POSITION or VAR_POS: move there with the present settings, or supply the vector of CALC_REL."""
    slots = dict(step.slots)
    source = slots.get("variable" if step.word == "POSITION" else "position")
    fixed = None if source is not None and "X" not in slots else target_of(slots, machine)

    def op() -> int:
        machine.effects += 1
        if machine.tool is None:
            raise StepFault(NO_TOOL)
        if fixed is not None:
            programmed = fixed
        else:
            assert source is not None
            programmed = target_from(structure(machine, source, "P"))
        if machine.path.relation is not None:
            _give_relation(machine, programmed)
            return following
        return go(machine, programmed, following)

    return op


def go(machine: Machine, programmed: Target, following: int) -> int:
    """Asks for the way to a position."""
    target, world = machine.path.shifted(programmed), machine.world
    return machine.ask(way(machine.path, world.based(target), world.planned(), machine.tool, machine.simulated), following)


def way(path: PathState, target: Target, planned: Target, tool: Structure | None = None, simulated: bool = False) -> Go:
    """To a position, from where the robot is once all before it is reached; StepFault with the number of a path error."""
    mode, settings = path.mode, dict(path.values)
    seconds = path.accept(target, planned, not simulated)
    approximates = not simulated and settings["FLYBY"] == 1 and mode != "SPLINE"
    return Go(target, mode, round(seconds * NS), settings, tool, path.auxiliary, approximates)


def _give_relation(machine: Machine, programmed: Target) -> None:
    """CALC_REL: vector = actual - programmed; the position is not approached (L400)."""
    actual = machine.world.actual()
    if programmed.frame and not actual.frame:
        actual = machine.world.seen_from(programmed.frame, actual)
    vector, machine.path.relation = machine.path.relation, None
    assert isinstance(vector, Structure)
    if actual.frame != programmed.frame:
        raise StepFault(f"CALC_REL: the robot is in frame {actual.frame}, the position in frame {programmed.frame}")
    if bool(actual.pose) != bool(programmed.pose):
        raise StepFault("CALC_REL: one of the positions is stated by axes, the other is not")
    for name, here, there in zip(CARTESIAN, actual.pose, programmed.pose, strict=False):
        vector.put(name, here - there)
    for name, value in programmed.axes.items():
        vector.put(name, actual.axes.get(name, 0.0) - value)
    vector.put("FRAME", programmed.frame)


def calc_rel(machine: Machine, step: Step, following: int) -> Op:
    """CALC_REL: the next position supplies the vector."""

    def act() -> None:
        vector = structure(machine, step.slots["vector"], "V")
        vector.check_writable()
        machine.path.relation = vector

    return _then(machine, act, following)


def relative(machine: Machine, step: Step, following: int) -> Op:
    """RELATIVE: added to all positions from now on."""

    def act() -> None:
        machine.path.shift = shift_of(valid(structure(machine, step.slots["vector"], "V")))

    return _then(machine, act, following)


def tool(machine: Machine, step: Step, following: int) -> Op:
    """TOOL: the values of the tool now."""

    def act() -> None:
        found = valid(structure(machine, step.slots["tool"], "T"))
        machine.tool = Structure("T")
        machine.tool.copy_from(found)

    return _then(machine, act, following)


def actual_position(machine: Machine, step: Step, following: int) -> Op:
    """ACT_POS: where the robot is."""
    return _then(machine, lambda: write_position(structure(machine, step.slots["position"], "P"), machine.world.actual()), following)


def parameter(machine: Machine, step: Step, following: int) -> Op:
    """A speed, acceleration, time, radius or distance."""
    value = number(machine, step.slots["value"])
    return _then(machine, lambda: machine.path.set(step.word, value()), following)


def mode(machine: Machine, step: Step, following: int) -> Op:
    """MOVE_MODE."""
    name = equate_of(step, "mode")
    return _then(machine, lambda: machine.path.set_mode(name), following)


def flyby(machine: Machine, step: Step, following: int) -> Op:
    """UEBERSCHL."""
    value = float(equate_of(step, "value") == "ON")
    return _then(machine, lambda: machine.path.set("FLYBY", value), following)


def calibrate(machine: Machine, step: Step, following: int) -> Op:
    """MAUS_KALIB: _RMOUSE_T and _RMOUSE_R of six vectors (L3104)."""
    data = step.slots["data"]

    def act() -> None:
        found = machine.names.get(data.name) if isinstance(data, Ref) and data.index is None and not data.element else None
        if not isinstance(found, Array):
            raise StepFault(NOT_FOUND if found is None else NO_ARRAY)
        machine.mouse.calibrate(found)

    return _then(machine, act, following)
