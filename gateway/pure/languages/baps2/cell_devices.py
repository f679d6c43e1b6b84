"""Devices of BAPS2 programs in a cell: V24_1 to V24_4 are units of the control on serial lines (AX-1021)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from gateway.pure.languages.baps2 import demands
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.machine import Machine
from gateway.pure.languages.baps2.outside import Outside
from gateway.pure.languages.baps2.tasks import Task
from gateway.pure.languages.baps2.values import Array
from gateway.pure.languages.base.requests import PENDING, Request, RuntimeFault

PROTOCOL = -9  # CONDITION: bytes that are not a value of the type (L1983)


@dataclass(frozen=True, slots=True)
class Caller:
    """A process that uses a unit; stop: a fault of the interface ends it (without ;;SER_IO_STOP -)."""

    number: int
    priority: int
    stop: bool


@dataclass(frozen=True, slots=True)
class Form:
    """Type of one value: components of a point, elements of an array (0: none)."""

    base: str
    size: int = 0
    count: int = 0


@dataclass(frozen=True, slots=True)
class Got:
    """Result of a READ: CONDITION (0: no fault), its text, and the value."""

    condition: int
    words: str = ""
    value: object = None


@dataclass(frozen=True, slots=True)
class Failed:
    """A call of a process has failed while the program went on, or waits."""

    number: int
    unit: str
    condition: int
    words: str


class SerialUnits(Protocol):
    """The serial units of a control.  Calls return at once."""

    def has(self, unit: str) -> bool:
        """Whether a line is assigned to it."""

    def room(self, caller: Caller, unit: str) -> bool:
        """Whether this process may WRITE now; else it waits."""

    def write(self, caller: Caller, unit: str, items: Sequence[tuple[Form, object]], hold: bool) -> Got:
        """WRITE; hold: nothing is sent before a WRITE without.  Refused at once, or under way."""

    def read(self, caller: Caller, unit: str, form: Form) -> int:
        """READ of one value; a ticket."""

    def got(self, ticket: int) -> Got | None:
        """None: it has not come yet."""

    def condition(self, caller: Caller, unit: str) -> int | None:
        """CONDITION; None: an output of this process is under way."""

    def status(self, caller: Caller, unit: str) -> int:
        """CONDITION as it is now."""

    def begin(self, caller: Caller, unit: str, word: str) -> None:
        """READ_BEGIN, WRITE_BEGIN."""

    def end(self, caller: Caller, aborted: bool) -> None:
        """The process is over."""

    def turn(self, inputs: bytes) -> list[Failed]:
        """Moves bytes; `inputs`: RC inputs, which have the disable signals."""


class CellDevices(Outside):
    """With units on lines; a unit without one has no interface (-1), the PHG is the panel."""

    def __init__(self, machine: Machine, serial: SerialUnits) -> None:
        super().__init__(machine, seen=True)
        self.serial = serial
        self._tickets: dict[int, int] = {}  # process -> its READ

    def answer(self, task: Task, request: Request) -> object:
        """CONDITION waits for the outputs of its process."""
        if isinstance(request, demands.Condition) and not request.signal:
            name, is_device = self.place(task, request.unit)
            if is_device and self.serial.has(name):
                found = self.serial.condition(caller(task), name)
                return PENDING if found is None else found
        return super().answer(task, request)

    def condition(self, task: Task, request: demands.Condition) -> int:
        """In a condition that is waited for: as it is now."""
        name, is_device = self.place(task, request.unit) if not request.signal else ("", False)
        if is_device and self.serial.has(name):
            return self.serial.status(caller(task), name)
        return super().condition(task, request)

    def ended(self, task: Task, aborted: bool) -> None:
        """Its calls are dropped."""
        self._tickets.pop(task.process.number, None)
        self.serial.end(caller(task), aborted)

    def _read_device(self, task: Task, name: str, request: demands.ReadDevice) -> object:
        if not self.serial.has(name):
            return super()._read_device(task, name, request)
        number = task.process.number
        if number not in self._tickets:
            self._tickets[number] = self.serial.read(caller(task), name, Form(request.base, request.size, request.count))
        found = self.serial.got(self._tickets[number])
        if found is None:
            return PENDING
        del self._tickets[number]
        return found.value if self._sound(task, name, found) else None

    def _write_device(self, task: Task, name: str, request: demands.WriteDevice) -> object:
        if not self.serial.has(name):
            return super()._write_device(task, name, request)
        if not self.serial.room(caller(task), name):
            return PENDING
        items = [(form_of(base, value), plain(value)) for base, value in request.items]
        self._sound(task, name, self.serial.write(caller(task), name, items, request.open))
        return None

    def _clear(self, task: Task, name: str, word: str) -> None:
        if self.serial.has(name):
            self.serial.begin(caller(task), name, word)
        else:
            super()._clear(task, name, word)

    @staticmethod
    def _sound(task: Task, name: str, found: Got) -> bool:
        if found.condition and task.unit.program.head.serial_stop:
            raise fault_of(name, found.condition, found.words)
        return not found.condition


def fault_of(unit: str, condition: int, words: str) -> RuntimeFault:
    """The runtime error of a fault of an interface."""
    return fault(201) if condition == PROTOCOL else fault(212, f"{unit}: {words}")


def caller(task: Task) -> Caller:
    """The process of a task."""
    return Caller(task.process.number, task.process.priority, task.unit.program.head.serial_stop)


def form_of(base: str, value: object) -> Form:
    """Of a value that is written."""
    if isinstance(value, Array):
        first = value.items[0] if value.items else None
        return Form(base, len(first) if isinstance(first, tuple) else 0, len(value.items))
    return Form(base, len(value) if isinstance(value, tuple) else 0)


def plain(value: object) -> object:
    """Without the language's own array."""
    return list(value.items) if isinstance(value, Array) else value
