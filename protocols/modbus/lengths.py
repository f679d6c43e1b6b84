"""Length of an RTU frame, derived from its first bytes.  Source: V1.1b3, sections 6.1 to 6.21 (request and answer layouts).

RTU frames carry no length; on a line silence ends them, over TCP (RTU over TCP) only these lengths can.
"""

UNIT_AND_CHECK = 3  # bytes of a frame in addition to its PDU
LONGEST_FRAME = 256  # unit, a PDU of 253 bytes, check (serial line guide, 2.5.1)

FIXED_REQUESTS = {**dict.fromkeys(range(1, 7), 5), 7: 1, 8: 5, 11: 1, 12: 1, 17: 1, 22: 7, 24: 3, 43: 4}  # function -> PDU bytes
COUNTED_REQUESTS = {15: 5, 16: 5, 20: 1, 21: 1, 23: 9}  # function -> where in the PDU the byte count is
FIXED_ANSWERS = {5: 5, 6: 5, 7: 2, 11: 5, 15: 5, 16: 5, 22: 7}
COUNTED_ANSWERS = (1, 2, 3, 4, 12, 17, 20, 21, 23)  # the byte count is the second byte
EXCEPTION_PDU = 2


def request_length(frame: bytes) -> int | None:
    """Bytes of the complete request frame; 0: more bytes are needed; None: a function of unknown length."""
    if len(frame) < 2:
        return 0
    function = frame[1]
    if function in FIXED_REQUESTS:
        return FIXED_REQUESTS[function] + UNIT_AND_CHECK
    if function not in COUNTED_REQUESTS:
        return None
    return _counted(frame, COUNTED_REQUESTS[function], 1)


def answer_length(frame: bytes, request: bytes) -> int | None:
    """Bytes of the complete answer frame to `request` (its PDU); 0: more bytes are needed; None: unknown."""
    if len(frame) < 2:
        return 0
    function = frame[1]
    if function & 0x80:
        return EXCEPTION_PDU + UNIT_AND_CHECK
    if function in FIXED_ANSWERS:
        return FIXED_ANSWERS[function] + UNIT_AND_CHECK
    if function in COUNTED_ANSWERS:
        return _counted(frame, 1, 1)
    if function == 24:
        return _counted(frame, 1, 2)
    return len(request) + UNIT_AND_CHECK if function == 8 else None  # a diagnosis is echoed or answered by one word


def _counted(frame: bytes, at: int, size: int) -> int:
    """A frame with `size` bytes of byte count at `at` of its PDU."""
    start = 1 + at
    if len(frame) < start + size:
        return 0
    return start + size + int.from_bytes(frame[start : start + size], "big") + 2
