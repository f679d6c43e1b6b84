"""Steps that calculate: COPY, COPY_OFFSETS, mathematics, vectors, logic.  Source: robotstar 2.4, 2.6; L827-1017, L3921-4222."""

import math
from collections.abc import Callable, Mapping

from gateway.pure.languages.robotstar.access import copy, scalar, structure, valid, variable, whole, writer
from gateway.pure.languages.robotstar.faults import INDEX_RANGE, UNSET, WRONG_TYPES, StepFault
from gateway.pure.languages.robotstar.machine import Machine, Op
from gateway.pure.languages.robotstar.operands import HIGHEST, LOWEST, Operand, Ref, signed
from gateway.pure.languages.robotstar.program import Step
from gateway.pure.languages.robotstar.values import ELEMENTS, INTEGERS, Cell, Scalar, Structure

Calculation = Callable[[int | float, int | float], int | float]


def _then(act: Callable[[], None], following: int) -> Op:
    def op() -> int:
        act()
        return following

    return op


def copy_step(machine: Machine, step: Step, following: int) -> Op:
    """COPY; a scalar variable from a scalar uses the short path."""
    source, destination = step.slots["source"], step.slots["destination"]
    general = copy(machine, source, destination)
    if (
        not isinstance(destination, Ref)
        or destination.index is not None
        or destination.element
        or (isinstance(source, Ref) and source.element)
    ):
        return _then(general, following)
    get, name = scalar(machine, source), destination.name
    simple = not isinstance(source, Ref) or source.index is None

    def op() -> int:
        found = machine.names.get(name)
        if simple and found.__class__ is Cell and found.kind == "I" and not found.constant:
            try:
                value = get()
            except StepFault:
                general()
                return following
            if value.__class__ is int and LOWEST <= value <= HIGHEST:
                found.value = value
                machine.effects += 1
                return following
        general()
        return following

    return op


# ---- mathematics -----------------------------------------------------------------------------------------------------------
def _divided(value: int | float, by: int | float) -> int | float:
    if by == 0:
        raise StepFault("division by zero")
    if isinstance(value, int) and isinstance(by, int):
        return int(math.copysign(1, value) * math.copysign(1, by)) * (abs(value) // abs(by))
    return value / by


def _rest(value: int | float, by: int | float) -> int | float:
    if by == 0:
        raise StepFault("division by zero")
    if isinstance(value, int) and isinstance(by, int):
        return value - by * int(_divided(value, by))
    return math.fmod(value, by)


MATH: Mapping[str, Calculation] = {
    "ADD": lambda value, by: value + by,
    "SUB": lambda value, by: value - by,
    "MUL": lambda value, by: value * by,
    "DIV": _divided,
    "MODULO": _rest,
}


def math_step(machine: Machine, step: Step, following: int) -> Op:
    """Destination = destination, calculated with the source."""
    calculate = MATH[step.word]
    get = scalar(machine, step.slots["source"])
    read, put = scalar(machine, step.slots["destination"]), writer(machine, step.slots["destination"])
    destination = step.slots["destination"]
    name = destination.name if isinstance(destination, Ref) and destination.index is None and not destination.element else ""

    def op() -> int:
        found = machine.names.get(name)
        by = get()
        if found.__class__ is Cell and found.kind == "I" and by.__class__ is int and not found.constant:
            value = found.value
            if value.__class__ is int:
                result = calculate(value, by)
                if LOWEST <= result <= HIGHEST:
                    found.value = result
                    machine.effects += 1
                    return following
        _general(calculate, read, by, put)
        return following

    return op


def _general(calculate: Calculation, read: Callable[[], Scalar], by: Scalar, put: Callable[[Scalar], None]) -> None:
    value = read()
    if isinstance(value, str) or isinstance(by, str):
        raise StepFault(WRONG_TYPES)
    try:
        put(calculate(value, by))
    except OverflowError as error:
        raise StepFault("the result is outside the range of a real variable") from error


def negate(machine: Machine, step: Step, following: int) -> Op:
    """NEG: the sign of an integer or a real; the lowest integer remains, as two's complement does."""
    read, put = scalar(machine, step.slots["destination"]), writer(machine, step.slots["destination"])

    def act() -> None:
        value = read()
        if isinstance(value, str):
            raise StepFault(WRONG_TYPES)
        put(signed(-value) if isinstance(value, int) else -value)

    return _then(act, following)


# ---- logic -----------------------------------------------------------------------------------------------------------------
LOGIC: Mapping[str, Callable[[int, int], int]] = {
    "AND": lambda value, by: value & by,
    "OR": lambda value, by: value | by,
    "EXCL_OR": lambda value, by: value ^ by,
    "SHIFT_L": lambda value, by: value << by if by < 32 else 0,
    "SHIFT_R": lambda value, by: value >> by if by < 32 else 0,
}


def logic_step(machine: Machine, step: Step, following: int) -> Op:
    """32 bits without a sign (L941-1017)."""
    calculate = LOGIC[step.word]
    get = scalar(machine, step.slots["source" if "source" in step.slots else "count"])
    read, put = scalar(machine, step.slots["destination"]), writer(machine, step.slots["destination"])

    def act() -> None:
        by, value = get(), read()
        if not isinstance(by, int) or not isinstance(value, int):
            raise StepFault(WRONG_TYPES)
        if not LOWEST <= by <= 0xFFFFFFFF or (by < 0 and step.word.startswith("SHIFT")):
            raise StepFault(f"operand {by} has no 32 bits" if not step.word.startswith("SHIFT") else f"count {by} is below 0")
        put(signed(calculate(value & 0xFFFFFFFF, by & 0xFFFFFFFF)))

    return _then(act, following)


def invert(machine: Machine, step: Step, following: int) -> Op:
    """INVERT: one's complement."""
    read, put = scalar(machine, step.slots["destination"]), writer(machine, step.slots["destination"])

    def act() -> None:
        value = read()
        if not isinstance(value, int):
            raise StepFault(WRONG_TYPES)
        put(~value)

    return _then(act, following)


# ---- structures ------------------------------------------------------------------------------------------------------------
def vector_step(machine: Machine, step: Step, following: int) -> Op:
    """VEC_ADD, VEC_SUB: the second becomes second + first or second - first (D-38); the frame stays."""
    sign = 1 if step.word == "VEC_ADD" else -1

    def act() -> None:
        first, second = (valid(structure(machine, step.slots[name], "V")) for name in ("source", "destination"))
        second.check_writable()
        machine.effects += 1
        for name in ELEMENTS["V"]:
            if name not in INTEGERS and not (first.parts[name] is None and second.parts[name] is None):
                second.put(name, second.number(name) + sign * first.number(name))

    return _then(act, following)


def vector_value(machine: Machine, step: Step, following: int) -> Op:
    """VEC_VALUE: the length of the shift."""
    put = writer(machine, step.slots["destination"])

    def act() -> None:
        vector = valid(structure(machine, step.slots["source"], "V"))
        put(math.hypot(*(vector.number(name) for name in "XYZ")))

    return _then(act, following)


def copy_offsets(machine: Machine, step: Step, following: int) -> Op:
    """COPY_OFFSETS: `count` components by number.  A number as source goes to one component, one component to a number (L843)."""
    first, to, count = (whole(machine, step.slots[name], 1, 36, name) for name in ("from", "to", "count"))
    source, destination = step.slots["source"], step.slots["destination"]
    put = writer(machine, destination)

    def act() -> None:
        machine.effects += 1
        target = _of(machine, destination)
        values, at = _components(machine, source, first(), count()), to()
        if not isinstance(target, Structure):
            if at != 1 or len(values) != 1:
                raise StepFault(INDEX_RANGE)
            put(values[0])
            return
        target.check_writable()
        if at + len(values) - 1 > target.components():
            raise StepFault(INDEX_RANGE)
        for number, value in enumerate(values, at):
            target.set_component(number, value)

    return _then(act, following)


def _of(machine: Machine, operand: Operand) -> Cell | Structure:
    if not isinstance(operand, Ref) or operand.element:
        raise StepFault(WRONG_TYPES)
    return variable(machine, operand)


def _components(machine: Machine, source: Operand, first: int, count: int) -> list[int | float]:
    found = variable(machine, source) if isinstance(source, Ref) and not source.element else None
    if isinstance(found, Structure):
        if not found.valid:
            raise StepFault(UNSET)
        return [found.component(number) for number in range(first, first + count)]
    value = scalar(machine, source)()
    if isinstance(value, str):
        raise StepFault(WRONG_TYPES)
    if first != 1 or count != 1:
        raise StepFault(INDEX_RANGE)
    return [value]
