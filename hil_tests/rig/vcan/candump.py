"""Debian's candump as a witness: it records a CAN interface outside our code; what it wrote is read back here."""

import contextlib
import pathlib
import re
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass

LISTENERS = pathlib.Path("/proc/net/can/rcvlist_all")
LINE = re.compile(r"\((?P<s>\d+)\.(?P<us>\d{6})\) (?P<interface>\S+) (?P<id>[0-9A-F]{3})#(?P<data>[0-9A-F]*)$")
READY_S = 10.0  # the guest is slow: longest wait for candump's socket, and for its end


@dataclass(frozen=True, slots=True)
class Recorded:
    """A frame as candump saw it; the stamp is the kernel's wall clock."""

    stamp_us: int
    identifier: int
    data: bytes


@contextlib.contextmanager
def candump(log: pathlib.Path, interface: str = "vcan0") -> Iterator[None]:
    """While inside, every frame of the interface goes to `log`; candump listens before the body begins."""
    before = listeners(interface)
    with log.open("wb") as file:
        process = subprocess.Popen(["candump", "-L", interface], stdout=file)
        try:
            until = time.monotonic() + READY_S
            while listeners(interface) == before:
                assert process.poll() is None, f"candump {interface} ended with {process.returncode}"
                assert time.monotonic() < until, f"candump opened no socket on {interface} within {READY_S} s"
                time.sleep(0.01)
            yield
            time.sleep(0.1)  # what is in its socket's queue
        finally:
            process.terminate()
            process.wait(READY_S)


def listeners(interface: str) -> int:
    """How many sockets take every frame of this interface."""
    return sum(line.split()[:1] == [interface] for line in LISTENERS.read_text().splitlines())


def read(log: pathlib.Path) -> list[Recorded]:
    """The frames of a candump -L log; a line that is none is an error."""
    found = []
    for number, text in enumerate(log.read_text().splitlines(), 1):
        match = LINE.match(text)
        assert match, f"{log}:{number}: not a line of candump -L: {text!r}"
        stamp = int(match["s"]) * 1_000_000 + int(match["us"])
        found.append(Recorded(stamp, int(match["id"], 16), bytes.fromhex(match["data"])))
    return found
