"""Processes, points and positions of a cell as its test system asks for them."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from gateway.pure.languages.baps2.cell_debugger import DebugFault
from gateway.pure.languages.baps2.frames import to_workpiece
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.robots import CellRobot
from gateway.pure.languages.baps2.tasks import Lane, Task
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.base.requests import RuntimeFault


class AccessibleCell(Protocol):
    """The programs of a cell that run."""

    library: Library
    memory: Memory
    port: Port
    robots: tuple[CellRobot, ...]
    tasks: dict[int, Task]

    def task_of(self, run: int) -> Task | None:
        """A process by its run."""

    def robot_lane(self, number: int) -> Lane:
        """A robot by its number."""

    def keep(self, program: str, name: str, value: tuple[float, ...]) -> None:
        """Stores a point."""


class CellAccess:
    """Looks at one cell."""

    def __init__(self, cell: AccessibleCell) -> None:
        self._cell = cell

    def task_of(self, run: int) -> Task | None:
        """A process by its run."""
        return self._cell.task_of(run)

    def tasks_of(self, run: int) -> Sequence[Task]:
        """A process with its branches; 0: all processes."""
        return [task for task in self._cell.tasks.values() if (task.main.run == run if run else task.root is None)]

    def components(self, program: str) -> int:
        """Return the number of components of a program's points: axes of its kinematic."""
        robots = self._cell.robots
        return robots[min(self._number_of(program), len(robots)) - 1].size if robots else 0

    def _number_of(self, program: str) -> int:
        tree = self._cell.library.tree(program)
        return min(tree.head.kinematics.values(), default=1) if tree is not None else 1

    def points_of(self, program: str) -> Mapping[str, tuple[float, ...]]:
        """Of its point file."""
        return self._cell.memory.points(program, Faults())

    def define(self, program: str, point: str, value: tuple[float, ...]) -> None:
        """Into its point file."""
        self._cell.keep(program, point, value)

    def here(self, program: str, point: str, kinematic: int) -> tuple[float, ...]:
        """Actual position: joints for @ points, else in the workpiece system that is active.  kinematic 0: that of the program."""
        number, robots = kinematic or self._number_of(program), self._cell.robots
        if not 1 <= number <= len(robots):
            raise DebugFault(f"kinematic {number}: this cell has {len(robots)} with a model")
        robot = robots[number - 1]
        joints = robot.own(self._cell.port.view.actual)
        try:
            found = joints if point.startswith("@") else to_workpiece(self._cell.robot_lane(number).frame, robot.world(joints))
        except RuntimeFault as error:
            raise DebugFault(error.text) from error
        return tuple(round(each, 6) + 0.0 for each in found)
