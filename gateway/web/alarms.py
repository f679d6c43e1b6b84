"""The history of alarms for the page: filtered, or as a file."""

import asyncio
import json
import pathlib
from collections.abc import Mapping
from typing import Any

from starlette.responses import Response

from gateway.services.alarm_file import alarm_rows, as_csv, read
from gateway.web.german import both

MOST = 1000
STATES = ("active", "open", "gone")  # not gone; not acknowledged yet; gone
KINDS = {"csv": "text/csv; charset=utf-8", "json": "application/json"}
Row = dict[str, Any]


class AlarmHistory:
    """One file, read again when it changed."""

    def __init__(self, path: pathlib.Path) -> None:
        self._path = path
        self._seen: tuple[int, int] | None = None
        self._rows: list[Row] = []

    @property
    def version(self) -> str:
        """Another one when there is something new."""
        try:
            found = self._path.stat()
        except OSError:
            return ""
        return f"{found.st_ino}-{found.st_size}"

    async def found(self, query: Mapping[str, str]) -> Row:
        """Rows that fit, the newest first, and the sources there are; ValueError: no such state."""
        rows = await self._all()
        fitting = [row for row in rows if fits(row, query)]
        sources = sorted({str(row["source"]) for row in rows})
        shown = [{**row, "say": both(int(str(row["code"])), str(row["text"]))} for row in fitting[:MOST]]
        return {"alarms": shown, "total": len(fitting), "sources": sources}

    async def file(self, query: Mapping[str, str]) -> Response:
        """Matching alarms, as CSV or JSON."""
        kind = query.get("as", "csv")
        if kind not in KINDS:
            raise ValueError(f"as: {', '.join(KINDS)}")
        rows = [row for row in await self._all() if fits(row, query)]
        data = "\ufeff" + as_csv(rows) if kind == "csv" else json.dumps(rows, ensure_ascii=False)
        return Response(data, media_type=KINDS[kind], headers={"content-disposition": f'attachment; filename="alarms.{kind}"'})

    async def _all(self) -> list[Row]:
        try:
            found = self._path.stat()
        except OSError:
            return []
        seen = (found.st_mtime_ns, found.st_size)
        if seen != self._seen:
            self._rows, self._seen = await asyncio.to_thread(lambda: alarm_rows(read(self._path))), seen
        return self._rows


def fits(row: Row, query: Mapping[str, str]) -> bool:
    """Words of the text, a state, a source, a time from and to (as their beginning is written: 2026-11-23T08)."""
    state, source = query.get("state", ""), query.get("source", "")
    if state and state not in STATES:
        raise ValueError(f"state: {', '.join(STATES)}")
    wanted = {"active": not row["gone"], "open": not row["acknowledged"], "gone": bool(row["gone"]), "": True}[state]
    words = f"{row['code']} {row['source']} {row['text']} {row['by']}".lower()
    came = str(row["came"])
    begins, ends = query.get("from", ""), query.get("to", "")
    within = (not begins or came >= begins) and (not ends or came[: len(ends)] <= ends)
    return (
        wanted and within and (not source or row["source"] == source) and all(word in words for word in query.get("q", "").lower().split())
    )
