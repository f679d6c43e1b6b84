"""The driver task of protocol 8: 3964R for READ and WRITE, one block buffered.

Source: rho 3 Releases part 1, sections 7.1, 7.4, 7.5, 8.2; part 2, sections 10.3, 10.4; what they leave open: AX-166..170.
"""

from gateway.pure.controllers.rho3.serial.baps import ItemError, unpack
from gateway.pure.controllers.rho3.serial.events import LinkReport
from gateway.pure.controllers.rho3.serial.line_interface import Job, LineInterface, earliest, first
from gateway.pure.controllers.rho3.serial.setup import Assignment, Condition, Process, Setup
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.events import BlockReceived, BlockSent, Event, Failure, ReceptionFailed, Refusal, SendFailed
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, priority_from_output_timeout

REPETITION_DELAY: Ns = ms(4000)  # part 2, 10.3
OF_DAMAGE = {
    Damage.PARITY: Condition.PARITY,
    Damage.FRAMING: Condition.FRAMING,
    Damage.OVERRUN: Condition.OVERRUN,
    Damage.BREAK: Condition.FRAMING,  # a BREAK reads as a 00h without stop bit
}
OF_FAILURE = {
    Failure.SILENT: Condition.TIME_OUT,
    Failure.NAK: Condition.PROTOCOL,
    Failure.WRONG: Condition.PROTOCOL,
    Failure.CONFLICT: Condition.PROTOCOL,
    Failure.REVOKED: Condition.PROTOCOL,
    Failure.BREAK: Condition.FRAMING,
}
OF_REFUSAL = {
    Refusal.GAP: Condition.TIME_OUT,
    Refusal.ORDER: Condition.PROTOCOL,
    Refusal.LENGTH: Condition.PROTOCOL,
    Refusal.CHECK: Condition.PROTOCOL,
}


class Driver:
    """Serves the READs and WRITEs of one unit; `active` while it has its line."""

    def __init__(self, assignment: Assignment, setup: Setup, interface: LineInterface) -> None:
        self._assignment, self._setup, self._interface = assignment, setup, interface
        self.link = Link(PROFILES["rho3"], priority_from_output_timeout(assignment.output_timeout_ms), keep_one=True)
        profile = self.link.profile
        self._patience: Ns = profile.connect_attempts * profile.ack_delay  # with a port that accepts nothing
        self.active = False
        self._writes: list[Job] = []
        self._reads: list[Job] = []
        self._current: Job | None = None  # the WRITE that the link has
        self._not_before: Ns | None = None  # 4 s allowance
        self._block: bytes | None = None  # acknowledged, not yet used up
        self._at = 0
        self._readers: set[int] = set()  # processes that read some of it
        self._damage = Condition.INTERFACE

    # ---- calls
    def submit(self, job: Job, now: Ns) -> None:
        if job.wanted:
            self._reads.append(job)
            self._watch(job, now)
            self._serve(now)
        else:
            self._writes.append(job)
            self._start(now)

    def write_begin(self, process: Process, now: Ns) -> None:
        """Prepared outputs deleted, the one under way not repeated."""
        if self._current is not None and self._current.process == process:
            self._current.silent = True
            self.link.revoke()
        for job in [job for job in self._writes if job.process == process]:
            self._writes.remove(job)
            self._interface.delete(job, now)

    def read_begin(self, now: Ns) -> None:
        """The input buffer of the driver only; characters on the line are still taken by the protocol."""
        if self._block is not None:
            self._drop_block(now)

    def drop(self, process: Process, aborted: bool, now: Ns) -> None:
        """The program has ended; if aborted, its outputs and a block it began to read go with it (7.5)."""
        for job in [job for job in self._reads if job.process == process]:
            self._reads.remove(job)
            self._interface.delete(job, now)
        if aborted:
            self.write_begin(process, now)
            if process.number in self._readers:
                self.read_begin(now)

    def resume(self, now: Ns) -> None:
        """The line is allocated."""
        self.active = True
        for job in self._reads:
            self._interface.status.pop((job.process.number, job.function), None)
            self._watch(job, now)
        self._serve(now)
        self._start(now)

    def suspend(self, now: Ns) -> None:
        """Disable signal: outputs are aborted, READs stay until it goes away (AX-168)."""
        self.active = False
        outputs = [*([self._current] if self._current else []), *self._writes]
        self._current, self._writes = None, []
        self._heard(self.link.lost(now), now)
        for job in self._reads:
            job.due = None
            self._interface.status[job.process.number, job.function] = Condition.INTERFACE
        for job in outputs:
            self._interface.finish(job, Condition.INTERFACE, now)

    # ---- the machine, while active
    def receive(self, data: bytes, now: Ns) -> None:
        self._heard(self.link.receive(data, now), now)

    def damaged(self, kind: Damage, now: Ns) -> None:
        self._damage = OF_DAMAGE[kind]
        self._heard(self.link.damaged(kind, now), now)

    def sent(self, now: Ns) -> None:
        self._heard(self.link.sent(now), now)

    def lost(self, now: Ns) -> None:
        """The port is gone: the running WRITE ends with -7, READs wait for its return."""
        self._heard(self.link.lost(now), now)

    def wake(self, now: Ns) -> None:
        self._heard(self.link.wake(now), now)
        if self._current is not None and self._current.due is not None and self._current.due <= now:
            self._nobody_takes_it(self._current, now)
        for job in [job for job in self._reads if job.due is not None and job.due <= now]:
            if job in self._reads:
                self._end_read(job, Condition.TIME_OUT, now)

    def deadline(self) -> Ns | None:
        waits = self._not_before if self._writes and self._current is None and self.active else None
        untaken = self._current.due if self._current is not None else None
        return earliest(self.link.deadline(), waits, untaken, *(job.due for job in self._reads))

    def take_output(self) -> bytes:
        output = self.link.take_output()
        if output and self._current is not None:
            self._current.due = None  # the port is there; from here on the link's own times run
        return output

    # ---- inside
    def _heard(self, events: list[Event], now: Ns) -> None:
        for event in events:
            match event:
                case BlockReceived(data):
                    self._block, self._at, self._readers = data, 0, set()
                    if not data:
                        self._drop_block(now)
                case BlockSent():
                    self._written(Condition.NO_ERROR, now)
                case SendFailed(_, why, _):
                    spoiled = self._damage if why is Failure.DAMAGED else Condition.INTERFACE
                    self._written(OF_FAILURE.get(why, spoiled), now)
                case _:
                    self._interface.report(LinkReport(self._assignment.function, event), now)
                    if isinstance(event, ReceptionFailed):
                        self._not_received(event.why, now)
        self._serve(now)
        self._start(now)

    def _written(self, condition: Condition, now: Ns) -> None:
        job, self._current = self._current, None
        if job is None:
            return
        if job.silent and condition:
            self._not_before = now + REPETITION_DELAY
        self._interface.finish(job, condition, now)

    def _start(self, now: Ns) -> None:
        if self._not_before is not None and now >= self._not_before:
            self._not_before = None
        if self.active and self._current is None and self._writes and self._not_before is None:
            self._current = first(self._writes)
            self._writes.remove(self._current)
            self._current.due = now + self._patience
            self.link.send(self._current.data, now)

    def _nobody_takes_it(self, job: Job, now: Ns) -> None:
        """The port not available: the same end as with a partner who is silent (AX-169).  Or the partner has the line: then we wait."""
        if not self.link.untaken:
            job.due = now + self._patience
            return
        self._current = None
        self._heard(self.link.lost(now), now)
        self._interface.finish(job, Condition.TIME_OUT, now)

    def _serve(self, now: Ns) -> None:
        """Each READ consumes one variable, the first by priority; a block may serve several (7.4)."""
        while self.active and self._block is not None and self._reads:
            job = first(self._reads)
            kind = job.wanted[len(job.values)]
            data = self._block[self._at : self._at + kind.size]
            self._at += kind.size  # beyond the end: a border inside the item, which discards the remainder of the block (AX-167)
            self._readers.add(job.process.number)
            try:
                job.values.append(unpack(kind, data, self._setup.low_byte_first))
            except ItemError as error:
                self._end_read(job, error.condition, now)
            else:
                self._read_on(job, now)
            self._used_up(now)

    def _used_up(self, now: Ns) -> None:
        """The program that was served last may have been aborted, its block with it."""
        if self._block is not None and self._at >= len(self._block):
            self._drop_block(now)

    def _read_on(self, job: Job, now: Ns) -> None:
        if len(job.values) == len(job.wanted):
            self._end_read(job, Condition.NO_ERROR, now)
        else:
            job.order = self._interface.order()
            self._watch(job, now)

    def _end_read(self, job: Job, condition: Condition, now: Ns) -> None:
        self._reads.remove(job)
        self._interface.finish(job, condition, now)

    def _not_received(self, why: Refusal, now: Ns) -> None:
        """The partner gave up: the READ that waits for the block learns why (AX-169)."""
        if self._reads and self.active:
            spoiled = self._damage if why in (Refusal.DAMAGED, Refusal.BREAK) else Condition.INTERFACE
            self._end_read(first(self._reads), OF_REFUSAL.get(why, spoiled), now)

    def _watch(self, job: Job, now: Ns) -> None:
        limit = self._assignment.input_limit
        job.due = None if limit is None or not self.active else now + limit

    def _drop_block(self, now: Ns) -> None:
        self._block, self._at, self._readers = None, 0, set()
        self.link.take_block(now)
