"""Addresses and ports that come late, as at power-up: a listener waits for them and reports it once; nothing else stops."""

import asyncio
import errno
import socket
from collections.abc import Awaitable, Callable
from typing import TypeVar

from gateway.runtime.life import BEAT_S

LATE = {errno.EADDRNOTAVAIL: "no interface of this machine has this address yet", errno.EADDRINUSE: "another program has this port"}
RETRY_S = 1.0

T = TypeVar("T")


def listening(host: str, port: int) -> socket.socket:
    """A bound socket; the caller makes it listen.  OSError."""
    found = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind((host.strip("[]"), port))
        found.listen(128)
    except (OSError, OverflowError):
        found.close()
        raise
    return found


async def patiently(
    what: str,
    start: Callable[[], Awaitable[T]],
    say: Callable[[str], None],
    beat: Callable[[], None] = lambda: None,
    ended: Callable[[], bool] = lambda: False,
) -> T | None:
    """The result of `start`, as soon as its address is available; None: `ended` came first.  Any other OSError is raised."""
    waited = False
    while not ended():
        try:
            made = await start()
        except OSError as error:
            if error.errno not in LATE:
                raise
            if not waited:
                say(f"{what}: {LATE[error.errno]}; tried again every second until it exists")
            waited = True
        else:
            if waited:
                say(f"{what}: listens now")
            return made
        for _ in range(round(RETRY_S / BEAT_S)):
            beat()
            await asyncio.sleep(BEAT_S)
    return None
