"""The recorder: writes the records of the cycle's and the services' rings to a file.  A process of its own (AX-482)."""

import contextlib
import json
import os
import pathlib
import pickle
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from drivers.ports.base import PortError
from gateway.pure.image.records.cell import CELL_STATE_LAYOUT, RC_BYTES
from gateway.pure.recording.messages import (
    ASKED,
    ASKED_LAYOUT,
    CHUNK_LAYOUT,
    SERVICE_EVENT,
    SERVICE_EVENT_LAYOUT,
    Assembly,
    What,
    pack,
    unpack,
)
from gateway.pure.scope.records import SCOPE_LAYOUT
from gateway.recording.file import Writer
from gateway.recording.states import Start, frozen
from gateway.runtime.regions import ImageError, RegionWriter, RingReader, recv_fds
from gateway.runtime.supervisor_client import ask

NAP_S = 0.02
AT_ONCE = 512
OUTPUTS_KEPT = 16_384
FLUSH_S = 0.5
ASK_AGAIN_S = 2.0
SILENT_S = 5.0
CYCLE = 8  # bytes at the front of a cell state


class RecorderError(Exception):
    """No such run, or it is being recorded already."""


@dataclass(slots=True)
class Rings:
    """Rings that a run passes to a recorder."""

    record: RingReader
    events: RingReader
    scope: RingReader
    asked: RegionWriter
    run: str  # distinguishes this run from any other


@dataclass(slots=True)
class Counts:
    """Counters of one recorder."""

    cycles: int = 0
    lost: list[dict[str, Any]] = field(default_factory=list)
    outputs_lost: int = 0


@contextlib.contextmanager
def attached(run: str) -> Iterator[Rings]:
    """Raises RecorderError."""
    fds: dict[str, int] = {}
    try:
        with ask(run, "regions") as connection:
            fds = recv_fds(connection)
        boot = pathlib.Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        rings = Rings(
            RingReader(fds["record"], "record", CHUNK_LAYOUT),
            RingReader(fds["service_events"], "service_events", SERVICE_EVENT_LAYOUT),
            RingReader(fds["scope"], "scope", SCOPE_LAYOUT),
            RegionWriter(fds["recorder"], "recorder", ASKED_LAYOUT),
            f"{boot}-{os.fstat(fds['record']).st_ino}",
        )
    except PortError as error:
        raise RecorderError(str(error)) from error
    except (OSError, ImageError, KeyError) as error:
        raise RecorderError(f"run {run!r} cannot be recorded ({error}); start it with: axisgate run CELL") from error
    finally:
        for fd in fds.values():
            os.close(fd)
    try:
        yield rings
    finally:
        rings.asked.close()


class Recorder:
    """Moves messages from the rings into the file."""

    def __init__(self, rings: Rings, writer: Writer) -> None:
        self.counts = Counts()
        self._rings, self._writer = rings, writer
        self._assembly = Assembly()
        self._next = writer.goes_on_with  # the cycle that has to come; None: a start has to come first
        self._outputs: deque[tuple[int, bytes]] = deque()
        self._gaps = 0
        self._wishes = rings.asked.published
        self._asked_at = self._heard = time.monotonic()
        if self._next is not None:
            rings.record.position = min(writer.sequence, rings.record.published)
            rings.scope.position = max(0, rings.scope.published - rings.scope.count + 2)
        else:
            self._wish()

    def run(self, stop: Callable[[], bool], said: Callable[[int], None]) -> None:
        """Until `stop()`; RecorderError when the cycle falls silent."""
        flushed = time.monotonic()
        while not stop():
            now = time.monotonic()
            self._rings.asked.beat(time.monotonic_ns())
            took = self.turn()
            self._heard = now if took else self._heard
            if now - flushed > FLUSH_S:
                self._writer.flush()
                flushed = now
                said(self.counts.cycles)
            if now - self._heard > SILENT_S and now - self._asked_at > ASK_AGAIN_S and self._next is not None:
                self._lose("the cycle no longer ran; the recording continues at its next start")
            elif self._next is None and now - self._asked_at > ASK_AGAIN_S and not took:
                self._wish()  # the cycle that got the request may have died
            if took < AT_ONCE:
                time.sleep(NAP_S)
        self.turn()

    def turn(self) -> int:
        """Read the waiting records; return how many of the cycle there were."""
        records = self._rings.record.take(AT_ONCE)
        self._take_outputs()
        if self._rings.record.gaps > self._gaps:
            lost = self._rings.record.gaps - self._gaps
            self._gaps = self._rings.record.gaps
            self._lose(f"{lost} records of the ring were overwritten before they were taken")
        for sequence, record in records:
            whole = self._assembly.take(record)
            if whole is not None:
                self._cycle(*whole, sequence)
        self._take_service_events()
        return len(records)

    # ---- one cycle -------------------------------------------------------------------------------------------------------
    def _cycle(self, number: int, octets: bytes, sequence: int) -> None:
        messages = list(unpack(octets))
        start = next((payload for what, payload in messages if what is What.START), None)
        if start is not None and messages[0].what is What.START:  # nothing was recorded before it
            self._begin(number, start, b"".join(pack(*each) for each in messages if each.what is not What.START), sequence)
            return
        if self._next is None:
            return
        if self._next != number:
            self._lose(f"cycle {self._next} was expected, {number} came")
            return
        kept = b"".join(pack(*each) for each in messages if each.what is not What.START)
        self._writer.cycle(number, kept + self._outputs_of(number), sequence)
        self._next = number + 1
        self.counts.cycles += 1

    def _begin(self, cycle: int, pickled: bytes, more: bytes, sequence: int) -> None:
        """The cycle of our own run, through memory only its user can open, is trusted with its pickle; a file never is."""
        if self._next is not None and self._next != cycle + 1:
            self._lose("the cycle was restarted")
        state = pickle.loads(pickled)
        assert isinstance(state, Start)
        tree = {"core": frozen(state.core), "families": frozen(state.families), "late": state.late, "sent": state.sent_ns}
        self._writer.start(cycle, {**tree, "encoders": state.encoders})
        self._next = cycle + 1
        self._writer.cycle(cycle, more, sequence)

    def _take_outputs(self) -> None:
        """All of them: those of the cycles just read were published before."""
        while records := self._rings.scope.take(AT_ONCE):
            for _, record in records:
                self._outputs.append((int.from_bytes(record[:CYCLE], "little"), record[:-RC_BYTES]))
        while len(self._outputs) > OUTPUTS_KEPT:
            self._outputs.popleft()

    def _outputs_of(self, cycle: int) -> bytes:
        """Outputs published by the cycle; a missing one is counted and not compared."""
        if not any(number == cycle for number, _ in self._outputs):  # nearly always the first
            self.counts.outputs_lost += 1
            return b""
        while self._outputs[0][0] != cycle:
            self._outputs.popleft()
        return pack(What.OUTPUTS, self._outputs.popleft()[1])

    def _take_service_events(self) -> None:
        for _, record in self._rings.events.take(AT_ONCE):
            size = SERVICE_EVENT.unpack_from(record)[3]
            if self._next is not None:
                self._writer.aside(pack(What.SERVICE_EVENT, record[: SERVICE_EVENT.size + size]))

    # ---- gaps ------------------------------------------------------------------------------------------------------------
    def _lose(self, why: str) -> None:
        if self._next is not None:
            entry = {"after_cycle": self._next - 1, "why": why}
            self.counts.lost.append(entry)
            self._writer.lost(entry)
        self._next = None
        self._wish()

    def _wish(self) -> None:
        self._wishes += 1
        self._asked_at = time.monotonic()
        self._rings.asked.write(ASKED.pack(self._wishes), time.monotonic_ns())
        self._rings.asked.beat(time.monotonic_ns())


def head_of(status: Mapping[str, Any], rings: Rings, **more: Any) -> dict[str, Any]:
    """First block of a file."""
    from gateway.recording.backup import version
    from gateway.recording.file import FORMAT
    from gateway.runtime.clock import wall

    shown = {name: status[name] for name in ("cell", "file", "simulated", "p5_ms")}
    return {
        "format": FORMAT,
        "state": CELL_STATE_LAYOUT,
        "version": version(),
        "wall": wall(),
        "stamp_ns": time.monotonic_ns(),
        "run": rings.run,
        **shown,
        **more,
    }


def status_of(run: str) -> dict[str, Any]:
    """Status of a run; RecorderError."""
    try:
        with ask(run, "status") as connection:
            found: dict[str, Any] = json.loads(connection.makefile().readline())
    except (OSError, ValueError) as error:
        raise RecorderError(f"run {run!r} does not answer ({error}); start it with: axisgate run CELL") from error
    return found
