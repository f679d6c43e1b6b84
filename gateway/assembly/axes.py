"""Converts [[axis]] of a cell for core, dispatcher and planner: the only place where units of the file become SI."""

from collections.abc import Mapping, Sequence
from math import inf

from drivers.drives.family import DriveHoming, DriveMaker
from drivers.drives.reference_settings import ReferenceMove, ReferenceSettings
from drivers.drives.scaling import Scaling
from gateway.assembly.axis_scaling import scaling_of, window_of
from gateway.assembly.limits import limits_of
from gateway.assembly.programs import kinematic_by_axis
from gateway.pure.arbitration.dispatcher import Planner
from gateway.pure.arbitration.jobs import AxisFacts
from gateway.pure.cell.cell import Axis, Cell
from gateway.pure.cycle.axis import CoreAxis
from gateway.pure.image.reasons import Reason, Refusal
from gateway.registry import DRIVE_FAMILIES
from motion.errors import MotionError
from motion.execution.pieces import encode
from motion.execution.ptp import plan_ptp
from motion.geometry.units import to_si

SLOW_SHARE = 0.2  # of the homing speed, where the cell names no slow speed
HOMING_ACCEL_S = 0.25  # homing reaches its speed in this time, if the axis' own limits allow
NO_ZEROS: Mapping[str, float] = {}


def reference_of(axis: Axis, scaling: Scaling) -> ReferenceSettings | DriveHoming | None:
    """Referencing by the gateway, modes 0 to 3, or by the drive; None where the axis needs none."""
    home = axis.home
    if home.by == "drive":
        return DriveHoming(to_si(home.position + home.offset, axis.unit))
    if home.by != "gateway":
        return None
    limits = axis.limits
    accel = min(limits.accel, home.speed / HOMING_ACCEL_S)

    def si(value: float) -> float:
        return to_si(value, axis.unit)

    move = ReferenceMove(
        direction=-1 if home.direction == "-" else 1,
        speed=si(home.speed),
        slow_speed=si(home.slow_speed or SLOW_SHARE * home.speed),
        accel=si(accel),
        jerk=si(min(limits.jerk, accel / HOMING_ACCEL_S * 4.0)),
        position=si(home.position),
        offset=si(home.offset),
        way=si(limits.max - limits.min) * 1.2,
        timeout_s=home.timeout_s,
        mode=home.mode,
    )
    return move.at_motor(scaling)


def drive_of(axis: Axis, step_inc: int, p5_ms: float) -> DriveMaker:
    """Settings of the axis' drive, of whichever family; `step_inc`: the largest set value step of one cycle."""
    return DRIVE_FAMILIES[axis.drive.type].settings(axis, step_inc, p5_ms)


def core_axes(cell: Cell, p5_ms: float, zeros: Mapping[str, float] = NO_ZEROS, *, simulated: bool = True) -> list[CoreAxis]:
    """The axes in the form the cycle's core reads, in the order of the file.

    `zeros`: increments at which absolute axes read 0 (`axisgate axis zero`); on real drives an axis without a zero is not referenced.
    """
    found = []
    for axis, kinematic in zip(cell.axis, kinematic_by_axis(cell), strict=True):
        scaling = scaling_of(axis)
        absolute = axis.home.by == "none"
        if absolute and axis.name in zeros:
            scaling = scaling.with_zero(zeros[axis.name])
        zeroed = simulated or not absolute or axis.name in zeros
        per_cycle = axis.limits.speed * p5_ms / 1000.0
        step = 4 * abs(scaling.inc_per_unit) * to_si(per_cycle, axis.unit)
        drive = drive_of(axis, max(1024, round(step)), p5_ms)
        lag = axis.following_error
        warn, trip = (to_si(lag.warn, axis.unit), to_si(lag.trip, axis.unit)) if lag else (float("inf"), float("inf"))
        standstill = to_si(lag.standstill, axis.unit) if lag and lag.standstill is not None else float("inf")
        modulo = to_si(axis.modulo, axis.unit)
        travel = (-inf, inf) if modulo else (to_si(axis.limits.min, axis.unit), to_si(axis.limits.max, axis.unit))
        lags, reference = (warn, trip, standstill), reference_of(axis, scaling)
        found.append(CoreAxis(axis.name, scaling, reference, window_of(axis), drive, *lags, zeroed, modulo, kinematic, travel))
    return found


def axis_facts(cell: Cell) -> list[AxisFacts]:
    """The axes as the dispatcher needs them."""
    return [
        AxisFacts(
            axis.name,
            axis.unit,
            to_si(1.0, axis.unit),
            axis.limits.min,
            axis.limits.max,
            axis.modulo > 0.0,
            axis.home.by == "none",
        )
        for axis in cell.axis
    ]


def make_planner(cell: Cell) -> Planner:
    """PTP planning for the dispatcher: start and target in SI to an encoded piece; a motion error becomes a refusal."""
    limits = [limits_of(axis) for axis in cell.axis]

    def plan(start: Sequence[float], target: Sequence[float], mask: int, velocity: float, acceleration: float, job: int) -> bytes:
        try:
            return encode(plan_ptp(start, target, limits, velocity, acceleration, job, mask))
        except MotionError as error:
            raise Refusal(Reason.TARGET_LIMIT, str(error)) from error

    return plan
