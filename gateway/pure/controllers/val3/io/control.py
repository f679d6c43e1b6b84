"""The system inputs and outputs of a VAL 3 controller on the image, once per cycle of the services.  Pure.

Source: val3 3.5; AX-338.  dio.NAME and aio.NAME are values of the cell; dio.NAME.status is ioStatus; an operator locks with
dio.NAME.lock = 1 or 0, simulates with dio.NAME.simulate = value and ends that with dio.NAME.real = 1.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.val3.io.system import Health, IoSystem, Point, RunTimeFault
from gateway.pure.controllers.val3.io.variables import Aio, Dio, Instructions
from gateway.pure.image.records.cell import RC_BYTES, CellState, InputImage
from protocols.base.machine import Ns

FIELDS = ("status", "lock", "simulate", "real")
APPLICATION = ("val3.run", "val3.hold", "val3.move", "val3.fault")


@dataclass(slots=True)
class Application:
    """The application of the interpreter, as the PLC starts, holds and sees it (AX-930)."""

    running: bool = False
    fault: bool = False  # a task has stopped with an error
    run: bool | None = None  # start or stop: an edge of val3.run; None: none came
    hold: bool = False
    move: bool = False  # the operator permits motion: after another stop, and back to the path that the arm was moved away from
    _run: bool = False

    def put(self, name: str, value: bool) -> None:
        """KeyError: only read."""
        match name:
            case "val3.run":
                if value != self._run:
                    self.run = self._run = value
            case "val3.hold":
                self.hold = value
            case "val3.move":
                self.move = self.move or value
            case _:
                raise KeyError(f"{name} is only read")

    def value(self, name: str) -> float:
        """0 or 1."""
        return float({"val3.run": self.running, "val3.hold": self.hold, "val3.fault": self.fault}.get(name, self.move))


class Val3Control:
    """Call `step` once per cycle of the services."""

    def __init__(self, points: Iterable[Point], owned: Collection[int] = (), *, hosts: bool = False) -> None:
        """`owned`: RC input bytes that a command source writes; a board with an input in one of them is in fault while that command source
        is lost; `hosts`: the cell runs an application.
        """
        self.application = Application()
        self._hosts = hosts
        self.image = PicImage()
        self.points = {point.name: point for point in points}
        self.system = IoSystem(self.image, self.points.values())
        self.instructions = Instructions(self.system)
        mine = bytearray(RC_BYTES)
        for point in self.points.values():
            if point.output and point.steps:
                mine[point.byte : point.byte + 2] = b"\xff\xff"
            elif point.output:
                mine[point.bit >> 3] |= 1 << (point.bit & 7)
        self._mine = int.from_bytes(mine, "little")
        self._given = [(point, byte) for point in self.points.values() if not point.output for byte in _bytes(point) if byte in owned]

    @property
    def outputs(self) -> bytes:
        """RC outputs, the cycle's and those of the points."""
        return bytes(self.image.outputs)

    def step(self, inputs: InputImage, cycle: bytes, state: CellState, now: Ns, *, heard: bool = False) -> list[str]:
        """`cycle`: RC outputs as the cycle published them."""
        self.image.take(inputs)
        own = int.from_bytes(self.image.outputs, "little") & self._mine
        self.image.outputs[:] = (own | int.from_bytes(cycle, "little") & ~self._mine).to_bytes(RC_BYTES, "little")
        for point in self.points.values():
            point.board.health = Health.WORKS
        for point, byte in self._given:
            if not self.image.good[byte]:
                point.board.health = Health.FAULT
        return []

    # ---- what others see -----------------------------------------------------------------------------------------------
    def flag_bytes(self) -> bytes:
        """There are none."""
        return b""

    def write_flags(self, first: int, data: bytes) -> bool:
        """There are none."""
        return False

    def retained(self) -> bytes:
        """Nothing."""
        return b""

    def restore(self, flags: bytes, counters: Mapping[int, int]) -> None:
        """There is nothing to restore."""

    def timer(self, number: int) -> int | None:
        """There are none."""
        return None

    def counter(self, number: int) -> int | None:
        """There are none."""
        return None

    def names(self) -> list[str]:
        """dio.NAME or aio.NAME, and what an operator may ask of it."""
        found = [f"{'aio' if point.steps else 'dio'}.{name}" for name, point in self.points.items()]
        found += [f"{name}.{field}" for name in found for field in FIELDS]
        return found + list(APPLICATION if self._hosts else ())

    def value(self, name: str) -> float:
        """Value, ioStatus, whether locked or simulated; KeyError: unknown name, ValueError: a run-time error of the language."""
        if self._hosts and name in APPLICATION:
            return self.application.value(name)
        point, field = self._found(name)
        match field:
            case "status":
                return float(self.instructions.io_status(Dio(point.name)))
            case "lock":
                return float(self.system.locked(point.name))
            case "simulate" | "real":
                return float(self.system.simulated(point.name) is (field == "simulate"))
        try:
            return self.instructions.aio_get(Aio(point.name)) if point.steps else float(self.instructions.value(Dio(point.name)))
        except RunTimeFault as fault:
            raise ValueError(str(fault)) from fault

    def put(self, name: str, value: float) -> None:
        """An output's value, or the operator's doing; KeyError and ValueError as above (122: an input is not written)."""
        if self._hosts and name in APPLICATION:
            self.application.put(name, bool(value))
            return
        point, field = self._found(name)
        match field:
            case "lock":
                self.system.lock(point.name, bool(value))
            case "simulate":
                self.system.simulate(point.name, round(value * point.steps) if point.steps else int(bool(value)))
            case "real":
                self.system.simulate(point.name, None)
            case "status":
                raise KeyError(f"{name} is only read")
            case _:
                self._assign(point, value)

    def assign(self, name: str, value: float) -> None:
        """The application writes an output; KeyError, ValueError."""
        self._assign(self.points[name], value)

    def _assign(self, point: Point, value: float) -> None:
        try:
            if point.steps:
                self.instructions.aio_set(Aio(point.name), value)
            else:
                self.instructions.assign(Dio(point.name), bool(value))
        except RunTimeFault as fault:
            raise ValueError(str(fault)) from fault

    def status(self) -> dict[str, object]:
        """For tools and pages: points that are not as they should be."""
        odd = {name: int(self.system.status(name)) for name in self.points if self.system.status(name)}
        return {"kind": "val3", "points": len(self.points), "not_working": odd}

    def _found(self, name: str) -> tuple[Point, str]:
        kind, _, rest = name.partition(".")
        own, _, field = rest.partition(".")
        point = self.points.get(own)
        if point is None or kind != ("aio" if point.steps else "dio") or (field and field not in FIELDS):
            raise KeyError(name)
        return point, field


def _bytes(point: Point) -> tuple[int, ...]:
    return (point.byte, point.byte + 1) if point.steps else (point.bit >> 3,)
