"""LineManager: the serial devices of a rho 3 as a program interpreter uses them.  Pure; a loop moves the bytes of each Line.

Source: rho 3 Releases part 1, sections 7 to 9; part 2, section 10; decisions AX-160..179.  The guide: docs/guide/rho3-lines.md.
"""

from collections.abc import Sequence

from gateway.pure.controllers.rho3.serial.baps import BapsType, Item, ItemError, pack
from gateway.pure.controllers.rho3.serial.driver import Driver
from gateway.pure.controllers.rho3.serial.events import DriverNotStarted, Event
from gateway.pure.controllers.rho3.serial.line import Line
from gateway.pure.controllers.rho3.serial.line_interface import LineInterface
from gateway.pure.controllers.rho3.serial.setup import (
    DEVICES,
    DISABLE_BITS,
    INFO_TEXTS,
    Assignment,
    Condition,
    Function,
    Procedure,
    Process,
    Setup,
)
from gateway.pure.controllers.rho3.serial.textual import to_text
from protocols.base.errors import ProtocolError
from protocols.base.machine import Ns

MOST_OUTPUTS = 16  # of one process on one unit; the interpreter lets the program wait (AX-171)
MOST_HELD = 4096  # characters held back by `..`


class DeviceError(ProtocolError):
    """A name that is not a unit, or a call that the interpreter must not make now."""


class LineManager:
    """Functions of a control on its lines.

    Calls return at once with a ticket; the events of the lines' methods report how they end (Finished names the ticket).
    """

    def __init__(self, setup: Setup, rc_inputs: bytes = b"", now: Ns = 0) -> None:
        self.setup = setup
        self._interface = LineInterface()
        self._interface.on_abort = self._aborted
        self.lines = {name: Line(name, setup, self._interface) for name in setup.lines}
        self._disabled = {function for function in DISABLE_BITS if _bit(rc_inputs, function)}
        self._absent: dict[Function, Condition] = {}  # what units without a running driver answer
        self._held: dict[tuple[int, Function], bytes] = {}
        self._files: dict[tuple[int, str], Function] = {}
        self._start(now)

    # ---- WRITE, READ, CONDITION
    def write(self, process: Process, device: str | None, items: Sequence[Item], now: Ns, hold: bool = False) -> int:
        """WRITE device, items; hold: it ends in `..`, nothing is sent before a WRITE without.  0 when held without error, else a ticket.

        Raises DeviceError where `room` refuses.
        """
        function = self.function(process, device)
        if not self.room(process, device):
            raise DeviceError(f"{function.value}: process {process.number} has {MOST_OUTPUTS} outputs waiting; ask room() first")
        key = (process.number, function)
        refused = self._refusal(function)
        try:
            data = self._held.pop(key, b"") + b"".join(self._encode(function, item) for item in items)
        except ItemError as error:
            refused, data = refused or error.condition, b""
        refused = refused or self._too_long(function, data)
        if hold and not refused:
            self._held[key] = data
            return 0
        if self._protocol(function) is not Procedure.LINK_3964R:
            data += self.setup.line_end
        return self._call(process, function, now, refused, data)

    def read(self, process: Process, device: str | None, variables: Sequence[BapsType], now: Ns) -> int:
        """READ device, variables: the line is had for one variable at a time."""
        function = self.function(process, device)
        if not variables:
            raise DeviceError(f"READ {function.value}: at least one variable")
        return self._call(process, function, now, self._refusal(function), wanted=variables)

    def print_out(self, process: Process, data: bytes, now: Ns) -> int:
        """Print (a piece of) a file or the machine parameters."""
        return self._call(process, Function.PRINTING, now, self._refusal(Function.PRINTING), data)

    def condition(self, process: Process, device: str | None) -> Condition | None:
        """CONDITION(device), STATUS(device): None while an output of this process is under way; ask again after the next Finished."""
        function = self.function(process, device)
        return None if self._interface.outputs(process, function) else self.status(process, device)

    def status(self, process: Process, device: str | None) -> Condition:
        """What CONDITION would return, without waiting; an absent unit is reported even before the first call."""
        function = self.function(process, device)
        absent = self._absent.get(function, Condition.NO_ERROR)
        return self._interface.status.get((process.number, function), absent)

    def room(self, process: Process, device: str | None) -> bool:
        """Whether this process may WRITE now; if not, the interpreter lets it wait for a Finished."""
        return self._interface.outputs(process, self.function(process, device)) < MOST_OUTPUTS

    # ---- READ_BEGIN, WRITE_BEGIN (part 2, section 10)
    def write_begin(self, process: Process, device: str | None, now: Ns, line: int | None = None) -> None:
        """Delete prepared outputs of this process; STATUS 0.  The line number is ignored (10.2)."""
        function = self.function(process, device)
        if self._begins(process, function, now):
            self._held.pop((process.number, function), None)
            self._interface.status[process.number, function] = Condition.NO_ERROR
            place, driver = self._place(function)
            if driver is not None:
                driver.write_begin(process, now)
            elif place is not None:
                place.write_begin(process, function, now)

    def read_begin(self, process: Process, device: str | None, now: Ns, line: int | None = None) -> None:
        """Delete characters not yet read; STATUS 0.  The line number is ignored (10.2)."""
        function = self.function(process, device)
        if self._begins(process, function, now):
            self._interface.status[process.number, function] = Condition.NO_ERROR
            place, driver = self._place(function)
            if driver is not None:
                driver.read_begin(now)
            elif place is not None:
                place.read_begin(process)

    def assign(self, process: Process, file: str, unit: str) -> None:
        """ASSIGN file, unit: blanks and the dot after the unit's name are extension.  Raise DeviceError."""
        self._files[process.number, file] = _device(unit)

    def function(self, process: Process, device: str | None) -> Function:
        """Of a unit's name or an assigned file variable; None is the PHG (10.2).  Raises DeviceError."""
        if device is None:
            return Function.PHG
        known = self._files.get((process.number, device))
        return known if known is not None else _device(device)

    # ---- coupling and user interface
    def couple(self, data: bytes) -> bool:
        """Answer the programming unit; False while the coupling does not have its line."""
        place, _ = self._place(Function.COUPLING)
        return place is not None and place.say(data, Function.COUPLING)

    def display(self, data: bytes) -> bool:
        """Output of the user interface; False while it is stopped: draw anew at UserInterfaceResumed."""
        panel = self.lines.get(self.setup.panel or "")
        return panel is not None and panel.say(data, None)

    # ---- disable signals
    def rc_inputs(self, image: bytes, now: Ns) -> None:
        """The RC inputs, bit N at byte N div 8; each change of bits 112 to 117 acts."""
        for function in DISABLE_BITS:
            self.set_disable(function, _bit(image, function), now)

    def set_disable(self, function: Function, disabled: bool, now: Ns) -> None:
        """One disable signal; nothing happens unless it changes (8.2)."""
        if disabled == (function in self._disabled):
            return
        place, _ = self._place(function)
        if disabled:
            self._disabled.add(function)
            if place is not None:
                place.disable(function, now)
        else:
            self._disabled.remove(function)
            if place is not None and function not in self._absent and self.setup.by_function[function].permanent:
                place.submit(self._interface.claim(function), now)

    def info(self) -> list[str]:
        """Texts of the INFO function, one for each disable signal that is 1 (8.4)."""
        return [text for function, text in INFO_TEXTS.items() if function in self._disabled]

    def owner(self, line: str) -> Function | None:
        """The function that has this line now."""
        job = self.lines[line].owner
        return None if job is None else job.function

    # ---- programs
    def end_process(self, process: Process, aborted: bool, now: Ns) -> None:
        """The program has ended.  aborted: its outputs, and the rest of a block it began to read, are deleted (7.5)."""
        for key in [key for key in self._held if key[0] == process.number]:
            del self._held[key]
        for file in [file for file in self._files if file[0] == process.number]:
            del self._files[file]
        self._drop(process, aborted, now)
        for status in [status for status in self._interface.status if status[0] == process.number]:
            del self._interface.status[status]

    def take_events(self) -> list[Event]:
        """For a control without lines; else the methods of the lines report them."""
        return self._interface.take_events()

    # ---- inside
    def _start(self, now: Ns) -> None:
        """Control start: the coupling first, then the drivers of V24_1 to V24_4 (AX-166)."""
        for function in (Function.COUPLING, *DEVICES):
            assignment = self.setup.by_function.get(function)
            if assignment is None:
                if function is not Function.COUPLING:
                    self._absent[function] = Condition.NO_INTERFACE
                continue
            if assignment.line not in self.lines:
                self._absent[function] = Condition.NO_INTERFACE
            elif assignment.permanent and self.lines[assignment.line].owner is not None and function not in self._disabled:
                self._absent[function] = Condition.OCCUPIED
            elif assignment.permanent:
                self._start_permanent(assignment, now)
            if function in self._absent and assignment.protocol == Procedure.LINK_3964R:
                self._interface.report(DriverNotStarted(function, self._absent[function]), now)

    def _start_permanent(self, assignment: Assignment, now: Ns) -> None:
        place, function = self.lines[assignment.line], assignment.function
        if function is not Function.COUPLING:
            place.drivers[function] = Driver(assignment, self.setup, self._interface)
        if function not in self._disabled:
            place.submit(self._interface.claim(function), now)

    def _place(self, function: Function) -> tuple[Line | None, Driver | None]:
        assignment = self.setup.by_function.get(function)
        place = self.lines.get(assignment.line) if assignment is not None else None
        return place, None if place is None else place.drivers.get(function)

    def _protocol(self, function: Function) -> Procedure | None:
        assignment = self.setup.by_function.get(function)
        return None if assignment is None else Procedure(assignment.protocol)

    def _encode(self, function: Function, item: Item) -> bytes:
        if self._protocol(function) is Procedure.LINK_3964R:
            return pack(*item, self.setup.low_byte_first)
        return to_text(*item)

    def _too_long(self, function: Function, data: bytes) -> Condition:
        _, driver = self._place(function)
        most = MOST_HELD if driver is None else driver.link.profile.max_data
        return Condition.LENGTH if len(data) > most else Condition.NO_ERROR

    def _refusal(self, function: Function) -> Condition:
        """Why a call is not executed."""
        if function in self._disabled:
            return Condition.OCCUPIED
        if self._place(function)[0] is None:
            return Condition.NO_INTERFACE
        return self._absent.get(function, Condition.NO_ERROR)

    def _call(
        self, process: Process, function: Function, now: Ns, refused: Condition, data: bytes = b"", wanted: Sequence[BapsType] = ()
    ) -> int:
        job = self._interface.open(process, function, data, wanted)
        place, driver = self._place(function)
        if refused or place is None or not (data or wanted):
            self._interface.finish(job, refused, now)
        elif driver is not None:
            driver.submit(job, now)
        else:
            place.submit(job, now)
        return job.ticket

    def _begins(self, process: Process, function: Function, now: Ns) -> bool:
        """Whether this version knows the two commands (10.5)."""
        if self.setup.version >= 5:
            return True
        if not self.setup.files_option:
            self._interface.stop(process, function, None, "option not found", now)
        elif self.setup.version <= 3:
            self._interface.stop(process, function, None, "system error 83: invalid device address", now)
        return False

    def _drop(self, process: Process, aborted: bool, now: Ns) -> None:
        for place in self.lines.values():
            for driver in place.drivers.values():
                driver.drop(process, aborted, now)
            place.drop(process, aborted, now)

    def _aborted(self, process: Process, now: Ns) -> None:
        """Keep the status until end_process, so that the abort can be shown."""
        self._held = {key: data for key, data in self._held.items() if key[0] != process.number}
        self._drop(process, True, now)


def _bit(image: bytes, function: Function) -> bool:
    octet, bit = divmod(DISABLE_BITS[function], 8)
    return octet < len(image) and bool(image[octet] >> bit & 1)


def _device(name: str) -> Function:
    plain = name.strip().rstrip(". ").upper()
    for function in DEVICES:
        if function.value == plain:
            return function
    raise DeviceError(f"{name!r}: no unit; {', '.join(one.value for one in DEVICES)}")
