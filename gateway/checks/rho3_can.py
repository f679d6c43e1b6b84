"""[rho3] P5, P15, P30..P32 and P401 of a cell, judged as the old controller would judge them at its start-up (rho3 2.1 to 2.4)."""

import dataclasses
from collections.abc import Iterator

from drivers.drives.orientation import segment_deg, segments
from drivers.drives.reference_settings import ORIENTED
from gateway.assembly.rho3_blocks import blocks_of
from gateway.checks.context import Context, number
from gateway.pure.cell.cell import Cell, IoBus, Notice, Rho3
from gateway.pure.controllers.rho3.can.download import gaps, zero_offset_deg
from gateway.pure.controllers.rho3.can.rules import BusSetup, Setup, judge
from gateway.registry import BUS_PROTOCOLS, DRIVE_FAMILIES

BEST_OFFSET_DEG = 90.0
CARRIER = 'protocol = "rho3-io"'


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
    """Parameters that would stop the control's start-up, each with its table."""
    params = check.cell.rho3
    if params is None:
        return
    setup = setup_of(check.cell, params)
    if _faulty(check, params):  # only blocks without a fault of their own are known
        setup = dataclasses.replace(setup, buses=tuple(BusSetup(bus.axes) for bus in setup.buses))
    for found in judge(setup):
        code = f"; the rho 3 shows {found.code} {found.text}, system error {found.system_error}" if found.code else ""
        check.fault(f"rho3.{found.parameter}", found.value, found.hint + code)


def _faulty(check: Context, params: Rho3) -> bool:
    """Whether one of P30 to P32 was left out for a fault of a value."""
    given = {"P30": params.P30, "P31": params.P31, "P32": params.P32}
    return any(name in check.known["rho3"] and not value for name, value in given.items())


def carriers(check: Context) -> None:
    """Blocks of bus n are exchanged on the n-th [[bus]], which has to be there and to carry such blocks."""
    params = check.cell.rho3
    if params is None or check.known["bus"] - {bus.name for bus in check.cell.bus}:  # a bus with a fault has no number
        return
    buses = check.cell.bus
    named = {block.bus: "P32" for block in params.P32} | {block.bus: "P31" for block in params.P31}
    for bus in sorted(named):
        hint = ""
        if bus > len(buses):
            hint = f"bus {bus} of the P list is [[bus]] number {bus} of this file, which has {len(buses)}; add it with {CARRIER}"
        elif not _carries(buses[bus - 1].protocol):
            speaks = f'bus {buses[bus - 1].name} uses "{buses[bus - 1].protocol}", which carries no blocks of P31 and P32'
            hint = f"{speaks}; add a [[bus]] with {CARRIER} for them"
        if hint:
            check.fault(f"rho3.{named[bus]}", f"bus = {bus}", hint)


def _carries(protocol: str) -> bool:
    return BUS_PROTOCOLS[protocol].blocks or BUS_PROTOCOLS[protocol].boosted


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
            check.fault("rho3.P601", "true", f"the download lacks {', '.join(missing)}; add them, or set P601 = false")


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


CHECKS = (parameters, carriers, downloads)
NOTES = (orientation_notes, zero_offset_notes)
