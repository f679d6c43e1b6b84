"""Retained data of a run inside the services: what a start brings back, and what is kept while it runs (AX-423, AX-425).

Brought back: flags, markers and counters of the control, named values (marked stale: their source has not spoken yet).  Not brought
back, whatever [retain] says: signals of telegrams and values whose edge sends one, RC inputs, commands, control.
"""

import pathlib
from typing import TYPE_CHECKING

from gateway.clock import wall
from gateway.pure.errorlist import ErrorRecord
from gateway.pure.records import Quality
from gateway.telegramtables import watched
from protocols.base.machine import Ns

if TYPE_CHECKING:
    from gateway.assembly import RunPlan
    from gateway.controllers import Control
    from gateway.processes.services import Services
    from gateway.retain import Retained

ERRORS, CONFIGURATION = "error", "configuration"  # kinds of history
FLAGS, COUNTER, SOURCE = "flags.M", "counter", "retained"
COUNTERS = 32  # the most a PIC has (P3)


class RetainDesk:
    """Values of the last run in, values of this one out.  A run that keeps nothing has an empty desk and loads nothing."""

    def __init__(self, services: "Services", now: Ns) -> None:
        self._services = services
        self._errors: dict[tuple[int, str, str], ErrorRecord] = {}
        path = file_of(services.plan)
        self.kept = None if path is None else self._retained(path)
        if self.kept is not None:
            self._restore_named(self.kept, now)
            self._configured(self.kept)

    def _retained(self, path: pathlib.Path) -> "Retained":
        from gateway.retain import Retained  # only who keeps something pays for it

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
        self._keep_named(kept)
        self._log(kept)

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


def file_of(plan: "RunPlan") -> pathlib.Path | None:
    """Beside the cell file on a machine; in the folder of the run in a simulation, and only where the cell has [retain]."""
    if plan.simulated:
        return plan.folder / "retain.sqlite" if plan.cell.retain else None
    from gateway.retain import path_of

    return path_of(plan.cell)
