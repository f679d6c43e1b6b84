"""Point to point: straight in joint space, all axes start and end together, limits of every axis kept (goal 15).

On a straight line each axis moves by its share of one s(t); s gets the smallest of the axes' limits divided by their
shares, so the jerk-limited optimum in s is the optimum on that line.
"""

from collections.abc import Sequence

from motion.errors import MotionError
from motion.execution.pieces import MAX_AXES, Piece, Segment
from motion.execution.profile import Profile
from motion.geometry.limits import AxisLimits, check_factor, check_targets

SMALLEST = 1e-12  # m or rad: less is no motion


def plan_ptp(
    start: Sequence[float],
    target: Sequence[float],
    limits: Sequence[AxisLimits],
    velocity_factor: float = 1.0,
    acceleration_factor: float = 1.0,
    piece_id: int = 1,
    mask: int | None = None,
) -> Piece:
    """start, target: (n,) m or rad; mask: axes that move (default all n).

    Jerk is not scaled by the acceleration factor (AX-101).  Raises LimitError for a target outside, with the axis named.
    """
    axes = _axes(start, target, limits, mask)
    check_factor("velocity factor", velocity_factor)
    check_factor("acceleration factor", acceleration_factor)
    check_targets([limits[n] for n in axes], [target[n] for n in axes])
    travel = [float(target[n]) - start[n] for n in axes]
    length = max(abs(way) for way in travel)
    if not length < float("inf"):  # a NaN start makes the travel NaN
        raise MotionError(f"start {list(start)} is not all numbers")
    bits = sum(1 << n for n in axes)
    if length <= SMALLEST:
        return Piece(piece_id, bits, 0.0, (Segment(0.0, tuple((target[n],) for n in axes)),), (1.0, 1.0), 1.0, 1.0)
    moving = [(limits[n], abs(way) / length) for n, way in zip(axes, travel, strict=True) if abs(way) > SMALLEST]
    speed = velocity_factor * min(axis.speed / share for axis, share in moving)
    line = Segment(length, tuple((start[n], way / length) for n, way in zip(axes, travel, strict=True)))
    return Piece(
        piece_id,
        bits,
        length,
        (line,),
        (speed * speed, speed * speed),
        acceleration_factor * min(axis.accel / share for axis, share in moving),
        min(axis.jerk / share for axis, share in moving),
    )


def _axes(start: Sequence[float], target: Sequence[float], limits: Sequence[AxisLimits], mask: int | None) -> list[int]:
    count = len(limits)
    if not (len(start) == len(target) == count and 1 <= count <= MAX_AXES):
        raise MotionError(f"{len(start)} starts, {len(target)} targets, {count} limits: the same number, 1 .. {MAX_AXES}, is needed")
    bits = (1 << count) - 1 if mask is None else mask
    if not 0 < bits < 1 << count:
        raise MotionError(f"axis mask {bits:#x} is outside 1 .. {(1 << count) - 1:#x}")
    return [n for n in range(count) if bits >> n & 1]


def nominal_duration(piece: Piece) -> float:
    """Seconds from rest to the end at override 1."""
    if piece.length == 0.0:
        return 0.0
    if len(set(piece.table)) > 1:
        return _stepped_duration(piece, 1e-3)
    profile = Profile()
    profile.configure(piece.length, piece.accel, piece.jerk)
    if not profile.to_end((0.0, 0.0, 0.0), piece.table[0] ** 0.5):
        raise MotionError(f"piece {piece.id}: no jerk-limited motion found for length {piece.length}")
    return profile.duration


def _stepped_duration(piece: Piece, period_s: float) -> float:
    """For a varying speed table: the stepper itself knows, to one period."""
    from motion.execution.stepper import State, Stepper  # who only plans (services) does not load the stepper, and numpy with it

    stepper = Stepper(max(piece.axes) + 1, period_s)
    stepper.place_for(piece)
    stepper.load(piece)
    steps = 1
    while stepper.step().state is State.RUNNING:
        steps += 1
    return steps * period_s
