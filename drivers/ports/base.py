"""Interface of a port: it moves bytes or frames and decides nothing.

A broken cable, a missing adapter or a dead broker is a PortError; an empty port is an empty list.
"""

import os
import pathlib
import stat
from collections.abc import Sequence
from typing import Protocol

from protocols.base.machine import Damage, Frame, FrameFault, Ns


class PortError(OSError):
    """The port cannot be opened or is lost; the message names the port and the remedy."""


class BytePort(Protocol):
    """A serial line, pty, TCP connection or memory pipe.  Nothing here ever blocks."""

    name: str
    char_ns: Ns  # time of one character on the line; 0: no pace (a bare pty, memory)

    def fileno(self) -> int: ...  # readable when read() has something
    def read(self) -> list[bytes | Damage]: ...  # in line order; [] when nothing waits; PortError when gone
    def write(self, data: bytes) -> int: ...  # number of bytes accepted; PortError when lost
    def unsent(self) -> int: ...  # accepted bytes that have not left the line yet
    def close(self) -> None: ...


class CanPort(Protocol):
    """A CAN interface.  Nothing here ever blocks."""

    name: str

    def fileno(self) -> int: ...
    def send(self, frames: Sequence[Frame]) -> int: ...  # number of frames accepted (in order); PortError when lost
    def receive(self) -> list[Frame]: ...  # everything that waits, with stamps; PortError when gone
    def receive_next(self) -> list[Frame]: ...  # the same, but some of it may be left for the next call where that is cheaper
    def take_faults(self) -> list[tuple[FrameFault, Ns]]: ...  # error frames since the last call, with their stamps; after receive()
    def close(self) -> None: ...


def runtime_dir() -> pathlib.Path:
    """Folder for sockets and links: $AXISGATE_RUNTIME, else $XDG_RUNTIME_DIR/axisgate, else /tmp/axisgate-UID; mode 0700."""
    named = os.environ.get("AXISGATE_RUNTIME")
    session = os.environ.get("XDG_RUNTIME_DIR")
    usual = pathlib.Path(session, "axisgate") if session else pathlib.Path(f"/tmp/axisgate-{os.getuid()}")
    folder = pathlib.Path(named) if named else usual
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    info = folder.lstat()
    if not stat.S_ISDIR(info.st_mode) or info.st_uid != os.getuid():
        raise PortError(f"{folder}: is not a folder of this user; set AXISGATE_RUNTIME to one that is")
    return folder
