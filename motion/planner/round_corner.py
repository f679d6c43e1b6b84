"""Length of the parameter of a corner between two straight paths of the axes.  The longer it is, the closer the corner comes to the point,
and the more gently it bends at its ends.

A corner that is small compared with the distance of a full acceleration ramp is limited by jerk: the gentle ends gain more time there than
the longer path costs (AX-1846).  A wide corner is limited by acceleration: there the longer path costs more.  An axis that keeps its
direction keeps its speed best with the parameter of the two paths.
"""

from collections.abc import Sequence

import numpy as np

from motion.geometry.limits import AxisLimits
from motion.paths.joints import JointPath

GENTLER = 0.08  # at most so much longer, as a share
SMALL, WIDE = 2.0, 8.0  # times the distance of a ramp: all of GENTLER up to the first, none of it from the second on
FLAT = 1e-12


def span(before: JointPath, after: JointPath, reach: float, limits: Sequence[AxisLimits]) -> float:
    """Return the length for the quintic that leaves `before` at `reach` from its end and joins `after` at `reach` from its start."""
    accel, jerk = (np.array([getattr(axis, name) for axis in limits]) for name in ("accel", "jerk"))
    one, two = (path.at(np.array([s]), 1)[0, : path.axes] for path, s in ((before, before.length), (after, 0.0)))
    sizes = [np.maximum(np.abs(slope), FLAT) for slope in (one, two)]
    ramp = max(float(np.min(accel / size)) ** 3 / float(np.min(jerk / size)) ** 2 for size in sizes)
    small = min(max((WIDE - reach / ramp) / (WIDE - SMALL), 0.0), 1.0)
    going_on = float(np.max(np.where(one * two > 0.0, np.minimum(*sizes), 0.0)))
    return 2.0 * reach * (1.0 + GENTLER * small * (1.0 - min(going_on, 1.0)))
