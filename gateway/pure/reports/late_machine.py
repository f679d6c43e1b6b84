"""Whether the drives of a simulation stopped because this machine was late, not because of anything a plug or a supply can cure."""

from gateway.pure.image.records.cell import AxisFlag, AxisState, CellState
from protocols.base.machine import Ns, ms

RECENT_NS = ms(3_000)  # how long before a drive's stop a skipped SYNC or a late answer counts
AFTER_NS = ms(250)  # how long after it a late answer still explains the stop: answers held back by the machine come after the stop
STOPPED = AxisFlag.FAULT | AxisFlag.LOST
SUPERVISED = frozenset((1, 2, 0x8130, 0x8700))  # SYNC and life: SERVODYN 1 and 2 (AX-082), CiA 301 heartbeat 8130h, CiA 402 SYNC 8700h


class LateMachine:
    """Looks at every state the cycle of a simulation publishes."""

    def __init__(self, *, simulated: bool) -> None:
        self._simulated = simulated
        self._counted = 0
        self._answers = 0  # that came late
        self._seen: Ns | None = None  # when the machine was late last
        self._stopped: frozenset[int] = frozenset()
        self._lost_at: dict[int, Ns] = {}  # axes whose answers stayed away first
        self._after_late: frozenset[int] = frozenset()  # axes that stopped within RECENT_NS of it
        self.axes: frozenset[int] = frozenset()  # those whose stop lateness explains; until each is well again

    @property
    def blamed(self) -> bool:
        """Some drive stopped because of it."""
        return bool(self.axes)

    def observe(self, state: CellState, now: Ns) -> None:
        """In the order of time."""
        counted = state.skipped + state.late
        if counted > self._counted:
            self._seen = now
        self._counted = counted
        answered, self._answers = state.late > self._answers, state.late
        stopped = frozenset(n for n, axis in enumerate(state.axes) if axis.flags & STOPPED)
        recent = self._simulated and self._seen is not None and now - self._seen <= RECENT_NS
        lost = {n: now for n in stopped - self._stopped if state.axes[n].flags & AxisFlag.LOST}
        self._lost_at = lost | {n: at for n, at in self._lost_at.items() if n in stopped}
        explained = stopped - self._stopped if recent else frozenset[int]()
        if self._simulated and answered:
            explained |= {n for n, at in self._lost_at.items() if now - at <= AFTER_NS}
        self._after_late = (self._after_late & stopped) | explained
        self._stopped = stopped
        self.axes = frozenset(n for n in self._after_late if _by_lateness(state.axes[n]))


def _by_lateness(axis: AxisState) -> bool:
    """A drive that names another fault has that fault, late machine or not."""
    return not axis.flags & AxisFlag.FAULT or axis.fault_code in SUPERVISED
