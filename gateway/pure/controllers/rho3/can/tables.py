"""Limits, bit rates and identifiers of a rho 3 CAN bus.

Source: rho 3 Releases part 5, sections 6.2 to 6.12 (L7256-7455); identifiers decimal: "rho3 D-13"; 125 kbit/s: "rho3 D-11".
"""

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

BLOCK_BYTES = 8  # digital I/O of one block (L7294)
INPUT_BLOCKS, OUTPUT_BLOCKS = 5, 4  # at most, on one bus (L7407-7408)
AXES = 6  # on one bus (L7250)
IMAGE_BYTES = 128  # PIC bytes 0..127 (L7431)
INPUT_IDS = range(541, 551)  # modules to the control (L7433)
OUTPUT_IDS = range(471, 481)  # control to modules, and between controls (L7449, L10977)
P5_MAX_MS = 32  # with CAN axes: limit of the boosters (L7322)
P5_WATCHDOG_MS = 26  # without an additional SERVO-i: watchdog of the control (L7322-7324)
CAN_MODULES = (3, 5, 6)  # P15: CAN module alone, with a narrow, with a wide servo board without intelligence (L7314-7320)
FIRST_PLACE_ONLY = (5, 6)
NO_SERVO_I = (0, 3, 5, 6, 9)  # empty, CAN, boards without intelligence, rho 3.0: none of these is a SERVO-i (AX-261)


class Room(NamedTuple):
    """Bytes of digital I/O."""

    inputs: int
    outputs: int


class Rate(NamedTuple):
    """One value of P30's baud."""

    kbit_s: int
    cable_m: int  # longest cable


class Side(Enum):
    """Direction of a block, seen from the control; the value is the parameter that defines it."""

    INPUT = "P31"
    OUTPUT = "P32"

    @property
    def word(self) -> str:
        return "input" if self is Side.INPUT else "output"


ROOM: Mapping[int, Room] = {  # axes on the bus -> bytes (L7263-7268)
    6: Room(0, 0),
    5: Room(8, 8),
    4: Room(8, 8),
    3: Room(16, 16),
    2: Room(24, 24),
    1: Room(32, 32),
    0: Room(40, 32),
}
RATES: Mapping[int, Rate] = {0: Rate(1000, 20), 1: Rate(500, 40), 2: Rate(250, 80), 3: Rate(125, 160)}  # P30 (L7301-7308, L7411-7417)


def room(axes: int) -> Room:
    """What `axes` on a bus leave for digital I/O; nothing beyond six axes."""
    return ROOM.get(axes, ROOM[AXES])


def fits(axes: int, inputs: int, outputs: int) -> bool:
    """Return whether these bytes fit together with `axes`.  A block occupies eight bytes even where fewer are transferred (AX-260)."""
    free = room(axes)
    return whole(inputs) <= free.inputs and whole(outputs) <= free.outputs


def whole(size: int) -> int:
    """Return `size` bytes rounded up to full blocks, in bytes."""
    return -(-size // BLOCK_BYTES) * BLOCK_BYTES


def kbit_s(baud: int) -> int:
    """Return the bit rate of a P30 code; 0: unknown code."""
    rate = RATES.get(baud)
    return rate.kbit_s if rate else 0


def table(side: Side) -> str:
    """The limits of one direction, axes -> bytes, as `axisgate check` prints them."""
    return ", ".join(f"{axes} -> {free.inputs if side is Side.INPUT else free.outputs}" for axes, free in ROOM.items())
