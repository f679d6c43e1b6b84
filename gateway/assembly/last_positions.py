"""Positions of the axes when the gateway stopped: the next start reports multi-turn encoders that overflowed meanwhile."""

import contextlib
import json
import threading
from collections.abc import Mapping

from gateway.assembly import axis_zeros as zeros
from gateway.assembly.axis_scaling import scaling_of
from gateway.files.safe_file import write_whole
from gateway.pure.cell.cell import Axis, Cell
from gateway.pure.cycle.encoder_wrap import beside, wrapped, wrapped_endless
from gateway.pure.image.records.cell import AxisFlag, CellState
from motion.geometry.units import from_si, to_si

NO_PLACES: Mapping[str, int] = {}
SHARE = 16  # of a motor turn an axis moves before its place is kept again
AGAIN = "check the position and write it again with: axisgate axis zero"


def remember(cell: Cell, state: CellState, placed: int = 0, before: Mapping[str, int] = NO_PLACES) -> None:
    """Store raw increments of the absolute axes next to their zeros; a read-only folder is not an error.  placed: axes (bit n-1 = axis n)
    whose position a program has set: their value does not show their encoder.  Endless axes: those of the first revolution.  before: places
    of axes that show none now.
    """
    _write(cell, {**before, **_raw(cell, state, placed)})


def _write(cell: Cell, places: dict[str, int]) -> None:
    if places:
        with contextlib.suppress(OSError):
            write_whole(zeros.path_of(cell).with_suffix(".last.json"), json.dumps(places).encode())


class LastPlaces:
    """Keeps the places during the run, because of power failures.  A separate thread writes them after an axis has left its kept place by
    more than a share of a motor turn, so that no disk blocks the services.
    """

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._steps = {axis.name: axis.drive.inc_per_turn / SHARE for axis in cell.axis}
        self._kept: dict[str, int] = {}
        self._writer: threading.Thread | None = None

    def look(self, state: CellState, placed: int = 0) -> None:
        """Once a second."""
        if self._writer is not None and self._writer.is_alive():
            return
        places = _raw(self._cell, state, placed)
        if all(abs(place - self._kept.get(name, 1 << 60)) <= self._steps[name] for name, place in places.items()):
            return
        self._kept |= places
        self._writer = threading.Thread(target=_write, args=(self._cell, dict(self._kept)), name="last places", daemon=True)
        self._writer.start()

    def stop(self, state: CellState, placed: int = 0) -> None:
        """Once more, as they are."""
        if self._writer is not None:
            self._writer.join(2.0)
        remember(self._cell, state, placed, self._kept)


def judge(cell: Cell, state: CellState) -> list[str]:
    """One sentence for each axis whose encoder jumped by its range since then, or an endless one where that is possible."""
    try:
        last = json.loads(zeros.path_of(cell).with_suffix(".last.json").read_text())
    except (OSError, ValueError):
        return []
    if not isinstance(last, dict):
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
        f"axis {axis.name}: the encoder overflowed by {turns:+g} turns since the last stop ({last} -> {now}): its zero is invalid, {AGAIN}"
    )
    return [what] if turns else []


def _counted_on(axis: Axis, last: int, now: int) -> list[str]:
    """Endless axis: what can be known of it (AX-607)."""
    per_unit = scaling_of(axis).inc_per_unit
    around = abs(per_unit * to_si(axis.modulo, axis.unit))
    turns = wrapped_endless(last, now, axis.drive.inc_per_turn, around) / axis.drive.inc_per_turn
    moved = from_si(beside(now - last, around) / per_unit, axis.unit)
    what = (
        f"axis {axis.name}: shown {moved:+.4g} {axis.unit} from its position at the last stop, as when its encoder overflows "
        f"by {turns:+g} turns: its zero is invalid unless the axis was turned, {AGAIN}"
    )
    return [what] if turns else []


def _raw(cell: Cell, state: CellState, placed: int = 0) -> dict[str, int]:
    absolute = [(n, axis) for n, axis in enumerate(cell.axis) if axis.home.by == "none" and not placed >> n & 1]
    return {
        axis.name: zeros.raw_inc(cell, axis, state.axes[n].actual / to_si(1.0, axis.unit))
        for n, axis in absolute
        if not state.axes[n].flags & (AxisFlag.LOST | AxisFlag.UNCONFIGURED)
    }
