"""Retained data of a run inside the services: restored at a start, and kept while it runs (AX-423, AX-425).

Restored: flags, markers and counters of the control, offsets of belts, named values (marked stale: their source has not sent yet).
Not restored, even if listed in [retain]: signals of telegrams and values whose edge sends one, RC inputs, commands, control.
"""

import math
import pathlib
from collections.abc import Mapping
from typing import Protocol, runtime_checkable

from gateway.assembly.contact_regions import OFFSETS, OFFSETS_LAYOUT
from gateway.assembly.telegrams import watched
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.controllers.control import Control
from gateway.pure.controllers.reis.regulator import Reference
from gateway.pure.image.error_list import ErrorList, ErrorRecord
from gateway.pure.image.records.cell import Quality
from gateway.runtime.clock import wall
from gateway.runtime.regions import RegionReader
from gateway.runtime.retained.store import Record
from gateway.runtime.retained.writer import Retained
from gateway.services.context import RunContext
from gateway.services.part import Part
from gateway.services.shared_image import SharedImage
from gateway.services.value_directory import ValueDirectory
from protocols.base.machine import Ns

NO_FDS: Mapping[str, int] = {}
ERRORS, CONFIGURATION, SYNCHRONISM = "error", "configuration", "synchronism"  # kinds of history
FLAGS, COUNTER, BELT, SOURCE = "flags.M", "counter", "belt", "retained"
COUNTERS = 32  # the most a PIC has (P3)


LOOK_EVERY, FIRST_LOOK = 20, 10  # ticks


@runtime_checkable
class Synchronising(Protocol):
    """A control whose axes are synchronised with machine data: a Reis."""

    @property
    def synchronised(self) -> Mapping[int, Reference]:
        """Axis -> machine data of its last synchronisation."""

    def was_synchronised(self, known: Mapping[int, Reference]) -> None:
        """Before the first step."""


class RetainedData(Part):
    """Values of the last run in, values of this one out; a run that keeps nothing has none."""

    def __init__(
        self,
        run: RunContext,
        image: SharedImage,
        values: ValueDirectory,
        dispatcher: CommandDispatcher,
        errors: ErrorList,
        path: pathlib.Path,
        now: Ns,
        fds: Mapping[str, int] = NO_FDS,
    ) -> None:
        self._run, self._image, self._values, self._dispatcher, self._list = run, image, values, dispatcher, errors
        self._offsets = RegionReader(fds["belts"], "belts", OFFSETS_LAYOUT) if "belts" in fds else None
        self._errors: dict[tuple[int, str, str], ErrorRecord] = {}
        self._synchronised: dict[int, Reference] = {}
        self._written = False  # this run has written the data its axes are synchronised with
        self._ticks = 0
        retain, journal = run.cell.retain, run.journal
        self.kept = Retained(path, retain.values if retain else (), lambda sentence: journal.write("retain", sentence))
        self._restore_named(self.kept, now)
        self._configured(self.kept)

    # ---- in ----------------------------------------------------------------------------------------------------------
    def restore(self, control: Control | None) -> None:
        """Flags or markers and counters of the control; before its first step."""
        kept = self.kept
        if control is None:
            return
        flags = kept.block(FLAGS, len(control.retained())) if kept.values("flags") else b""
        numbers = [number for number in range(COUNTERS) if control.counter(number) is not None]
        counters = {number: kept.value(f"{COUNTER}.{number}", -1) for number in numbers}
        control.restore(bytes(flags), {number: left for number, left in counters.items() if isinstance(left, int) and left >= 0})
        if isinstance(control, Synchronising):
            self._synchronised = dict(known_references(kept.last(SYNCHRONISM)) or control.synchronised)
            control.was_synchronised(self._synchronised)

    def _restore_named(self, kept: Retained, now: Ns) -> None:
        named, sets_off = self._values.named, set(watched(self._run.cell.telegram))
        for name, value in kept.values("order").items():
            if name in named and name not in named.signals | sets_off and not isinstance(value, bytes):
                named.put(name, value, now, SOURCE)
        named.source_gone(SOURCE)

    # ---- out ---------------------------------------------------------------------------------------------------------
    def look(self) -> None:
        """A few times a second: hand changed values to the writer."""
        kept, control = self.kept, self._image.control
        if control is not None:
            kept.keep_block(FLAGS, control.retained())
            counters = {f"{COUNTER}.{number}": control.counter(number) for number in range(COUNTERS)}
            kept.keep_all({name: left for name, left in counters.items() if left is not None})
            if isinstance(control, Synchronising):
                self._keep_synchronism(kept, control)
        self._keep_named(kept)
        if self._offsets is not None:
            self._belts(kept, self._offsets)
        self._log(kept)

    def _keep_synchronism(self, kept: Retained, control: Synchronising) -> None:
        if control.synchronised != self._synchronised or (kept.last(SYNCHRONISM) is None and not self._written):
            self._synchronised, self._written = dict(control.synchronised), True
            kept.record(SYNCHRONISM, {str(axis): [data.home, data.offset, data.direction] for axis, data in control.synchronised.items()})

    def _belts(self, kept: Retained, region: RegionReader) -> None:
        """Offsets of belts from the cycle; a restarted cycle gets the kept ones before any of its own are kept (AX-480)."""
        payload, dispatcher = region.read(), self._dispatcher
        if payload is None or dispatcher.cell is None or not dispatcher.cell.generation:
            return
        for place, (belt, offset) in enumerate(zip(self._run.cell.belt, OFFSETS.unpack(payload), strict=False)):
            name = f"{BELT}.{belt.name}.offset"
            if not math.isnan(offset):
                kept.keep(name, offset)
            elif belt.bus:
                before = kept.value(name, math.nan)
                dispatcher.restore_belt_offset(place, before if isinstance(before, float) else math.nan)

    def _keep_named(self, kept: Retained) -> None:
        named = self._values.named
        for name in named.names():
            if name.startswith("order.") and name not in named.signals:
                sample = named.sample(name)
                if sample.quality is Quality.GOOD and isinstance(sample.value, int | float | str):
                    kept.keep(name, sample.value)

    def _log(self, kept: Retained) -> None:
        """Errors that came into the list since the last look."""
        listed = {(record.code, record.source, record.where): record for record in self._list.records}
        for key, record in listed.items():
            if key not in self._errors:
                kept.record(ERRORS, {"wall": wall(), "code": record.code, "source": record.source, "where": record.where})
        self._errors = listed

    def _configured(self, kept: Retained) -> None:
        """The cell file and the version, once for each change."""
        import hashlib
        import importlib.metadata

        try:
            text = pathlib.Path(self._run.cell.file).read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError):
            return
        version = importlib.metadata.version("axisgate")
        digest = hashlib.sha256(text.encode()).hexdigest()
        last = kept.last(CONFIGURATION)
        if last is None or (last.get("sha256"), last.get("version")) != (digest, version):
            kept.record(CONFIGURATION, {"wall": wall(), "version": version, "sha256": digest, "text": text})

    def status(self) -> dict[str, object]:
        """For `links`; nothing where nothing is kept."""
        kept = self.kept
        if not kept.on:
            return {}
        return {"retain": {"writes": kept.writes, "failures": kept.failures, "dropped": kept.dropped}}

    def step(self, now: Ns) -> None:
        self._ticks += 1
        if self._ticks % LOOK_EVERY == FIRST_LOOK:
            self.look()

    async def close(self) -> None:
        """The last look, and everything is on the disk."""
        self.look()
        self.kept.close()


def known_references(record: Record | None) -> dict[int, Reference]:
    """Machine data each axis was synchronised with, as they were kept; {}: nothing usable was."""
    known: dict[int, Reference] = {}
    for axis, data in (record or {}).items():
        match data:
            case [int() | float() as home, int() as offset, int() as direction] if axis.isdecimal():
                known[int(axis)] = Reference(float(home), offset, direction)
    return known
