"""Who may command: one command source at a time owns a kinematic, and one may own all (design: section 5, Command sources and control)."""

from gateway.pure.image.reasons import Reason, Refusal
from gateway.pure.image.records.cell import EVERY_AXIS

NOBODY = 0


class Ownership:
    """Command sources are numbered from 1; word 8 of every status block contains the owner's number.  What is owned are axes (bit n-1 =
    axis n): all of a lane, and in a cell of one lane all there are."""

    def __init__(self) -> None:
        self._axes: dict[int, int] = {}  # command source -> its axes
        self._dead: set[int] = set()

    @property
    def owner(self) -> int:
        """Of the first axes that have one."""
        return min(self._axes, key=lambda source: self._axes[source] & -self._axes[source], default=NOBODY)

    def axes_of(self, source: int) -> int:
        """Those it has control of."""
        return self._axes.get(source, 0)

    def request(self, source: int, *, at_rest: bool, axes: int = EVERY_AXIS) -> bool:
        """Give control of these axes to `source`; True when it did not have it before.  Refused while another living command source owns
        some of them or they move."""
        if self.axes_of(source) & axes == axes:
            return False
        others = {other: own for other, own in self._axes.items() if other != source and own & axes}
        for other in others:
            if other not in self._dead:
                raise Refusal(Reason.NOT_OWNER, f"command source {other} has it")
        if not at_rest:
            raise Refusal(Reason.NOT_AT_REST)
        for other, own in others.items():
            self._set(other, own & ~axes)
        self._set(source, self.axes_of(source) | axes)
        return True

    def release(self, source: int, *, at_rest: bool, axes: int = EVERY_AXIS) -> None:
        """Give control of these axes back; only at rest, and only by their owner."""
        self.demand(source)
        if not at_rest:
            raise Refusal(Reason.NOT_AT_REST)
        self._set(source, self.axes_of(source) & ~axes)

    def demand(self, source: int, axes: int = 0) -> None:
        """Raise unless `source` owns these axes; 0: any."""
        own = self.axes_of(source)
        if own and own & axes == axes:
            return
        other = next((each for each, theirs in self._axes.items() if each != source and (theirs & axes or not axes)), NOBODY)
        raise Refusal(Reason.NOT_OWNER, f"command source {other} has it" if other else "no command source has it; request it first")

    def _set(self, source: int, axes: int) -> None:
        if axes:
            self._axes[source] = axes
        else:
            self._axes.pop(source, None)

    def link(self, source: int, *, alive: bool) -> None:
        """The owner keeps control while its link is dead, but then another command source may take it."""
        if alive:
            self._dead.discard(source)
        else:
            self._dead.add(source)
