"""The chain of timed pieces that a follower runs: the committed ones, and the tail that is received until it ends at rest."""

from collections import deque
from dataclasses import dataclass, field

from motion.execution.timed import TimedPiece
from motion.timing.track import Rows


@dataclass(slots=True)
class TimedChain:
    """Committed pieces; `begins`: tau at the start of each, `end`: tau at the end of the last one."""

    pieces: deque[TimedPiece] = field(default_factory=deque)
    begins: deque[float] = field(default_factory=deque)
    end: float = 0.0

    @property
    def last(self) -> TimedPiece | None:
        return self.pieces[-1] if self.pieces else None

    def place_of(self, number: int) -> int:
        """Return the index of the first piece with this id or a higher one, or the index after the last piece."""
        return next((k for k, piece in enumerate(self.pieces) if piece.id >= number), len(self.pieces))

    def append(self, piece: TimedPiece) -> None:
        self.begins.append(self.end)
        self.pieces.append(piece)
        self.end += piece.duration

    def pop(self) -> None:
        """The last one."""
        self.pieces.pop()
        self.end = self.begins.pop()

    def forget(self) -> None:
        """The first one."""
        self.pieces.popleft()
        self.begins.popleft()


@dataclass(slots=True)
class Tail:
    """Pieces that become valid as soon as one of them ends at rest.  Their rows are computed on arrival, so that taking many is cheap."""

    pieces: list[TimedPiece] = field(default_factory=list)
    rows: list[Rows] = field(default_factory=list)
    next: float = 0.0  # tau at which the next one begins

    def drop(self) -> None:
        self.pieces, self.rows = [], []

    def add(self, piece: TimedPiece, rows: Rows, begin: float) -> None:
        self.pieces.append(piece)
        self.rows.append(rows)
        self.next = begin + piece.duration

    def take(self) -> tuple[list[TimedPiece], list[Rows]]:
        """Return all pieces and rows of the complete tail."""
        pieces, rows = self.pieces, self.rows
        self.drop()
        return pieces, rows
