"""The history of alarms on disk: one JSON object per line, bounded, kept over restarts; written by the services, read by the page."""

import contextlib
import csv
import io
import json
import pathlib
from collections.abc import Iterable

from gateway.assembly.run import RunPlan
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.jobs import DispatcherEvent
from gateway.pure.image.alarms import Alarms, Record, alarm_rows
from gateway.runtime.journal import Journal

LIMIT = 4 << 20  # bytes of one file; the previous one is kept as well: some 40,000 records
COLUMNS = ("number", "came", "acknowledged", "by", "gone", "code", "source", "text")


def path_of(plan: RunPlan) -> pathlib.Path:
    """Next to the retained data: in the folder `retain` on a machine, in the folder of the run in a simulation."""
    if plan.simulated:
        return plan.folder / "alarms.jsonl"
    from gateway.runtime.retained.writer import path_of as retained

    return retained(plan.cell).with_name(f"{pathlib.Path(plan.cell.file).stem}.alarms.jsonl")


def read(path: pathlib.Path) -> list[Record]:
    """All records, oldest first; a torn line is passed over."""
    records: list[Record] = []
    for file in (path.with_suffix(path.suffix + ".1"), path):
        with contextlib.suppress(OSError):
            for line in file.read_bytes().splitlines():
                with contextlib.suppress(ValueError):
                    record = json.loads(line)
                    if isinstance(record, dict):
                        records.append(record)
    return records


def as_csv(rows: Iterable[Record]) -> str:
    """For a spreadsheet: a line per row, semicolons as in German tables."""
    out = io.StringIO()
    writer = csv.writer(out, delimiter=";", lineterminator="\r\n")
    writer.writerow(COLUMNS)
    writer.writerows([[row[name] for name in COLUMNS] for row in rows])
    return out.getvalue()


class AlarmFile:
    """The alarm file of the services."""

    def __init__(self, plan: RunPlan) -> None:
        cell, path = plan.cell, path_of(plan)
        with contextlib.suppress(OSError):  # the journal of the history counts entries that it cannot write
            path.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
        lines = [*(line.name for line in cell.line), *(each.name for each in cell.modbus)]
        names = [axis.name for axis in cell.axis], [io.name for io in cell.io], lines, [bus.name for bus in cell.bus]
        self._alarms = Alarms(names, read(path))
        self._journal = Journal(path, "services", limit=LIMIT)
        self._sources = {source.number: source.name for source in plan.sources}
        self._inputs: dict[int, bool] = {}
        for number in self._alarms.left_over:
            self._write({"what": "gone", "number": number, "why": "the run ended"})

    def look(self, errors: Iterable[tuple[int, str]]) -> None:
        """The list of errors as it was made just now."""
        for record in self._alarms.look(errors):
            self._write(record)

    def event(self, event: DispatcherEvent, names: dict[int, str]) -> None:
        """A command of a command source: a fault reset acknowledges."""
        if event.code == Code.FAULT_RESET and event.what == "accepted":
            self.acknowledge(self._sources.get(event.source) or names.get(event.source) or f"command source {event.source}")

    def inputs(self, values: dict[int, bool]) -> None:
        """RC inputs that acknowledge, as they are; one that is on at the start acknowledges nothing."""
        for number, value in values.items():
            if value and not self._inputs.get(number, True):
                self.acknowledge(f"RC input {number}")
        self._inputs = values

    def acknowledge(self, who: str) -> None:
        for record in self._alarms.acknowledge(who):
            self._write(record)

    def close(self) -> None:
        self._journal.close()

    def _write(self, record: Record) -> None:
        text = str(record.pop("text", record["what"]))
        self._journal.write("alarm", text, **record)


__all__ = ["AlarmFile", "alarm_rows", "as_csv", "path_of", "read"]
