"""Our own SEND and FETCH jobs on a line with role active or both: when each is due, which answer is whose (AX-252).

A job is never on its way twice.  What is missed while the partner is away is not made up for: the next one is due at its next moment.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from protocols.base.machine import Ns, ms
from protocols.rk512.header import Flag, Kind

AGAIN: Ns = ms(1000)  # a job on change that failed is given again, not sooner


@dataclass(frozen=True, slots=True)
class OwnJob:
    """One own block and its address at the partner."""

    key: int  # line_blocks.block_key
    fetch: bool
    kind: Kind
    block: int
    word: int
    words: int
    every: Ns = 0  # 0: only on change
    on_change: bool = False
    flag: Flag | None = None


class OwnJobs:
    """The jobs of one line."""

    def __init__(self, jobs: Iterable[OwnJob]) -> None:
        self.jobs = tuple(jobs)
        self._due: dict[OwnJob, Ns] = {}  # next moment of a cyclic job
        self._rest: dict[OwnJob, Ns] = {}  # a change is not tried again before
        self._open: dict[int, OwnJob] = {}  # number of the station -> job
        self._known: dict[OwnJob, bytes] = {}  # what the partner has

    def due(self, now: Ns, content: Callable[[int], bytes]) -> Iterator[tuple[OwnJob, bytes]]:
        """Return the jobs that are due, with the bytes to send; `content(key)` is called only for jobs that may be due."""
        for job in self.jobs:
            if job in self._open.values():
                continue
            cyclic = job.every > 0 and now >= self._due.get(job, now)
            watched = job.on_change and now >= self._rest.get(job, now)
            if not (cyclic or watched):
                continue
            data = b"" if job.fetch else content(job.key)
            if cyclic or data != self._known.get(job):
                yield job, data

    def given(self, number: int, job: OwnJob, data: bytes, now: Ns) -> None:
        """The station took it under this number."""
        self._open[number] = job
        self._known[job] = data
        if job.every:
            due = self._due.get(job, now)
            self._due[job] = due + ((now - due) // job.every + 1) * job.every if now >= due else due

    def over(self, number: int) -> OwnJob | None:
        """It is done; None: not an own job."""
        return self._open.pop(number, None)

    def failed(self, number: int, now: Ns) -> OwnJob | None:
        """It is not: the partner has not got what it should have."""
        job = self._open.pop(number, None)
        if job is not None:
            self._known.pop(job, None)
            self._rest[job] = now + AGAIN
        return job
