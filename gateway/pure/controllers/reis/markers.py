"""Markers M0..M2047 with the system markers, double words, retention.  Source: robotstar 5.1, 5.2, 5.8, 5.9; D-15, D-16, AX-516."""

from dataclasses import dataclass

from gateway.pure.controllers.reis.binary import BYTES, Area, BinaryIo, IoFault

SIZE = 2048
INPUTS, OUTPUTS = 1968, 2008  # binary inputs and outputs as markers
FREE = 512  # M0..M511 are the program's own
ERROR_NUMBER, USER_ERROR = 944, 948  # double words
POWER_ON, SYNCHRONOUS = (1020, 4), (1020, 6)
IN_ERROR, ACKNOWLEDGED, STARTED = (1021, 0), (1021, 1), (1021, 2)
MODE = 1022  # 16 bits: high byte main mode, low byte sub-mode (D-24)
ANALOG_INPUTS, ANALOG_OUTPUTS = 1872, 1920


@dataclass(frozen=True, slots=True)
class SystemMarker:
    """Bytes or one bit with a meaning set by the system; `writer`: robot, plc or both; `done` False: not implemented in the original."""

    name: str
    byte: int
    bytes: int
    writer: str
    bit: int | None = None
    done: bool = True


def _bits(byte: int, *rows: tuple[int, str, str]) -> tuple[SystemMarker, ...]:
    return tuple(SystemMarker(name, byte, 1, writer, bit) for bit, name, writer in rows)


SYSTEM = (
    SystemMarker("oscillation frequency, Hz/100", 900, 4, "both"),
    SystemMarker("oscillation amplitude, mm/100", 904, 4, "both"),
    SystemMarker("wait until arc on, 0.01 s", 908, 4, "robot"),
    SystemMarker("wait after arc on, 0.01 s", 912, 4, "robot"),
    SystemMarker("error response time while welding, 0.01 s", 916, 4, "robot"),
    SystemMarker("wait until arc off, 0.01 s", 920, 4, "robot"),
    SystemMarker("vision system data", 940, 4, "both"),
    SystemMarker("error number of the control", ERROR_NUMBER, 4, "robot"),
    SystemMarker("user error code", USER_ERROR, 4, "plc"),
    *(SystemMarker(f"text parameter {n}", 948 + 4 * n, 4, "plc") for n in (1, 2, 3, 4)),
    *_bits(968, (0, "program change to _SNMIPRG", "plc"), (1, "Auto Start", "plc"), (2, "Auto Stop", "plc"), (3, "lamp test", "plc")),
    *_bits(969, (0, "welding on", "robot"), (1, "stop path until source off", "robot"), (2, "arc on", "plc")),
    *_bits(969, (3, "preliminary sensor correction", "robot")),
    SystemMarker("system date", 988, 4, "robot"),
    SystemMarker("system time", 992, 4, "robot"),
    SystemMarker("active input inquiry", 996, 4, "robot"),
    SystemMarker("_ISYS_IN[2]", 1000, 4, "robot"),
    SystemMarker("_ISYS_OUT[2]", 1004, 4, "robot"),
    SystemMarker("_ISYS_IN[1]", 1008, 4, "robot"),
    SystemMarker("_ISYS_OUT[1]", 1012, 4, "robot"),
    SystemMarker("hold motion, no interpreter abort", 1020, 1, "plc", 3, done=False),
    *_bits(1020, (4, "power-on", "robot"), (5, "MU/DI error", "plc"), (6, "robot synchronous", "robot"), (7, "hold motion", "plc")),
    *_bits(1021, (0, "control in error", "robot"), (1, "error shown and acknowledged", "robot"), (2, "initialised", "robot")),
    *_bits(1021, (3, "plus key", "robot"), (4, "minus key", "robot"), (5, "robot moves", "robot"), (6, "PLC test display", "both")),
    SystemMarker("operating mode", MODE, 2, "robot"),
    *(SystemMarker(f"actual value axis {n}", 1020 + 4 * n, 4, "robot") for n in range(1, 25)),
    *_bits(1120, (0, "TCP valid", "robot")),
    SystemMarker("current station", 1122, 2, "robot"),
    *(SystemMarker(f"TCP {name}", 1124 + 4 * n, 4, "robot") for n, name in enumerate("XYZABC")),
    *(SystemMarker(f"nominal position axis {n}", 1144 + 4 * n, 4, "plc", done=False) for n in range(1, 25)),
    *(SystemMarker(f"acceleration axis {n}", 1240 + 4 * n, 4, "plc", done=False) for n in range(1, 25)),
    *(SystemMarker(f"override axis {n}", 1336 + 4 * n, 4, "plc", done=False) for n in range(1, 25)),
    SystemMarker("override factor, %", 1436, 4, "plc"),
    SystemMarker("move axes positive", 1440, 4, "plc", done=False),
    SystemMarker("move axes negative", 1444, 4, "plc", done=False),
    SystemMarker("position control per axis", 1448, 4, "plc", done=False),
    SystemMarker("in position per axis", 1452, 4, "robot", done=False),
    SystemMarker("station switch, transformation", 1456, 4, "plc", done=False),
    SystemMarker("station switch, freed axes", 1460, 4, "plc", done=False),
    SystemMarker("path length done, 0.01 mm", 1464, 4, "robot"),
    SystemMarker("path length left, 0.01 mm", 1468, 4, "robot"),
    SystemMarker("path time done, 0.01 s", 1472, 4, "robot"),
    SystemMarker("path time left, 0.01 s", 1476, 4, "robot"),
    *_bits(1871, (7, "toggle of an external PLC", "plc")),
    *(SystemMarker(f"analog input {n}", ANALOG_INPUTS - 2 + 2 * n, 2, "both") for n in range(1, 25)),
    *(SystemMarker(f"analog output {n}", ANALOG_OUTPUTS - 2 + 2 * n, 2, "both") for n in range(1, 25)),
    SystemMarker("binary inputs", INPUTS, BYTES, "robot"),
    SystemMarker("binary outputs", OUTPUTS, BYTES, "both"),
)

PLC_KEEPS = (POWER_ON, IN_ERROR, ACKNOWLEDGED, (1021, 6))  # of the robot's bits: those the integrated PLC itself keeps, and M944


def _robots_bits() -> int:
    """Bits of M0..M1967 the robot fills in before each scan of the integrated PLC, as one number; bit 0 is M0.0."""
    mask = 0
    for row in SYSTEM:
        if row.writer == "robot" and row.byte < INPUTS and row.byte != ERROR_NUMBER:
            bits = (1 << 8 * row.bytes) - 1 if row.bit is None else 1 << row.bit
            mask |= bits << 8 * row.byte
    for byte, bit in PLC_KEEPS:
        mask &= ~(1 << 8 * byte + bit)
    return mask


ROBOTS_BITS = _robots_bits()
ALL_BITS = (1 << 8 * INPUTS) - 1


def merged(robot: bytes, plc: bytes) -> bytes:
    """M0..M1967: the robot's bits from its side, all others from the PLC's."""
    bits = int.from_bytes(robot, "little") & ROBOTS_BITS | int.from_bytes(plc, "little") & ALL_BITS & ~ROBOTS_BITS
    return bits.to_bytes(INPUTS, "little")


def meaning(byte: int, bit: int) -> SystemMarker | None:
    """The system marker a bit belongs to; None for free and reserved ones.  IoFault outside M0.0..M2047.7."""
    _check(byte, bit)
    for row in SYSTEM:
        if row.byte <= byte < row.byte + row.bytes and row.bit in (None, bit):
            return row
    return None


class Markers:
    """2048 bytes; the last 80 are the binary inputs and outputs themselves."""

    def __init__(self, io: BinaryIo) -> None:
        self._io = io
        self._own = bytearray(INPUTS)
        self.set_bit(*POWER_ON, True)

    def byte(self, byte: int) -> int:
        """M `byte`."""
        _check(byte, 0)
        if byte >= OUTPUTS:
            return self._io.byte(Area.OUTPUT, byte - OUTPUTS)
        return self._io.byte(Area.INPUT, byte - INPUTS) if byte >= INPUTS else self._own[byte]

    def set_byte(self, byte: int, value: int) -> None:
        """M `byte` = value 0..255; IoFault for the binary inputs, which only modules write."""
        if 0 <= byte < INPUTS:
            self._own[byte] = value & 0xFF
            return
        for bit in range(8):
            self.set_bit(byte, bit, bool(value >> bit & 1))

    def bit(self, byte: int, bit: int) -> bool:
        """M byte.bit."""
        _check(byte, bit)
        return bool(self.byte(byte) >> bit & 1)

    def set_bit(self, byte: int, bit: int, value: bool) -> None:
        """M byte.bit = value; IoFault for the binary inputs."""
        _check(byte, bit)
        if byte >= OUTPUTS:
            self._io.write_bit(Area.OUTPUT, value, byte - OUTPUTS, bit)
        elif byte >= INPUTS:
            raise IoFault(f"M{byte}.{bit} is an input: modules write it")
        else:
            self._own[byte] = self._own[byte] | 1 << bit if value else self._own[byte] & ~(1 << bit)

    def number(self, byte: int, size: int = 4) -> int:
        """Double word (or `size` bytes) from M `byte`, lowest byte first (D-16), signed."""
        return int.from_bytes(bytes(self.byte(byte + at) for at in range(size)), "little", signed=True)

    def set_number(self, byte: int, value: int, size: int = 4) -> None:
        """The reverse of number; the value is cut to its size."""
        for at, part in enumerate((value & (1 << 8 * size) - 1).to_bytes(size, "little")):
            self.set_byte(byte + at, part)

    def content(self) -> bytes:
        """M0..M2047 as they are."""
        return bytes(self._own) + self._io.content(Area.INPUT) + self._io.content(Area.OUTPUT)

    def own(self) -> bytes:
        """M0..M1967."""
        return bytes(self._own)

    def by_plc(self, plc: bytes) -> None:
        """M0..M1967 as the integrated PLC has them; the robot's bits stay."""
        self._own[:] = merged(bytes(self._own), plc)

    def retained(self) -> bytes:
        """What outlives power-off: markers, without the binary inputs and outputs."""
        return bytes(self._own)

    def power_on(self, kept: bytes) -> None:
        """Markers as they were; the power-on bit is set, initialisation and errors are not (AX-516).  IoFault: wrong length."""
        if len(kept) != len(self._own):
            raise IoFault(f"{len(kept)} bytes of markers, {len(self._own)} expected")
        self._own[:] = kept
        self.set_bit(*POWER_ON, True)
        for place in (IN_ERROR, ACKNOWLEDGED, STARTED):
            self.set_bit(*place, False)
        self.set_number(ERROR_NUMBER, 0)


def _check(byte: int, bit: int) -> None:
    if not 0 <= byte < SIZE or not 0 <= bit <= 7:
        raise IoFault(f"M{byte}.{bit}: markers are M0.0..M{SIZE - 1}.7")
