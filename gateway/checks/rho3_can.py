"""[rho3] P5, P15, P30..P32 and P401 of a cell, judged as the old control would judge them at its start-up (rho3 2.1 to 2.4)."""

from collections.abc import Iterator

from drivers.drives.orientation import segment_deg, segments
from drivers.drives.reference_settings import ORIENTED
from gateway.assembly.rho3_blocks import blocks_of
from gateway.checks.context import Context, number
from gateway.pure.cell.cell import Cell, IoBus, Notice, Rho3
from gateway.pure.controllers.rho3.can.download import gaps, zero_offset_deg
from gateway.pure.controllers.rho3.can.rules import BusSetup, Setup, judge
from gateway.registry import DRIVE_FAMILIES

BEST_OFFSET_DEG = 90.0


def setup_of(cell: Cell, params: Rho3) -> Setup:
    """Bus n of the P list is the n-th [[bus]] of the cell."""
    count = max(len(params.P30), len(cell.bus))
    return Setup(cell.cycle_ms, tuple(_bus(cell, params, number) for number in range(1, count + 1)), params.P15)


def _bus(cell: Cell, params: Rho3, number: int) -> BusSetup:
    announced = params.P30[number - 1] if number <= len(params.P30) else IoBus()
    name = cell.bus[number - 1].name if number <= len(cell.bus) else None
    axes = sum(axis.drive.bus == name and DRIVE_FAMILIES[axis.drive.type].boosted for axis in cell.axis)
    inputs, outputs = blocks_of(params.P31, number), blocks_of(params.P32, number)
    return BusSetup(axes, announced.inputs, announced.outputs, announced.baud, inputs, outputs)


def parameters(check: Context) -> None:
    """What the control would stop its start-up with, each with the table behind it."""
    params = check.cell.rho3
    if params is None:
        return
    for found in judge(setup_of(check.cell, params)):
        code = f" ({found.code} {found.text})" if found.code else ""
        check.fault(f"rho3.{found.parameter}", found.value, found.hint + code)


def downloads(check: Context) -> None:
    """P601 = true sends numbers 1..24 to every booster: all of them have to be there (rho3 2.6)."""
    params = check.cell.rho3
    if params is None or not params.P601:
        return
    for index, axis in enumerate(check.cell.axis):
        if not DRIVE_FAMILIES[axis.drive.type].boosted:
            continue
        missing = list(gaps(params, axis, index))
        if missing:
            check.fault("rho3.P601", "true", f"the download lacks {', '.join(missing)}; give them, or P601 = false")


def orientation_notes(cell: Cell) -> Iterator[Notice]:
    """Modes 1 and 3 distinguish turns of the axis by the decimals of the gear factor (rho3 2.8)."""
    for axis in cell.axis:
        if axis.home.by != "gateway" or axis.home.mode not in ORIENTED:
            continue
        count, _ = segments(axis.mechanics.ratio)
        wide, at_axis = segment_deg(axis.mechanics.ratio)
        where = f"axis {axis.name}"
        if count == 1:
            text = f"referencing mode {axis.home.mode} with gear factor {number(axis.mechanics.ratio)}: no decimals, so turns are ambiguous"
            yield Notice("note", where, f"{text}; the encoder zero next to the edge counts (AX-264)")
        else:
            text = f"{count} segments of {number(wide)} degrees at the resolver, {number(at_axis)} degrees at the axis"
            yield Notice("note", where, f"referencing mode {axis.home.mode}: {text}; set the cam's edge to the middle of one")


def zero_offset_notes(cell: Cell) -> Iterator[Notice]:
    """The RMC zero offset should be between -90 and +90 degrees (L3736-3748)."""
    if cell.rho3 is None or not cell.rho3.P601:
        return
    for axis in cell.axis:
        degrees = zero_offset_deg(axis)
        if DRIVE_FAMILIES[axis.drive.type].boosted and abs(degrees) > BEST_OFFSET_DEG:
            text = f"referencing ends {number(degrees)} degrees from a resolver zero; change P208 so that it is within -90..90"
            yield Notice("warning", f"axis {axis.name}", f"{text}, else the software limits of the drive may lie a turn off")


CHECKS = (parameters, downloads)
NOTES = (orientation_notes, zero_offset_notes)
