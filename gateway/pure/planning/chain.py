"""What of a program's path was handed to the cycle, and where on it the follower may be.  Pure."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from gateway.pure.image.records.planner import AHEAD
from motion.execution.timed import TimedPiece


@dataclass
class Chain:
    """Pieces of the part under way, and when each begins: tau, at full speed since the part began.  last_id: of the last piece handed on;
    spare: of the next one: ids go on over jobs, a chain never meets an older number."""

    last_id: int = 0
    spare: int = 1
    _begins: dict[int, float] = field(default_factory=dict)
    _passed: dict[int, int] = field(default_factory=dict)  # piece -> blocks that are over where it begins
    _over: int = 0
    _at: int = 0  # last piece the cycle was seen on; 0: the part has not begun
    _rest: float | None = None  # tau at which it ran out, until it goes on

    def begin(self) -> None:
        """A part, or none."""
        self._begins.clear()
        self._passed.clear()
        self._over = 0
        self._at, self._rest = 0, None

    def add(self, made: TimedPiece, tau: float, passed: int = 0) -> None:
        """One more, before which so many blocks are over; a new tail takes the place of those from its number on."""
        if made.new_tail:
            self._drop(number for number in list(self._begins) if number >= made.id)
        self._begins[made.id] = tau
        self._passed[made.id] = passed
        self.last_id, self.spare = made.id, made.id + 1

    def tau(self, piece: int, end: float) -> float:
        """Where the follower may be at the latest: the end of the piece under way (0: none is), or of all there is (`end`) when it has run
        out."""
        if piece in self._begins:
            self._at, self._rest = piece, None
            return self._begins.get(piece + 1, end)
        if self._at and not piece and self._rest is None:  # it has run out: all that was handed on is run
            self._at, self._rest = self.last_id, end
        return 0.0 if self._rest is None else self._rest

    def passed(self, piece: int, added: int) -> int:
        """Blocks that are over for certain.  added: all of them where nothing of the path is to come, else 0."""
        if piece in self._passed:
            self._over = max(self._over, self._passed[piece])
        elif not piece and (self._rest is not None or not self._begins):  # all that was handed on is run, or nothing had a way
            self._over = max(self._over, added)
        return self._over

    @property
    def full(self) -> bool:
        """As many pieces wait as may."""
        return sum(number > self._at for number in self._begins) >= AHEAD

    def forget(self) -> None:
        """Those the cycle has left behind."""
        self._drop(number for number in list(self._begins) if number < self._at - 1)

    def _drop(self, numbers: Iterable[int]) -> None:
        for number in numbers:
            del self._begins[number]
            del self._passed[number]
