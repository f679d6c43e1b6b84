"""Inputs and outputs of a virtual run: every link that an application names is there.  Directions by name: AX-723."""

from dataclasses import dataclass, field
from enum import IntEnum

from gateway.pure.languages.val3.boards import SYSTEM_BOARDS, UserBoards, board_of
from gateway.pure.languages.val3.errors import Rte


class Status(IntEnum):
    """What ioStatus returns (L2385-2398)."""

    WORKS, LOCKED, SIMULATED = 0, 1, 2
    NO_LINK, UNKNOWN, FAULT = -1, -2, -3


@dataclass(slots=True)
class Point:
    """One input or output.  A digital one holds 0 or 1."""

    path: str
    value: float = 0.0
    is_input: bool = False
    status: Status = Status.WORKS
    description: str = ""


def looks_like_input(path: str) -> bool:
    """%I0, fIn0 and those that a board's module declares are inputs; all others are written, too."""
    last = last_name(path).lower()
    module = path.replace("/", "\\").lower().split("\\")[:-1]
    return last.startswith(("%i", "fin")) or any(part.endswith(("inputs", "_in")) or part == "in" for part in module)


def last_name(path: str) -> str:
    """Return the name without board and module."""
    return path.replace("/", "\\").rpartition("\\")[2]


@dataclass(slots=True)
class VirtualIo:
    """Points by path; a bare name finds the path that ends so.  boards None: changes are visible at once."""

    points: dict[str, Point] = field(default_factory=dict)
    changes: int = 0
    boards: UserBoards | None = None
    _coming: dict[int, tuple[Point, float]] = field(default_factory=dict)  # until the next refresh
    _lost: dict[int, tuple[Point, Status]] = field(default_factory=dict)  # invalid by an overrun; status before

    def find(self, link: str) -> Point | None:
        """Return the point of a link, as path or last name, ignoring case."""
        name = link.replace("/", "\\").lower()
        if (found := self.points.get(name)) is not None:
            return found
        last = last_name(name)
        for path, point in self.points.items():
            if last_name(path) == last and last in (name, path):
                return point
        return None

    def declare(self, link: str) -> Point:
        """Return the point of a link, creating it if missing."""
        found = self.find(link)
        if found is None:
            found = self.points[link.replace("/", "\\").lower()] = Point(link, is_input=looks_like_input(link))
        return found

    def waits(self, point: Point) -> bool:
        """Whether it is refreshed with the user boards only."""
        return self.boards is not None and board_of(point.path) not in SYSTEM_BOARDS

    def arrive(self, point: Point, value: float) -> None:
        """A value from the plant: seen with the next refresh of its board."""
        if self.waits(point):
            self._coming[id(point)] = (point, value)
        else:
            point.value = value

    def refresh(self) -> bool:
        """Once a system cycle; False: the robot must stop (overrun of the synchro task, L3460)."""
        boards = self.boards
        if boards is None or not boards.due():
            return True
        if boards.overrun:
            if boards.no_jitter:
                return False
            for point in self.points.values():
                if self.waits(point) and point.status is not Status.FAULT:
                    self._lost[id(point)] = (point, point.status)
                    point.status = Status.FAULT
            return True
        for point, status in self._lost.values():
            point.status = status
        for point, value in self._coming.values():
            point.value = value
        self._lost.clear()
        self._coming.clear()
        self.hand_on()
        return True

    def hand_on(self) -> None:
        """Outputs of user boards go to the plant."""

    def usable(self, link: str | None) -> Point:
        """123 without a link, 125 where the device is in fault."""
        if not link:
            raise Rte(123)
        point = self.declare(link)
        if point.status is Status.FAULT:
            raise Rte(125, point.path)
        return point

    def write(self, link: str | None, value: float) -> float:
        """The value as it is taken; 122 for an input; without effect where the operator has locked it."""
        point = self.usable(link)
        if point.is_input:
            raise Rte(122, point.path)
        if point.status is not Status.LOCKED:
            point.value = value
            self.changes += 1
        return value
