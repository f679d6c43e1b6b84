"""Where the axes stood when the gateway was stopped: at the next start a multi-turn encoder that counted round meanwhile is told."""

import contextlib
import json

from gateway import zeros
from gateway.axes import scaling_of
from gateway.cell import Axis, Cell
from gateway.pure.records import AxisFlag, CellState
from gateway.pure.wrap import beside, wrapped, wrapped_endless
from motion.units import from_si, to_si

AGAIN = "check the position and write it again with: axisgate axis zero"


def remember(cell: Cell, state: CellState, placed: int = 0) -> None:
    """Raw increments of the absolute axes, beside their zeros; a folder nobody may write to is no reason to fail.  placed: axes (bit n-1 =
    axis n) whose position a program has set: what they show says nothing of their encoder.  Of endless axes those of the first round."""
    places = _raw(cell, state, placed)
    if places:
        path = zeros.path_of(cell).with_suffix(".last.json")
        with contextlib.suppress(OSError):
            path.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
            path.write_text(json.dumps(places))


def judge(cell: Cell, state: CellState) -> list[str]:
    """One sentence for each axis whose encoder jumped by its range since then, or an endless one that stands where that would show it."""
    try:
        last = json.loads(zeros.path_of(cell).with_suffix(".last.json").read_text())
    except (OSError, ValueError):
        return []
    found = []
    for name, now in _raw(cell, state).items():
        if name in last:
            axis = cell.axis_named(name)
            found += _counted_on(axis, int(last[name]), now) if axis.modulo else _counted(axis, int(last[name]), now)
    return found


def _counted(axis: Axis, last: int, now: int) -> list[str]:
    turns = wrapped(last, now, axis.drive.inc_per_turn) / axis.drive.inc_per_turn
    what = (
        f"axis {axis.name}: the encoder counted round by {turns:+g} turns since the last stop ({last} -> {now}): its zero is void, {AGAIN}"
    )
    return [what] if turns else []


def _counted_on(axis: Axis, last: int, now: int) -> list[str]:
    """Of an endless axis: what can be known of one (AX-607)."""
    per_unit = scaling_of(axis).inc_per_unit
    around = abs(per_unit * to_si(axis.modulo, axis.unit))
    turns = wrapped_endless(last, now, axis.drive.inc_per_turn, around) / axis.drive.inc_per_turn
    moved = from_si(beside(now - last, around) / per_unit, axis.unit)
    what = (
        f"axis {axis.name}: shown {moved:+.4g} {axis.unit} beside its place at the last stop, as when its encoder counts round "
        f"by {turns:+g} turns: its zero is void unless somebody turned it, {AGAIN}"
    )
    return [what] if turns else []


def _raw(cell: Cell, state: CellState, placed: int = 0) -> dict[str, int]:
    absolute = [(n, axis) for n, axis in enumerate(cell.axis) if axis.home.by == "none" and not placed >> n & 1]
    return {
        axis.name: zeros.raw_inc(cell, axis, state.axes[n].actual / to_si(1.0, axis.unit))
        for n, axis in absolute
        if not state.axes[n].flags & (AxisFlag.LOST | AxisFlag.UNCONFIGURED)
    }
