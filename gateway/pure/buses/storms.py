"""Frames a node only reports with (EMCY, heartbeat), bounded: a storm of them costs no more than a few a window, and every one is counted.

The first `most` of one identifier in a window pass at once, so ordinary traffic loses nothing; of what comes beyond, the newest passes when
the window ends, the others are counted (AX-622).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from protocols.base.machine import Frame, Ns, ms

WINDOW = ms(20)
MOST = 4
FUNCTION, EMCY, HEARTBEAT = 0x780, 0x080, 0x700  # of CiA 301; identifier 080h itself is SYNC


@dataclass(slots=True)
class _Window:
    """One identifier."""

    ends: Ns
    passed: int = 0
    newest: Frame | None = None


@dataclass(slots=True)
class Storms:
    """One bus."""

    _windows: dict[int, _Window] = field(default_factory=dict)
    _left_out: dict[int, int] = field(default_factory=dict)

    def pass_on(self, frames: Sequence[Frame], now: Ns) -> list[Frame]:
        """What is worth handling now, in order; also what waited for the end of its window."""
        found = [window.newest for window in self._windows.values() if window.newest is not None and now >= window.ends]
        if found or len(self._windows) > MOST:
            self._windows = {identifier: window for identifier, window in self._windows.items() if now < window.ends}
        found += [frame for frame in frames if not _reports(frame.identifier) or self._passes(frame, now)]
        return found

    def left_out(self, identifier: int) -> int:
        """Frames of it that were not handed on since the last call."""
        return self._left_out.pop(identifier, 0)

    def _passes(self, frame: Frame, now: Ns) -> bool:
        window = self._windows.get(frame.identifier)
        if window is None or now >= window.ends:
            window = self._windows[frame.identifier] = _Window(now + WINDOW)
        window.passed += 1
        if window.passed <= MOST:
            return True
        if window.newest is not None:
            self._left_out[frame.identifier] = self._left_out.get(frame.identifier, 0) + 1
        window.newest = frame
        return False


def _reports(identifier: int) -> bool:
    return identifier & FUNCTION == HEARTBEAT or (identifier & FUNCTION == EMCY and identifier != EMCY)
