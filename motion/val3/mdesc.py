"""Motion descriptors: fields, default, validation, and the block's pace and blend they mean.

Source: VAL 3 reference 10.5 (L5690-5712), speed rule 10.3.2 (L5635-5665), errors 100 .. 106 (L6637-6643).  Percentages are of
nominal values and may be above 100 (L5667-5677); the limit is not documented: AX-411.
"""

import math
from dataclasses import dataclass
from enum import Enum

from motion.program.blocks import Blend, Pace, Rounding
from motion.val3.errors import RuntimeFault


class BlendKind(Enum):
    OFF = "off"
    JOINT = "joint"
    CARTESIAN = "Cartesian"


TOO_LARGE, STEEPEST = 500.0, 9999.0  # %: of vel; of accel and decel (AX-411)
_PERCENT = (("vel", 100, TOO_LARGE), ("accel", 101, STEEPEST), ("decel", 102, STEEPEST))
_TOOL = (("tvel", 103), ("rvel", 104))
_LENGTHS = (("leave", 106), ("reach", 105))


@dataclass(frozen=True, slots=True)
class Mdesc:
    """In the order of the fields (L5697-5708); the default is {100,100,100,9999,9999,joint,50,50} (L5712)."""

    accel: float = 100.0  # % of nominal
    vel: float = 100.0
    decel: float = 100.0
    tvel: float = 9999.0  # unit/s of the TCP
    rvel: float = 9999.0  # deg/s of the tool
    blend: BlendKind = BlendKind.JOINT
    leave: float = 50.0  # length unit of the application
    reach: float = 50.0

    def check(self) -> None:
        """Raises RuntimeFault 100 .. 106 for the first field that is invalid: speeds > 0, distances >= 0."""
        for name, code, most in _PERCENT:
            value = getattr(self, name)
            if not 0.0 < value <= most:
                raise RuntimeFault(code, f"{name} {value:g} %, 0 < {name} <= {most:g}")
        for name, code in _TOOL:
            if not 0.0 < getattr(self, name) < math.inf:
                raise RuntimeFault(code, f"{name} {getattr(self, name):g}, must be above 0")
        for name, code in _LENGTHS:
            if not 0.0 <= getattr(self, name) < math.inf:
                raise RuntimeFault(code, f"{name} {getattr(self, name):g}, must not be negative")

    def pace(self, unit_m: float = 1e-3) -> Pace:
        """Joint shares and TCP speeds; unit_m: the application's length unit in m (mm or inch)."""
        return Pace(self.vel / 100, self.accel / 100, self.decel / 100, self.tvel * unit_m, math.radians(self.rvel))

    def blending(self, unit_m: float = 1e-3) -> Blend:
        """leave and reach in m; nothing where blend is off."""
        if self.blend is BlendKind.OFF:
            return Blend()
        kind = Rounding.JOINT if self.blend is BlendKind.JOINT else Rounding.CARTESIAN
        return Blend(kind, self.leave * unit_m, self.reach * unit_m, past_circles=True)


def matching(vel: float) -> Mdesc:
    """The descriptor that goes with a speed by the tuning rule: accel = decel = (vel / 100)^2 (L5654): 120 % goes with 144 %."""
    if not 0.0 < vel <= TOO_LARGE:
        raise RuntimeFault(100, f"vel {vel:g} %, 0 < vel <= {TOO_LARGE:g}")
    square = vel * vel / 100.0
    return Mdesc(accel=square, vel=vel, decel=square)
