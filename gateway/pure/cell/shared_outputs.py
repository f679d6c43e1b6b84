"""[[shared_output]] of the cell file: several axes on one set-point output (docs/guide/motion-programs.md)."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SharedOutput:
    """[[shared_output]]: P401 sub-query 6 gives such axes 101, 102, 103 .. of one output (rho 3 section 17)."""

    name: str
    axes: tuple[str, ...]  # in the order of their running numbers
    output: int  # first RC output of the set point: a word, 32767 = the axis' speed limit
    select: int | None = None  # RC output of the first axis, the others behind it: 1 while the axis has the set point
    correction_ms: int = 0  # P201: so long the position loop stays closed behind INPOS
    gain: float = 16.7  # of that loop, 1/s
    keep_last: bool = False  # outside of programs the last axis keeps it until another one moves
    robot: tuple[str, ...] = ()  # whose axes they are: one; empty: the only one
