"""The scope of the page: one recording at a time from the cycle's ring, in this process (AX-497).

The ring holds 8 s at 2 ms; it is emptied twenty times a second.  A recording is a gateway.scope.Recording: the page saves, reopens and
exports the same files as `axisgate scope`.  numpy is loaded with the first recording, not with the page.
"""

import asyncio
import contextlib
import pathlib
import sys
import tempfile
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gateway.assembly.data_block_signals import signals_of
from gateway.assembly.run import RunPlan
from gateway.pure.scope.channels import AxisFact, Channel, all_names, channel
from gateway.pure.scope.rolling import Rolling
from gateway.pure.scope.trigger import Capture, parse_trigger
from gateway.runtime.regions import RingReader

if TYPE_CHECKING:
    from gateway.scope.recording import Recording

LOOK_S = 0.05
AT_ONCE = 2048
SILENT_S = 5.0
MOST_VALUES = 5_000_000  # records times channels, 40 MB: ten minutes of 16 channels at 2 ms; longer ones: axisgate scope record
MOST_FILES = 200
DRAWN, DRAWN_ROLLING = 160, 600  # moments of a running recording, and of a rolling one, that are sent
MOST_ROLLING_S = 60.0
Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Wanted:
    """A requested recording."""

    names: tuple[str, ...]
    seconds: float
    pre_s: float
    trigger: str
    who: str
    rolling: bool = False  # the last `seconds`, until it is stopped


class Scope:
    """The recording that runs, and the one that was made last."""

    def __init__(self, plan: RunPlan, ring: RingReader, folder: pathlib.Path) -> None:
        self._plan, self._ring, self.folder = plan, ring, folder
        self._facts = [AxisFact(axis.name, axis.unit) for axis in plan.cell.axis]
        self._signals = signals_of(plan.cell)
        self._period_s = plan.p5_ms / 1000.0
        self._channels: list[Channel] = []
        self._kept: Capture | Rolling | None = None
        self._wanted: Wanted | None = None
        self._task: asyncio.Task[None] | None = None
        self.recording: Recording | None = None
        self.number = 0  # of the recording: a page that has drawn it need not request it again
        self.name = ""  # of the file it was saved in or reopened from
        self.why = ""  # why the last one ended early

    # ---- recording --------------------------------------------------------------------------------------------------------
    def names(self) -> Row:
        """Names that can be recorded, and every RC input and output; whether a recording runs and how many were shown."""
        signals = [signal.name for signal in self._signals.all if not signal.until]
        return {"channels": all_names(self._facts), "signals": signals, "running": self._kept is not None, "number": self.number}

    def start(self, wanted: Wanted) -> None:
        """ValueError: an unknown channel or trigger, too long a recording, or one runs already."""
        if self._kept is not None:
            raise ValueError("a recording runs already; stop it first")
        records = (wanted.seconds + wanted.pre_s) / self._period_s
        if records * len(wanted.names) > MOST_VALUES:
            seconds = MOST_VALUES * self._period_s / len(wanted.names)
            raise ValueError(f"up to {seconds:.0f} s of {len(wanted.names)} channels here; longer: axisgate scope record")
        self._channels = [channel(name, self._facts, self._signals) for name in wanted.names]
        self._kept = self._keeper(wanted)
        self._wanted, self.why = wanted, ""
        while len(self._ring.take(AT_ONCE)) == AT_ONCE:
            pass  # records before the key was pressed
        self._task = asyncio.create_task(self._run(self._kept))

    def _keeper(self, wanted: Wanted) -> Capture | Rolling:
        post = max(1, round(wanted.seconds / self._period_s))
        if wanted.rolling:
            if wanted.trigger or wanted.pre_s or wanted.seconds > MOST_ROLLING_S:
                raise ValueError(f"a rolling scope keeps the last seconds, {MOST_ROLLING_S:.0f} at most, and has no trigger")
            return Rolling(self._channels, post)
        trigger = parse_trigger(wanted.trigger, self._facts, self._signals) if wanted.trigger else None
        return Capture(self._channels, post, round(wanted.pre_s / self._period_s), trigger)

    async def stop(self) -> None:
        """The recording so far is kept."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task
        self._end("stopped before its trigger" if self._kept is not None and self._kept.triggered_at is None else "")

    async def _run(self, kept: Capture | Rolling) -> None:
        heard, generation = time.monotonic(), self._ring.generation
        while not kept.full:
            await asyncio.sleep(LOOK_S)
            records = self._ring.take(AT_ONCE)
            if self._ring.generation != generation:  # its records count from 0
                self._end("the cycle was restarted")
                return
            for sequence, record in records:
                kept.take(sequence, record)
            if records:
                heard = time.monotonic()
            elif time.monotonic() - heard > SILENT_S:
                self._end("the cycle no longer ran")
                return
        self._end("")

    def _end(self, why: str) -> None:
        kept, self._kept, self._task = self._kept, None, None
        if kept is None or self._wanted is None:
            return
        self.why = why
        if isinstance(kept, Rolling):
            kept.trim()
        if len(kept.rows):
            from gateway.scope.live import recording_of

            self._show(recording_of(kept, self._channels, self._plan.cell, self._period_s, self._wanted.trigger), "")

    def _show(self, recording: "Recording", name: str) -> None:
        self.recording, self.name = recording, name
        self.number += 1

    # ---- looking ----------------------------------------------------------------------------------------------------------
    def row(self) -> Row:
        """For every page that shows the scope, a few times a second."""
        kept, wanted = self._kept, self._wanted
        row: Row = {"state": "none", "number": self.number, "name": self.name, "why": self.why, "records": 0, "lost": 0}
        if self.recording is not None:
            row |= {"state": "done", "records": len(self.recording.time), "lost": self.recording.lost, "trigger": self.recording.trigger}
        if kept is not None and wanted is not None:
            row |= {"state": "waiting" if kept.triggered_at is None else "running", "records": len(kept.rows), "lost": kept.lost,
                    "trigger": wanted.trigger, "who": wanted.who, "names": list(wanted.names),
                    "rolling": wanted.rolling, "tail": self._tail(kept)}  # fmt: skip
            row["units"] = [each.unit for each in self._channels]
            row["wanted"] = max(1, round(wanted.seconds / self._period_s)) + round(wanted.pre_s / self._period_s)
        return row

    def _tail(self, kept: Capture | Rolling) -> Row:
        """A reduced view of a growing recording: times in s, one list per channel."""
        if isinstance(kept, Rolling):
            times, columns = kept.picture(DRAWN_ROLLING)
            return {"t": [round(moment, 4) for moment in times], "values": [[round(value, 5) for value in column] for column in columns]}
        count = len(kept.rows)
        places = range(0, count, max(1, count // DRAWN))
        zero = kept.stamps[min(kept.triggered_at or 0, count - 1)] if count else 0
        times = [round((kept.stamps[n] - zero) / 1e9, 4) for n in places]
        return {"t": times, "values": [[round(kept.rows.value(n, c), 5) for n in places] for c in range(len(self._channels))]}

    # ---- files ------------------------------------------------------------------------------------------------------------
    def _file(self, name: str = ".shown") -> pathlib.Path:
        """The recording in a file.  KeyError: there is none."""
        if self.recording is None:
            raise KeyError("nothing has been recorded")
        from gateway.scope.recording import save

        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"{name}.scope"
        save(self.recording, path)
        return path

    async def export(self, suffix: str) -> bytes:
        """scope, csv or mf4.  MF4 needs a large package: a process of its own writes it, so this one stays as small as it is."""
        path = await asyncio.to_thread(self._file)
        assert self.recording is not None
        if suffix == "scope":
            return await asyncio.to_thread(path.read_bytes)
        with tempfile.TemporaryDirectory(dir=self.folder) as scratch:
            made = pathlib.Path(scratch) / f"export.{suffix}"
            if suffix == "csv":
                from gateway.scope.recording import export

                await asyncio.to_thread(export, self.recording, made)
                return await asyncio.to_thread(made.read_bytes)
            command = (sys.executable, "-m", "gateway", "scope", "export", str(path), "-o", str(made))
            process = await asyncio.create_subprocess_exec(*command, stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.PIPE)
            _, words = await process.communicate()
            if process.returncode:
                raise ValueError(words.decode(errors="replace").strip() or f"{suffix}: not written")
            return await asyncio.to_thread(made.read_bytes)

    def saved(self) -> list[Row]:
        """Recordings kept on the gateway, newest first."""
        found = sorted(self.folder.glob("[!.]*.scope"), key=lambda path: -path.stat().st_mtime)
        return [{"name": path.stem, "bytes": path.stat().st_size} for path in found[:MOST_FILES]]

    def save(self, name: str) -> None:
        """Under a name; an older one of the same name is replaced.  ValueError: too many."""
        if not (self.folder / f"{name}.scope").exists() and len(self.saved()) >= MOST_FILES:
            raise ValueError(f"{MOST_FILES} recordings are kept; remove one of {self.folder}")
        self._file(name)
        self.name = name

    def open(self, name: str) -> None:
        """A saved one becomes the one that is shown to all users.  KeyError: there is none of that name."""
        if self._kept is not None:
            raise ValueError("a recording runs; stop it first")
        from gateway.scope.recording import RecordingError, load

        path = self.folder / f"{name}.scope"
        if not path.exists():
            raise KeyError(f"no recording {name}")
        self.why = ""
        try:
            self._show(load(path), name)
        except RecordingError as error:
            raise ValueError(str(error)) from error
