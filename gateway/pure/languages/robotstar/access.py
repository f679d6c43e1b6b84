"""Reads and writes operands of a running program, with the texts of COPY's faults.  Source: robotstar 2.6, L3939-4222."""

from collections.abc import Callable

from gateway.pure.languages.robotstar.faults import (
    INDEX_NOT_FOUND,
    INDEX_UNSET,
    IS_ARRAY,
    NO_ARRAY,
    NO_VARIABLE,
    NO_WRITING,
    NOT_FOUND,
    UNSET,
    WRONG_TYPES,
    StepFault,
)
from gateway.pure.languages.robotstar.machine import Machine
from gateway.pure.languages.robotstar.memory import DEFAULT_TOOL
from gateway.pure.languages.robotstar.operands import Equate, Number, Operand, Ref, Text
from gateway.pure.languages.robotstar.path import outside
from gateway.pure.languages.robotstar.values import GROUPS, Array, Cell, Scalar, Structure

Get = Callable[[], Scalar]
Put = Callable[[Scalar], None]


def variable(machine: Machine, ref: Ref) -> Cell | Structure:
    """The cell or structure a name means now."""
    found = machine.names.get(ref.name)
    if found is None:
        raise StepFault(NOT_FOUND)
    if ref.index is None:
        if isinstance(found, Array):
            raise StepFault(IS_ARRAY)
        return found
    if not isinstance(found, Array):
        raise StepFault(NO_ARRAY)
    if ref.element:
        raise StepFault(WRONG_TYPES)  # elements in arrays of structures: not in RSV 2.3 (L3973)
    return found.at(_index(machine, ref.index))


def _index(machine: Machine, index: int | str) -> int:
    if isinstance(index, int):
        return index
    found = machine.names.get(index)
    if found is None:
        raise StepFault(INDEX_NOT_FOUND)
    if isinstance(found, Array):
        raise StepFault(IS_ARRAY)
    if not isinstance(found, Cell) or found.kind != "I":
        raise StepFault(WRONG_TYPES)
    try:
        value = found.read()
    except StepFault as fault:
        raise StepFault(INDEX_UNSET) if fault.text == UNSET else fault from None
    assert isinstance(value, int)
    return value


def scalar(machine: Machine, operand: Operand) -> Get:
    """A function that reads a number or a text."""
    if isinstance(operand, Number | Text):
        constant: Scalar = operand.value
        return lambda: constant
    if isinstance(operand, Equate) or not isinstance(operand, Ref):
        return _refused

    def slow() -> Scalar:
        found = variable(machine, operand)
        if isinstance(found, Structure):
            if not operand.element:
                raise StepFault(WRONG_TYPES)
            return found.get(element(found, operand.element))
        if operand.element:
            raise StepFault(WRONG_TYPES)
        return found.read()

    if operand.index is not None or operand.element:
        return slow
    name = operand.name

    def fast() -> Scalar:
        found = machine.names.get(name)
        if found.__class__ is Cell:
            value = found.value
            if value is not None:
                return value
        return slow()

    return fast


def _refused() -> Scalar:
    raise StepFault(WRONG_TYPES)


def element(structure: Structure, name: str) -> str:
    """The element of a structure; StepFault where it has none of that name."""
    if name not in structure.parts:
        raise StepFault(WRONG_TYPES)
    return name


def number(
    machine: Machine, operand: Operand, low: float | None = None, high: float | None = None, what: str = "value"
) -> Callable[[], float]:
    """A function that reads a number and checks its range."""
    get = scalar(machine, operand)

    def read() -> float:
        value = get()
        if isinstance(value, str):
            raise StepFault(WRONG_TYPES)
        if low is not None and high is not None and not low <= value <= high:
            raise StepFault(outside(what, value, low, high))
        return value

    return read


def whole(machine: Machine, operand: Operand, low: int, high: int, what: str) -> Callable[[], int]:
    """A function that reads an integer and checks its range."""
    if isinstance(operand, Number) and isinstance(operand.value, int) and low <= operand.value <= high:
        constant = operand.value
        return lambda: constant
    get = scalar(machine, operand)

    def read() -> int:
        value = get()
        if not isinstance(value, int):
            raise StepFault(WRONG_TYPES)
        if not low <= value <= high:
            raise StepFault(f"{what} {value} is outside {low} .. {high}")
        return value

    return read


def writer(machine: Machine, operand: Operand) -> Put:
    """A function that writes a number or a text."""
    if not isinstance(operand, Ref):
        return _no_variable

    def put(value: Scalar) -> None:
        machine.effects += 1
        found = variable(machine, operand)
        if isinstance(found, Structure):
            if not operand.element:
                raise StepFault(WRONG_TYPES)
            name = element(found, operand.element)
            found.check_writable()
            if isinstance(value, str):
                raise StepFault(WRONG_TYPES)
            found.put(name, value)
        elif operand.element:
            raise StepFault(WRONG_TYPES)
        else:
            found.write(value)

    return put


def _no_variable(value: Scalar) -> None:
    raise StepFault(NO_VARIABLE)


def structure(machine: Machine, operand: Operand, kind: str) -> Structure:
    """Return a complete structure of one type."""
    if not isinstance(operand, Ref) or operand.element:
        raise StepFault(WRONG_TYPES)
    if kind == "T" and operand.name == DEFAULT_TOOL and operand.name not in machine.names:
        return Structure("T", dict.fromkeys(("X", "Y", "Z", "RX", "RY", "RZ"), 0.0))
    found = variable(machine, operand)
    if not isinstance(found, Structure) or found.kind != kind:
        raise StepFault(WRONG_TYPES)
    return found


def valid(found: Structure) -> Structure:
    """The structure, where anything has been written to it."""
    if not found.valid:
        raise StepFault(UNSET)
    return found


def text(machine: Machine, operand: Operand) -> Callable[[], str]:
    """The name of a program: a text, a string variable, or the bare name itself."""
    if isinstance(operand, Text):
        plain = operand.value.strip()
        return lambda: plain
    assert isinstance(operand, Ref)

    def read() -> str:
        if operand.name[0] == "S" or operand.name.startswith("_S") or operand.index is not None:
            if operand.name not in machine.names and operand.index is None and machine.memory.find(operand.name) is not None:
                return operand.name
            found = variable(machine, operand)
            if isinstance(found, Cell) and found.kind == "S":
                return str(found.read()).strip()
            raise StepFault(WRONG_TYPES)
        return operand.name

    return read


def copy(machine: Machine, source: Operand, destination: Operand) -> Callable[[], None]:
    """COPY: numbers with conversion, texts, complete structures, elements inside their groups."""
    if not isinstance(destination, Ref):
        return lambda: _no_variable(0)
    get, put = scalar(machine, source), writer(machine, destination)
    plain = isinstance(source, Number | Text)

    def general() -> None:
        machine.effects += 1
        if plain:
            put(get())
            return
        assert isinstance(source, Ref)
        default = source == Ref(DEFAULT_TOOL)
        from_, to = structure(machine, source, "T") if default else variable(machine, source), variable(machine, destination)
        if isinstance(from_, Structure) and not source.element:
            if not isinstance(to, Structure) or destination.element or to.kind != from_.kind:
                raise StepFault(WRONG_TYPES)
            to.copy_from(from_)
            return
        if isinstance(from_, Structure) and isinstance(to, Structure):
            check_groups(from_, source.element, to, destination.element)
        if isinstance(to, Structure) and not destination.element:
            raise StepFault(WRONG_TYPES)
        put(get())

    return general


def check_groups(from_: Structure, one: str, to: Structure, other: str) -> None:
    """Elements pass within a type, and between vectors and positions within one group (L4109-4146)."""
    one, other = element(from_, one), element(to, other)
    if from_.kind == to.kind:
        return
    if "T" in (from_.kind, to.kind) or not of_one_group(one, other):
        raise StepFault(WRONG_TYPES)


def of_one_group(one: str, other: str) -> bool:
    """Whether two elements are in one group: translation, orientation, axis angle or frame (L4109-4139)."""
    return GROUPS.get(one) is not None and GROUPS.get(one) == GROUPS.get(other)


__all__ = ["NO_WRITING", "copy", "number", "scalar", "structure", "text", "valid", "variable", "whole", "writer"]
