"""I/O blocks of one CAN bus of a rho 3."""

from gateway.pure.cell.cell import IoBlock
from gateway.pure.controllers.rho3.can.rules import Block


def blocks_of(blocks: tuple[IoBlock, ...], bus: int) -> tuple[Block, ...]:
    """The blocks of one bus, in the order of the list: the first is block 1 in the messages (AX-262)."""
    return tuple(Block(block.start, block.length, block.id) for block in blocks if block.bus == bus)
