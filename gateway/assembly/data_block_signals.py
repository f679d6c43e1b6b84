"""Entries of data blocks: their places, and the names they may use besides those of the cell: `to = "K01_A_MN_RCI"`, `from = "I8.4"`."""

from collections.abc import Mapping

from gateway.files.signal_lists import signal_list
from gateway.pure.cell.cell import Cell, Db, Entry
from gateway.pure.image.addresses import AddressFault, DataBit, DataWord, Direction, Kind, Operand, RcBit, parse, parse_operand
from gateway.pure.image.names import lookup
from gateway.pure.image.signals import SignalList


def parsed(block: Db, entry: Entry) -> object:
    """Entries at `at`; an area has no number, but its words are counted.  Raises AddressFault."""
    return parse(entry.at, db=number_of(block))


def number_of(block: Db) -> int:
    """The number its places are written with: 1 where it has none."""
    return block.number or 1


def place_of(block: Db, entry: Entry) -> DataWord | DataBit | None:
    """The parsed place of an entry, None when it is none."""
    try:
        address = parsed(block, entry)
    except AddressFault:
        return None
    return address if isinstance(address, DataWord | DataBit) and address.db == number_of(block) else None


def signals_of(cell: Cell) -> SignalList:
    """The list with the places of this cell."""
    return signal_list().moved(cell.signals)


def rc_place(text: str, signals: SignalList) -> RcBit | None:
    """The RC bit a text means; None where it means something else."""
    signal = signals.named(text)
    if signal is not None:
        return signal.at
    place = operand(text)
    return place if isinstance(place, RcBit) else None


def operand(text: str) -> object:
    """The result of parse_operand, without names of signals; None if it is not an address."""
    try:
        return parse_operand(text)
    except AddressFault:
        return None


def flag_operand(text: str) -> Operand | None:
    """M 6.3, MB 7, MW 10, MD 1436; None for anything else."""
    place = operand(text)
    return place if isinstance(place, Operand) and place.kind is Kind.FLAG else None


def flags_of(cell: Cell, line: str) -> Mapping[str, Operand]:
    """`to` of a line's entries that are flags of the control."""
    entries = [entry.to for block in cell.db if block.line == line for entry in block.entries if entry.to and lookup(entry.to) is None]
    return {to: place for to in entries if (place := flag_operand(to)) is not None} if cell.controller is not None else {}


def inputs_of(cell: Cell) -> Mapping[str, Mapping[str, int]]:
    """Line -> `to` of its entries -> RC input; the list is read only if an entry needs it."""
    found: dict[str, dict[str, int]] = {}
    signals: SignalList | None = None
    for block in cell.db:
        for entry in block.entries:
            if not entry.to or lookup(entry.to) is not None:
                continue
            signals = signals or signals_of(cell)
            place = rc_place(entry.to, signals)
            if place is not None and place.direction is Direction.INPUT:
                found.setdefault(block.line, {})[entry.to] = place.number
    return found
