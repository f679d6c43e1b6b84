"""The check of Modbus RTU: CRC-16, polynomial A001h, start value FFFFh, low byte first.  Source: MODBUS over Serial Line V1.02, 6.2.2."""

POLYNOMIAL, START = 0xA001, 0xFFFF


def _entry(byte: int) -> int:
    for _ in range(8):
        byte = byte >> 1 ^ (POLYNOMIAL if byte & 1 else 0)
    return byte


TABLE = tuple(_entry(byte) for byte in range(256))


def crc(data: bytes, check: int = START) -> int:
    """CRC-16 over unit and PDU; over a complete good frame with its two check bytes it is 0.  `check`: CRC of the bytes before these."""
    for byte in data:
        check = check >> 8 ^ TABLE[(check ^ byte) & 0xFF]
    return check


def sealed(data: bytes) -> bytes:
    """Unit and PDU with their check: a frame for the line."""
    return data + crc(data).to_bytes(2, "little")
