"""[alter] of the cell file: a correction from outside that alterable parts of programs follow (docs/guide/belts.md)."""

from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le

from gateway.pure.cell.marks import Robots, Unit


@dataclass(frozen=True, slots=True)
class Alter:
    """[alter]: where a command source writes x, y, z, rx, ry, rz, and where it reads what became of it (VAL 3 13.1)."""

    input: Annotated[int, Ge(0), Le(1023)]  # first RC input of the correction
    source: Literal["image", "application"] = "image"  # who corrects: what writes these inputs, or the application of [val3]
    type: Literal["INT", "REAL"] = "INT"
    length: Annotated[float, Gt(0.0), Le(10.0), Unit("mm")] = 0.01  # mm of one count, INT
    angle: Annotated[float, Gt(0.0), Le(1.0), Unit("deg")] = 0.01  # deg of one count, INT
    # first RC input of a byte that changes with every correction; None: the command source writes again and again
    life: Annotated[int | None, Ge(0), Le(1023)] = None
    silence_ms: Annotated[int, Ge(10), Le(10000), Unit("ms")] = 100  # so old a correction may be
    # sampling period; in between the set values go straight from one to the next
    every_ms: Annotated[int, Ge(1), Le(1000), Unit("ms")] = 4
    status: Annotated[int | None, Ge(0), Le(1023)] = None  # first RC output of two words: answer and mode, alterStopTime
    robot: Robots = ()  # whose programs it corrects; empty: the only one
