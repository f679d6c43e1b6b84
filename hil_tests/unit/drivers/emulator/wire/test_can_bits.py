"""Bits of CAN frames against a second, plain reading of ISO 11898-1 and the figures of can.md C4."""

import pytest

from protocols.base import can_bits as canbits


def plain_reading(identifier: int, data: bytes, *, extended: bool = False, remote: bool = False) -> tuple[int, int]:
    """(all bits, stuff bits), the frame written out as a text of zeros and ones."""
    rtr = "1" if remote else "0"
    if extended:
        text = f"0{identifier >> 18:011b}11{identifier & 0x3FFFF:018b}{rtr}00{len(data):04b}"
    else:
        text = f"0{identifier:011b}{rtr}00{len(data):04b}"
    text += "" if remote else "".join(f"{byte:08b}" for byte in data)
    text += f"{remainder(text):015b}"
    stuffed, run = "", 0
    for bit in text:
        run = run + 1 if stuffed.endswith(bit) else 1
        stuffed += bit
        if run == 5:
            stuffed += "1" if bit == "0" else "0"
            run = 1
    return len(stuffed) + 1 + 2 + 7 + 3, len(stuffed) - len(text)


def remainder(text: str) -> int:
    """CRC-15 as long division of the bits followed by 15 zeros by 1100010110011001."""
    value = int(text, 2) << 15
    for at in range(value.bit_length() - 1, 14, -1):
        if value >> at & 1:
            value ^= 0xC599 << (at - 15)
    return value


PAYLOADS = (
    [bytes(n) for n in range(9)] + [bytes([0xFF] * n) for n in range(9)] + [bytes(range(7 * n % 251, 7 * n % 251 + n)) for n in range(9)]
)


@pytest.mark.parametrize("identifier", [0, 0x64, 0x80, 0x181, 210, 610, 0x555, 0x7FF])
def test_base_frames_bit_for_bit(identifier: int) -> None:
    for data in PAYLOADS:
        expected, stuff = plain_reading(identifier, data)
        assert (canbits.frame_bits(identifier, data), canbits.stuff_bits(identifier, data)) == (expected, stuff), (identifier, data.hex())
        assert canbits.plain_bits(len(data)) <= expected <= canbits.worst_bits(len(data))


@pytest.mark.parametrize("identifier", [0, 0x18FEF100, 0x1FFFFFFF, 0x0CF00400])
def test_extended_and_remote_frames(identifier: int) -> None:
    for data in PAYLOADS[:12]:
        assert canbits.frame_bits(identifier, data, extended=True) == plain_reading(identifier, data, extended=True)[0]
    assert canbits.frame_bits(0x181, b"12345678", remote=True) == plain_reading(0x181, b"12345678", remote=True)[0]


def test_figures_of_the_bus_limit() -> None:
    """can.md C4: unstuffed and worst per payload; SYNC of both families measured 51."""
    assert [(canbits.plain_bits(n), canbits.worst_bits(n)) for n in (0, 4, 6, 8)] == [(47, 55), (79, 95), (95, 115), (111, 135)]
    assert canbits.frame_bits(100) == canbits.frame_bits(0x80) == 51
    same = {canbits.frame_bits(identifier, bytes([fill]) * 8) for identifier in range(210, 270, 10) for fill in (0, 255)}
    assert 124 in same and max(same) <= 135, "all 00 or FF: about 124"


def test_impossible_frames_are_the_callers_mistake() -> None:
    for identifier, data, extended in ((0x800, b"", False), (-1, b"", False), (1 << 29, b"", True), (1, bytes(9), False)):
        with pytest.raises(ValueError, match="CAN"):
            canbits.frame_bits(identifier, data, extended=extended)
