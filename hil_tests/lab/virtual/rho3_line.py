"""A rho 3 with one line under test, on the bench: programs' calls, disable signals, and what the line sends and reports.

An exception in a call is a failed assertion, as on every Bench.
"""

from collections.abc import Callable
from typing import TypeVar

from gateway.pure.controllers.rho3.serial.baps import BapsType, Item, Value
from gateway.pure.controllers.rho3.serial.events import Event, Finished, LinkReport
from gateway.pure.controllers.rho3.serial.line import Line
from gateway.pure.controllers.rho3.serial.manager import LineManager
from gateway.pure.controllers.rho3.serial.setup import Assignment, Condition, Function, Process, Setup
from hil_tests.lab.virtual.bench import Bench
from protocols.base.machine import Damage, Ns
from protocols.p3964r.characters import wire_block

R = TypeVar("R")
STX, DLE, NAK = b"\x02", b"\x10", b"\x15"
ONE, TWO, THREE = (Process(number, 100 + number, stop_on_error=False) for number in (1, 2, 3))  # ONE goes before TWO


def wire(data: bytes) -> bytes:
    """Return a block as it is sent on the line."""
    return bytes(wire_block(data, True))


class ManagedLine:
    """The bench copies machines; a line that carries its manager is copied with it."""

    def __init__(self, manager: LineManager, line: Line) -> None:
        self.manager, self._line = manager, line
        self.answers: dict[str, object] = {}

    def receive(self, data: bytes, now: Ns) -> list[Event]:
        return self._line.receive(data, now)

    def damaged(self, kind: Damage, now: Ns) -> list[Event]:
        return self._line.damaged(kind, now)

    def sent(self, now: Ns) -> list[Event]:
        return self._line.sent(now)

    def wake(self, now: Ns) -> list[Event]:
        return self._line.wake(now)

    def deadline(self) -> Ns | None:
        return self._line.deadline()

    def take_output(self) -> bytes:
        return self._line.take_output()

    def lost(self, now: Ns) -> list[Event]:
        return self._line.lost(now)


class InterfaceBench(Bench[ManagedLine]):
    """`desk.at(0).write(ONE, "V24_1", (INTEGER, 1)).says(...)`; reports() leaves link reports of the driver out unless asked for."""

    def __init__(self, setup: Setup, line: str = "SER_1", rc_inputs: bytes = b"", leaves_at_once: bool = True) -> None:
        manager = self.made(setup, rc_inputs)
        super().__init__(ManagedLine(manager, manager.lines[line]), leaves_at_once)

    # ---- as on every bench, for chains of ours
    def at(self, now: Ns) -> "InterfaceBench":
        super().at(now)
        return self

    def hears(self, data: bytes) -> "InterfaceBench":
        super().hears(data)
        return self

    def says(self, expected: bytes) -> "InterfaceBench":
        super().says(expected)
        return self

    def damaged(self, kind: Damage) -> "InterfaceBench":
        super().damaged(kind)
        return self

    def left(self) -> "InterfaceBench":
        super().left()
        return self

    def loses_the_port(self) -> "InterfaceBench":
        super().loses_the_port()
        return self

    # ---- calls of programs, signals
    @staticmethod
    def made(setup: Setup, rc_inputs: bytes = b"") -> LineManager:
        """Control start."""
        return LineManager(setup, rc_inputs)

    def write(self, process: Process, device: str | None, *items: Item, hold: bool = False) -> "InterfaceBench":
        self.does(lambda line, now: line.manager.write(process, device, items, now, hold))
        return self

    def read(self, process: Process, device: str | None, *variables: BapsType) -> "InterfaceBench":
        self.does(lambda line, now: line.manager.read(process, device, variables, now))
        return self

    def prints(self, data: bytes, process: Process = TWO) -> "InterfaceBench":
        self.does(lambda line, now: line.manager.print_out(process, data, now))
        return self

    def disables(self, function: Function, disabled: bool = True) -> "InterfaceBench":
        self.does(lambda line, now: line.manager.set_disable(function, disabled, now))
        return self

    def rc_byte_14(self, value: int) -> "InterfaceBench":
        """The byte that holds the six disable signals."""
        self.does(lambda line, now: line.manager.rc_inputs(bytes(14) + bytes((value,)), now))
        return self

    def write_begin(self, process: Process, device: str | None) -> "InterfaceBench":
        self.does(lambda line, now: line.manager.write_begin(process, device, now))
        return self

    def read_begin(self, process: Process, device: str | None) -> "InterfaceBench":
        self.does(lambda line, now: line.manager.read_begin(process, device, now))
        return self

    def ends(self, process: Process, aborted: bool = True) -> "InterfaceBench":
        self.does(lambda line, now: line.manager.end_process(process, aborted, now))
        return self

    def asked(self, question: Callable[[LineManager], R]) -> R:
        """What the manager answers; no time passes."""
        return question(self.machine.manager)

    def condition(self, process: Process, device: str | None) -> Condition | None:
        """CONDITION(device)."""
        return self.asked(lambda manager: manager.condition(process, device))

    def finds(self, *expected: Event) -> "InterfaceBench":
        """As reports(), without what the driver counts."""
        told = [event for event in self.told() if not isinstance(event, LinkReport)]
        assert told == list(expected), f"reports {told}, expected {list(expected)}"
        return self

    def heard_from(self) -> bytes:
        """Return what the line has sent since the last question, for callers with a comparison of their own."""
        said = [bytes(twin.said) for twin in self._twins]
        for twin in self._twins:
            twin.said.clear()
        assert said[0] == said[1]
        return said[0]

    def acknowledges(self, data: bytes) -> "InterfaceBench":
        """We send this block, the partner takes it."""
        self.says(STX)
        self.hears(DLE).says(wire(data))
        self.hears(DLE)
        return self

    def gets(self, data: bytes) -> "InterfaceBench":
        """The partner sends this block, we take it."""
        self.hears(STX).says(DLE)
        self.hears(wire(data)).says(DLE)
        return self


def v24_1(
    protocol: int, line: str = "SER_1", format: str = "9600 8E1", output_timeout_ms: int = 10_000, input_timeout_ms: int | None = None
) -> Assignment:
    """V24_1, usually on SER_1."""
    return Assignment(Function.V24_1, line, protocol, format, output_timeout_ms, input_timeout_ms)


def on(function: str, protocol: int = 5, line: str = "SER_1", format: str = "9600 8E1") -> Assignment:
    """Any function on a line."""
    return Assignment(Function(function), line, protocol, format)


def done(ticket: int, *values: Value) -> Finished:
    """A call that ended well."""
    return Finished(ticket, Condition.NO_ERROR, tuple(values))


def failed(ticket: int, condition: Condition, *values: Value) -> Finished:
    """A call that did not."""
    return Finished(ticket, condition, tuple(values))


def deleted(ticket: int) -> Finished:
    """A call taken back."""
    return Finished(ticket, Condition.NO_ERROR, (), True)
