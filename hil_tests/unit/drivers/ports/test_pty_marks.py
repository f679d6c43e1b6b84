"""Who gets damage marks at a pty that offers them: a port that asks by its lock, and nobody else (AX-1400)."""

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator

import pytest

from drivers.ports.base import PortError
from drivers.ports.serial.line_format import parse_format
from drivers.ports.serial.pty import PtyPort, marks_asked, offer_marks

FORMAT = parse_format("9600 8E1")
FOREIGN = """
import fcntl, sys
file = open(sys.argv[1], "r+b", buffering=0)
fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
print("locked", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def offered() -> Iterator[tuple[int, str]]:
    """The line process' descriptor of a side that offers marks, and the name a program opens."""
    master, slave = os.openpty()
    offer_marks(slave)
    yield slave, os.ttyname(slave)
    for fd in (master, slave):
        with contextlib.suppress(OSError):
            os.close(fd)


def test_a_port_asks_for_marks_until_it_is_closed(offered: tuple[int, str]) -> None:
    fd, name = offered
    assert not marks_asked(fd)
    port = PtyPort(name, FORMAT)
    assert marks_asked(fd)
    port.close()
    assert not marks_asked(fd)


def test_a_foreign_program_that_locks_the_whole_pty_asks_for_nothing(offered: tuple[int, str]) -> None:
    fd, name = offered
    with subprocess.Popen([sys.executable, "-c", FOREIGN, name], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as foreign:
        assert foreign.stdout is not None and foreign.stdout.readline() == b"locked\n"
        assert not marks_asked(fd)
        with pytest.raises(PortError, match="is used by another program"):
            PtyPort(name, FORMAT)
        foreign.communicate()
    PtyPort(name, FORMAT).close()
