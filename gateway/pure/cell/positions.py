"""[[position]] of a cell file as plain frozen data: the meaning of a number of the handshakes number-select and strobe-parity, in addition
to the numbers of [[program]].
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Le, MinLen

from gateway.pure.cell.marks import Unit


@dataclass(frozen=True, slots=True)
class Position:
    """One row of the position table; axes that are not named stay where they are."""

    number: Annotated[int, Ge(1), Le(65535)]
    at: Annotated[Mapping[str, float], MinLen(1)]  # axis -> position in its unit
    speed: Annotated[float, Gt(0), Le(100), Unit("%")] = 100.0  # %
    comment: str = ""
