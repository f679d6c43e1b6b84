"""Lines of `candump -L` and of our own broker's log (AX-095: three more numbers behind the frame, remarks behind #)."""

import re
from collections.abc import Iterable, Iterator

from protocols.base.machine import Frame

_LINE = re.compile(r"\((\d+)\.(\d{6})\) \S+ ([0-9A-Fa-f]{3})#([0-9A-Fa-f]{0,16})(?:\s|$)")


def frames_of(lines: Iterable[str]) -> Iterator[Frame]:
    """Data frames with 11-bit identifiers; everything else (remarks, remote, error and extended frames) is passed over."""
    for line in lines:
        found = _LINE.match(line)
        if found is not None and len(found[4]) % 2 == 0:
            yield Frame(int(found[3], 16), bytes.fromhex(found[4]), int(found[1]) * 1_000_000_000 + int(found[2]) * 1000)
