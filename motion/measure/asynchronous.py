"""Speed and distance set from another process while a kinematic moves: SF 41 POTI_MODIFY, SF 42 MOVE_DIST.

Source: rho 3 Releases part 2 (TO05), section 3 (L6756-6830).  SF 41 replaces the kinematic's VFACTOR during the movement; SF 42 is the
distance a modified MOVE UNTIL travels past the edge of the probe.
"""

import math

from motion.errors import MotionError
from motion.program.factors import FactorTable

PLANNED = 1.0  # V factor to plan with where SF 41 is used: the override then carries the factor, up as well as down (AX-458)


class Asynchronous:
    """The mailbox of one control; any process writes, the kinematic reads once a cycle."""

    def __init__(self, kinematics: int, factors: FactorTable) -> None:
        self._factors = factors
        self._distances = [0.0] * kinematics

    def poti_modify(self, kinematic: int, poti: float) -> None:
        """SF 41: from now on the V factor of this kinematic (1..); MotionError outside 0 .. 1."""
        self._place(kinematic)
        self._factors.set_kinematic(kinematic, velocity=poti)

    def move_dist(self, kinematic: int, distance: float) -> None:
        """SF 42: mm or deg past the edge; stays until set anew."""
        if not math.isfinite(distance):
            raise MotionError(f"MOVE_DIST: {distance} is not a number")
        self._distances[self._place(kinematic)] = distance

    def distance(self, kinematic: int) -> float:
        """As set last by SF 42; 0 before."""
        return self._distances[self._place(kinematic)]

    def override(self, kinematic: int, planned: float = PLANNED) -> float:
        """For Stepper.set_override in each cycle; planned: V factor the pieces under way were planned with."""
        if not 0.0 < planned <= 1.0:
            raise MotionError(f"V factor {planned:.6g} of planned pieces is outside 0 .. 1")
        return min(self._factors.acting(kinematic).velocity / planned, 1.0)

    def _place(self, kinematic: int) -> int:
        if not 1 <= kinematic <= len(self._distances):
            raise MotionError(f"kinematic {kinematic} is outside 1 .. {len(self._distances)}")
        return kinematic - 1
