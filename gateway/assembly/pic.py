"""The PIC program of a rho 3 in this cell: a command source with bytes of its own (AX-981).  Small: every check loads it."""

from gateway.pure.cell.cell import Cell

PIC = "pic"  # name and kind of its command source


def own_sources(cell: Cell) -> list[tuple[str, str]]:
    """Name and kind of the command sources inside the cell."""
    return [(PIC, PIC)] if cell.controller is not None and cell.controller.pic else []


def pic_bytes(cell: Cell) -> frozenset[int]:
    """RC input bytes that the PIC writes."""
    return frozenset(byte for byte, owner in cell.rc_inputs.owner.items() if owner == PIC)
