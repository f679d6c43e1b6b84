"""Times and loads `check` prints: of a serial line (characters x 11 bits) and of a CAN bus (worst stuffing, can.md C4)."""

import math

from gateway.pure.cell.cell import Bus, Cell, Line
from gateway.pure.lines.line_profiles import link_profile

FRAME_CHARS = 6  # STX, DLE, DLE ETX BCC, DLE around every block (serial-protocols 1.3, 1.4)
HEADER, REACTION = 10, 4  # bytes of an RK512 command header and reaction header (serial-protocols 2.1, 2.2)
WORDS_PER_TELEGRAM = 64  # 128 bytes (serial-protocols 2.3)
SDO_PAIR_FRAMES = 2  # request and answer, 8 bytes each


def character_ms(line: Line) -> float:
    """Time of one character: start bit, data bits, parity, stop bits."""
    bits = line.format.split()[1]
    return 1000.0 * (1 + int(bits[0]) + (bits[1] != "N") + int(bits[2])) / line.baud


def job_ms(line: Line, words: int) -> float:
    """A SEND or FETCH of `words` data words with its reaction; both move the same characters, doubled DLE not counted."""
    telegrams = max(1, math.ceil(words / WORDS_PER_TELEGRAM))
    follow_on = (telegrams - 1) * (4 + REACTION + 2 * FRAME_CHARS)
    return character_ms(line) * (HEADER + REACTION + 2 * FRAME_CHARS + follow_on + 2 * words)


def silence_s(line: Line) -> tuple[float, int]:
    """How long the link tries before it reports the partner gone: QVZ in ms, and attempts."""
    profile = link_profile(line)
    return profile.ack_delay / 1e6, profile.connect_attempts


def frame_us(data: int) -> int:
    """Worst length of a standard frame in bits (= us at 1 Mbit/s) with interframe space (can.md C4)."""
    return 47 + 8 * data + (33 + 8 * data) // 4


def cycle_us(cell: Cell, bus: Bus) -> float:
    """Worst bus time of one cycle: SYNC and, for each axis, one frame each way."""
    axes = sum(axis.drive.bus == bus.name for axis in cell.axis)
    data = 8 if bus.protocol == "servodyn" else 6  # CiA 402 CSP: controlword + position, statusword + position
    return (frame_us(0) + 2 * axes * frame_us(data)) / megabits(bus)


def sdo_us(bus: Bus) -> float:
    """Worst bus time of one SDO request and its answer."""
    return SDO_PAIR_FRAMES * frame_us(8) / megabits(bus)


def megabits(bus: Bus) -> float:
    """Bit rate in Mbit/s."""
    value, unit = bus.bitrate.split()
    return float(value) / (1.0 if unit == "Mbit/s" else 1000.0)


def canopen_room(cell: Cell, bus: Bus, p5_ms: int) -> bool:
    """Whether a second TPDO of every drive fits into each cycle: below 60 % in the worst case; SDO and I/O keep their place (AX-302)."""
    axes = sum(axis.drive.bus == bus.name for axis in cell.axis)
    return cycle_us(cell, bus) + axes * frame_us(6) / megabits(bus) + sdo_us(bus) < 600.0 * p5_ms
