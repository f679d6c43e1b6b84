"""The axes of a new cell: three linear ones, then three turning ones, with a machine that `run --sim` can move."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class _Kind:
    unit: str
    feed: str
    gear: str
    limits: str
    error: str
    home: str
    plant: str


_LINEAR = _Kind(
    "mm", "100.0", "5:1",
    "min = -5.0, max = 1000.0, speed = 800.0, accel = 3000.0, jerk = 30000.0",
    "warn = 12.5, trip = 16.0",
    'speed = 100.0, slow_speed = 20.0, direction = "-", position = 0.0, offset = 10.0, timeout_s = 20',
    "start            = 120.0         # mm, at power-up\nreference_switch = { from = -20.0, to = 10.0 }",
)  # fmt: skip
_TURNING = _Kind(
    "deg", "360.0", "80:1",
    "min = -110.0, max = 110.0, speed = 180.0, accel = 600.0, jerk = 6000.0",
    "warn = 2.9, trip = 3.8",
    'speed = 20.0, slow_speed = 4.0, direction = "-", position = 0.0, offset = 0.0, timeout_s = 20',
    "start            = 22.0          # deg, at power-up\nreference_switch = { from = -120.0, to = 2.25 }",
)  # fmt: skip
_NAMES = (("X", _LINEAR), ("Y", _LINEAR), ("Z", _LINEAR), ("A", _TURNING), ("B", _TURNING), ("C", _TURNING))


def blocks_of_axes(count: int) -> tuple[str, str]:
    """Lines of targets and of actual values for the two data blocks, DW 2 onwards."""
    targets, actuals = [], []
    for place, (name, kind) in enumerate(_NAMES[:count]):
        at = f'{{ at = "DW {place + 2}",   type = "KF",'
        targets.append(f'  {at}  to = "move.{name}.target",    unit = "0.1 {kind.unit}" }},')
        actuals.append(f'  {at}  from = "axis.{name}.actual", unit = "0.1 {kind.unit}" }},')
    return "\n".join(targets), "\n".join(actuals)


def axes_text(family: str, count: int) -> str:
    """[[axis]] tables and the emulated machine of `run --sim`."""
    axes = [_axis(family, number, name, kind) for number, (name, kind) in enumerate(_NAMES[:count], start=1)]
    plant = [f"[plant.axis.{name}]\n{kind.plant}\n" for name, kind in _NAMES[:count]]
    heading = "# ---- only for `run --sim`: where the axes are at power-up and where their reference switches are ----"
    return "\n".join([*axes, heading, "[plant]\nseed = 1\n", *plant])


def _axis(family: str, number: int, name: str, kind: _Kind) -> str:
    if family == "servodyn":
        drive = f'type = "servodyn", bus = "drives", module = {number}, inc_per_turn = 16384'
    else:
        drive = f'type = "cia402", bus = "drives", node = {number}, eds = "axisgate_402.eds", inc_per_turn = 16384'
    return f"""\
[[axis]]
name   = "{name}"
unit   = "{kind.unit}"
drive  = {{ {drive} }}
mechanics       = {{ feed_per_turn = {kind.feed}, gear = "{kind.gear}", direction = "+" }}
limits          = {{ {kind.limits} }}
following_error = {{ {kind.error} }}   # without feed-forward the lag is speed / Kv
home            = {{ by = "gateway", mode = 0, {kind.home} }}
"""
