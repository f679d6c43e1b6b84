"""The page's ends of the sockets: services (command source 91), supervisor, emulators and line processes.  None of them ever waits for
us long."""

import asyncio
import contextlib
import json
from typing import Any

from drivers.ports.base import runtime_dir
from gateway.pure.cell.web import PAGE_SOURCE

PATIENCE_S = 4.0  # services are back within 3 s of their death
GLANCE_S = 0.4  # of looks, ten times a second: an answer that is late is not waited for
AGAIN_S = 0.1
HAND_S = 2.0  # for simulated parts
LONGEST = 1 << 20
Row = dict[str, Any]


class Gone(Exception):
    """The other side does not answer, in words for a person."""


class Refused(Exception):
    """It answered with an error, in its own words."""


class Link:
    """One connection of JSON lines that is made again when it broke; one request at a time."""

    def __init__(self, path: str, what: str, patience_s: float = PATIENCE_S) -> None:
        self.path, self.what, self._patience_s = path, what, patience_s
        self._lock = asyncio.Lock()
        self._reader: asyncio.StreamReader | None = None
        self._writer: asyncio.StreamWriter | None = None

    async def ask(self, **request: object) -> Row:
        """The answer; Gone: the socket does not answer."""
        async with self._lock:
            try:
                async with asyncio.timeout(self._patience_s):
                    return await self._asked(request)
            except (OSError, TimeoutError, ValueError, asyncio.IncompleteReadError) as error:
                self.close()
                raise Gone(f"{self.what}: no answer") from error
            except asyncio.CancelledError:
                self.close()  # its answer must not be read as the next request's
                raise

    async def _asked(self, request: dict[str, object]) -> Row:
        if self._reader is not None and self._reader.at_eof():  # it went away since the last request: nothing was sent to the new one yet
            self.close()
        while self._writer is None:
            try:
                self._reader, self._writer = await asyncio.open_unix_connection(self.path, limit=LONGEST)
            except OSError:
                await asyncio.sleep(AGAIN_S)  # within the time limit, and before anything was sent: no command is sent twice
        assert self._reader is not None
        self._writer.write(json.dumps(request).encode() + b"\n")
        await self._writer.drain()
        line = await self._reader.readline()
        if not line.endswith(b"\n"):
            raise ConnectionError("closed")
        answer = json.loads(line)
        if not isinstance(answer, dict):
            raise ValueError("a JSON object is expected")
        return answer

    def close(self) -> None:
        """Made again at the next request."""
        if self._writer is not None:
            with contextlib.suppress(OSError, RuntimeError):
                self._writer.close()
        self._reader = self._writer = None


class ServicesLink:
    """Command source 91 of the services."""

    def __init__(self, slug: str, patience_s: float = PATIENCE_S) -> None:
        self._link = Link(str(runtime_dir() / f"{slug}-services.sock"), "services", patience_s)

    async def ask(self, op: str, **request: object) -> Row:
        """Gone; Refused with the services' words."""
        answer = await self._link.ask(op=op, source=PAGE_SOURCE, **request)
        if "error" in answer:
            raise Refused(str(answer["error"]))
        return answer

    async def command(self, code: str, mask: int = 0, **rest: object) -> Row:
        """One command of the own block (AX-011): {job, state, reason, words, detail, open}."""
        return await self.ask("tool", code=code, mask=mask, **rest)

    def close(self) -> None:
        self._link.close()


async def supervisor(slug: str, op: str, **more: str) -> Row:
    """One request to the supervisor, which closes after its answer.  Gone."""
    link = Link(str(runtime_dir() / f"{slug}.sock"), "supervisor", GLANCE_S)
    try:
        return await link.ask(op=op, **more)
    finally:
        link.close()


class Hand:
    """A line process' or an emulator's control socket: {"do": ...} in, {"ok": ...} out."""

    def __init__(self, path: str, what: str) -> None:
        self._link = Link(path, what, HAND_S)

    async def ask(self, do: str, **arguments: object) -> Row:
        """Gone; Refused with its words."""
        answer = await self._link.ask(do=do, **arguments)
        if answer.pop("ok", False) is not True:
            raise Refused(str(answer.get("why", "refused")))
        return answer

    def close(self) -> None:
        self._link.close()
