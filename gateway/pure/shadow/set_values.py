"""Set values on a drive bus as a shadow compares them, whatever the family: two bytes of commands, then the position in increments (AX-493,
AX-512).  Commands are compared as bits, positions as numbers within a tolerance.
"""

import struct
from collections.abc import Callable

from drivers.drives.cia402_family import Cia402Family
from drivers.drives.family import BusFamily
from drivers.drives.servodyn_family import ServodynFamily
from gateway.pure.controllers.rho3.can.family import RhoFamily
from gateway.pure.shadow.addresses import Place
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.servodyn.codec import SET_SIGNALS, Codec
from protocols.servodyn.codec import SYNC as SERVODYN_SYNC
from protocols.servodyn.plan import SLOTS, set_id

FLAGS = SET_SIGNALS.index("life")  # the commands precede it: enable, drive on, limit switch, fault reset, brake
SERVODYN_IDS = {set_id(slot): slot for slot in range(1, SLOTS + 1)}
CANOPEN_IDS = {cobid.rpdo(1, node): node for node in range(1, 128)}
CONTROLWORD = {
    0: "switch on",
    1: "enable voltage",
    2: "quick stop not",
    3: "enable operation",
    7: "fault reset",
    8: "halt",
}  # IEC 61800-7-201
TARGET = struct.Struct("<Hi")  # RPDO1 as axisgate maps it: 6040h, 607Ah (AX-302)
CONTENT = struct.Struct(">Hi")


class SetValues:
    """Of one bus."""

    def __init__(self, family: BusFamily) -> None:
        drives = family.drives if isinstance(family, RhoFamily) else family
        self.codec: Codec | None = drives.codec if isinstance(drives, ServodynFamily) else None
        self._canopen = isinstance(drives, Cia402Family)
        self.sync = cobid.SYNC if self._canopen else SERVODYN_SYNC.identifier

    def drive(self, frame: Frame) -> int | None:
        """Module or node a set value is for; None: it is none."""
        if self._canopen:
            return CANOPEN_IDS.get(frame.identifier)
        return SERVODYN_IDS.get(frame.identifier) if self.codec is not None else None

    @property
    def whole(self) -> bool:
        """Return whether telegrams other than set values are compared byte by byte: not on CANopen, where each master has its own
        configuration.
        """
        return not self._canopen

    def content(self, frame: Frame) -> bytes:
        """Return the content of a set value; empty: it is too short."""
        if self.codec is None:
            if len(frame.data) != TARGET.size:
                return b""
            word, position = TARGET.unpack(frame.data)
            return CONTENT.pack(word & sum(1 << bit for bit in CONTROLWORD), position)
        try:
            _, value = self.codec.decode_set(frame)
        except DecodeError:
            return b""
        return CONTENT.pack(sum(bool(flag) << n for n, flag in enumerate(value[:FLAGS])), value.position_inc)

    def places(self, axis: str, per_unit: float, tolerance: float) -> list[Place]:
        """`per_unit`: increments; `tolerance` in the unit of the axis."""
        names = CONTROLWORD if self.codec is None else dict(enumerate(SET_SIGNALS[:FLAGS]))
        bits = [Place(name, "", 0, (1 << bit).to_bytes(2, "big")) for bit, name in names.items()]
        return [*bits, Place("position", axis, 2, b"\xff" * 4, _number(per_unit), tolerance)]


def _number(per_unit: float) -> Callable[[bytes], float]:
    """From the drive's own zero, in the unit of the axis."""

    def number(part: bytes) -> float:
        return int.from_bytes(part, "big", signed=True) / per_unit

    return number
