"""Bus and identifiers of each axis.

Source: rho 3 Releases part 1, L7250, L7276 (axes 1..6 on bus 1, 7..12 on bus 2 with the same identifiers), L11024-11026 (SYNC 100, set
values 210.., actual values 610..).  "rho3 D-13": the numbers are read as decimal; drives 5 and 6 are derived (200+10n, 600+10n).
"""

from typing import NamedTuple

SYNC_ID = 100
SLOTS = 6  # axes on one bus
AXES = 12


class Place(NamedTuple):
    bus: int  # 1 or 2
    slot: int  # module 1..6 on that bus
    set_id: int
    actual_id: int


def set_id(slot: int) -> int:
    """Identifier of the set values of module `slot` (1..6) of a bus."""
    return 200 + 10 * slot


def actual_id(slot: int) -> int:
    """Identifier of the actual values of module `slot` (1..6) of a bus."""
    return 600 + 10 * slot


def place(axis: int) -> Place:
    """Where axis 1..12 of the old controller is found.  Raises ValueError for any other number."""
    if not 1 <= axis <= AXES:
        raise ValueError(f"axis {axis} is outside 1..{AXES}")
    bus, slot = divmod(axis - 1, SLOTS)
    return Place(bus + 1, slot + 1, set_id(slot + 1), actual_id(slot + 1))
