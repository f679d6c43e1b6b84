"""The read buffer of one connection: bytes, and in their order what went wrong between them."""

from dataclasses import dataclass
from enum import Enum, auto

from gateway.pure.controllers.val3.sio.channel import READ_BUFFER
from gateway.pure.controllers.val3.sio.text import TextScan


class Mark(Enum):
    DAMAGED = auto()  # here a character is missing or was spoiled: one read reports it, the channel stays open (AX-184)
    ENDED = auto()  # the partner closed, or the connection broke: the last thing a reader sees


@dataclass(frozen=True, slots=True)
class Line:
    """One string off the buffer."""

    text: str
    damaged: bool


class Inbox:
    """Bytes that came and were not read; a mark precedes the byte whose index it holds."""

    def __init__(self, limit: int = READ_BUFFER) -> None:
        self._limit = limit
        self._data = bytearray()
        self._marks: list[tuple[int, Mark]] = []
        self._scan: TextScan | None = None

    def __len__(self) -> int:
        return len(self._data)

    @property
    def room(self) -> int:
        """Bytes that still fit."""
        return self._limit - len(self._data)

    @property
    def ended(self) -> bool:
        """Nothing comes any more."""
        return bool(self._marks) and self._marks[-1][1] is Mark.ENDED

    def put(self, data: bytes) -> int:
        """Keeps what fits; returns how many bytes that were."""
        kept = data[: self.room]
        self._data += kept
        return len(kept)

    def mark(self, mark: Mark) -> None:
        """Behind everything that is here; twice the same in one place is one."""
        if not self.ended and (len(self._data), mark) not in self._marks:
            self._marks.append((len(self._data), mark))

    def front(self) -> Mark | None:
        """The mark the next read meets first."""
        return self._marks[0][1] if self._marks and self._marks[0][0] == 0 else None

    def drop_front(self) -> None:
        """That mark has been reported."""
        del self._marks[0]

    def take(self, limit: int) -> bytes:
        """Up to `limit` bytes, not past a mark."""
        count = min(limit, len(self._data), self._marks[0][0] if self._marks else limit)
        taken = bytes(self._data[:count])
        self._forget(count)
        return taken

    def line(self, end_of_string: int) -> Line | None:
        """Read one complete string, or nothing; a damaged string is read to its end and reported as damaged."""
        if self._scan is None or self._scan.end_of_string != end_of_string:
            self._scan = TextScan(end_of_string)
        scan = self._scan
        if not scan.run(self._data):
            if not self.room:
                self._squeeze(scan)
            return None
        outside = [(place, mark) for place, mark in self._marks if place >= scan.used]
        damaged, self._marks = len(outside) < len(self._marks), outside  # the end of the connection is never inside
        self._forget(scan.used)
        return Line(scan.text.decode(), damaged)

    def clear(self) -> int:
        """Empties the buffer; the end of a connection stays known.  Returns how many bytes were dropped."""
        count = len(self._data)
        self._marks = [(0, Mark.ENDED)] if self.ended else []
        self._data.clear()
        self._scan = None
        return count

    def _forget(self, count: int) -> None:
        del self._data[:count]
        self._marks = [(max(0, place - count), mark) for place, mark in self._marks]
        self._scan = None

    def _squeeze(self, scan: TextScan) -> None:
        """Drop characters that no string can hold: a buffer full of them would never end, and the string drops them anyway."""
        gone = scan.used - len(scan.text)
        self._data[: scan.used] = scan.text
        self._marks = [(max(0, place - gone), mark) for place, mark in self._marks]
        scan.used = len(scan.text)
