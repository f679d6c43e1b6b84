"""Enabling inputs and status outputs of the axes: their numbers in this cell, and inputs the cell takes as 1."""

from dataclasses import replace

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


def rc_numbers(cell: Cell) -> RcNumbers:
    """AX-002's numbers as this cell has them; moving the first axis' bit moves the row."""
    moved = {name.upper(): bit for name, bit in cell.signals.items()}
    return replace(RcNumbers(), **{field: moved[name] for name, field in {**INPUT_SIGNALS, **OUTPUT_SIGNALS}.items() if name in moved})


def assumed_permits(cell: Cell) -> Permit:
    """Enabling inputs that the cell declares as not wired; they count as 1."""
    permits = Permit(0)
    for name in cell.rc_inputs.assume:
        permits |= ASSUMED[INPUT_SIGNALS.get(name.upper(), name.lower())]
    return permits
