"""The journal's last entries, followed as it grows."""

import json
import pathlib
from collections import deque
from typing import Any

KEPT = 500
TAIL = 256 * 1024  # bytes read of a long journal at first
Row = dict[str, Any]


class Events:
    """Entries of one journal; `number` counts those read."""

    def __init__(self, path: pathlib.Path) -> None:
        self._path = path
        self._at = 0
        self._rest = b""
        self.kept: deque[Row] = deque(maxlen=KEPT)
        self.number = 0

    def look(self) -> None:
        """Read what is new; a journal that was moved away is begun again."""
        try:
            size = self._path.stat().st_size
            if size < self._at:
                self._at, self._rest = 0, b""
            if size == self._at:
                return
            with self._path.open("rb") as file:
                first = self._at == 0 and size > TAIL
                file.seek(size - TAIL if first else self._at)
                data = file.read(TAIL)
                self._at = file.tell()
        except OSError:
            return
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines[1 if first else 0 :]:
            self._take(line)

    def _take(self, line: bytes) -> None:
        try:
            entry = json.loads(line)
        except ValueError:
            return
        if isinstance(entry, dict):
            self.number += 1
            names = ("wall", "process", "kind", "text", "door", "reason")
            self.kept.append({"n": self.number, **{name: entry[name] for name in names if name in entry}})
