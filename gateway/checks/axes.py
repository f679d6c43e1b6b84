"""Axes: limits that do not contradict each other, homing that can end, P401 signs, check positions, the plant."""

from gateway.checks.context import Context, near, number
from gateway.pure.cell.cell import Axis, PlantAxis
from gateway.pure.image.records.cell import MOST_AXES


def limits(check: Context) -> None:
    """min < max, warn <= trip, brake ramp shorter than the travel."""
    if len(check.cell.axis) > MOST_AXES:
        check.fault("axis", f"{len(check.cell.axis)} axes", "", f"at most {MOST_AXES}")
    for axis in check.cell.axis:
        key, bound = f"axis.{axis.name}.limits", axis.limits
        if bound.min >= bound.max:
            check.fault(f"{key}.min", number(bound.min), f"must be below max = {number(bound.max)}", "", axis.unit)
        lag = axis.following_error
        if lag is not None and lag.warn > lag.trip:
            key = f"axis.{axis.name}.following_error.warn"
            check.fault(key, number(lag.warn), f"must be at most trip = {number(lag.trip)}", "", axis.unit)


def endless(check: Context) -> None:
    """modulo: a turning axis whose positions are 0 .. modulo (P303 = 3, P311)."""
    for axis in check.cell.axis:
        if not axis.modulo:
            continue
        key, bound = f"axis.{axis.name}", axis.limits
        if axis.unit != "deg":
            check.fault(f"{key}.modulo", number(axis.modulo), "an endless axis turns: unit must be deg", "", axis.unit)
        if (bound.min, bound.max) != (0.0, axis.modulo):
            hint = f"an endless axis has the positions 0..{number(axis.modulo)}: min = 0, max = modulo"
            check.fault(f"{key}.limits", f"{number(bound.min)}..{number(bound.max)}", hint, "", axis.unit)


def homing(check: Context) -> None:
    """A gateway-run search has a speed, its result lies inside the limits."""
    for axis in check.cell.axis:
        key, home = f"axis.{axis.name}.home", axis.home
        if home.by == "drive" and home.method is None:
            check.fault(f"{key}.method", "", 'by = "drive" needs the CiA 402 homing method', "-128..37")
        if home.by != "gateway":
            continue
        if home.speed <= 0:
            check.fault(
                f"{key}.speed", number(home.speed), "the search for the reference switch needs a speed (P108)", "> 0", f"{axis.unit}/s"
            )
        if home.speed > axis.limits.speed:
            hint = f"faster than the axis: limits.speed = {number(axis.limits.speed)}"
            check.fault(f"{key}.speed", number(home.speed), hint, "", f"{axis.unit}/s")
        if home.slow_speed > home.speed > 0:
            hint = f"the reduced speed (P109) is above home.speed = {number(home.speed)}"
            check.fault(f"{key}.slow_speed", number(home.slow_speed), hint, "", f"{axis.unit}/s")
        end = home.position + home.offset
        if axis.limits.min < axis.limits.max and not axis.limits.min <= end <= axis.limits.max:
            hint = f"position + offset = {number(end)} is outside the limits"
            check.fault(f"{key}.offset", number(home.offset), hint, f"{number(axis.limits.min)}..{number(axis.limits.max)}", axis.unit)


def measuring_systems(check: Context) -> None:
    """P401: one table for each axis and module; both signs or none reverse an axis (rho3 2.9)."""
    if check.cell.rho3 is None:
        return
    axes: set[int] = set()
    modules: set[int] = set()
    for system in check.cell.rho3.P401:
        key = f"rho3.P401.{system.axis}"
        if system.axis in axes:
            check.fault(f"{key}.axis", system.axis, "this axis has a P401 table already")
        if system.module in modules:
            check.fault(f"{key}.module", system.module, "this module belongs to another axis already")
        axes.add(system.axis)
        modules.add(system.module)
        if system.output and (system.evaluation < 0) != (system.output < 0):
            values = f"evaluation {number(system.evaluation)}, output {system.output}"
            check.fault(f"{key}.output", values, "both negative reverse the axis; with only one it never reaches position (rho3 2.9)")


def positions(check: Context) -> None:
    """Check positions name axes that exist and lie inside their limits."""
    axes = {axis.name: axis for axis in check.cell.axis}
    for position in check.cell.check_position:
        key = f"check_position.{position.name}"
        pairs = dict(position.at)
        if position.joints and len(position.joints) != len(axes):
            check.fault(f"{key}.joints", f"{len(position.joints)} values", f"the cell has {len(axes)} axes")
        else:
            pairs |= dict(zip(axes, position.joints, strict=False))
        for name, value in pairs.items():
            if check.unknown(f"{key}.at", name, "axis") or name not in axes:
                continue
            bound = axes[name].limits
            if bound.min < bound.max and not bound.min <= value <= bound.max:
                check.fault(
                    f"{key}.at", f"{name} = {number(value)}", "outside the axis' limits", f"{number(bound.min)}..{number(bound.max)}"
                )


def plant(check: Context) -> None:
    """The emulated axes exist, start inside their travel, can be referenced and can follow."""
    if check.cell.plant is None:
        return
    axes = {axis.name: axis for axis in check.cell.axis}
    for name, values in check.cell.plant.axis.items():
        if name not in check.known["axis"]:
            check.fault(f"plant.axis.{name}", name, f"no such axis; {near(name, check.known['axis']) or 'named as in [[axis]]'}")
        elif name in axes:
            _plant_axis(check, axes[name], values)


def _plant_axis(check: Context, axis: Axis, values: PlantAxis) -> None:
    key = f"plant.axis.{axis.name}"
    switch = values.reference_switch
    for name, span in (("reference_switch", switch), ("hard_limits", values.hard_limits), ("probe", values.probe)):
        if span is not None and span.from_ >= span.to:
            check.fault(f"{key}.{name}", f"{number(span.from_)}..{number(span.to)}", "from must be below to", "", axis.unit)
    if values.hard_limits and not values.hard_limits.from_ <= values.start <= values.hard_limits.to:
        check.fault(f"{key}.start", number(values.start), "beyond the hard limits", "", axis.unit)
    if switch and axis.home.by == "gateway" and switch.from_ < switch.to:
        away = values.start < switch.from_ if axis.home.direction == "-" else values.start > switch.to
        if away:
            ends = f"{number(switch.from_)}..{number(switch.to)}"
            hint = f'the search goes in direction "{axis.home.direction}" and never reaches the switch {ends}'
            check.fault(f"{key}.start", number(values.start), hint, "", axis.unit)
    limit = values.settings.get("speed_limit_rad_s")
    speed = axis.limits.speed / axis.mechanics.feed_per_turn * axis.mechanics.ratio * 6.283185307179586
    if limit is not None and speed > limit:
        hint = f"limits.speed = {number(axis.limits.speed)} {axis.unit}/s needs {number(speed)} rad/s at the motor"
        check.fault(f"{key}.speed_limit_rad_s", number(limit), hint, "", "rad/s")


CHECKS = (limits, endless, homing, measuring_systems, positions, plant)
