"""Inputs and outputs of a cell as an application links to them: the points of [controller] (AX-338)."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.val3.io.system import IoSystem
from gateway.pure.controllers.val3.io.system import Point as CellPoint
from gateway.pure.image.records.interpreter import Channels
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.virtual_io import Point, Status, VirtualIo

Write = Callable[[str, float], None]


def paths_of(point: CellPoint) -> list[str]:
    """What an application may call it: its name, and board with module, address or name."""
    board, module, name = point.board.name, point.module, point.name
    parts = ([name], [board, name], [board, module, name], [board, point.address], [board, module, point.address])
    return ["\\".join(part).lower() for part in parts]


def found(points: Iterable[CellPoint], link: str) -> CellPoint | None:
    """The point a link leads to; a path, or its last name."""
    wanted = link.replace("/", "\\").lower()
    known = [(path, point) for point in points for path in paths_of(point)]
    whole = next((point for path, point in known if path == wanted), None)
    if whole is not None:
        return whole
    last = wanted.rpartition("\\")[2] if "\\" not in wanted else ""
    return next((point for path, point in known if last and path.rpartition("\\")[2] == last), None)


@dataclass(slots=True)
class CellIo(VirtualIo):
    """owned: points of the cell; write: an output changes (name, value).  Its own writes are seen at once."""

    owned: tuple[CellPoint, ...] = ()
    put: Write = lambda name, value: None
    _image: PicImage = field(default_factory=PicImage)
    _system: IoSystem | None = None
    _by_link: dict[str, CellPoint | None] = field(default_factory=dict)
    _seen: Channels | None = None
    _written: dict[str, float] = field(default_factory=dict)  # not yet in the image
    _going: dict[str, float] = field(default_factory=dict)  # with the next refresh of the user boards

    def __post_init__(self) -> None:
        self._system = IoSystem(self._image, self.owned)
        for point in self.owned:
            self.points[point.path.lower()] = Point(point.path, is_input=not point.output, description=point.description)

    def look(self, channels: Channels) -> None:
        """The image in a new turn."""
        if channels is self._seen:
            return
        self._seen = channels
        self._image.inputs[:], self._image.outputs[:] = channels.inputs, channels.outputs
        assert self._system is not None
        for point in self.owned:
            raw = self._system.raw(point)
            own, value = self.points[point.path.lower()], raw / point.steps if point.steps else float(raw)
            if self._written.get(point.name, value) == value:
                self._written.pop(point.name, None)
                self.arrive(own, value)

    def state(self, name: str, status: int) -> None:
        """ioStatus of a point, as the services have it; a write that a lock holds back is seen as it is."""
        point = next((each for each in self.owned if each.name == name), None)
        if point is not None:
            own = self.points[point.path.lower()]
            if id(own) in self._lost:
                self._lost[id(own)] = (own, Status(status))
            else:
                own.status = Status(status)
            self._written.pop(name, None)
            self._seen = None

    def _found(self, link: str) -> CellPoint | None:
        if link not in self._by_link:
            self._by_link[link] = found(self.owned, link)
        return self._by_link[link]

    def find(self, link: str) -> Point | None:
        """Return the point of a link."""
        point = self._found(link)
        return None if point is None else self.points[point.path.lower()]

    def declare(self, link: str) -> Point:
        """Return the point of a link; an unknown point for a dangling link."""
        return self.find(link) or Point(link, status=Status.UNKNOWN)

    def usable(self, link: str | None) -> Point:
        """123 without a link or with one to nothing, 125 where the device is in fault."""
        if link and self.find(link) is None:
            raise Rte(123, link)
        return VirtualIo.usable(self, link)

    def write(self, link: str | None, value: float) -> float:
        """Write an output; return the value as it accepts it; 122 for an input; an analog value out of range leaves it
        unchanged (AX-519).
        """
        before = self.usable(link)
        if before.is_input:
            raise Rte(122, before.path)
        point = self._found(link or "")
        if point is None:
            return value
        taken = float(int(value)) if point.steps and point.integer else value
        if point.steps and not point.low <= taken <= point.high:
            return before.value
        value = round(taken * point.steps) / point.steps if point.steps else taken
        if before.status is not Status.LOCKED and before.value != value:
            before.value = self._written[point.name] = value
            if self.waits(before):
                self._coming.pop(id(before), None)
                self._going[point.name] = value
            else:
                self.put(point.name, value)
        return taken

    def hand_on(self) -> None:
        """Outputs of user boards go to the image."""
        for name, value in self._going.items():
            self.put(name, value)
        self._going.clear()
