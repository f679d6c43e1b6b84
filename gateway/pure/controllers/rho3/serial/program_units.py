"""The units of a control as BAPS2 programs of a cell use them: the language's values and those of the LineManager (AX-1021).  Pure: a
loop gives the manager, the time and the events of its lines.
"""

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

from gateway.pure.controllers.rho3.serial.baps import BapsType, Item, ItemError, Kind, Value, array, as_text
from gateway.pure.controllers.rho3.serial.events import Event, Finished, ProgramAborted
from gateway.pure.controllers.rho3.serial.manager import LineManager
from gateway.pure.controllers.rho3.serial.setup import DISABLE_BITS, WORDS, Condition, Function, Process, Setup
from gateway.pure.languages.baps2.cell_devices import Caller, Failed, Form, Got
from gateway.pure.languages.baps2.types import CODE_PAGE
from protocols.base.machine import Ns

R = TypeVar("R")
KINDS = {
    "BINARY": Kind.BINARY, "CHAR": Kind.CHARACTER, "INTEGER": Kind.INTEGER, "REAL": Kind.REAL, "TEXT": Kind.TEXT, "POINT": Kind.POINT,
    "JC_POINT": Kind.JC_POINT,
}  # fmt: skip
DISABLING = sorted({bit // 8 for bit in DISABLE_BITS.values()})  # RC input bytes
POINTS = (Kind.POINT, Kind.JC_POINT)
UNITS = (Function.V24_1, Function.V24_2, Function.V24_3, Function.V24_4)
NO_PRIORITY = 150  # of a program without ;;PROC_PRIO


class Do(Protocol):
    """Makes a call with the manager and the time, then moves bytes."""

    def __call__(self, action: Callable[[LineManager, Ns], R], /) -> R: ...


class ProgramUnits:
    """Every event of the lines comes to `hear`; step: moves bytes."""

    def __init__(self, setup: Setup, do: Do, step: Callable[[], None] = lambda: None) -> None:
        self._do, self._step = do, step
        self._units = {function.value for function in setup.by_function if function in UNITS}
        self._reads: dict[int, tuple[BapsType, Finished | None]] = {}
        self._at_once: dict[int, Finished] = {}  # outputs and inputs that ended during the present call
        self._failed: list[Failed] = []
        self._inputs = b""
        self._refusals = 0  # READs that no line could serve have tickets below 0

    def hear(self, event: Event, now: Ns) -> None:
        """Of any line."""
        if isinstance(event, Finished):
            self._at_once[event.ticket] = event
            if event.ticket in self._reads:
                self._reads[event.ticket] = self._reads[event.ticket][0], event
        elif isinstance(event, ProgramAborted):
            code = int(event.condition) if event.condition is not None else int(Condition.INTERFACE)
            self._failed.append(Failed(event.process, event.device.value, code, event.text))

    # ---- calls

    def has(self, unit: str) -> bool:
        """Whether a line is assigned to it."""
        return unit in self._units

    def room(self, caller: Caller, unit: str) -> bool:
        """Whether this process may WRITE now."""
        return self._do(lambda manager, now: manager.room(process_of(caller), unit))

    def write(self, caller: Caller, unit: str, items: Sequence[tuple[Form, object]], hold: bool) -> Got:
        """WRITE; a condition where it is refused at once."""
        try:
            sent = [item_of(form, value) for form, value in items]
        except ItemError as error:
            return Got(int(error.condition), WORDS[error.condition])
        self._at_once.clear()
        ticket = self._do(lambda manager, now: manager.write(process_of(caller), unit, sent, now, hold))
        found = self._at_once.get(ticket)
        if found is not None and found.condition:
            self._failed = [each for each in self._failed if each.number != caller.number]  # this call reports it
            return Got(int(found.condition), WORDS[found.condition])
        return Got(0)

    def read(self, caller: Caller, unit: str, form: Form) -> int:
        """READ of one value; a ticket."""
        try:
            kind = type_of(form)
        except ItemError as error:
            self._refusals -= 1
            self._reads[self._refusals] = BapsType(Kind.BINARY), Finished(self._refusals, error.condition)
            return self._refusals
        self._at_once.clear()
        ticket = self._do(lambda manager, now: manager.read(process_of(caller), unit, [kind], now))
        self._reads[ticket] = kind, self._at_once.get(ticket)
        return ticket

    def got(self, ticket: int) -> Got | None:
        """None: it has not come yet."""
        kind, finished = self._reads[ticket]
        if finished is None:
            return None
        del self._reads[ticket]
        condition = finished.condition
        if condition or not finished.values:
            return Got(int(condition), WORDS.get(condition, ""))
        return Got(0, "", value_of(kind, finished.values[0]))

    def condition(self, caller: Caller, unit: str) -> int | None:
        """CONDITION; None: an output of this process is under way."""
        found = self._do(lambda manager, now: manager.condition(process_of(caller), unit))
        return None if found is None else int(found)

    def status(self, caller: Caller, unit: str) -> int:
        """CONDITION as it is now."""
        return int(self._do(lambda manager, now: manager.status(process_of(caller), unit)))

    def begin(self, caller: Caller, unit: str, word: str) -> None:
        """READ_BEGIN, WRITE_BEGIN."""

        def clear(manager: LineManager, now: Ns) -> None:
            (manager.read_begin if word == "READ_BEGIN" else manager.write_begin)(process_of(caller), unit, now)

        self._do(clear)

    def end(self, caller: Caller, aborted: bool) -> None:
        """The process is over."""
        self._do(lambda manager, now: manager.end_process(process_of(caller), aborted, now))

    def turn(self, inputs: bytes) -> list[Failed]:
        """Moves bytes; `inputs`: RC inputs, which have the disable signals."""
        seen = bytes(inputs[byte] if byte < len(inputs) else 0 for byte in DISABLING)
        if seen != self._inputs:
            self._inputs = seen
            self._do(lambda manager, now: manager.rc_inputs(inputs, now))
        self._step()
        failed, self._failed = self._failed, []
        return failed


def process_of(caller: Caller) -> Process:
    """As the lines know a program."""
    return Process(caller.number, caller.priority or NO_PRIORITY, caller.stop)


def type_of(form: Form) -> BapsType:
    """Of the language's form; ItemError for an array that cannot be sent."""
    kind = KINDS[form.base]
    one = BapsType(kind, form.size if kind in POINTS else 0)
    return array(one, form.count) if form.count else one


def item_of(form: Form, value: object) -> Item:
    """A value to write; ItemError."""
    kind = type_of(form)
    return kind, tuple(sent(kind.kind, each) for each in value) if isinstance(value, list) else sent(kind.kind, value)


def sent(kind: Kind, value: object) -> Value:
    """One value of the language as the lines send it."""
    if kind is Kind.TEXT:
        return str(value).encode(CODE_PAGE, "replace")
    if kind is Kind.CHARACTER:
        return (str(value).encode(CODE_PAGE, "replace") or b"\0")[0]
    if isinstance(value, tuple):
        return tuple(float(each) if isinstance(each, int | float) else None for each in value)
    return value if isinstance(value, int | float) else None


def value_of(kind: BapsType, value: Value) -> object:
    """One value that was read, as the language has it."""
    if kind.length and isinstance(value, tuple):
        return [value_of(kind.element, each) for each in value]
    if isinstance(value, bytes):
        return as_text(value).decode(CODE_PAGE)
    if kind.kind is Kind.CHARACTER and isinstance(value, int):
        return bytes((value,)).decode(CODE_PAGE)
    return int(value) if isinstance(value, bool) else value
