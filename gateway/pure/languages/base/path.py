"""The paths of a cell as programs have them: one owner at a time of each, blocks handed on one by one, answers by block.  Pure.

Between two rests a program has one order of the cycle (a stretch).  It is asked for with the first block, and over when nothing has
followed for a while, when another program waits for the axes, or when something ends it.
"""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count

from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.base.process import Place
from gateway.pure.languages.base.requests import Ns, RuntimeFault

NOWHERE = Place()


@dataclass(slots=True, eq=False)
class Stretch:
    """One order.  job 0: not given yet; count: blocks handed on; places: in the program, of each."""

    owner: object
    program: str
    robot: int
    ticket: int
    job: int = 0
    count: int = 0
    places: list[Place] = field(default_factory=list)
    finished: bool = True  # nothing was handed on since the last word that nothing follows
    ended: bool = False
    whole: bool = False  # a movement that an input ends: alone, and read completely
    over: bool = False
    passed: int = 0
    fault: RuntimeFault | None = None
    dry: Ns | None = None  # since when no block is running


@dataclass(slots=True)
class Path:
    """Who moves a robot, or in a cell that moves one at a time any of them.  tickets: numbers of orders."""

    port: Port
    now: Stretch | None = None
    tickets: Iterator[int] = field(default_factory=lambda: count(1))
    _waiting: deque[object] = field(default_factory=deque)

    def held_by(self, owner: object) -> Stretch | None:
        """The stretch of this owner that is not over."""
        return self.now if self.now is not None and self.now.owner is owner else None

    @property
    def contended(self) -> bool:
        """Another one waits for the axes."""
        return self.now is not None and any(each is not self.now.owner for each in self._waiting)

    def wanted(self, owner: object, program: str, robot: int, *, whole: bool = False) -> Stretch | None:
        """The stretch of this owner, if it may hand on blocks now; else it is asked for, and the owner waits its turn."""
        now = self.now
        if now is not None and now.owner is owner and now.robot == robot and not now.ended and now.whole is whole:
            return now if now.job and now.fault is None else None
        if owner not in self._waiting:
            self._waiting.append(owner)
        if now is not None:
            if now.owner is owner:
                self.release(owner)  # another robot, another kind, or the one before is ending
            return None
        if self._waiting[0] is owner:
            self._waiting.popleft()
            self.now = Stretch(owner, program, robot, next(self.tickets), whole=whole)
            self.port.ask_path(self.now.ticket, program, robot)
        return None

    def reference(self, owner: object, program: str, robot: int) -> Stretch | None:
        """Return an order that references the robot and accepts no blocks; None: the owner waits its turn and asks again."""
        if owner not in self._waiting:
            self._waiting.append(owner)
        if self.now is not None:
            self.release(owner)
            return None
        if self._waiting[0] is not owner:
            return None
        self._waiting.popleft()
        self.now = Stretch(owner, program, robot, next(self.tickets), ended=True)
        self.port.send("reference", ticket=self.now.ticket, program=program, robot=robot)
        return self.now

    def hand_on(self, stretch: Stretch, text: str, place: Place = NOWHERE, *, block: bool = True) -> int:
        """A statement; the number of its block, counted from 1."""
        self.port.line(stretch.job, text)
        if block:
            stretch.count += 1
            stretch.places.append(place)
        stretch.finished, stretch.dry = False, None
        return stretch.count

    def finish(self, stretch: Stretch) -> None:
        """Nothing follows for the time being."""
        if stretch.job and not stretch.finished and not stretch.ended:
            stretch.finished = True
            self.port.finish(stretch.job)

    def release(self, owner: object) -> bool:
        """Nothing follows any more; True: the owner has no stretch left."""
        stretch = self.held_by(owner)
        if stretch is None:
            return True
        if stretch.job and not stretch.ended:
            stretch.ended = True
            self.port.end(stretch.job)
        return False

    def forget(self, owner: object) -> None:
        """Forget an owner that is gone: end its stretch and drop its requests."""
        if owner in self._waiting:
            self._waiting.remove(owner)
        stretch = self.held_by(owner)
        if stretch is not None:
            self.release(owner)
            stretch.owner = None  # it is over when the cell reports it

    def drop(self) -> None:
        """The source of the orders has restarted and knows none of them: what was passed on ends, and nothing waits."""
        if self.now is not None:
            self.release(self.now.owner)
        self.now = None
        self._waiting.clear()

    def given(self, ticket: int, job: int) -> None:
        """The cell moves for it."""
        if self.now is not None and self.now.ticket == ticket:
            self.now.job = job
            if self.now.owner is None:
                self.now.ended = True
                self.port.end(job)

    def ended(self, ticket: int, fault: RuntimeFault | None) -> Stretch | None:
        """End the order; return its stretch if it is the current one."""
        stretch = self.now
        if stretch is None or stretch.ticket != ticket:
            return None
        stretch.over, stretch.fault, self.now = True, fault, None
        if fault is None:
            stretch.passed = stretch.count
        return stretch

    def look(self) -> None:
        """Report of the planner in this turn."""
        stretch = self.now
        if stretch is None or not stretch.job:
            return
        path = self.port.view.path_of(stretch.robot)
        if path.job == stretch.job:
            stretch.passed = max(stretch.passed, min(path.passed, stretch.count))

    def place_of(self, stretch: Stretch) -> Place | None:
        """Return the place of the failed block; None: none failed."""
        path = self.port.view.path_of(stretch.robot)
        if path.failed_job != stretch.job or not 0 < path.fault_block <= len(stretch.places):
            return None
        return stretch.places[path.fault_block - 1]


class Paths:
    """Of all robots of a cell.  `one`: a single path, on which one robot moves at a time."""

    def __init__(self, port: Port, robots: int, *, one: bool) -> None:
        tickets = count(1)
        self._all = [Path(port, tickets=tickets) for _ in range(1 if one else max(robots, 1))]

    def of(self, robot: int) -> Path:
        """By the number of the robot, from 1."""
        return self._all[robot - 1] if robot <= len(self._all) else self._all[0]

    @property
    def stretches(self) -> list[Stretch]:
        """The current stretches, waiting or running."""
        return [path.now for path in self._all if path.now is not None]

    def look(self) -> None:
        """Report of the planner in this turn."""
        for path in self._all:
            path.look()

    def given(self, ticket: int, job: int) -> Stretch | None:
        """The cell moves for this one from now on; None: nothing is waited for under this number."""
        for path in self._all:
            path.given(ticket, job)
        return next((stretch for stretch in self.stretches if stretch.ticket == ticket and stretch.job == job), None)

    def ended(self, ticket: int, fault: RuntimeFault | None) -> Stretch | None:
        """The order is over; the stretch it was."""
        found = [path.ended(ticket, fault) for path in self._all]
        return next((stretch for stretch in found if stretch is not None), None)

    def release(self, owner: object) -> bool:
        """Nothing follows any more; True: the owner has no stretch left."""
        released = [path.release(owner) for path in self._all]  # each of them, whatever the first returns
        return all(released)

    def forget(self, owner: object) -> None:
        """The owner is gone."""
        for path in self._all:
            path.forget(owner)

    def drop(self) -> None:
        """The source of the orders has restarted and knows none of them."""
        for path in self._all:
            path.drop()
