"""Binary inputs and outputs, 40 bytes each.  Source: robotstar 4.1 (L438-504, L1597-1618, L2272-2276); place in the image: AX-515."""

from collections.abc import Collection
from enum import Enum

from gateway.pure.controllers.pic_image import PicImage

BYTES = 40
FIRST_BYTE = 88  # of the image: after the 88 bytes of the rho3 interface (AX-515)
PER_ELEMENT = 4  # bytes of one element of _IBIN_IN and _IBIN_OUT, the lowest byte first


class IoFault(ValueError):
    """No such input, output or element."""


class Area(Enum):
    """Inputs or outputs of the robot; the value is the word of the language."""

    INPUT = "#EINGANG"
    OUTPUT = "#AUSGANG"


def check_place(byte: int, bit: int) -> None:
    """IoFault unless byte 0..39 and bit 0..7."""
    if not 0 <= byte < BYTES or not 0 <= bit <= 7:
        raise IoFault(f"{byte}.{bit}: bytes are 0..{BYTES - 1}, bits 0..7")


class BinaryIo:
    """The 320 inputs and 320 outputs in the image."""

    def __init__(self, image: PicImage, first_byte: int = FIRST_BYTE) -> None:
        if not 0 <= first_byte <= len(image.inputs) - BYTES:
            raise IoFault(f"first byte {first_byte}: 0..{len(image.inputs) - BYTES}")
        self._image, self._first = image, first_byte

    def byte(self, area: Area, byte: int) -> int:
        """Byte 0..39 of an area."""
        check_place(byte, 0)
        return self._bytes(area)[self._first + byte]

    def content(self, area: Area) -> bytes:
        """All 40 bytes of an area."""
        return bytes(self._bytes(area)[self._first : self._first + BYTES])

    def read_bit(self, area: Area, byte: int, bit: int) -> bool:
        """Input or output `byte`.`bit` as the circuit diagram numbers it."""
        check_place(byte, bit)
        return bool(self._bytes(area)[self._first + byte] >> bit & 1)

    def write_bit(self, area: Area, level: bool, byte: int, bit: int) -> None:
        """WRITE_BIT; for inputs the values of the modules."""
        check_place(byte, bit)
        place, mask = self._first + byte, 1 << bit
        data = self._bytes(area)
        data[place] = data[place] | mask if level else data[place] & ~mask

    def element(self, area: Area, number: int) -> int:
        """_IBIN_IN[n] or _IBIN_OUT[n], n 1..10: bytes 4(n-1).. with the first as bits 0..7."""
        return int.from_bytes(self._bytes(area)[self._at(number) : self._at(number) + PER_ELEMENT], "little")

    def set_element(self, area: Area, number: int, value: int) -> None:
        """The reverse of element; `value` is taken as 32 bits, negative ones too."""
        at = self._at(number)
        self._bytes(area)[at : at + PER_ELEMENT] = (value & 0xFFFFFFFF).to_bytes(PER_ELEMENT, "little")

    def _bytes(self, area: Area) -> bytearray:
        return self._image.inputs if area is Area.INPUT else self._image.outputs

    def _at(self, number: int) -> int:
        if not 1 <= number <= BYTES // PER_ELEMENT:
            raise IoFault(f"element {number}: 1..{BYTES // PER_ELEMENT}")
        return self._first + PER_ELEMENT * (number - 1)


class SharedOutputs:
    """Outputs robot and PLC may both write: within a cycle the PLC's value remains (L2272-2275)."""

    def __init__(self, io: BinaryIo, plc_only: Collection[int] = (), robot_only: Collection[int] = ()) -> None:
        """`plc_only`, `robot_only`: bytes that are given to one side."""
        self._io, self._plc_only, self._robot_only = io, plc_only, robot_only
        self._robot: dict[tuple[int, int], bool] = {}
        self._plc: dict[tuple[int, int], bool] = {}

    def by_robot(self, level: bool, byte: int, bit: int) -> None:
        """The robot program writes; IoFault where the byte is the PLC's."""
        check_place(byte, bit)
        if byte in self._plc_only:
            raise IoFault(f"output {byte}.{bit} belongs to the PLC")
        self._robot[byte, bit] = level

    def by_plc(self, level: bool, byte: int, bit: int) -> None:
        """The PLC program writes; IoFault where the byte is the robot's."""
        check_place(byte, bit)
        if byte in self._robot_only:
            raise IoFault(f"output {byte}.{bit} belongs to the robot")
        self._plc[byte, bit] = level

    def end_of_cycle(self) -> None:
        """What was written goes out, the PLC's word last."""
        for (byte, bit), level in {**self._robot, **self._plc}.items():
            self._io.write_bit(Area.OUTPUT, level, byte, bit)
        self._robot, self._plc = {}, {}
