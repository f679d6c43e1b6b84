"""Robots by pinocchio alone: where their flange is by a model of joints and links that shares no line with the project's kinematics."""

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from motion.geometry.frames import Pose

Axis = tuple[str, str, str]  # joint type, axis, origin
LIMIT = '<limit lower="-9" upper="9" velocity="1" effort="1"/>'


class Pinned:
    """joints: from the base on; flange: origin and rpy of the last, fixed one."""

    def __init__(self, joints: Sequence[Axis], flange: tuple[str, str] = ("0 0 0", "0 0 0")) -> None:
        text = '<robot name="r"><link name="l0"/>'
        for n, (kind, axis, origin) in enumerate(joints, 1):
            text += f'<link name="l{n}"/><joint name="j{n}" type="{kind}"><parent link="l{n - 1}"/><child link="l{n}"/>'
            text += f'<origin xyz="{origin}"/><axis xyz="{axis}"/>{LIMIT}</joint>'
        text += f'<link name="flange"/><joint name="f" type="fixed"><parent link="l{len(joints)}"/><child link="flange"/>'
        self._model = pin.buildModelFromXML(text + f'<origin xyz="{flange[0]}" rpy="{flange[1]}"/></joint></robot>')
        self._data, self._frame = self._model.createData(), self._model.getFrameId("flange")

    def forward(self, q: Sequence[float]) -> Pose:
        """The flange in the base."""
        pin.forwardKinematics(self._model, self._data, np.array(q[: self._model.nq]))
        place = pin.updateFramePlacement(self._model, self._data, self._frame)
        x, y, z = (float(value) for value in place.translation)
        a, b, c, d, e, f, g, h, i = (float(value) for value in place.rotation.flat)
        return Pose((x, y, z), (a, b, c, d, e, f, g, h, i))


def tx60() -> Pinned:
    """configs/robots/tx60-like.toml."""
    turns = (("0 0 1", "0 0 0"), ("0 1 0", "0 0 0.375"), ("0 1 0", "0 0 0.29"), ("0 0 1", "0 0.02 0"), ("0 1 0", "0 0 0.31"))
    return Pinned([*(("revolute", axis, origin) for axis, origin in turns), ("revolute", "0 0 1", "0 0 0")], ("0 0 0.07", "0 0 0"))


def sr60() -> Pinned:
    """configs/robots/sr60-like.toml."""
    links = (("revolute", "0 0 0"), ("revolute", "0.35 0 0"), ("prismatic", "0.25 0 0.3"), ("revolute", "0 0 0"))
    return Pinned([(kind, "0 0 1", origin) for kind, origin in links], ("0 0 0", f"{math.pi} 0 0"))
