"""Requests to the supervisor of a run, at its socket in the runtime folder."""

import contextlib
import json
import socket
import time

from drivers.ports.base import PortError, runtime_dir

RETRY_S = 0.01


def ask(slug: str, op: str, timeout_s: float = 5.0, **more: str) -> socket.socket:
    """Open connection with the request sent; the caller reads the answer.  PortError when no such run is up."""
    path = runtime_dir() / f"{slug}.sock"
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    connection.settimeout(timeout_s)
    try:
        _connect(connection, str(path), time.monotonic() + timeout_s)
        connection.sendall(json.dumps({"op": op, **more}).encode())
    except OSError as error:
        connection.close()
        raise PortError(f"no run {slug!r} answers ({path}: {error.strerror}); start it with: axisgate run CELL --sim") from error
    return connection


def _connect(connection: socket.socket, path: str, until: float) -> None:
    """Retry while the queue is full: it refuses a socket that has a time-out at once (unix(7): EAGAIN)."""
    while True:
        try:
            connection.connect(path)
            return
        except BlockingIOError:
            if time.monotonic() > until:
                raise
            time.sleep(RETRY_S)


def wait_up(slug: str, seconds: float) -> bool:
    """True when cycle and services of the run are up within `seconds`."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        with contextlib.suppress(OSError, ValueError):
            connection = ask(slug, "status")
            with connection:
                status = json.loads(connection.makefile().readline())
            if all(p["state"] == "up" and (p["life_age_ms"] or 0) < 1000 for p in status["processes"]):
                return True
        time.sleep(0.05)
    return False
