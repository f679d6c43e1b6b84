"""Whether the drives of a simulation stopped because this machine was late, not because of anything a plug or a supply can cure."""

from gateway.pure.image.records.cell import AxisFlag, CellState
from protocols.base.machine import Ns, ms

RECENT_NS = ms(3_000)  # so long before a drive stopped counts a SYNC that was skipped or an answer that came late
STOPPED = int(AxisFlag.FAULT | AxisFlag.LOST)


class LateMachine:
    """Looks at every state the cycle of a simulation publishes."""

    def __init__(self, *, simulated: bool) -> None:
        self._simulated = simulated
        self._counted = 0
        self._seen: Ns | None = None  # when the machine was late last
        self._stopped = False
        self.blamed = False  # drives stopped right after that; until all are well again

    def observe(self, state: CellState, now: Ns) -> None:
        """In the order of time."""
        counted = state.skipped + state.late
        if counted > self._counted:
            self._seen = now
        self._counted = counted
        stopped = any(axis.flags & STOPPED for axis in state.axes)
        if stopped and not self._stopped:
            self.blamed = self._simulated and self._seen is not None and now - self._seen <= RECENT_NS
        if not stopped:
            self.blamed = False
        self._stopped = stopped
