"""Retained data of a run inside the services: what a start brings back, and what is kept while it runs (AX-423, AX-425).

Brought back: flags, markers and counters of the control, offsets of belts, named values (marked stale: their source has not spoken yet).
Not brought back, even if listed in [retain]: signals of telegrams and values whose edge sends one, RC inputs, commands, control.
"""

import math
import pathlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

from gateway.assembly.contact_regions import OFFSETS, OFFSETS_LAYOUT
from gateway.assembly.telegrams import watched
from gateway.pure.image.error_list import ErrorRecord
from gateway.pure.image.records.cell import Quality
from gateway.runtime.clock import wall
from gateway.runtime.regions import RegionReader
from protocols.base.machine import Ns

if TYPE_CHECKING:
    from gateway.assembly.controllers import Control
    from gateway.assembly.run import RunPlan
    from gateway.pure.controllers.reis.control import ReisControl
    from gateway.pure.controllers.reis.regulator import Reference
    from gateway.runtime.retained.store import Record
    from gateway.runtime.retained.writer import Retained
    from gateway.services.loop import Services

NO_FDS: Mapping[str, int] = {}
ERRORS, CONFIGURATION, SYNCHRONISM = "error", "configuration", "synchronism"  # kinds of history
FLAGS, COUNTER, BELT, SOURCE = "flags.M", "counter", "belt", "retained"
COUNTERS = 32  # the most a PIC has (P3)


class RetainedData:
    """Values of the last run in, values of this one out.  A run that keeps nothing has an empty part and loads nothing."""

    def __init__(self, services: "Services", now: Ns, fds: Mapping[str, int] = NO_FDS) -> None:
        self._services = services
        self._offsets = RegionReader(fds["belts"], "belts", OFFSETS_LAYOUT) if "belts" in fds else None
        self._errors: dict[tuple[int, str, str], ErrorRecord] = {}
        self._synchronised: dict[int, Reference] = {}
        self._told = False  # this run has written what its axes are synchronised with
        path = file_of(services.plan)
        self.kept = None if path is None else self._retained(path)
        if self.kept is not None:
            self._restore_named(self.kept, now)
            self._configured(self.kept)

    def _retained(self, path: pathlib.Path) -> "Retained":
        from gateway.runtime.retained.writer import Retained  # only who keeps something pays for it

        journal, retain = self._services.journal, self._services.cell.retain
        return Retained(path, retain.values if retain else (), lambda sentence: journal.write("retain", sentence))

    # ---- in ----------------------------------------------------------------------------------------------------------
    def restore(self, control: "Control | None") -> None:
        """Flags or markers and counters of the control; before its first step."""
        kept = self.kept
        if control is None or kept is None:
            return
        flags = kept.block(FLAGS, len(control.retained())) if kept.values("flags") else b""
        numbers = [number for number in range(COUNTERS) if control.counter(number) is not None]
        counters = {number: kept.value(f"{COUNTER}.{number}", -1) for number in numbers}
        control.restore(bytes(flags), {number: left for number, left in counters.items() if isinstance(left, int) and left >= 0})
        reis = self._reis(control)
        if reis is not None:
            self._synchronised = dict(known_references(kept.last(SYNCHRONISM)) or reis.synchronised)
            reis.was_synchronised(self._synchronised)

    @staticmethod
    def _reis(control: "Control") -> "ReisControl | None":
        from gateway.pure.controllers.reis.control import ReisControl  # loaded long ago: there is a control

        return control if isinstance(control, ReisControl) else None

    def _restore_named(self, kept: "Retained", now: Ns) -> None:
        named, sets_off = self._services.named, set(watched(self._services.cell.telegram))
        for name, value in kept.values("order").items():
            if name in named and name not in named.signals | sets_off and not isinstance(value, bytes):
                named.put(name, value, now, SOURCE)
        named.source_gone(SOURCE)

    # ---- out ---------------------------------------------------------------------------------------------------------
    def look(self) -> None:
        """A few times a second: what has changed since is handed to the writer."""
        kept, control = self.kept, self._services.signals.control
        if kept is None:
            return
        if control is not None:
            kept.keep_block(FLAGS, control.retained())
            counters = {f"{COUNTER}.{number}": control.counter(number) for number in range(COUNTERS)}
            kept.keep_all({name: left for name, left in counters.items() if left is not None})
            reis = self._reis(control)
            if reis is not None and (reis.synchronised != self._synchronised or (kept.last(SYNCHRONISM) is None and not self._told)):
                self._synchronised, self._told = dict(reis.synchronised), True
                kept.record(SYNCHRONISM, {str(axis): [data.home, data.offset, data.direction] for axis, data in reis.synchronised.items()})
        self._keep_named(kept)
        if self._offsets is not None:
            self._belts(kept, self._offsets)
        self._log(kept)

    def _belts(self, kept: "Retained", region: RegionReader) -> None:
        """Offsets of belts out of the cycle; a cycle that has begun anew gets what was kept before anything of it is (AX-480)."""
        payload, office = region.read(), self._services.office
        if payload is None or office.cell is None or not office.cell.generation:
            return
        for place, (belt, offset) in enumerate(zip(self._services.cell.belt, OFFSETS.unpack(payload), strict=False)):
            name = f"{BELT}.{belt.name}.offset"
            if not math.isnan(offset):
                kept.keep(name, offset)
            elif belt.bus:
                before = kept.value(name, math.nan)
                office.belt_stood(place, before if isinstance(before, float) else math.nan)

    def _keep_named(self, kept: "Retained") -> None:
        named = self._services.named
        for name in named.names():
            if name.startswith("order.") and name not in named.signals:
                sample = named.sample(name)
                if sample.quality is Quality.GOOD and isinstance(sample.value, int | float | str):
                    kept.keep(name, sample.value)

    def _log(self, kept: "Retained") -> None:
        """Errors that came into the list since the last look."""
        standing = {(record.code, record.source, record.where): record for record in self._services.signals.errors.records}
        for key, record in standing.items():
            if key not in self._errors:
                kept.record(ERRORS, {"wall": wall(), "code": record.code, "source": record.source, "where": record.where})
        self._errors = standing

    def _configured(self, kept: "Retained") -> None:
        """The cell file and the version, once for each change."""
        import hashlib
        import importlib.metadata

        try:
            text = pathlib.Path(self._services.cell.file).read_text(encoding="utf-8-sig")
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
        if kept is None or not kept.on:
            return {}
        return {"retain": {"writes": kept.writes, "failures": kept.failures, "dropped": kept.dropped}}

    def close(self) -> None:
        """The last look, and everything is on the disk."""
        if self.kept is not None:
            self.look()
            self.kept.close()


def known_references(record: "Record | None") -> "dict[int, Reference]":
    """Machine data each axis was synchronised with, as they were kept; {}: nothing usable was."""
    from gateway.pure.controllers.reis.regulator import Reference

    known: dict[int, Reference] = {}
    for axis, data in (record or {}).items():
        match data:
            case [int() | float() as home, int() as offset, int() as direction] if axis.isdecimal():
                known[int(axis)] = Reference(float(home), offset, direction)
    return known


def file_of(plan: "RunPlan") -> pathlib.Path | None:
    """Beside the cell file on a machine; in the folder of the run in a simulation, and only where the cell has [retain]."""
    if plan.simulated:
        return plan.folder / "retain.sqlite" if plan.cell.retain else None
    from gateway.runtime.retained.writer import path_of

    return path_of(plan.cell)
