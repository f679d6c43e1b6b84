"""The planner's ring for the cycle, which publishes its reading position, so that the planner knows the waiting pieces (AX-1330)."""

from collections.abc import Mapping

from gateway.pure.image.records.planner import PIECE_LAYOUT, TAKEN_LAYOUT, pack_taken
from gateway.runtime.regions import RegionWriter, RingReader


class PieceRing(RingReader):
    """publish() after the state of the cycle: a record counts as read when the published state shows it."""

    def __init__(self, fds: Mapping[str, int]) -> None:
        super().__init__(fds["pieces"], "pieces", PIECE_LAYOUT)
        self._taken = RegionWriter(fds["pieces-taken"], "pieces-taken", TAKEN_LAYOUT) if "pieces-taken" in fds else None
        self._shown = -1

    def publish(self, now: int) -> None:
        """Where it has changed.  now: of the cycle; ns."""
        if self._taken is not None and self._shown != self.position:
            self._shown = self.position
            self._taken.write(pack_taken(self._shown), now)


def piece_ring(fds: Mapping[str, int]) -> PieceRing | None:
    """None: a run without a planner."""
    return PieceRing(fds) if "pieces" in fds else None
