"""One record for each cycle: the state the cycle published, its RC outputs and the RC inputs it judged by (AX-492)."""

from gateway.pure.records import CELL_STATE_LAYOUT, CELL_STATE_SIZE, RC_BYTES

SCOPE_BYTES = CELL_STATE_SIZE + 2 * RC_BYTES
SCOPE_RECORDS = 4096  # 8 s at 2 ms: a reader that sleeps shorter loses nothing
SCOPE_LAYOUT = f"scope/1 {CELL_STATE_LAYOUT} {RC_BYTES} {RC_BYTES}"
OUTPUTS_AT, INPUTS_AT = CELL_STATE_SIZE, CELL_STATE_SIZE + RC_BYTES


def pack_scope(state: bytes, outputs: bytes | bytearray, inputs: bytes | bytearray) -> bytes:
    """A packed cell state and the two images."""
    return b"".join((state, outputs, inputs))
