"""Enabling inputs and status outputs of the axes: their numbers in this cell, and inputs that the cell sets to 1."""

import re
from dataclasses import replace

from gateway.assembly.data_block_signals import signals_of
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.enabling_inputs import RcNumbers
from gateway.pure.image.records.cell import Permit

ASSUMED = {"chain": Permit.CHAIN, "control": Permit.CONTROL, "feed": Permit.FEED, "run": Permit.RUN, "travel": Permit.TRAVEL}

INPUT_SIGNALS = {  # names of the enabling inputs (AX-002) -> RcNumbers field
    "EMSTOP_OK_RCI": "chain",
    "CTRL_ALLOW_RCI": "control",
    "FEED_ALLOW_RCI": "feed",
    "FEED_HOLD_N_RCI": "run",
    "TRAVEL_ALLOW_RCI": "travel",
}

OUTPUT_SIGNALS = {
    "READY_RCO": "ready",
    "READY2_RCO": "ready2",
    "DRIVES_ON_RCO": "drives_on",
    "EMSTOP_RCO": "emergency",
    "INPOS_1_RCO": "in_position",
    "REF_1_RCO": "referenced",
}


SINGLE = re.compile("KIN_([0-9]+)_(FEED_ALLOW|FEED_HOLD_N)_RCI")  # feed inputs of one kinematic (AX-1787)
SINGLE_PERMITS = {"FEED_ALLOW": Permit.FEED, "FEED_HOLD_N": Permit.RUN}


def rc_numbers(cell: Cell) -> RcNumbers:
    """AX-002's numbers as this cell has them; moving the first axis' bit moves the row."""
    moved = {name.upper(): bit for name, bit in cell.signals.items()}
    own = {field: moved[name] for name, field in {**INPUT_SIGNALS, **OUTPUT_SIGNALS}.items() if name in moved}
    return replace(RcNumbers(), **own, kinematics=single_inputs(cell))


def single_inputs(cell: Cell) -> tuple[tuple[int, int, int], ...]:
    """Feed inputs of single kinematics that the cell has: number of the kinematic, bit of Permit, RC input."""
    if not cell.rc_inputs.wired:
        return ()
    signals, found = signals_of(cell), []
    for name in cell.rc_inputs.wired:
        signal = signals.named(name)
        row = SINGLE.fullmatch(signal.name) if signal is not None else None
        if signal is not None and row is not None:
            found.append((int(row[1]), int(SINGLE_PERMITS[row[2]]), signal.at.number))
    return tuple(found)


def assumed_permits(cell: Cell) -> Permit:
    """Enabling inputs that the cell declares as not wired; they count as 1."""
    permits = Permit(0)
    for name in cell.rc_inputs.assume:
        permits |= ASSUMED[INPUT_SIGNALS.get(name.upper(), name.lower())]
    return permits
