"""[[position]] of a cell file as plain frozen data: what a number of the handshakes number-select and strobe-parity means, beside the
numbers of [[program]]."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Position:
    """One row of the position table; axes that are not named stay where they are."""

    number: int
    at: Mapping[str, float] = field(default_factory=dict)  # axis -> position in its unit
    speed: float = 100.0  # %
    comment: str = ""
