"""Inputs of [[measuring]] that the cycle receives directly: contacts of CiA 401 couplers and CAN I/O blocks on its own buses (AX-481).

The cell already defines the path of a wire: a contact whose signal is that RC input, or a plain route of a bit into it.  A contact on a
gpiochip or a Modbus coupler belongs to another process and arrives through the services.
"""

from collections.abc import Callable, Mapping
from functools import partial

from drivers.drives.family import BusFamily
from gateway.assembly.contacts import COUPLER, signal_bit
from gateway.assembly.routes import Compiled, compile_routes, symbols_of
from gateway.pure.buses.cia401 import CouplerFamily
from gateway.pure.cell.cell import Cell, Io
from gateway.pure.controllers.rho3.can.family import RhoFamily
from gateway.pure.image.fast_inputs import FastWires, InputLevel, Wire
from gateway.pure.routes.addresses import World
from gateway.pure.routes.forms import BIT
from gateway.pure.routes.route import Edge

Hear = Callable[[], InputLevel | None]
PLAIN = {(1.0, 0.0): False, (-1.0, 1.0): True}  # scale and offset of a bit -> turned round


def fast_wires(cell: Cell, families: Mapping[str, BusFamily]) -> FastWires | None:
    """`families`: drive family of each bus; None: every measuring input comes through the services."""
    if not cell.measuring:
        return None
    numbers = sorted({each.input for each in cell.measuring if each.input >= 0})
    found = [wire for number in numbers if (wire := _wire(cell, families, number)) is not None]
    return FastWires(found) if found else None


def _wire(cell: Cell, families: Mapping[str, BusFamily], number: int) -> Wire | None:
    """The wire of one RC input."""
    symbols = symbols_of(cell) if cell.io else {}
    contact = next((io for io in cell.io if signal_bit(cell, io, symbols) == number), None)
    if contact is not None:
        hear = _coupler(families, contact)
        return None if hear is None else Wire(number, False, hear)
    for each in compile_routes(cell):
        if (each.target.world, each.target.form, 8 * each.target.byte + each.target.bit) == (World.RC_INPUT, BIT, number):
            return _routed(cell, families, each, number)
    return None


def _routed(cell: Cell, families: Mapping[str, BusFamily], route: Compiled, number: int) -> Wire | None:
    """A route that does more than carry the level stays the services' alone."""
    settings, source = route.settings, route.source
    turned = PLAIN.get((settings.scale, settings.offset))
    if turned is None or settings.edge is not Edge.LEVEL or settings.debounce_ns or settings.rate_ns:
        return None
    if source.world is World.CONTACT:
        hear = _coupler(families, next(io for io in cell.io if io.name == source.name))
    elif source.world is World.RC_OUTPUT and source.form == BIT:
        hear = _block(families, source.byte, source.bit)
    else:
        return None
    return None if hear is None else Wire(number, turned, hear)


def _coupler(families: Mapping[str, BusFamily], contact: Io) -> Hear | None:
    device = contact.device
    family = families.get(device.bus)
    if device.type != COUPLER or device.node is None or device.input is None or not isinstance(family, CouplerFamily):
        return None
    return partial(family.input_at, device.node, device.input)


def _block(families: Mapping[str, BusFamily], byte: int, bit: int) -> Hear | None:
    """An input block of [rho3] P31 that covers the byte."""
    for family in families.values():
        io = family.io if isinstance(family, RhoFamily) else None
        if io is not None and any(byte in block.span for block in io.settings.inputs):
            return partial(io.input_at, byte, bit)
    return None
