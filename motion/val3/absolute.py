"""Absolute robot: getDH, getDefaultDH, setDH.  Source: VAL 3 reference 13.3, L6515-6576; doubt D16 (order and the missing b)."""

from motion.errors import MotionError
from motion.kinematics.arm6 import Arm6
from motion.kinematics.base import Kinematics
from motion.kinematics.dh import DhParameters, MeasuredArm, default_dh, too_far
from motion.val3.errors import RuntimeFault


class AbsoluteRobot:
    """The geometry of one arm: as built, or as measured."""

    def __init__(self, arm: Arm6, *, licensed: bool) -> None:
        self.arm, self.licensed = arm, licensed
        self._default = default_dh(arm.geometry)
        self._measured: DhParameters | None = None
        self.kinematics: Kinematics = arm

    def get_default_dh(self) -> DhParameters:
        """getDefaultDH: the arm as built."""
        return self._default

    def get_dh(self) -> DhParameters:
        """getDH: return the parameters in force."""
        return self._measured or self._default

    def set_dh(self, parameters: DhParameters, *, moves_pending: bool = False) -> bool:
        """setDH: True and in force at once, False when too far from the arm as built.  250 without licence.

        The instruction waits until no move is pending; the caller does the waiting.
        """
        if not self.licensed:
            raise RuntimeFault(250, "absolute robot")
        if moves_pending:
            raise MotionError("setDH while moves are pending: wait until the motion generator is empty")
        if too_far(parameters, self._default):
            return False
        self._measured = parameters
        self.kinematics = MeasuredArm(self.arm, parameters)
        return True
