"""[[io]] of a cell compiled: which process drives which contact, and the settings of CiA 401 couplers."""

from collections.abc import Mapping, Sequence

from drivers.drives.cia402_family import GATEWAY_NODE
from drivers.drives.family import BusFamily
from drivers.drives.io_boot import CouplerPlan
from gateway.assembly.axis_signals import rc_numbers
from gateway.assembly.routes import symbols_of
from gateway.pure.arbitration.data_blocks import RC_NAMES
from gateway.pure.buses.cia401 import Coupler, CouplerFamily
from gateway.pure.buses.contacts import OWN, Output, source_of
from gateway.pure.cell.cell import Bus, Cell, Io
from gateway.pure.image.addresses import Direction, RcBit

PATIENCE = 4  # heartbeats of a coupler that may stay away
COUPLER, MODBUS, CHIP = "canopen-401", "modbus", "gpiochip"


def outputs_of(cell: Cell, kind: str, p5_ms: int) -> list[Output]:
    """The output contacts on devices of that kind."""
    symbols = symbols_of(cell)
    return [
        _output(cell, number, io, p5_ms, symbols)
        for number, io in enumerate(cell.io)
        if io.device.type == kind and io.device.output is not None
    ]


def signal_bit(cell: Cell, io: Io, symbols: Mapping[str, RcBit]) -> int | None:
    """RC input an input contact drives: an enabling name, or a signal of the list."""
    if io.device.input is None:
        return None
    if io.signal in RC_NAMES:
        number: int = getattr(rc_numbers(cell), RC_NAMES[io.signal])
        return number
    place = symbols.get(io.signal.upper())
    return place.number if place is not None and place.direction is Direction.INPUT else None


def _output(cell: Cell, number: int, io: Io, p5_ms: int, symbols: Mapping[str, RcBit]) -> Output:
    place = symbols.get(io.signal.upper())
    bit = place.number if place is not None and place.direction is Direction.OUTPUT else None
    source, axis, flag, found = source_of(io.signal, [each.name for each in cell.axis], bit)
    return Output(number, source, axis, flag, found, max(1, io.toggle_ms // p5_ms), io.on_loss)


def couplers_of(cell: Cell, bus: str) -> list[Coupler]:
    """The CiA 401 nodes of one bus with their channels."""
    here = [(n, io.device) for n, io in enumerate(cell.io) if io.device.type == COUPLER and io.device.bus == bus]
    nodes = sorted({device.node for _, device in here if device.node is not None})
    return [
        Coupler(
            node,
            {device.output: n for n, device in here if device.node == node and device.output is not None},
            {device.input: n for n, device in here if device.node == node and device.input is not None},
            vital_inputs=any(device.node == node and device.input is not None and cell.io[n].signal in RC_NAMES for n, device in here),
            vital_outputs=any(device.node == node and device.output is not None and _vital(cell.io[n].signal) for n, device in here),
        )
        for node in nodes
    ]


def _vital(signal: str) -> bool:
    """An output by which others know, or act on, whether the cell is alive and ready."""
    return signal in OWN or (signal.startswith("axis.") and signal.endswith(".brake"))


def with_couplers(cell: Cell, bus: Bus, drives: BusFamily, p5_ms: int) -> BusFamily:
    """The drives' family, with the couplers of the bus around it where it has some."""
    couplers = couplers_of(cell, bus.name)
    return CouplerFamily(drives, couplers, PATIENCE * bus.heartbeat_ms // p5_ms + 1) if couplers else drives


def coupler_plans(cell: Cell, bus: Bus) -> list[tuple[str, CouplerPlan]]:
    """Settings sent to each coupler; its outputs fall when the gateway's heartbeat is missing."""
    return [
        (
            f"coupler {coupler.node}",
            CouplerPlan(
                coupler.node,
                (),
                heartbeat_ms=bus.heartbeat_ms,
                gateway=GATEWAY_NODE,
                falls=falls(cell.io, coupler),
                channels=max(coupler.outputs, default=-1) + 1,
                inputs=bool(coupler.inputs),
            ),
        )
        for coupler in couplers_of(cell, bus.name)
    ]


def falls(contacts: Sequence[Io], coupler: Coupler) -> tuple[tuple[int, int, int], ...]:
    """(byte, mask of outputs that change, their values) for 6206h and 6207h: on_loss, or 0."""
    found: dict[int, tuple[int, int]] = {}
    for channel, number in coupler.outputs.items():
        mask, values = found.get(channel // 8, (0, 0))
        loss = contacts[number].on_loss or 0
        found[channel // 8] = (mask | 1 << channel % 8, values | loss << channel % 8)
    return tuple((octet, mask, values) for octet, (mask, values) in sorted(found.items()))
