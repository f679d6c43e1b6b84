"""[retain] of a cell: which values outlive power-off (AX-425)."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Retain:
    """Names, with * and ?: flags.M*, counter.*, order.*, belt.*"""

    values: tuple[str, ...] = ()
