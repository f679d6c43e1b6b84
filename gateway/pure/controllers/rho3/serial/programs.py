"""Statements about the devices in a BAPS program: `;;SER_IO_STOP`, and CONDITION of a file.

Source: rho 3 Releases part 1, sections 9.1 and 9.3; part 2, section 12.6 (FILE_ERROR).
"""

import re
from collections.abc import Iterator

from protocols.base.errors import ProtocolError

SER_IO_STOP = re.compile(r";;\s*SER_IO_STOP\b\s*(?P<sign>[+-]?)\s*(;.*)?", re.IGNORECASE)
NAMED = re.compile(r";;\s*SER_IO_STOP\b", re.IGNORECASE)


class DirectiveError(ProtocolError):
    """A compiler instruction where or as it must not be; the message names the line."""


def ser_io_stop(source: str) -> bool:
    """Whether an I/O error aborts this program.  Raise DirectiveError: repeated, after the first statement, or malformed."""
    stop: bool | None = None
    started = False
    for number, line in _lines(source):
        if not NAMED.match(line):
            started = started or not line.startswith(";")
            continue
        match = SER_IO_STOP.fullmatch(line)
        if match is None:
            raise DirectiveError(f"line {number}: {line!r}; ;;SER_IO_STOP [+/-] expected")
        if started or stop is not None:
            raise DirectiveError(f"line {number}: ;;SER_IO_STOP is allowed once, at the beginning of the program")
        stop = match["sign"] != "-"
    return stop is not False


def _lines(source: str) -> Iterator[tuple[int, str]]:
    return ((number, line.strip()) for number, line in enumerate(source.splitlines(), 1) if line.strip())
