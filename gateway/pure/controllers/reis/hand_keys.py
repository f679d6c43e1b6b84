"""Manual motion of a Reis robot through command sources, wires and tools: keys, Position Control, 6D mouse.  Pure.

Source: robotstar 8.2 (L175-193, L1302-1337), 8.4; AX-1050.
"""

from dataclasses import dataclass, field

from gateway.pure.image.records.interpreter import Fact

FRAMES = ("AXIS", "XYZ", "UVW", "AXIS7")  # reis.coord 0..3: AXIS 1-6, tXYZ rABC, tUVW, AXIS 7-12
CARTESIAN = ("XYZ", "UVW")
HAND_AXIS, HAND_CART, HAND_ORI = 0x0101, 0x0102, 0x0103  # M1022 (robotstar 5.9)
KEYS = 6


@dataclass(slots=True)
class HandKeys:
    """coord: number of the movement mode; ways: of the six key pairs; position: mm a turn of the wheel, 0 is key O; mouse: its six
    coordinates; least: IMOUSE_MIN."""

    coord: int = 0
    ways: list[float] = field(default_factory=lambda: [0.0] * KEYS)
    position: float = 0.0
    wheel: float = 0.0  # turns
    mouse: list[float] = field(default_factory=lambda: [0.0] * KEYS)
    moves: bool = False  # tXYZ mouse
    turns: bool = False  # rABC mouse
    least: float = 30
    _from: float = 0.0  # the wheel when the key was pressed
    _held: tuple[float, ...] = (0.0,) * KEYS

    @property
    def frame(self) -> str:
        """AXIS, XYZ, UVW or AXIS7."""
        return FRAMES[self.coord]

    @property
    def code(self) -> int:
        """M1022 in HAND: CART in a Cartesian mode, ORI where nothing but the orientation is moved."""
        if self.frame not in CARTESIAN:
            return HAND_AXIS
        only_turns = any(self.ways[3:]) and not any(self.ways[:3])
        return HAND_ORI if only_turns or (self.turns and not self.moves) else HAND_CART

    @property
    def plus(self) -> bool:
        """A plus key is pressed (M1021.3)."""
        return any(way > 0 for way in self.ways)

    @property
    def minus(self) -> bool:
        """A minus key is pressed (M1021.4)."""
        return any(way < 0 for way in self.ways)

    def push(self) -> dict[str, Fact]:
        """What is wanted now; kind "" where nothing is."""
        ways = tuple(self.ways)
        if ways != self._held:
            self._held, self._from = ways, self.wheel
        kind, turned = "", 0.0
        if any(ways):
            kind = "wheel" if self.position and self.frame in CARTESIAN else "keys"
            turned = (self.wheel - self._from) * self.position if kind == "wheel" else 0.0
        elif self.frame in CARTESIAN and ((self.moves and self._deflected(0)) or (self.turns and self._deflected(3))):
            kind = "mouse"
        shown = " ".join(f"{way:g}" for way in (ways if kind in ("keys", "wheel") else (0.0,) * KEYS))
        return {"kind": kind, "frame": self.frame, "ways": shown, "turned": turned, "moves": int(self.moves), "turns": int(self.turns)}

    def _deflected(self, first: int) -> bool:
        return any(abs(value) >= self.least for value in self.mouse[first : first + 3])

    def put(self, name: str, value: float) -> bool:
        """False: it is none of these; ValueError where the value does not fit."""
        match name.split("."):
            case ["coord"]:
                if value not in range(len(FRAMES)):
                    raise ValueError(f"reis.coord {value:g}: 0 AXIS 1-6, 1 tXYZ rABC, 2 tUVW, 3 AXIS 7-12")
                self.coord = int(value)
            case ["jog", number] if _of_six(number):
                if value not in (-1, 0, 1):
                    raise ValueError(f"reis.{name} {value:g}: 1 plus key, -1 minus key, 0 released")
                self.ways[int(number) - 1] = float(value)
            case ["position"]:
                if not 0 <= value <= 100:
                    raise ValueError(f"reis.position {value:g}: 0 .. 100 mm a turn of the wheel, 0 ends Position Control")
                self.position = float(value)
            case ["wheel"]:
                self.wheel = float(value)
            case ["mouse", "t"]:
                self.moves = bool(value)
            case ["mouse", "r"]:
                self.turns = bool(value)
            case ["mouse", number] if _of_six(number):
                if not -32768 <= value <= 32767:
                    raise ValueError(f"reis.{name} {value:g}: -32768 .. 32767")
                self.mouse[int(number) - 1] = float(value)
            case _:
                return False
        return True

    def value(self, name: str) -> float | None:
        """The same, read; None: it is none of these."""
        match name.split("."):
            case ["coord" | "position" | "wheel" as which]:
                return float(getattr(self, which))
            case ["jog", number] if _of_six(number):
                return self.ways[int(number) - 1]
            case ["mouse", "t"]:
                return float(self.moves)
            case ["mouse", "r"]:
                return float(self.turns)
            case ["mouse", number] if _of_six(number):
                return self.mouse[int(number) - 1]
        return None

    @staticmethod
    def names() -> list[str]:
        """Behind `reis.`."""
        numbers = range(1, KEYS + 1)
        return [
            "coord",
            "position",
            "wheel",
            "mouse.t",
            "mouse.r",
            *(f"{kind}.{number}" for kind in ("jog", "mouse") for number in numbers),
        ]


def _of_six(number: str) -> bool:
    return number.isdecimal() and 1 <= int(number) <= KEYS
