"""One physical line: who owns it, who waits, what comes and goes.  A byte machine.

Source: rho 3 Releases part 1, section 8; part 3, section 2.5 (PHG port); what they leave open: AX-160..165.
"""

from collections import deque

from gateway.pure.controllers.rho3.serial.baps import ItemError
from gateway.pure.controllers.rho3.serial.driver import OF_DAMAGE, Driver
from gateway.pure.controllers.rho3.serial.events import (
    CouplingInput,
    Event,
    FormatWanted,
    KeyInput,
    UserInterfaceResumed,
    UserInterfaceStopped,
)
from gateway.pure.controllers.rho3.serial.line_interface import Job, LineInterface, earliest, first
from gateway.pure.controllers.rho3.serial.setup import Assignment, Condition, Function, Procedure, Process, Setup
from gateway.pure.controllers.rho3.serial.textual import ItemReader
from protocols.base.machine import Damage, Ns

MOST_WAITING = 4096  # characters of user interface or coupling that the port has not taken


class Line:
    """SER_1 .. SER_4 or the PHG port.  Its seven methods report the events of the entire control, in order."""

    def __init__(self, name: str, setup: Setup, interface: LineInterface) -> None:
        self.name = name
        self.drivers: dict[Function, Driver] = {}
        self.owner: Job | None = None
        self.waiting: list[Job] = []
        self._setup, self._interface = setup, interface
        formats = [one.format for one in setup.by_function.values() if one.line == name]
        self.format = formats[0] if formats else "9600 8E1"  # the port's rate and format now
        self._panel = setup.panel == name
        self._stopped = False  # the user interface
        self._reopening = False
        self._fifo: deque[int | Damage] = deque()
        self._reader: ItemReader | None = None
        self._out = bytearray()

    # ---- for the manager
    def submit(self, job: Job, now: Ns) -> None:
        """Queue a call, or the claim of a permanent function."""
        self.waiting.append(job)
        self._turn(now)

    def disable(self, function: Function, now: Ns) -> None:
        """0 -> 1: whatever this function has under way ends (8.2)."""
        gone = [job for job in self.waiting if job.function is function]
        self.waiting = [job for job in self.waiting if job.function is not function]
        if self.owner is not None and self.owner.function is function:
            gone.insert(0, self.owner)
            self._release()
        for job in gone:
            if not job.permanent:
                self._interface.finish(job, Condition.INTERFACE, now)
        if function in self.drivers:
            self.drivers[function].suspend(now)
        self._turn(now)

    def write_begin(self, process: Process, function: Function, now: Ns) -> None:
        """Outputs of this process are deleted, the running one as far as it was not given out (10.3)."""
        if self._writing(process, function) and self.owner is not None:
            job = self.owner
            self._release()
            self._interface.delete(job, now)
        for job in [job for job in self.waiting if job.process == process and job.function is function and not job.wanted]:
            self.waiting.remove(job)
            self._interface.delete(job, now)
        self._turn(now)

    def read_begin(self, process: Process) -> None:
        """Characters are deleted only while no other process has the line (10.4)."""
        if self.owner is None or self.owner.process == process:
            self._fifo.clear()

    def drop(self, process: Process, aborted: bool, now: Ns) -> None:
        """Drop an ended program; its outputs continue unless it was aborted."""
        gone = [job for job in self.waiting if job.process == process and (aborted or job.wanted)]
        self.waiting = [job for job in self.waiting if job not in gone]
        if self.owner is not None and self.owner.process == process and (aborted or self.owner.wanted):
            gone.append(self.owner)
            self._release()
        for job in gone:
            self._interface.delete(job, now)
        self._turn(now)

    def say(self, data: bytes, function: Function | None) -> bool:
        """Characters of the coupling, or (None) of the user interface; False while it does not have the line."""
        allowed = self._panel and self.owner is None if function is None else self.owner is not None and self.owner.function is function
        if not allowed or len(self._out) + len(data) > MOST_WAITING:
            return False
        self._out += data
        return True

    def reopened(self, now: Ns) -> None:
        """The port has the format that FormatWanted named."""
        self._reopening = False

    # ---- the machine
    def receive(self, data: bytes, now: Ns) -> list[Event]:
        self._expire(now)
        if self.owner is not None and self.owner.permanent:
            self._deliver(data, now)
        elif self.owner is None and self._panel:
            self._interface.report(KeyInput(self.name, data), now)
        else:
            for byte in data:
                self._store(byte)
            self._turn(now)
        return self._interface.take_events()

    def damaged(self, kind: Damage, now: Ns) -> list[Event]:
        self._expire(now)
        driver = self._driver
        if driver is not None:
            driver.damaged(kind, now)
        elif self.owner is None or not self.owner.permanent:
            if self.owner is not None or not self._panel:
                self._store(kind)
            self._turn(now)
        return self._interface.take_events()

    def sent(self, now: Ns) -> list[Event]:
        if self._driver is not None:
            self._driver.sent(now)
        elif not self._out and self.owner is not None and not self.owner.wanted and not self.owner.permanent:
            self._load(self.owner, now)
            self._turn(now)
        return self._interface.take_events()

    def wake(self, now: Ns) -> list[Event]:
        self._expire(now)
        return self._interface.take_events()

    def deadline(self) -> Ns | None:
        if self._interface.events:
            return self._interface.reported_at
        return earliest(self.owner.due if self.owner else None, *(driver.deadline() for driver in self.drivers.values()))

    def take_output(self) -> bytes:
        if self._reopening:
            return b""
        output = bytes(self._out)
        self._out.clear()
        return output + (self._driver.take_output() if self._driver is not None else b"")

    def lost(self, now: Ns) -> list[Event]:
        if self._reopening:  # closed by us, to be opened with another format
            return self._interface.take_events()
        self._out.clear()
        if self._driver is not None:
            self._driver.lost(now)
        elif self.owner is not None and not self.owner.permanent:
            self._end(Condition.INTERFACE, now)
        return self._interface.take_events()

    # ---- inside
    @property
    def _driver(self) -> Driver | None:
        return self.drivers.get(self.owner.function) if self.owner is not None and self.owner.permanent else None

    def _writing(self, process: Process, function: Function) -> bool:
        owner = self.owner
        return owner is not None and owner.process == process and owner.function is function and not owner.wanted

    def _assignment(self, job: Job) -> Assignment:
        return self._setup.by_function[job.function]

    def _deliver(self, data: bytes, now: Ns) -> None:
        if self._driver is not None:
            self._driver.receive(data, now)
        else:
            self._interface.report(CouplingInput(self.name, data), now)

    def _store(self, item: int | Damage) -> None:
        if len(self._fifo) < self._setup.fifo:
            self._fifo.append(item)
        elif self._fifo[-1] is not Damage.OVERRUN:
            self._fifo.append(Damage.OVERRUN)

    def _expire(self, now: Ns) -> None:
        for driver in self.drivers.values():
            due = driver.deadline()
            if due is not None and due <= now:
                driver.wake(now)
        if self.owner is not None and self.owner.due is not None and self.owner.due <= now:
            self._end(Condition.TIME_OUT, now)

    def _end(self, condition: Condition, now: Ns) -> None:
        """The owner's call is over; the next may have the line."""
        if self.owner is not None:
            job = self.owner
            self._release()
            self._interface.finish(job, condition, now)
            self._turn(now)

    def _release(self) -> None:
        if self.owner is not None and not self.owner.wanted:
            self._out.clear()  # blocks that an aborted output had prepared; a completed one has none
        if self._driver is not None:
            self._driver.active = False
        self.owner, self._reader = None, None

    def _turn(self, now: Ns) -> None:
        """Let owners begin, continue and end until one has to wait for the line."""
        while True:
            if self.owner is None:
                if not self.waiting:
                    break
                self.owner = first(self.waiting)
                self.waiting.remove(self.owner)
                self._begin(self.owner, now)
            if not self._advance(now):
                break
        if self._stopped and not (self.owner is not None and self._needs_panel(self.owner)):
            self._stopped = False
            self._interface.report(UserInterfaceResumed(self.name), now)

    def _needs_panel(self, job: Job) -> bool:
        return self._assignment(job).protocol == Procedure.PHG and job.function is not Function.COUPLING

    def _begin(self, job: Job, now: Ns) -> None:
        """The new owner's first step; an output of nothing is over with it."""
        wanted = self._assignment(job).format
        if wanted != self.format:
            self.format, self._reopening = wanted, True
            self._fifo.clear()
            self._interface.report(FormatWanted(self.name, wanted), now)
        if self._needs_panel(job) and not self._stopped:
            self._stopped = True
            self._interface.report(UserInterfaceStopped(self.name), now)
        if job.permanent:
            self._fifo.clear()
            if self._driver is not None:
                self._driver.resume(now)
        elif job.wanted:
            self._reader = ItemReader(job.wanted[len(job.values)])
            limit = self._assignment(job).input_limit
            job.due = None if limit is None else now + limit
        else:
            self._load(job, now)

    def _load(self, job: Job, now: Ns) -> None:
        """The next characters go to the interface; what was given cannot be taken back."""
        chunk, job.data = job.data[: self._setup.chunk], job.data[self._setup.chunk :]
        self._out += chunk
        limit = self._assignment(job).output_limit
        job.due = None if limit is None else now + limit
        if not chunk:
            self._end(Condition.NO_ERROR, now)

    def _advance(self, now: Ns) -> bool:
        """True: the owner is done with the line."""
        owner = self.owner
        if owner is None:
            return True
        if owner.wanted and self._reader is not None:
            return self._read(owner, self._reader, now)
        return False

    def _read(self, job: Job, reader: ItemReader, now: Ns) -> bool:
        """Read characters of one variable; True when it is complete or corrupted."""
        while self._fifo:
            item = self._fifo.popleft()
            if isinstance(item, Damage):
                return self._read_failed(job, OF_DAMAGE[item], now)
            if self._assignment(job).protocol == Procedure.ECHO:
                self._out.append(item)
            limit = self._assignment(job).input_limit
            job.due = None if limit is None else now + limit
            try:
                if reader.feed(item):
                    self._one_read(job, reader, now)
                    return True
            except ItemError as error:
                return self._read_failed(job, error.condition, now)
        return False

    def _one_read(self, job: Job, reader: ItemReader, now: Ns) -> None:
        """READ has the line for exactly one variable (8.1)."""
        job.values.append(reader.value)
        self._release()
        if len(job.values) == len(job.wanted):
            self._interface.finish(job, Condition.NO_ERROR, now)
        else:
            job.order = self._interface.order()
            self.waiting.append(job)

    def _read_failed(self, job: Job, condition: Condition, now: Ns) -> bool:
        self._release()
        self._interface.finish(job, condition, now)
        return True
