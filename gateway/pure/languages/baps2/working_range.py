"""LIMIT_MIN and LIMIT_MAX: the working range of a kinematic in world points (rho 3 releases L8976-8983).  Pure."""

from collections.abc import Mapping, Sequence

from gateway.pure.languages.baps2.errors import fault

LOWER, UPPER = "LIMIT_MIN", "LIMIT_MAX"
KEYS = {LOWER: "limitmin", UPPER: "limitmax"}  # of a block in the text form
ROUNDING = 1e-6  # mm or deg
Limits = Mapping[str, Sequence[float]]


def check_limits(limits: Limits) -> None:
    """Both, as they are set; a runtime error where the lower end is above the upper one."""
    for n, (low, high) in enumerate(zip(limits.get(LOWER, ()), limits.get(UPPER, ()), strict=False), 1):
        if low > high:
            raise fault(218, f"component {n} of LIMIT_MIN is {low:g}, of LIMIT_MAX {high:g}")


def check_range(limits: Limits, place: Sequence[float]) -> None:
    """A point that a block leads to, in the workpiece system that is selected; a runtime error for one outside."""
    for name, sign in ((LOWER, -1.0), (UPPER, 1.0)):
        for n, (value, end) in enumerate(zip(place, limits.get(name, ()), strict=False), 1):
            if sign * (value - end) > ROUNDING:
                raise fault(225, f"component {n} = {value:g}, {name} is {end:g}")


def range_keys(limits: Limits) -> str:
    """The same for the way of a block, where the planner looks at x, y and z."""
    return " ".join(f"{KEYS[name]}={','.join(f'{each:.10g}' for each in ends[:3])}" for name, ends in limits.items() if len(ends) >= 3)
