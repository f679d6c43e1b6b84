"""The journal's last entries, followed as it grows."""

import json
import pathlib
from collections import deque
from typing import Any

from gateway.runtime.journal import JournalReader

KEPT = 500
TAIL = 256 * 1024  # bytes read of a long journal at first
Row = dict[str, Any]


class Events:
    """Entries of one journal; `number` counts those read."""

    def __init__(self, path: pathlib.Path) -> None:
        self._reader = JournalReader(path, TAIL)
        self.kept: deque[Row] = deque(maxlen=KEPT)
        self.number = 0

    def look(self) -> None:
        """Read new entries; a rotated journal is followed into the new file."""
        for line in self._reader.lines():
            self._take(line)

    def _take(self, line: bytes) -> None:
        try:
            entry = json.loads(line)
        except ValueError:
            return
        if isinstance(entry, dict):
            self.number += 1
            names = ("wall", "process", "kind", "text", "source", "reason")
            self.kept.append({"n": self.number, **{name: entry[name] for name in names if name in entry}})
