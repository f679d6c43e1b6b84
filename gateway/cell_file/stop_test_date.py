"""`last_stop_test` of [safety], written into the cell file after a stop test on the machine itself; everything else stays unchanged."""

import datetime
import os
import pathlib
import re

from gateway.files.find import PACKAGED
from gateway.pure.reports.toml_lines import lines_of

KEY = ("safety", "last_stop_test")
_DATE = re.compile(r"=\s*\S+")


class NotWritten(Exception):
    """Why, and the alternative."""


def write(file: pathlib.Path, day: datetime.date) -> int:
    """Its present line.  NotWritten: a shipped file, one without [safety], or a read-only one."""
    line = f"last_stop_test = {day.isoformat()}"
    if file.resolve().is_relative_to(PACKAGED):
        raise NotWritten(f"{file} is shipped with axisgate; in a copy of your own write: {line}")
    text = file.read_text(encoding="utf-8")
    place, changed = dated(text, day)
    if not place:
        raise NotWritten(f"{file} has no [safety]; with the others of its keys write there: {line}")
    beside = file.with_name(f".{file.name}.new")
    try:
        beside.write_text(changed, encoding="utf-8")
        os.chmod(beside, file.stat().st_mode & 0o777)
        beside.replace(file)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise NotWritten(f"{file}: {error.strerror}; write into [safety]: {line}") from error
    return place


def dated(text: str, day: datetime.date) -> tuple[int, str]:
    """Line (1..) of the date and the complete text with it; 0: there is no [safety]."""
    places, lines = lines_of(text), text.splitlines(keepends=True)
    if KEY in places:
        number = places[KEY]
        lines[number - 1] = _DATE.sub(f"= {day.isoformat()}", lines[number - 1], count=1)
        return number, "".join(lines)
    if KEY[:1] not in places:
        return 0, text
    number = places[KEY[:1]] + 1
    lines[number - 2] = lines[number - 2].rstrip("\r\n") + "\n"
    lines.insert(number - 1, f"last_stop_test = {day.isoformat()}\n")
    return number, "".join(lines)
