"""The alarms of a cell over time: what came, who acknowledged it, when it went (AX-642).

A list of errors goes in each time it is made; records come out when something changed.  Records of an earlier run go in as they were
written, so numbers count on, and alarms pending when that run ended are gone.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

Record = dict[str, object]
MOST_OPEN = 500  # more are not errors of one cell but a fault of what reports them
_MEASURED = re.compile(r"-?\d+\.\d+")  # the same alarm, though the following error it names grows


@dataclass(slots=True)
class OpenAlarm:
    """An alarm that has not gone, or was not acknowledged."""

    number: int
    code: int
    text: str
    source: str
    gone: bool = False
    acknowledged: bool = False


class Alarms:
    """`names`: of axes, of contacts, of lines, of buses; the first group with a name in a text has its source."""

    def __init__(self, names: Iterable[Iterable[str]], before: Iterable[Mapping[str, object]] = ()) -> None:
        groups = [sorted({name for name in group if name}, key=len, reverse=True) for group in names]
        self._names = [re.compile("|".join(rf"(?<![\w.]){re.escape(name)}(?!\w)" for name in group)) for group in groups if group]
        self._open: dict[tuple[int, str, str], OpenAlarm] = {}
        self._number = 0
        for record in before:
            self._again(record)
        self.left_over = [alarm.number for alarm in self._open.values() if not alarm.gone]
        self._open.clear()

    def source(self, text: str) -> str:
        """Which part of the cell a text is about."""
        found = (names.search(text) for names in self._names)
        return next((each[0] for each in found if each is not None), "cell")

    def look(self, errors: Iterable[tuple[int, str]]) -> list[Record]:
        """What came and what went since the last list."""
        now = {self._key(code, text): (code, text) for code, text in errors}
        records: list[Record] = []
        for key, alarm in list(self._open.items()):
            if key not in now and not alarm.gone:
                alarm.gone = True
                records.append({"what": "gone", "number": alarm.number})
                if alarm.acknowledged:
                    del self._open[key]
        for key, (code, text) in now.items():
            before = self._open.get(key)
            if before is not None and not before.gone:
                continue
            if len(self._open) >= MOST_OPEN:
                self._forget()
            self._number += 1
            self._open[key] = OpenAlarm(self._number, int(code), text, key[1])
            records.append({"what": "came", "number": self._number, "code": int(code), "text": text, "source": key[1]})
        return records

    def acknowledge(self, who: str) -> list[Record]:
        """Faults were reset: everything pending or unseen is acknowledged."""
        records: list[Record] = []
        for key, alarm in list(self._open.items()):
            if not alarm.acknowledged:
                alarm.acknowledged = True
                records.append({"what": "acknowledged", "number": alarm.number, "by": who})
            if alarm.gone:
                del self._open[key]
        return records

    def _key(self, code: int, text: str) -> tuple[int, str, str]:
        return int(code), self.source(text), _MEASURED.sub("#", text)

    def _forget(self) -> None:
        del self._open[next(iter(self._open))]

    def _again(self, record: Mapping[str, object]) -> None:
        number = record.get("number")
        if not isinstance(number, int):
            return
        self._number = max(self._number, number)
        match record.get("what"):
            case "came":
                self._open[number, "", ""] = OpenAlarm(number, 0, "", "")
            case "gone":
                self._open.pop((number, "", ""), None)


def alarm_rows(records: Iterable[Mapping[str, object]]) -> list[Record]:
    """One row an alarm, the newest first: number, code, text, source, came, acknowledged, by, gone; foreign records are left out."""
    rows: dict[int, Record] = {}
    for record in records:
        number, what, wall = record.get("number"), record.get("what"), record.get("wall")
        if not isinstance(number, int) or not isinstance(wall, str):
            continue
        if what == "came":
            fields = {name: record.get(name, "") for name in ("code", "text", "source")}
            rows[number] = {"number": number, **fields, "came": wall, "acknowledged": "", "by": "", "gone": ""}
        elif number in rows and what in ("acknowledged", "gone") and not rows[number][what]:
            rows[number][what] = wall
            if what == "acknowledged":
                rows[number]["by"] = record.get("by", "")
    return list(reversed(rows.values()))
