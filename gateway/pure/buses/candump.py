"""Lines of `candump -L` and of the log of axisgate's broker (AX-095: three more numbers after the frame, remarks after #)."""

import re
from collections.abc import Iterable, Iterator

from protocols.base.machine import Frame

_LINE = re.compile(r"\((\d+)\.(\d{6})\) \S+ ([0-9A-Fa-f]{3})#([0-9A-Fa-f]{0,16})(?:\s|$)")


_ANY = re.compile(r"\((\d+)\.(\d{6})\) \S+ ([0-9A-Fa-f]{8}|[0-9A-Fa-f]{3})#(?:(R)([0-8])?|((?:[0-9A-Fa-f]{2}){0,8}))(?:\s|$)")
_FD = re.compile(r"\(\d+\.\d{6}\) \S+ [0-9A-Fa-f]+##")
EXTENDED, REMOTE = 0x80000000, 0x40000000  # marks of struct can_frame


def is_fd(line: str) -> bool:
    """A frame of CAN FD, which no bus here has."""
    return _FD.match(line) is not None


def marked_frames_of(lines: Iterable[str]) -> Iterator[Frame]:
    """Data and remote frames, also extended ones, with the marks of struct can_frame; a remote frame has as many zeros as it asks for."""
    for line in lines:
        found = _ANY.match(line)
        if found is not None:
            marks = (EXTENDED if len(found[3]) == 8 else 0) | (REMOTE if found[4] else 0)
            data = bytes(int(found[5] or 0)) if found[4] else bytes.fromhex(found[6])
            yield Frame(int(found[3], 16) | marks, data, int(found[1]) * 1_000_000_000 + int(found[2]) * 1000)


def frames_of(lines: Iterable[str]) -> Iterator[Frame]:
    """Data frames with 11-bit identifiers; everything else (remarks, remote, error and extended frames) is passed over."""
    for line in lines:
        found = _LINE.match(line)
        if found is not None and len(found[4]) % 2 == 0:
            yield Frame(int(found[3], 16), bytes.fromhex(found[4]), int(found[1]) * 1_000_000_000 + int(found[2]) * 1000)
