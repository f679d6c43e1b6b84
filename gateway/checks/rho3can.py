"""[rho3] P5, P15, P30..P32 and P401 of a cell, judged as the old control would judge them at its start-up (rho3 2.1 to 2.4)."""

from gateway.cell import Cell, IoBlock, IoBus, Rho3
from gateway.checks.context import Context
from gateway.pure.rho3can.download import gaps
from gateway.pure.rho3can.rules import Block, BusSetup, Setup, judge


def setup_of(cell: Cell, params: Rho3) -> Setup:
    """Bus n of the P list is the n-th [[bus]] of the cell."""
    count = max(len(params.P30), len(cell.bus))
    return Setup(cell.cycle_ms, tuple(_bus(cell, params, number) for number in range(1, count + 1)), params.P15)


def blocks_of(blocks: tuple[IoBlock, ...], bus: int) -> tuple[Block, ...]:
    """The blocks of one bus, in the order of the list: the first is block 1 in the messages (AX-262)."""
    return tuple(Block(block.start, block.length, block.id) for block in blocks if block.bus == bus)


def _bus(cell: Cell, params: Rho3, number: int) -> BusSetup:
    announced = params.P30[number - 1] if number <= len(params.P30) else IoBus()
    name = cell.bus[number - 1].name if number <= len(cell.bus) else None
    axes = sum(axis.drive.bus == name and axis.drive.type == "servodyn" for axis in cell.axis)
    inputs, outputs = blocks_of(params.P31, number), blocks_of(params.P32, number)
    return BusSetup(axes, announced.inputs, announced.outputs, announced.baud, inputs, outputs)


def parameters(check: Context) -> None:
    """What the control would stop its start-up with, each with the table behind it."""
    params = check.cell.rho3
    if params is None:
        return
    for found in judge(setup_of(check.cell, params)):
        number = f" ({found.code} {found.text})" if found.code else ""
        check.fault(f"rho3.{found.parameter}", found.value, found.hint + number)


def downloads(check: Context) -> None:
    """P601 = true sends numbers 1..24 to every booster: all of them have to be there (rho3 2.6)."""
    params = check.cell.rho3
    if params is None or not params.P601:
        return
    for index, axis in enumerate(check.cell.axis):
        if axis.drive.type != "servodyn":
            continue
        missing = list(gaps(params, axis, index))
        if missing:
            check.fault("rho3.P601", "true", f"the download lacks {', '.join(missing)}; give them, or P601 = false")


CHECKS = (parameters, downloads)
