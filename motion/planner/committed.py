"""A committed law: its place in the chain, its pieces, and the state from which another law may continue."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from motion.errors import MotionError
from motion.planner.quick_law import Swift
from motion.planner.route import RouteState
from motion.planner.runs import Run
from motion.planner.stretch import Kind, Stretch
from motion.timing.law import Law


class Origin(NamedTuple):
    quick: Swift | None
    first: int
    width: float
    led: bool = False  # a law that is led over into the next one


@dataclass(frozen=True)
class Planned:
    """One law that was committed.  begin: tau at its start; cuts: (tau, piece id) of its pieces; end: tau at its end, or where a
    newer law replaced it."""

    run: Run
    law: Law
    begin: float
    end: float
    cuts: tuple[tuple[float, int], ...]
    stops: bool  # the path is meant to end at rest here, not for lack of blocks
    quick: Swift | None = None  # the quick law from which an open path continues
    first: int = 0  # sample of it at which this law begins
    width: float = 0.0
    led: bool = False

    def s(self, tau: float) -> float:
        """On the run's path."""
        return self.law.place(tau - self.begin)

    def state(self, tau: float) -> tuple[float, float, float]:
        """(s, sdot, sddot) at the node nearest to tau: cuts lie on nodes of the law."""
        k = min(max(round((tau - self.begin) / self.law.step), 0), len(self.law.s) - 1)
        return float(self.law.s[k]), float(self.law.speed[k]), float(self.law.accel[k])


def block_ends(run: Run) -> list[tuple[float, int]]:
    """(s at which it is left, block), rising: a corner belongs to both of its blocks, half and half."""
    ends: list[tuple[float, int]] = []
    for stretch, start in zip(run.stretches, run.starts, strict=True):
        length = stretch.path.length
        if stretch.kind is Kind.CORNER:
            ends.append((start + 0.5 * length, stretch.block))
            ends.append((start + length, stretch.block + 1))
        else:
            ends.append((start + length, stretch.block))
    return ends


def state_at(law: Law, k: int) -> tuple[float, float, float]:
    """(s, sdot, sddot) at one of its nodes."""
    return float(law.s[k]), float(law.speed[k]), float(law.accel[k])


def stretches_of(planned: Iterable[Planned]) -> list[Stretch]:
    """Return the stretches of all these laws, each once: a law that replaces the tail of another one shares some with it."""
    known: list[Stretch] = []
    for law in planned:
        known += [each for each in law.run.stretches if not any(each is one for one in known)]
    return known


def runs_between(planned: Iterable[Planned], between: tuple[float, float]) -> list[tuple[Run, float, float]]:
    """Runs that the chain is on between two tau, and from where to where on the path of each."""
    begin, end = between
    return [
        (each.run, each.s(max(begin, each.begin)), each.s(min(end, each.end)))
        for each in planned
        if each.end >= begin and each.begin <= end
    ]


def state_behind(kept: Sequence[tuple[int, RouteState]], planned: Iterable[Planned], number: int) -> RouteState:
    """Return the state of the route after a block that is not done.  kept: the state after each such block.  Raise MotionError."""
    if not kept:
        raise MotionError("blocks of several kinematics cannot be cut: flush the stream")
    state = next((state for at, state in kept if at == number), None)
    if state is None:
        raise MotionError(f"block {number} is over already")
    last = state.splines[-1][0] if state.splines else 0
    if last and any(each.block == last for law in planned for each in law.run.stretches):
        raise MotionError(f"block {number} is inside a spline that is being executed: flush the stream, or cut it after the spline")
    return state
