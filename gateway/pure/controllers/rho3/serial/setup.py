"""Who uses which serial line of a rho 3: functions, protocols, conditions, assignment.

Source: rho 3 Releases part 1, sections 7 to 9 (L1910-2280) and part 2, section 10 (READ_BEGIN/WRITE_BEGIN); what they leave open:
AX-160..179.
"""

from dataclasses import dataclass, field
from enum import Enum, IntEnum

from protocols.base.errors import ProtocolError
from protocols.base.machine import Ns, ms


class SetupError(ProtocolError):
    """An assignment that no control could have; the message names function, value and range."""


class Function(Enum):
    """What wants a serial line.  The first six share the lines (8); PHG and TTY are units of CONDITION (9.2)."""

    COUPLING = "COUPLING"  # to the programming unit
    PRINTING = "PRINTING"  # files or machine parameters
    V24_1 = "V24_1"
    V24_2 = "V24_2"
    V24_3 = "V24_3"
    V24_4 = "V24_4"
    PHG = "PHG"
    TTY = "TTY"


DISABLE_BITS = {  # RC inputs 13.1 to 13.6 (8.2); bit numbers by the address arithmetic
    Function.COUPLING: 112,
    Function.PRINTING: 113,
    Function.V24_1: 114,
    Function.V24_2: 115,
    Function.V24_3: 116,
    Function.V24_4: 117,
}
INFO_TEXTS = {  # as the INFO function shows them while the disable signal is 1 (L2835-2840)
    Function.COUPLING: "Disable coupling PG ",
    Function.PRINTING: "Disable printer ",
    Function.V24_1: "READ/WR. SER 1 disab",
    Function.V24_2: "READ/WR. SER 2 disab",
    Function.V24_3: "READ/WR. SER 3 disab.",
    Function.V24_4: "READ/WR. SER 4 disab",
}
DEVICES = (Function.V24_1, Function.V24_2, Function.V24_3, Function.V24_4, Function.PHG, Function.TTY)


class Procedure(IntEnum):
    """Protocol number of mode 9.1 / 7.8.3.  1, 3, 4 and 7 are not described; they are refused (AX-161)."""

    ECHO = 2
    NO_ECHO = 5
    PHG = 6
    LINK_3964R = 8


class Condition(IntEnum):
    """What CONDITION (STATUS, ZUSTAND) of a unit returns (9.2)."""

    NO_ERROR = 0
    NO_INTERFACE = -1
    OCCUPIED = -2
    TIME_OUT = -3
    PARITY = -4
    OVERRUN = -5
    FRAMING = -6
    INTERFACE = -7
    LENGTH = -8
    PROTOCOL = -9
    DEC_VALUE = -10
    POINT = -11


WORDS = {  # besides "Protocol error READ" (7.4) the manual prints no texts; these are the meanings of its table
    Condition.NO_INTERFACE: "No interface",
    Condition.OCCUPIED: "Interface occupied",
    Condition.TIME_OUT: "Time out",
    Condition.PARITY: "Parity error",
    Condition.OVERRUN: "Overrun error",
    Condition.FRAMING: "Framing error",
    Condition.INTERFACE: "General interface error",
    Condition.LENGTH: "Incorrect character string length",
    Condition.PROTOCOL: "Protocol error",
    Condition.DEC_VALUE: "Illegal DEC value",
    Condition.POINT: "Point not defined",
}


@dataclass(frozen=True, slots=True)
class Process:
    """A program under way.  priority: lower goes first; stop_on_error: False under `;;SER_IO_STOP -`."""

    number: int
    priority: int = 150
    stop_on_error: bool = True


SYSTEM = Process(0, -1, stop_on_error=False)  # coupling and the 3964R drivers: they claim a line before any program


@dataclass(frozen=True, slots=True)
class Assignment:
    """One function on one line (mode 9.1 or 7.8.3).  Times in ms."""

    function: Function
    line: str
    protocol: int = Procedure.NO_ECHO
    format: str = "9600 8E1"
    output_timeout_ms: int = 10_000  # with 3964R only the priority: -1 is without, all else with (7.1); 0: not watched
    input_timeout_ms: int | None = None  # None: READ waits for ever (AX-162)

    @property
    def permanent(self) -> bool:
        """Occupies its line for ever (8)."""
        return self.function is Function.COUPLING or self.protocol == Procedure.LINK_3964R

    @property
    def output_limit(self) -> Ns | None:
        return ms(self.output_timeout_ms) if self.output_timeout_ms > 0 else None

    @property
    def input_limit(self) -> Ns | None:
        return None if self.input_timeout_ms is None else ms(self.input_timeout_ms)


@dataclass(frozen=True, slots=True)
class Setup:
    """The serial lines of a control.  Raise SetupError for an invalid setting; a line that is not in `lines` is legal: -1 at run time."""

    assignments: tuple[Assignment, ...]
    lines: tuple[str, ...] = ("SER_1", "SER_2", "SER_3", "SER_4", "PHG")  # those physically there
    panel: str | None = "PHG"  # the line of the user interface; None: no PHG is plugged, the port is like any other (part 3, 2.5)
    low_byte_first: bool = True  # option: byte sequence of INTEGER and REAL (7.2)
    version: int = 5  # TO01.. = 1.., decides on READ_BEGIN and WRITE_BEGIN (part 2, 10.5)
    files_option: bool = True
    chunk: int = 8  # characters passed to the interface at a time; they cannot be taken back (AX-163)
    fifo: int = 256  # characters kept while no program reads; one more is an overrun (AX-163)
    line_end: bytes = b""  # what a WRITE of protocols 2, 5, 6 adds when it does not end in `..` (AX-164)
    by_function: dict[Function, Assignment] = field(init=False, repr=False, compare=False, default_factory=dict)

    def __post_init__(self) -> None:
        if self.chunk < 1 or self.fifo < 1:
            raise SetupError(f"chunk {self.chunk}, fifo {self.fifo}: at least 1 character each")
        for one in self.assignments:
            self._take(one)
        if self.panel is not None and self.panel in self.lines:
            self.by_function.setdefault(Function.PHG, Assignment(Function.PHG, self.panel, Procedure.PHG))

    def _take(self, one: Assignment) -> None:
        legal = [int(known) for known in Procedure]
        if one.protocol not in legal:
            raise SetupError(f"{one.function.value}: protocol {one.protocol}; the manual describes {legal} only (AX-161)")
        if one.function in self.by_function:
            raise SetupError(f"{one.function.value}: assigned to {self.by_function[one.function].line} and to {one.line}")
        if one.function is Function.PHG and one.protocol != Procedure.PHG:
            raise SetupError(f"PHG: protocol {one.protocol}; the unit PHG speaks 6")
        if one.function in (Function.PRINTING, Function.TTY) and one.protocol == Procedure.LINK_3964R:
            raise SetupError(f"{one.function.value}: protocol 8 is for V24_1 to V24_4")
        self.by_function[one.function] = one
