"""[alter] of the cell file: a correction from outside that alterable parts of programs follow (docs/guide/belts.md)."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Alter:
    """[alter]: where a command source writes x, y, z, rx, ry, rz, and where it reads what became of it (VAL 3 13.1)."""

    input: int  # first RC input of the correction
    type: str = "INT"  # INT | REAL
    length: float = 0.01  # mm of one count, INT
    angle: float = 0.01  # deg of one count, INT
    life: int | None = None  # first RC input of a byte that changes with every correction; None: the command source writes again and again
    silence_ms: int = 100  # so old a correction may be
    every_ms: int = 4  # so often it is taken; in between the set values go straight from one to the next
    status: int | None = None  # first RC output of two words: answer and mode, alterStopTime
    robot: tuple[str, ...] = ()  # whose programs it corrects; empty: the only one
