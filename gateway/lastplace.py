"""Where the axes stood when the gateway was stopped: at the next start a multi-turn encoder that counted round meanwhile is told."""

import contextlib
import json

from gateway import zeros
from gateway.cell import Cell
from gateway.pure.records import AxisFlag, CellState
from gateway.pure.wrap import wrapped
from motion.units import to_si


def remember(cell: Cell, state: CellState, placed: int = 0) -> None:
    """Raw increments of the absolute axes, beside their zeros; a folder nobody may write to is no reason to fail.  placed: axes (bit n-1 =
    axis n) whose position a program has set: what they show says nothing of their encoder.  Nor does what endless axes show (AX-607)."""
    places = _raw(cell, state, placed)
    if places:
        path = zeros.path_of(cell).with_suffix(".last.json")
        with contextlib.suppress(OSError):
            path.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
            path.write_text(json.dumps(places))


def judge(cell: Cell, state: CellState) -> list[str]:
    """One sentence for each axis whose encoder jumped by its range since then."""
    try:
        last = json.loads(zeros.path_of(cell).with_suffix(".last.json").read_text())
    except (OSError, ValueError):
        return []
    found = []
    for name, now in _raw(cell, state).items():
        axis = cell.axis_named(name)
        jump = wrapped(int(last[name]), now, axis.drive.inc_per_turn) if name in last else 0
        if jump:
            turns = jump / axis.drive.inc_per_turn
            found.append(
                f"axis {name}: the encoder counted round by {turns:+g} turns since the last stop ({last[name]} -> {now}): "
                f"its zero is void, check the position and write it again with: axisgate axis zero"
            )
    return found


def _raw(cell: Cell, state: CellState, placed: int = 0) -> dict[str, int]:
    absolute = [(n, axis) for n, axis in enumerate(cell.axis) if axis.home.by == "none" and not axis.modulo and not placed >> n & 1]
    return {
        axis.name: zeros.raw_inc(cell, axis, state.axes[n].actual / to_si(1.0, axis.unit))
        for n, axis in absolute
        if not state.axes[n].flags & (AxisFlag.LOST | AxisFlag.UNCONFIGURED)
    }
