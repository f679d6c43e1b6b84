"""One record for each cycle: the state the cycle published, its RC outputs and the RC inputs it judged by (AX-492)."""

from gateway.pure.image.records.cell import CELL_STATE_LAYOUT, RC_BYTES, cell_state_size

SCOPE_RECORDS = 4096  # 8 s at 2 ms: a reader that sleeps shorter loses nothing
SCOPE_LAYOUT = f"scope/2 {CELL_STATE_LAYOUT} {RC_BYTES} {RC_BYTES}"
OUTPUTS_AT, INPUTS_AT = -2 * RC_BYTES, -RC_BYTES  # from the end: the state before them is as long as the cell has axes


def scope_bytes(axes: int, lanes: int = 0) -> int:
    """Return the bytes of one record of a cell of these axes and lanes."""
    return cell_state_size(axes, lanes) + 2 * RC_BYTES


def pack_scope(state: bytes, outputs: bytes | bytearray, inputs: bytes | bytearray) -> bytes:
    """A packed cell state and the two images."""
    return b"".join((state, outputs, inputs))
