"""What the PHG is fed with, what it wants done, and its information windows.  Source: robotstar 8.2 (L1339-1368)."""

import textwrap
from dataclasses import dataclass

from gateway.pure.controllers.reis.pendant.unit import COLUMNS
from gateway.pure.controllers.reis.pendant.words import say

POSE = ("X", "Y", "Z", "A", "B", "C")
BYTES_A_LINE, WORDS_A_LINE = 2, 2  # L1362, L1368


@dataclass(frozen=True, slots=True)
class View:
    """The present state of the cell.  override: %; mode: auto, test1 .. test6, "" is HAND; selected: program of START, as the memory names
    it; program, step, state, waits: the execution; done: the step executed before; axes: name, value, unit; increments: of the axes;
    moves, turns: tXYZ and rABC mouse; position: mm a turn, 0 in override mode.
    """

    override: float = 0.0
    mode: str = ""
    selected: str = ""
    program: str = ""
    step: int = 0
    state: str = ""
    waits: str = ""
    message: str = ""
    axes: tuple[tuple[str, float, str], ...] = ()
    pose: tuple[float, ...] = ()
    increments: tuple[int, ...] = ()
    inputs: bytes = b""
    outputs: bytes = b""
    markers: bytes = b""
    synchronous: bool = True
    coor: int = 0
    moves: bool = False
    turns: bool = False
    position: float = 0.0
    looked: tuple[str, int | float | str | None, str] = ("", None, "")  # a variable: name, value or why there is none
    done: int = 0

    @property
    def operating(self) -> str:
        """The operating mode as it is displayed."""
        return "HAND" if not self.mode else "AUTO" if self.mode == "auto" else f"TEST {self.mode[-1]}"


@dataclass(frozen=True, slots=True)
class Order:
    """One thing the pendant wants done: `do` and what it concerns."""

    do: str
    text: str = ""
    number: float = 0
    more: str = ""


def window(name: str, view: View, first: int, language: str) -> list[str]:
    """The lines of an information window; `first`: line it begins with."""
    match name:
        case "axes":
            return [f"{axis:<8}{value:12.3f} {unit}" for axis, value, unit in view.axes]
        case "increments":
            return [f"{axis[0]:<8}{count:12d} inc" for axis, count in zip(view.axes, view.increments, strict=False)]
        case "pose":
            units = ("mm",) * 3 + ("deg",) * 3
            rows = [f"{letter:<8}{value:12.3f} {unit}" for letter, value, unit in zip(POSE, view.pose, units, strict=False)]
            return rows or [say("no kinematics: no Cartesian position", language)]
        case "inputs" | "outputs":
            return _bits(view.inputs if name == "inputs" else view.outputs)[first:]
        case "markers":
            return _words(view.markers)[first:]
    return _variable(*view.looked, language) if view.looked[0] else [say("no value", language)]


def _bits(content: bytes) -> list[str]:
    """Two bytes a line, bit 0 of the first one on the right (L1361-1363)."""
    rows = []
    for at in range(0, len(content), BYTES_A_LINE):
        pair = content[at : at + BYTES_A_LINE]
        rows.append(f"{at:>3}-{at + len(pair) - 1:<3} " + " ".join(f"{byte:08b}" for byte in reversed(pair)))
    return rows


def _words(content: bytes) -> list[str]:
    """_SPS[1] and _SPS[2] in the first line, in hexadecimal (L1366-1368)."""
    words = [int.from_bytes(content[at : at + 4], "little") for at in range(0, len(content), 4)]
    return [
        f"_SPS[{at + 1}]".ljust(10) + "  ".join(f"{word:08X}" for word in words[at : at + WORDS_A_LINE])
        for at in range(0, len(words), WORDS_A_LINE)
    ]


def _variable(name: str, value: int | float | str | None, why: str, language: str) -> list[str]:
    """An integer in all three formats (L1358)."""
    if value is None:
        return [name, *textwrap.wrap(say(why or "no value", language), COLUMNS)]
    if isinstance(value, int):
        return [name, f"dec {value}", f"hex {value & 0xFFFFFFFF:X}H", f"bin {value & 0xFFFFFFFF:b}B"]
    return [name, *(textwrap.wrap(value, COLUMNS) or ['""'])] if isinstance(value, str) else [name, f"{value:.10g}"]
