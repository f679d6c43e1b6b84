"""Machine data of the path control of the Reis ROBOTstar V, with their ranges.  Source: L1962-2041, L4702."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

from motion.program.errors import BlockError

MACHINE_DATA_RANGE = 650  # "machine data exceeds value range" (L4702)


@dataclass(frozen=True, slots=True)
class MachineData:
    """Constants of the spline mathematics and of zero steps (L1962-2041); a value outside its range raises number 650."""

    RSPOS_APPROX_QUAL: float = 1e-6  # mm
    RSORI_APPROX_QUAL: float = 1e-5  # deg
    RDELTA_OV_MAX: float = 0.1
    RAPPR_FACT_MAX: float = 0.4
    RSYNC_WEIGHT: float = 1.0
    RSMOOTH_WEIGHT: float = 0.5
    RSYNC_MIN_PHASE: float = 0.1
    RTIME_EPS: float = 0.001  # s
    RS_POS_EPS: float = 0.01  # mm
    RS_ORI_EPS: float = 0.1  # deg
    RS_AX_EPS: float = 0.001  # deg
    RACC_MAX: float = 2000.0  # mm/s2

    def __post_init__(self) -> None:
        for entry in fields(self):
            check_machine_data(entry.name, getattr(self, entry.name))


# name -> (lower, lower belongs to it, upper, upper belongs to it)
_OPEN = (0.0, False, math.inf, False)
_DATA_RANGES: Mapping[str, tuple[float, bool, float, bool]] = {
    "RDELTA_OV_MAX": (0.0, False, 1.0, True),
    "RAPPR_FACT_MAX": (0.0, False, 0.5, False),
    "RSYNC_WEIGHT": (0.0, True, 1.0, True),
    "RSMOOTH_WEIGHT": (0.0, True, 1.0, True),
    "RSYNC_MIN_PHASE": (0.0, True, 0.5, True),
}


def check_machine_data(name: str, value: float) -> None:
    """Raises BlockError 650 for a machine datum outside its range."""
    low, with_low, high, with_high = _DATA_RANGES.get(name, _OPEN)
    if not ((low <= value if with_low else low < value) and (value <= high if with_high else value < high)):  # a NaN fails, too
        sides = f"{low:g} {'<=' if with_low else '<'} x {'<=' if with_high else '<'} {high:g}"
        raise BlockError(f"machine data exceeds value range: {name} = {value:g}, {sides}", code=MACHINE_DATA_RANGE, source="Reis")
