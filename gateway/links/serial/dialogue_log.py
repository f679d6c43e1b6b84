"""Journal of a line on a real port: a machine between loop and station that logs received and sent bytes and events.

`axisgate run CELL --record FOLDER` keeps it as FOLDER/line-NAME.txt, in the form of the test vectors (protocols.base.dialogue); on a
simulated line the line process keeps its own record of both sides.  `axisgate line export` reads either.
"""

import pathlib
import time
from collections.abc import Callable, Sequence
from typing import Generic, Protocol, TypeVar

from gateway.assembly.run import RunPlan
from gateway.pure.cell.cell import Line
from gateway.runtime.bounded_file import BoundedFile
from protocols.base.dialogue import Dialogue, Entry, describe, line_of, write
from protocols.base.machine import Damage, Machine, Ns

E = TypeVar("E")


class Lines(Protocol):
    """Where it is written down."""

    def write(self, text: str, /) -> int: ...  # OSError ends it


class JournalFile:
    """The log file of one line, limited in size; the first text is the head of each part."""

    def __init__(self, path: pathlib.Path) -> None:
        self._path = path
        self._file: BoundedFile | None = None

    def write(self, text: str, /) -> int:
        octets = text.encode("ascii", "backslashreplace")
        if self._file is None:
            self._file = BoundedFile(self._path, octets, _missing)
        else:
            self._file.write(octets)
        return len(text)


def _missing(lines: int, reason: str) -> bytes:
    return f"# {lines} lines are missing: {reason}\n".encode()


class Journaled(Generic[E]):
    """The same machine, logged.  Neither a full disk nor a read-only folder ends the line."""

    def __init__(
        self, machine: Machine[E], out: Lines, name: str, settings: dict[str, str], clock: Callable[[], Ns] = time.monotonic_ns
    ) -> None:
        self._machine, self._clock, self._start = machine, clock, clock()
        self._out: Lines | None = out
        self._latest: Ns = 0
        self._put(write([Dialogue(name, {**settings, "side": "B", "start_ns": str(self._start)})]))

    def receive(self, data: bytes, now: Ns) -> Sequence[E]:
        self._note(now, "hears", data.hex(" ").upper())
        return self._reported(self._machine.receive(data, now), now)

    def damaged(self, kind: Damage, now: Ns) -> Sequence[E]:
        self._note(now, "damaged", kind.name)
        return self._reported(self._machine.damaged(kind, now), now)

    def sent(self, now: Ns) -> Sequence[E]:
        return self._reported(self._machine.sent(now), now)

    def wake(self, now: Ns) -> Sequence[E]:
        return self._reported(self._machine.wake(now), now)

    def lost(self, now: Ns) -> Sequence[E]:
        return self._reported(self._machine.lost(now), now)

    def deadline(self) -> Ns | None:
        return self._machine.deadline()

    def take_output(self) -> bytes:
        output = self._machine.take_output()
        if output:
            self._note(self._clock(), "says", output.hex(" ").upper())
        return output

    def _reported(self, events: Sequence[E], now: Ns) -> Sequence[E]:
        for event in events:
            self._note(now, "reports", describe(event))
        return events

    def _note(self, now: Ns, verb: str, what: str) -> None:
        self._latest = max(self._latest, now - self._start)  # never decreasing: output has a later stamp than the input it answers
        self._put(line_of(Entry(self._latest, verb, what)) + "\n")

    def _put(self, text: str) -> None:
        if self._out is None:
            return
        try:
            self._out.write(text)
        except OSError:
            self._out = None


def journaled(machine: Machine[E], plan: RunPlan, line: Line) -> Machine[E]:
    """The machine itself, or with a journal where the run is recorded and the line is a real one.  A journal is continued."""
    if plan.record is None or plan.lines[line.name] != line.port:
        return machine
    out = JournalFile(plan.record / f"line-{line.name}.txt")
    return Journaled(machine, out, line.name, {"profile": line.profile, "priority": line.priority})
