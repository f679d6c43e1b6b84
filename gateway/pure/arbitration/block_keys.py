"""One number for every block a line may serve: data block n is n, what other types hold has numbers above (AX-250)."""

KINDS = "DXEAMTZ"  # as byte 4 of an RK512 header has them
AREA_BYTES = 256  # of E, A and M; T and Z count 256 words


def block_key(kind: str, number: int) -> int:
    """DB 10 is 10, DX 10 is 266; an area has no number."""
    return KINDS.index(kind) << 8 | (number if kind in "DX" else 0)


def block_name(key: int) -> str:
    """As people call it: DB 10, DX 10, area M."""
    kind = KINDS[key >> 8]
    return f"D{'B' if kind == 'D' else 'X'} {key & 0xFF}" if kind in "DX" else f"area {kind}"
