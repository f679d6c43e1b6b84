"""The journal: one JSON object a line, appended by every process of a run (whole lines, so writers never mix)."""

import json
import os
import pathlib

from gateway.clock import now_ns, wall

LIMIT = 64 << 20  # a journal beyond this is moved to .1 when the next run starts


class Journal:
    """Append-only; `echo` also prints the sentence for a person."""

    def __init__(self, path: pathlib.Path | None, process: str, *, echo: bool = False) -> None:
        self._process, self._echo = process, echo
        self._fd = -1 if path is None else os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)

    def write(self, kind: str, text: str, **facts: object) -> None:
        """`kind` is a word to filter by (process, link, command, error), `text` the sentence."""
        moment = wall()
        record = {"wall": moment, "ns": now_ns(), "process": self._process, "kind": kind, "text": text, **facts}
        if self._fd >= 0:
            os.write(self._fd, (json.dumps(record, ensure_ascii=False, default=str) + "\n").encode())
        if self._echo:
            print(f"{moment[11:23]} {self._process}: {text}", flush=True)

    def close(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1


def rotate(path: pathlib.Path) -> None:
    """Keep one old journal when the present one has grown beyond LIMIT."""
    if path.exists() and path.stat().st_size > LIMIT:
        path.replace(path.with_suffix(path.suffix + ".1"))
