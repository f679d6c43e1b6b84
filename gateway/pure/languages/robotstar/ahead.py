"""Look-ahead of a program: positions handed on to the planner or waiting, and the actions after each.  Pure.

A position is over where its block is: at its end, or in the middle of its corner.  Writes after a position wait for that.
"""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from gateway.pure.languages.base.path import Path, Stretch
from gateway.pure.languages.base.process import Place
from gateway.pure.languages.robotstar.arm import Arm, tool_values
from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.lines import line, past_via, rest_of_circle, tool_line
from gateway.pure.languages.robotstar.machine import Go
from gateway.pure.languages.robotstar.path import CIRCLES, Target
from gateway.pure.languages.robotstar.progress import Progress, length_of
from gateway.pure.languages.robotstar.values import Structure

FEWEST, MOST, AHEAD_NS = 4, 200, 2_000_000_000  # positions that may be prepared, and how much motion
BACK = "speed=10 accel=50 decel=50 lead=yes"  # of the way back to where a program was interrupted
NEAR = 1e-3  # mm or degrees: the axes are still there
ROBOT = 1


@dataclass(slots=True, eq=False)
class Block:
    """A position.  place: program and step; start: where it leads from; index: of its block in the stretch, 0: not handed on; through: of
    the auxiliary point before it; text: of a way back, as it is handed on."""

    go: Go
    place: tuple[str, int]
    done: tuple[str, int]  # executed last before it
    start: Target
    through: "Block | None" = None
    stretch: Stretch | None = None
    index: int = 0
    text: str = ""

    @property
    def lasts(self) -> float:
        """Approximate duration in ns; an approximated position is passed at its speed."""
        if self.go.approximates and self.go.mode == "LINEAR" and self.go.target.pose and self.start.pose:
            return math.dist(self.start.pose[:3], self.go.target.pose[:3]) / self.go.settings["PATH_SPEED"] * 1e9
        return self.go.whole

    @property
    def over(self) -> bool:
        """Reached, or passed in its corner."""
        return self.stretch is not None and self.stretch.passed >= self.index > 0


@dataclass(slots=True, eq=False)
class Via:
    """The auxiliary point of a circle: over where the tool passes it.  circle: its block, None: the end is not known yet."""

    circle: Block | None = None


@dataclass(slots=True)
class Ahead:
    """Call `look` once a turn.  set: set values of the cell's axes."""

    path: Path
    arm: Arm
    place: Callable[[], tuple[str, int]]
    done: Callable[[], tuple[str, int]]
    items: deque[Block | Via | Callable[[], None]] = field(default_factory=deque)
    interrupted: tuple[float, ...] = ()  # axes where the path was left; (): it was not
    rested: tuple[float, ...] = ()  # axes where the program was stopped with nothing under way
    _auxiliary: Block | None = None  # of a circle whose end is not known yet
    _via: Via = field(default_factory=Via)  # the same in `items`
    _tools: dict[tuple[float, ...], str] = field(default_factory=dict)  # as the stretch knows them
    _begun: Stretch | None = None
    _last: tuple[float, ...] = ()  # axes in the last turn in which a block was under way
    _return: tuple[int, tuple[float, ...]] = (0, ())  # block of the stretch that leads back to a place where the path was left

    # ---- what the program puts in
    @property
    def busy(self) -> bool:
        """Something is not over."""
        return bool(self.items)

    def room(self) -> bool:
        """Return whether one more may be prepared; a spline is prepared completely, since each point changes the course before it.  The
        current position does not count: the planner must know the short moves after a long one in time.
        """
        blocks = [item for item in self.items if isinstance(item, Block)]
        if blocks and blocks[-1].go.mode == "SPLINE":
            return len(blocks) < MOST
        return len(blocks) < FEWEST or (len(blocks) < MOST and sum(block.lasts for block in blocks[1:]) < AHEAD_NS)

    @property
    def full(self) -> bool:
        """Return whether a spline exceeds the look-ahead and so comes to rest there.  Other positions wait until one is over."""
        last = next((item for item in reversed(self.items) if isinstance(item, Block)), None)
        return last is not None and last.go.mode == "SPLINE" and len(self.items) >= MOST and not self.room()

    def put(self, go: Go, start: Target, places: tuple[float, ...]) -> None:
        """A position; StepFault where this robot has none such, or does not reach it."""
        self.arm.text(go.target, start)
        wrong = self.arm.unreachable(go.target, start, go.tool, self.arm.own(places))
        if wrong:
            raise StepFault(wrong, 0, "path")
        block = Block(go, self.place(), self.done(), start)
        if go.auxiliary:
            if not go.target.pose:
                raise StepFault("an auxiliary point of a circle is a position of the tool, not of the axes", 0, "path")
            self._auxiliary, self._via = block, Via()
            self.items.append(self._via)
            return
        if go.mode in CIRCLES:
            block.through, self._auxiliary = self._auxiliary, None
            if block.through is None or not go.target.pose or not block.through.start.pose:
                raise StepFault("a circle needs start, auxiliary point and end as positions of the tool", 0, "path")
            block.start, self._via.circle = block.through.start, block
        self.items.append(block)

    def act(self, action: Callable[[], None]) -> None:
        """At once, or where the last position is over."""
        if self.items:
            self.items.append(action)
        else:
            action()

    def last(self) -> Target | None:
        """Where the last position leads; None: nothing is under way."""
        if self._auxiliary is not None:
            return self._auxiliary.go.target
        return next((item.go.target for item in reversed(self.items) if isinstance(item, Block)), None)

    def under_way(self) -> Block | None:
        """The first position that is not over."""
        return next((item for item in self.items if isinstance(item, Block)), None)

    def progress(self, before: Progress) -> Progress:
        """Of the position under way; of the last one, as it was, where there is none or the program is stopped."""
        block = self.under_way()
        if block is None:
            return replace(before, share=1.0)
        if block.stretch is None or not block.stretch.job:
            return before
        report, through = self.path.port.view.path_of(ROBOT), block.through
        share = report.share if report.job == block.stretch.job and report.block == block.index else 0.0
        length = length_of(block.start, block.go.target, None if through is None else through.go.target)
        return Progress(length, (block.lasts + (0 if through is None else through.go.whole)) / 1e9, min(max(share, 0.0), 1.0))

    # ---- turns
    def look(self, places: tuple[float, ...]) -> None:
        """Remove completed positions and execute the actions after them."""
        first = self.under_way()
        if first is not None and first.stretch is not None and not first.stretch.over:
            self._last = self.arm.own(places)
        while self.items:
            item = self.items[0]
            if (isinstance(item, Block) and not item.over) or (isinstance(item, Via) and not self._goes_past(item, places)):
                return
            self.items.popleft()
            if not isinstance(item, Block | Via):
                item()

    def _goes_past(self, via: Via, places: tuple[float, ...]) -> bool:
        """Return whether the tool is past the auxiliary point, on the circle or on its way out of it."""
        circle = via.circle
        if circle is None or circle.through is None or circle.stretch is None or circle.stretch.passed < circle.index - 1:
            return False
        points = circle.start.pose, circle.through.go.target.pose, circle.go.target.pose
        try:
            return circle.over or past_via(*points, self.arm.actual(self.arm.own(places), circle.go.tool).pose)
        except StepFault:
            return False  # no circle: the planner refuses it

    def hand_on(self, owner: object, program: str, places: tuple[float, ...], *, one: bool) -> None:
        """To the planner, as much as is there; one: the first position alone."""
        blocks = [item for item in self.items if isinstance(item, Block)]
        for block in blocks[:1] if one else blocks:
            if block.stretch is not None:
                continue
            stretch = self.path.wanted(owner, program, ROBOT)
            if stretch is None:
                return
            self._begin(stretch)
            self._way_back(stretch, block, places)
            block.stretch, block.index = stretch, self.path.hand_on(stretch, self._line(stretch, block, places), Place(block.place[1]))

    def settle(self) -> None:
        """Run the positions handed on to their end: nothing follows for the time being.  A circle without its end is not started yet."""
        if self.items and self.items[0] is self._via and self._via.circle is None:
            self.items.popleft()
        if self.path.now is not None:
            self.path.finish(self.path.now)

    def _begin(self, stretch: Stretch) -> None:
        if self._begun is not stretch:
            self._begun = stretch
            self._tools.clear()
            self._return = 0, ()

    def _way_back(self, stretch: Stretch, block: Block, places: tuple[float, ...]) -> None:
        """To where the path was left, at a moderate speed (L1262)."""
        here, there, self.interrupted = self.arm.own(places), self.interrupted, ()
        if _left(here, there):
            self._return = self.path.hand_on(stretch, _back_to(there), Place(block.place[1])), there

    def _line(self, stretch: Stretch, block: Block, places: tuple[float, ...]) -> str:
        if block.text:
            return block.text
        values = tool_values(block.go.tool)
        name = self._tools.get(values)
        if name is None:
            name = self._tools[values] = f"T{len(self._tools) + 1}"
            self.path.hand_on(stretch, tool_line(name, values), block=False)
        if block.through is None:
            return line(block.go, self.arm.text(block.go.target, block.start), name)
        through = block.through.go
        return line(
            block.go,
            self.arm.text(block.go.target, block.start),
            name,
            self.arm.text(through.target, block.start),
            through.settings["_IORI_CIRCHP"],
        )

    # ---- interruptions
    def rests(self, places: tuple[float, ...]) -> None:
        """Keep the axes at which the program was stopped, if no block was running."""
        self.rested = () if self.items else self.arm.own(places)

    def goes_on(self, places: tuple[float, ...], tool: Structure | None) -> None:
        """START: first back to where it was stopped, if the axes were moved since (L1262)."""
        here, there, self.rested = self.arm.own(places), self.rested, ()
        if _left(here, there) and not self.items:
            start, end = (self.arm.actual(axes, tool) for axes in (here, there))
            self.items.append(Block(Go(end, "PTP", 0, tool=tool), self.place(), self.done(), start, text=_back_to(there)))

    def left(self, stretch: Stretch) -> None:
        """Note that the path was left: uncompleted positions are handed on anew from where the axes were, once the program continues."""
        handed = [item for item in self.items if isinstance(item, Block) and item.stretch is stretch]
        back, place = self._return
        returning = bool(place) and stretch is self._begun and stretch.passed < back
        if handed and not handed[0].text and (place if returning else self._last):
            self.interrupted = place if returning else self._last
            if not returning and handed[0].go.target.pose:
                self._shorten(handed[0])
        for item in handed:
            item.stretch, item.index = None, 0

    def _shorten(self, block: Block) -> None:
        """Shorten the current block to its remainder."""
        here = self.arm.actual(self.interrupted, block.go.tool)
        if block.through is not None:
            through = block.through
            xyz = rest_of_circle(block.start.pose, through.go.target.pose, block.go.target.pose, here.pose)
            target = Target((*xyz, *through.go.target.pose[3:]), 0, through.go.target.axes)
            go = Go(target, through.go.mode, 0, through.go.settings, through.go.tool, auxiliary=True)
            block.through = Block(go, through.place, through.done, here)
        block.start = here

    def forget(self) -> None:
        """Nothing of it is run any more: another program, or another step, was chosen."""
        self.items.clear()
        self._auxiliary, self.interrupted, self.rested, self._last = None, (), (), ()


def _left(here: tuple[float, ...], there: tuple[float, ...]) -> bool:
    """The axes were moved away from a place."""
    return bool(there) and any(abs(a - b) > NEAR for a, b in zip(here, there, strict=True))


def _back_to(there: tuple[float, ...]) -> str:
    """The block of a way back."""
    return f"ptp joints {' '.join(f'{value:.10g}' for value in there)} {BACK}"
