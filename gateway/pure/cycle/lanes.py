"""The lanes of a cell: one for each of its kinematics and one for axes of none; their samples as set values of all axes.  Pure."""

from collections.abc import Sequence

from gateway.pure.cycle.alter_mover import make_mover
from gateway.pure.cycle.homing import Homings
from gateway.pure.cycle.lane import Lane
from gateway.pure.cycle.lane_masks import masks_of
from gateway.pure.cycle.lane_parts import LaneParts
from gateway.pure.image.records.cell import EVERY_AXIS, CellState, LaneState
from motion.execution.stepper import Sample
from motion.timing.override_ramp import OverrideRamp


def make_lanes(parts: LaneParts) -> list[Lane]:
    """In the order of the kinematics; axes of none come last."""
    state, numbers = parts.state, [axis.plan.kinematic for axis in parts.axes]
    masks = masks_of(numbers, one=False)
    if len(masks) == 1:
        return [_lane(masks[0], state, parts)]
    if parts.functions is not None:
        parts.functions.cell = state
        parts.functions.masks = {number: sum(1 << n for n, own in enumerate(numbers) if own == number) for number in set(numbers)}
    if parts.belts is not None or parts.alter is not None:
        state.lanes = [LaneState(own=mask) for mask in masks]
        lane = _lane(EVERY_AXIS, state, parts)
        lane.kinematics = state.lanes
        return [lane]
    state.lanes = [LaneState(own=mask, holds=mask) for mask in masks]
    return [_lane(mask, CellState(generation=state.generation, axes=state.axes), parts) for mask in masks]


def _lane(mask: int, state: CellState, parts: LaneParts) -> Lane:
    homings = Homings(parts.axes, state, parts.period_s)
    mover = make_mover(parts, state, homings)
    mover.functions = parts.functions
    return Lane(mask, state, homings, mover, OverrideRamp(parts.override_step))


def merged(lanes: Sequence[Lane], samples: Sequence[Sample]) -> Sample:
    """Each axis from the lane that holds it."""
    if len(samples) == 1:
        return samples[0]
    q, qd = list(samples[0].q), list(samples[0].qd)
    for lane, sample in zip(lanes[1:], samples[1:], strict=True):
        for n in lane.places:
            q[n], qd[n] = sample.q[n], sample.qd[n]
    return samples[0]._replace(q=tuple(q), qd=tuple(qd))
