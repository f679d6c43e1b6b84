"""Retained data of a run: values that outlive power-off, and histories (errors, configuration).  A thread writes; the callers do not wait.

    kept = Retained(path, patterns)          reads the file; kept.events lists its faults
    kept.value("counter.3", 0)               what the last run left, else the default
    kept.keep("counter.3", 7)                written soon, if [retain] of the cell names it; costs nothing without a change
    kept.block("flags.M", 2048)              bytes that were kept one by one as flags.M0, flags.M1, ...
    kept.keep_block("flags.M", image)        the reverse; all changes of one call reach the disk together or not at all
    kept.record("error", {...})              a history; the newest are kept
    kept.close()                             writes everything to the disk

Never used by the cycle.  A value that may start a move is never retained: only GROUPS may be kept (AX-425).
"""

import contextlib
import math
import pathlib
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase

from gateway.pure.cell.cell import Cell
from gateway.runtime.retained.groups import group_of
from gateway.runtime.retained.store import Record, RetainError, RetainFile, Value, open_file
from gateway.runtime.state_folder import place

PAUSE_S = 0.05  # changes within it become one transaction
RETRY_S = 1.0  # after a write that failed
WAITING_RECORDS = 1000  # records of histories not yet written; the oldest is dropped and counted


class Retained:
    """Values of the last run, and the way to the next one."""

    def __init__(
        self, path: pathlib.Path | None, patterns: Sequence[str] = (), report: Callable[[str], None] = lambda sentence: None
    ) -> None:
        """`path` None: nothing outlives this run; `patterns`: [retain] values; `report`: sentences for the journal, from any thread."""
        self.patterns, self._report = tuple(patterns), report
        self.events: list[str] = []
        self.dropped = 0  # records of histories that never reached the disk
        self.failures = 0  # writes that failed
        self.writes = 0
        self._file = self._opened(path)
        self._last: dict[str, Record] = {}
        self._values = self._read()
        self._blocks: dict[str, bytes] = {}  # as they were kept last
        self._waiting: dict[str, Value] = {}
        self._records: deque[tuple[str, Record]] = deque()
        self._change = threading.Condition()
        self._busy = self._closing = False
        self._thread = threading.Thread(target=self._work, name="retain", daemon=True)
        for event in self.events:
            report(event)
        if self._file is not None:
            self._thread.start()

    def kept(self, name: str) -> bool:
        """Whether a value of that name outlives power-off.  ValueError: no group that may be kept."""
        group_of(name)
        return any(fnmatchcase(name, pattern) for pattern in self.patterns)

    def value(self, name: str, default: Value) -> Value:
        """The value as it was kept; the default where there is none, or none of the default's type."""
        found = self._values.get(name) if self.kept(name) else None
        return found if type(found) is type(default) else default

    def values(self, group: str) -> dict[str, Value]:
        """All kept values of a group, under their full names."""
        return {name: value for name, value in self._values.items() if name.startswith(group + ".") and self.kept(name)}

    def block(self, name: str, size: int) -> bytearray:
        """Bytes NAME0 .. NAMEn as they were kept; 0 where there is none."""
        found = (self.value(f"{name}{at}", 0) for at in range(size))
        return bytearray(value & 0xFF if isinstance(value, int) else 0 for value in found)

    def keep(self, name: str, value: Value) -> None:
        """The value as it is now."""
        self.keep_all({name: value})

    def keep_block(self, name: str, data: bytes) -> None:
        """Bytes as they are now."""
        last = self._blocks.get(name, b"")
        if data != last:
            self._blocks[name] = data
            self.keep_all({f"{name}{at}": octet for at, octet in enumerate(data) if at >= len(last) or octet != last[at]})

    def keep_all(self, values: Mapping[str, Value]) -> None:
        """Values that belong together: all of them reach the disk or none.  A number no file can hold is left out."""
        news = {name: value for name, value in values.items() if self._new(name, value) and self.kept(name) and _storable(value)}
        if not news:
            return
        self._values.update(news)
        with self._change:
            self._waiting.update(news)
            self._change.notify_all()

    def _new(self, name: str, value: Value) -> bool:
        old = self._values.get(name)
        return type(old) is not type(value) or old != value

    def record(self, kind: str, record: Record) -> None:
        """One line of a history."""
        with self._change:
            if len(self._records) >= WAITING_RECORDS:
                self._records.popleft()
                self.dropped += 1
            self._records.append((kind, record))
            self._change.notify_all()

    def flush(self, timeout_s: float = 5.0) -> bool:
        """Waits until everything has reached the disk; False: it has not."""
        with self._change:
            return self._file is not None and self._change.wait_for(lambda: not (self._waiting or self._records or self._busy), timeout_s)

    def close(self, timeout_s: float = 5.0) -> None:
        """Write the waiting values and end the thread."""
        with self._change:
            self._closing = True
            self._change.notify_all()
        if self._thread.is_alive():
            self._thread.join(timeout_s)
        if self._file is not None and not self._thread.is_alive():
            self._file.close()

    @property
    def on(self) -> bool:
        """Whether anything outlives this run."""
        return self._file is not None

    def last(self, kind: str) -> Record | None:
        """The newest record of a kind as the last run left it; None: there is none, or it cannot be read."""
        return self._last.get(kind)

    # ---- the thread --------------------------------------------------------------------------------------------------
    def _work(self) -> None:
        assert self._file is not None
        while True:
            with self._change:
                self._change.wait_for(lambda: self._waiting or self._records or self._closing)
                if self._closing and not (self._waiting or self._records):
                    return
                if not self._closing:
                    self._change.wait(PAUSE_S)  # more of the same news
                values, self._waiting = self._waiting, {}
                records, self._records = list(self._records), deque()
                self._busy = True
            done = self._written(self._file, values, records)
            with self._change:
                self._busy = False
                if not done:
                    self._waiting = {**values, **self._waiting}
                    self._back(records)
                self._change.notify_all()
                if not done and self._closing:
                    return
                if not done:
                    self._change.wait_for(lambda: self._closing, RETRY_S)

    def _back(self, records: Sequence[tuple[str, Record]]) -> None:
        """Records that were not written wait again; the oldest beyond the bound are dropped."""
        waiting = [*records, *self._records]
        self.dropped += max(0, len(waiting) - WAITING_RECORDS)
        self._records = deque(waiting[-WAITING_RECORDS:])

    def _written(self, file: RetainFile, values: Mapping[str, Value], records: Sequence[tuple[str, Record]]) -> bool:
        try:
            file.write(values, records)
        except RetainError as error:
            self.failures += 1
            if self.failures == 1:
                self._report(f"retained data: {error}; tried again every {RETRY_S:g} s")
            return False
        self.writes += 1
        if self.failures:
            self.failures = 0
            self._report("retained data: written again")
        return True

    # ---- start -------------------------------------------------------------------------------------------------------
    def _opened(self, path: pathlib.Path | None) -> RetainFile | None:
        if path is None:
            return None
        try:
            opened = open_file(path)
        except RetainError as error:
            self.events.append(f"retained data: {error}; nothing of this run is retained")
            return None
        self.events += opened.events
        return opened.file

    def _read(self) -> dict[str, Value]:
        if self._file is None:
            return {}
        try:
            values, spoiled = self._file.values()
            self._last = {kind: records[-1] for kind in self._file.kinds() if (records := self._file.history(kind))}
        except RetainError as error:
            self.events.append(f"retained data: {error}; defaults apply")
            return {}
        if spoiled:
            self.events.append(f"retained data: {self._file.path}: {', '.join(spoiled[:8])} damaged; their defaults apply")
        return values


def _storable(value: Value) -> bool:
    if isinstance(value, bool):
        return False  # SQLite has no truth values: store 0 or 1
    if isinstance(value, float):
        return math.isfinite(value)
    return not isinstance(value, int) or -(1 << 63) <= value < 1 << 63


def path_of(cell: Cell) -> pathlib.Path:
    """Path of this cell's data: retain/NAME.sqlite next to its file, or from gateway.runtime.state_folder."""
    return place(cell.file, "retain", f"{pathlib.Path(cell.file).resolve().stem}.sqlite")


def history(path: pathlib.Path, kind: str) -> list[Record]:
    """Records of a kind for tools, oldest first; [] without a file.  RetainError."""
    if not path.exists():
        return []
    with contextlib.closing(open_file(path, repair=False).file) as file:
        return file.history(kind)


def append(path: pathlib.Path, kind: str, record: Record) -> None:
    """One record of a history, by a tool; on return it has reached the disk.  RetainError: it has not."""
    with contextlib.closing(open_file(path, repair=False).file) as file:
        file.write({}, [(kind, record)])
