"""Speed and distance that a program sets while another process moves the kinematic: special functions 41 and 42 (rho 3 releases
part 2, section 3, L6756-6830).  Pure.

The cycle holds the distance, and reads it when the edge comes.  The speed is a share of the one the block was planned with, so a block
becomes slower at once, and never faster than planned (AX-458, AX-1680).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.lines import Wanted
from gateway.pure.languages.baps2.robots import CellRobot
from gateway.pure.languages.baps2.tasks import Block, Lane, Task
from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.base.path import Paths, Stretch
from motion.geometry.units import to_si

SPEED, DISTANCE = 41, 42


class Cell(Protocol):
    """The machine of a cell."""

    port: Port
    paths: Paths
    tasks: dict[int, Task]

    def robot_of(self, kinematic: str) -> CellRobot:
        """As programs name it."""

    def lane_of(self, task: Task, number: object) -> tuple[str, Lane]:
        """A kinematic of the program by its number."""


@dataclass(slots=True, eq=False)
class _Slowed:
    """A stretch whose blocks up to `last` run with this V factor; said: their share of the speed, as known to the cycle."""

    stretch: Stretch
    last: int
    factor: float
    said: float = 1.0


class CellAsynchronous:
    """Statements that act asynchronously to the blocks."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._slowed: dict[int, _Slowed] = {}  # by robot

    def call(self, task: Task, number: int, values: tuple[object, ...]) -> None:
        """41, 42; at once, whatever is prepared."""
        name, lane = self._cell.lane_of(task, values[0])
        robot, value = self._cell.robot_of(name), float(values[1]) if isinstance(values[1], int | float) else 0.0
        if number == DISTANCE:
            lane.distance = value
            self._cell.port.send("run-on", robot=robot.number, distance=to_si(value, robot.units[0]))
            return
        if value <= 0.0:
            raise fault(218, f"VFACTOR = {value:g}")
        lane.factors["VFACTOR"] = value
        for block in self._prepared(name):
            if block.wanted is not None and block.stretch is None:
                block.wanted = _with(block.wanted, value)
            if block.farther is not None:
                block.farther = _with(block.farther, value)
        stretch = next((each for each in self._cell.paths.stretches if each.robot == robot.number and each.job), None)
        if stretch is not None:
            before = self._slowed.get(robot.number)
            said = before.said if before is not None and before.stretch is stretch else 1.0
            self._slowed[robot.number] = _Slowed(stretch, stretch.count, value, said)
            self.turn()

    def turn(self) -> None:
        """Run each of these stretches with the share of the current block."""
        for robot, slowed in list(self._slowed.items()):
            stretch = slowed.stretch
            share = 1.0 if stretch.passed >= slowed.last else self._share(slowed)
            if share != slowed.said and not stretch.over:
                slowed.said = share
                self._cell.port.send("slow", job=stretch.job, share=share)
            if stretch.over or stretch.passed >= slowed.last:
                del self._slowed[robot]

    def _share(self, slowed: _Slowed) -> float:
        under_way = slowed.stretch.passed + 1
        for task in self._cell.tasks.values():
            for block in task.blocks():
                if block.stretch is slowed.stretch and block.index == under_way and block.wanted is not None:
                    planned: Mapping[str, float] = block.wanted.factors
                    return min(1.0, slowed.factor / planned.get("VFACTOR", 1.0))
        return slowed.said

    def _prepared(self, kinematic: str) -> list[Block]:
        return [block for task in self._cell.tasks.values() for block in task.blocks(kinematic)]


def _with(wanted: Wanted, factor: float) -> Wanted:
    """With this V factor."""
    return replace(wanted, factors={**wanted.factors, "VFACTOR": factor})
