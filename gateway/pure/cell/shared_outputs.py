"""[[shared_output]] of the cell file: several axes on one set-point output (docs/guide/motion-programs.md)."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Le, MaxLen, MinLen

from gateway.pure.cell.marks import Name, OneRobot, Unit


@dataclass(frozen=True, slots=True)
class SharedOutput:
    """[[shared_output]]: P401 sub-query 6 numbers these axes 101, 102, 103 .. of one output (rho 3 section 17)."""

    name: Name
    axes: Annotated[tuple[str, ...], MinLen(2), MaxLen(32)]  # in the order of their running numbers
    output: Annotated[int, Ge(0), Le(1023)]  # first RC output of the set point: a word, 32767 = the axis' speed limit
    # RC output of the first axis, the others follow it: 1 while the axis has the set point
    select: Annotated[int | None, Ge(0), Le(1023)] = None
    correction_ms: Annotated[int, Ge(0), Le(10000), Unit("ms")] = 0  # P201: how long the position loop stays closed after INPOS
    gain: Annotated[float, Ge(0.0), Le(1000.0), Unit("1/s")] = 16.7  # of that loop, 1/s
    keep_last: bool = False  # outside of programs the last axis keeps it until another one moves
    robot: OneRobot = ()  # whose axes they are: one; empty: the only one
