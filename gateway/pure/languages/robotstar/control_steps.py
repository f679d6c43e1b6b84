"""Steps that wait, branch, call and switch bits.  Source: robotstar 1.4, 2.4, 4; L424-756."""

import operator
from collections.abc import Callable, Mapping

from gateway.pure.languages.robotstar.access import number, scalar, text, whole, writer
from gateway.pure.languages.robotstar.faults import WRONG_TYPES, StepFault
from gateway.pure.languages.robotstar.machine import BitWait, Halted, KeyTest, Machine, Op, Wait
from gateway.pure.languages.robotstar.operands import Equate, Operand, Ref
from gateway.pure.languages.robotstar.program import Program, Step
from gateway.pure.languages.robotstar.reader import label_of
from gateway.pure.languages.robotstar.values import Scalar

NS = 1_000_000_000
BYTES = {"INPUT": 40, "OUTPUT": 40, "MARKER": 2048}
RELATIONS: Mapping[str, Callable[[Scalar, Scalar], bool]] = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}


def equate_of(step: Step, name: str) -> str:
    """The system equate in a place."""
    found = step.slots[name]
    assert isinstance(found, Equate)
    return found.name


def bit_test(machine: Machine, step: Step, area: str) -> Callable[[], bool]:
    """A function that reads the bit of a WAIT_BIT or TEST_BIT."""
    place = step.slots["byte"]
    if area == "VARIABLE":
        if not isinstance(place, Ref):
            return _no_variable
        get, bit = scalar(machine, place), whole(machine, step.slots["bit"], 0, 31, "bit")

        def of_variable() -> bool:
            value = get()
            if not isinstance(value, int):
                raise StepFault(WRONG_TYPES)
            return bool(value >> bit() & 1)

        return of_variable
    byte, bit = whole(machine, place, 0, BYTES[area] - 1, "byte"), whole(machine, step.slots["bit"], 0, 7, "bit")
    return lambda: bool(machine.world.byte(area, byte()) >> bit() & 1)


def input_of(machine: Machine, step: Step) -> Callable[[], int | None]:
    """Return a function that returns the number of an input, byte by byte."""
    byte, bit = whole(machine, step.slots["byte"], 0, 39, "byte"), whole(machine, step.slots["bit"], 0, 7, "bit")
    return lambda: 8 * byte() + bit()


def _no_variable() -> bool:
    raise StepFault(WRONG_TYPES)


def write_bit(machine: Machine, step: Step, following: int) -> Op:
    """WRITE_BIT; user outputs are not switched while inputs are simulated (L1227)."""
    area = equate_of(step, "area")
    level = whole(machine, step.slots["level"], 0, 1, "level")
    byte, bit = whole(machine, step.slots["byte"], 0, BYTES[area] - 1, "byte"), whole(machine, step.slots["bit"], 0, 7, "bit")

    def op() -> int:
        machine.effects += 1
        place = level(), byte(), bit()
        if machine.switches(area, place[1]):
            machine.world.set_bit(area, place[1], place[2], bool(place[0]))
        return following

    return op


def wait_bit(machine: Machine, step: Step, following: int, program: Program) -> Op:
    """WAIT_BIT; a time of 0 waits for ever, and has no label then."""
    area = equate_of(step, "area")
    test, level = bit_test(machine, step, area), whole(machine, step.slots["level"], 0, 1, "level")
    limit = number(machine, step.slots["time"], 0, 1e9, "time") if "time" in step.slots else lambda: 0.0
    label = label_of(step)
    place = input_of(machine, step) if area == "INPUT" else lambda: None

    def op() -> int:
        machine.effects += 1
        seconds, wanted = limit(), bool(level())
        keys = machine.simulated and area == "INPUT"
        if not keys and test() == wanted:
            return following
        late = program.labels.get(label, 0) - 1 if seconds else following
        if late < 0:
            raise StepFault(f"label {label or '(none)'} not found")
        left = round(seconds * NS) if seconds else None
        return machine.ask(BitWait(lambda: test() == wanted, wanted, left, late, keys, place()), following)

    return op


def test_bit(machine: Machine, step: Step, following: int, program: Program) -> Op:
    """TEST_BIT: branches where the bit has the state."""
    area, wanted = equate_of(step, "area"), equate_of(step, "condition") == "=1"
    test, here = bit_test(machine, step, area), following - 1
    target = program.labels.get(label_of(step), 0) - 1

    def op() -> int:
        if machine.simulated and area == "INPUT":
            test()
            return machine.ask(KeyTest(wanted, target), following)
        return machine.jump(here, target) if test() == wanted else following

    return op


def test_value(machine: Machine, step: Step, following: int, program: Program) -> Op:
    """TEST: branches where the relation holds; for a byte the second operand is its number (L718)."""
    area, relation = equate_of(step, "area"), RELATIONS[equate_of(step, "relation")]
    first, here = scalar(machine, step.slots["first"]), following - 1
    second = scalar(machine, step.slots["second"]) if area == "VARIABLE" else _byte_of(machine, area, step.slots["second"])
    target = program.labels.get(label_of(step), 0) - 1
    ordered = equate_of(step, "relation") not in ("=", "<>")

    def op() -> int:
        one, two = first(), second()
        if (one.__class__ is str or two.__class__ is str) and (one.__class__ is not two.__class__ or ordered):
            raise StepFault(WRONG_TYPES)
        if not relation(one, two):
            return following
        return target if target > here else machine.jump(here, target)

    return op


def _byte_of(machine: Machine, area: str, place: Operand) -> Callable[[], Scalar]:
    byte = whole(machine, place, 0, BYTES[area] - 1, "byte")
    return lambda: machine.world.byte(area, byte())


def branch(machine: Machine, step: Step, following: int, program: Program) -> Op:
    """BRANCH."""
    here, target = following - 1, program.labels.get(label_of(step), 0) - 1
    if target > here:
        return lambda: target
    return lambda: machine.jump(here, target)


def wait(machine: Machine, step: Step, following: int) -> Op:
    """WAIT, in all modes (L658)."""
    seconds = number(machine, step.slots["time"], 0, 1e9, "time")

    def op() -> int:
        machine.effects += 1
        return machine.ask(Wait(round(seconds() * NS)), following)

    return op


def stop(machine: Machine, following: int) -> Op:
    """STOP: the cursor goes to the next step."""

    def op() -> int:
        assert machine.frame is not None
        machine.frame.at, machine.frame.done = following, following - 1
        raise Halted

    return op


def call(machine: Machine, step: Step, following: int) -> Op:
    """CALL."""
    name = text(machine, step.slots["program"])

    def op() -> int:
        machine.effects += 1
        machine.call(name(), ("SPR",), following)
        return -1

    return op


def switch(machine: Machine, step: Step) -> Op:
    """PROGRAM."""
    name = text(machine, step.slots["program"])

    def op() -> int:
        machine.effects += 1
        machine.switch(name())
        return -1

    return op


def macro(machine: Machine, step: Step, following: int) -> Op:
    """A macro by its name."""

    def op() -> int:
        machine.effects += 1
        machine.call(step.word, ("MAC",), following)
        return -1

    return op


def analog_output(machine: Machine, step: Step, following: int) -> Op:
    """ANA_OUTP."""
    volts, channel = number(machine, step.slots["voltage"], -10, 10, "voltage"), whole(machine, step.slots["channel"], 1, 24, "output")

    def op() -> int:
        machine.effects += 1
        machine.world.set_analog_output(channel(), volts())
        return following

    return op


def analog_input(machine: Machine, step: Step, following: int) -> Op:
    """ANA_INP."""
    channel, put = whole(machine, step.slots["channel"], 1, 24, "input"), writer(machine, step.slots["destination"])

    def op() -> int:
        put(machine.world.analog_input(channel()))
        machine.effects -= 1  # reading the same again is not a change: a loop of it yields its time
        return following

    return op
