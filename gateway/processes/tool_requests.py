"""Requests of tools to a run, on runtime_dir()/SLUG.sock: Unix stream, one JSON line a request; each is answered once and closed.

A tool that connects and sends no request is closed after REQUEST_NS; the supervisor never waits for one.
"""

import contextlib
import json
import pathlib
import selectors
import socket
from collections.abc import Callable

from drivers.ports.base import PortError, runtime_dir
from gateway.runtime.clock import now_ns

REQUEST_NS = 2_000_000_000  # patience with a tool that has connected and sends no request
REQUEST_BYTES = 4096
TOOLS = 32  # connected at once; more wait
Answer = Callable[[socket.socket, dict[str, object]], None]


class ToolRequests:
    """Listens for tools; `answer` gets each request with its connection.  PortError: a run of this cell is already up."""

    def __init__(self, slug: str, selector: selectors.BaseSelector, answer: Answer) -> None:
        self.path: pathlib.Path = runtime_dir() / f"{slug}.sock"
        self._slug, self._selector, self._answer = slug, selector, answer
        self._tools: dict[socket.socket, tuple[int, bytearray]] = {}  # time of connection, text received so far
        self._socket = self._listen()

    def close(self) -> None:
        """Closes every connection and the socket; its file goes, too."""
        for tool in list(self._tools):
            self._forget(tool)
            tool.close()
        self._socket.close()
        with contextlib.suppress(OSError):
            self.path.unlink(missing_ok=True)

    def _listen(self) -> socket.socket:
        path = self.path
        listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        if path.exists():
            with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
                if probe.connect_ex(str(path)) == 0:
                    raise PortError(f"{path}: a run of cell {self._slug!r} is already up; stop it first (Ctrl-C there)")
            path.unlink()
        listener.bind(str(path))
        listener.listen(TOOLS)
        listener.setblocking(False)
        self._selector.register(listener, selectors.EVENT_READ, lambda _: self._accept(listener))
        return listener

    def _accept(self, listener: socket.socket) -> None:
        """A tool has connected.  Its request is read when it arrives; nothing waits for it."""
        with contextlib.suppress(OSError):
            connection, _ = listener.accept()
            if len(self._tools) >= TOOLS:
                connection.close()
                return
            connection.setblocking(False)
            self._tools[connection] = (now_ns(), bytearray())
            self._selector.register(connection, selectors.EVENT_READ, lambda _: self._listen_to(connection))

    def _listen_to(self, tool: socket.socket) -> None:
        """One request: a JSON object, its end marked by a newline or by being complete."""
        heard = self._tools[tool][1]
        try:
            data = tool.recv(REQUEST_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        heard += data
        request = _request(bytes(heard))
        if request is None and data and b"\n" not in heard and len(heard) < REQUEST_BYTES:
            return
        self._forget(tool)
        with tool, contextlib.suppress(OSError):
            if request is not None:
                self._answer(tool, request)
            elif heard:
                tool.sendall(b'{"error": "a JSON object with the key op is expected"}\n')

    def send_away(self) -> None:
        """Closes tools that connected and sent no request."""
        if not self._tools:
            return
        now = now_ns()
        for tool in [tool for tool, (since, _) in self._tools.items() if now - since > REQUEST_NS]:
            self._forget(tool)
            tool.close()

    def _forget(self, tool: socket.socket) -> None:
        del self._tools[tool]
        self._selector.unregister(tool)


def _request(heard: bytes) -> dict[str, object] | None:
    """The tool's request; None: no complete JSON object yet."""
    try:
        request = json.loads(heard)
    except ValueError:  # also invalid UTF-8
        return None
    return request if isinstance(request, dict) else None
