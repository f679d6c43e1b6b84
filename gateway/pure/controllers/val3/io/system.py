"""System inputs and outputs a VAL 3 variable may be linked to.  Source: val3 3.5 (L2290-2564), states AX-518, analog AX-519."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum, IntEnum

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.image.addresses import Direction, RcBit
from gateway.pure.image.records.cell import get_bit, set_bit


class Status(IntEnum):
    """Result of ioStatus."""

    WORKS = 0
    LOCKED = 1
    SIMULATED = 2
    NO_LINK = -1
    UNKNOWN_LINK = -2
    FAULT = -3


class RunTime(IntEnum):
    """Run-time errors of the language."""

    NOT_AN_OUTPUT = 122
    NO_LINK = 123
    DEVICE = 125


class RunTimeFault(Exception):
    """A run-time error; `code` as returned by taskStatus."""

    def __init__(self, code: RunTime, where: str) -> None:
        super().__init__(f"run-time error {int(code)}: {where}")
        self.code = code


class Health(Enum):
    """State of a board."""

    WORKS = "works"
    ABSENT = "board absent or not initialised"
    FAULT = "device fault"


@dataclass(slots=True)
class Board:
    """Boards come and go."""

    name: str
    health: Health = Health.WORKS


@dataclass(frozen=True, slots=True)
class Point:
    """One system input or output.  Digital: `bit`.  Analog: `byte` of the image, `steps` per unit and the range in units."""

    name: str
    board: Board
    module: str
    address: str
    output: bool
    bit: int = 0
    byte: int = 0
    steps: int = 0  # 0: digital
    low: float = 0.0
    high: float = 0.0
    integer: bool = False
    description: str = ""  # free text of the configuration

    @property
    def path(self) -> str:
        """Board, module and address as the controller writes them."""
        return f"{self.board.name}\\{self.module}\\{self.address}"

    @property
    def place(self) -> RcBit:
        """Where a digital point lies in the image."""
        return RcBit(Direction.OUTPUT if self.output else Direction.INPUT, self.bit)


class IoSystem:
    """All points by name; the operator may lock and simulate them."""

    def __init__(self, image: PicImage, points: Iterable[Point]) -> None:
        self._image = image
        self._points = {point.name: point for point in points}
        self._locked: dict[str, int] = {}  # name -> raw value it keeps
        self._simulated: dict[str, int] = {}  # name -> raw value it plays

    def point(self, link: str | None) -> Point | None:
        """The point of that name."""
        return None if link is None else self._points.get(link)

    def status(self, link: str | None) -> Status:
        """ioStatus of something linked to `link` (None: not linked)."""
        if link is None:
            return Status.NO_LINK
        point = self._points.get(link)
        if point is None or point.board.health is Health.ABSENT:
            return Status.UNKNOWN_LINK
        if point.board.health is Health.FAULT:
            return Status.FAULT
        return Status.LOCKED if link in self._locked else Status.SIMULATED if link in self._simulated else Status.WORKS

    def usable(self, link: str | None) -> Point:
        """Return the point of a link.  Raise RunTimeFault 123 without one, 125 where its device is in fault."""
        status = self.status(link)
        point = self.point(link)
        if point is None or status is Status.UNKNOWN_LINK:
            raise RunTimeFault(RunTime.NO_LINK, link or "not linked")
        if status is Status.FAULT:
            raise RunTimeFault(RunTime.DEVICE, point.path)
        return point

    def writable(self, link: str | None) -> Point:
        """Return the output of a link.  Raise RunTimeFault 122 for an input."""
        point = self.usable(link)
        if not point.output:
            raise RunTimeFault(RunTime.NOT_AN_OUTPUT, point.path)
        return point

    def raw(self, point: Point) -> int:
        """Its value: of the lock, of the simulation, else of the image."""
        for kept in (self._locked, self._simulated):
            if point.name in kept:
                return kept[point.name]
        data = self._image.outputs if point.output else self._image.inputs
        if point.steps:
            return int.from_bytes(data[point.byte : point.byte + 2], "little", signed=True)
        return int(get_bit(data, point.bit))

    def put(self, point: Point, raw: int) -> None:
        """Write an output; without effect where it is locked, outside the image where it is simulated."""
        if point.name in self._locked:
            return
        if point.name in self._simulated:
            self._simulated[point.name] = raw
        elif point.steps:
            self._image.outputs[point.byte : point.byte + 2] = raw.to_bytes(2, "little", signed=True)
        else:
            set_bit(self._image.outputs, point.bit, bool(raw))

    def lock(self, name: str, locked: bool) -> None:
        """The operator locks or releases a point."""
        if locked:
            self._locked[name] = self.raw(self._points[name])
        else:
            self._locked.pop(name, None)

    def simulate(self, name: str, raw: int | None) -> None:
        """The operator simulates a point with this value, or (None) no longer."""
        if raw is None:
            self._simulated.pop(name, None)
        else:
            self._simulated[name] = raw

    def locked(self, name: str) -> bool:
        """Whether the operator has locked it."""
        return name in self._locked

    def simulated(self, name: str) -> bool:
        """Whether the operator simulates it."""
        return name in self._simulated
