"""What the serial devices of a rho 3 report: to the interpreter, the user interface and displays of the lines."""

from dataclasses import dataclass

from gateway.pure.controllers.rho3.serial.baps import Value
from gateway.pure.controllers.rho3.serial.setup import Condition, Function
from protocols.p3964r.events import Event as LinkEvent


@dataclass(frozen=True, slots=True)
class Finished:
    """A READ, WRITE or print is over.  values: of a READ, those read before an error too; deleted: by WRITE_BEGIN or an abort."""

    ticket: int
    condition: Condition
    values: tuple[Value, ...] = ()
    deleted: bool = False


@dataclass(frozen=True, slots=True)
class ProgramAborted:
    """A program without `;;SER_IO_STOP -` met an I/O error (9.1), or any program a system error; its open calls are dropped."""

    process: int
    device: Function
    condition: Condition | None  # None: a system error
    text: str


@dataclass(frozen=True, slots=True)
class UserInterfaceStopped:
    """Protocol 6 needs the PHG (8.1)."""

    line: str


@dataclass(frozen=True, slots=True)
class UserInterfaceResumed:
    """Protocol 6 is done with it."""

    line: str


@dataclass(frozen=True, slots=True)
class KeyInput:
    """Characters of the PHG for the user interface."""

    line: str
    data: bytes


@dataclass(frozen=True, slots=True)
class CouplingInput:
    """Characters of the programming unit."""

    line: str
    data: bytes


@dataclass(frozen=True, slots=True)
class DriverNotStarted:
    """Protocol 8 on a line that is absent (-1) or taken (-2) at control start; what its unit answers from now on (7.5)."""

    device: Function
    condition: Condition


@dataclass(frozen=True, slots=True)
class FormatWanted:
    """The line has a new owner with another rate or format: open the port anew, then call `Line.reopened` (8.2)."""

    line: str
    format: str


@dataclass(frozen=True, slots=True)
class LinkReport:
    """What the 3964R driver of a device saw, for counting."""

    device: Function
    event: LinkEvent


Event = (
    Finished
    | ProgramAborted
    | UserInterfaceStopped
    | UserInterfaceResumed
    | KeyInput
    | CouplingInput
    | DriverNotStarted
    | FormatWanted
    | LinkReport
)
