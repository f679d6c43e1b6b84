"""One parser for every address the three worlds write, and the arithmetic between them.

Accepted: DB10.DW2, DB10.DL2, DB10.DR2, DB10.DD2, DB10.D0.8, `D 10.3` and `DW 2` in a given block, E/I and A/O/Q byte.bit
(PIC; with the word CL300 in front: CL300), `RC 7.3`, `RC out 7.3`, symbols (K01_A_MN_RCI), bit numbers (66, RCI 66, RCO 66),
register numbers 00001, 10001, 30001, 40001 and names of the cell (axis.X.actual).
Source of the arithmetic: rho 3 release manual, as collected in rho3 0.2 (L943-952, L1702, L1746, L2508-2518, L3945-3948).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

LAST_FLAG = 2047  # byte of the last marker (robotstar 5.2)
LAST_BIT = 1023  # PIC image: 1024 bits of each kind (rho3 L9292-9311)


class AddressFault(ValueError):
    """The text is not a known address; the message names the expected forms."""


class Direction(Enum):
    """Which way an RC signal goes; the value is its name in the manual."""

    INPUT = "RC input"  # PLC -> RC, suffix _RCI: an output of the PLC
    OUTPUT = "RC output"  # RC -> PLC, suffix _RCO: an input of the PLC


@dataclass(frozen=True, slots=True)
class Offsets:
    """How the bytes of one direction are counted elsewhere: byte = N div 8 minus this."""

    letters: str  # accepted letters, the English one first
    cl300: int
    rc: int


OFFSETS = {Direction.INPUT: Offsets("OAQ", cl300=1, rc=1), Direction.OUTPUT: Offsets("IE", cl300=2, rc=7)}


@dataclass(frozen=True, slots=True)
class RcBit:
    """Bit N of the RC inputs or RC outputs."""

    direction: Direction
    number: int


class Part(Enum):
    """Which part of a data word; the value is the letter pair of STEP 5."""

    WORD = "DW"
    LEFT = "DL"  # bits 8..15
    RIGHT = "DR"  # bits 0..7
    DOUBLE = "DD"  # this word and the next


@dataclass(frozen=True, slots=True)
class DataWord:
    """A data word, byte or double word."""

    db: int
    word: int
    part: Part

    def __str__(self) -> str:
        return f"DB{self.db}.{self.part.value}{self.word}"


@dataclass(frozen=True, slots=True)
class DataBit:
    """Bit 0..15 of a data word; bit 0 is the lowest."""

    db: int
    word: int
    bit: int

    def __str__(self) -> str:
        return f"DB{self.db}.D{self.word}.{self.bit}"


@dataclass(frozen=True, slots=True)
class FlagBit:
    """A coordination flag of a line: M byte.bit."""

    byte: int
    bit: int

    def __str__(self) -> str:
        return f"M {self.byte}.{self.bit}"


class Table(Enum):
    """The four tables of Modbus; the value is the leading digit of a register number."""

    COIL = 0
    DISCRETE = 1
    INPUT = 3
    HOLDING = 4


@dataclass(frozen=True, slots=True)
class Register:
    """A Modbus object by its protocol address (base 0): 40001 is holding 0."""

    table: Table
    address: int


@dataclass(frozen=True, slots=True)
class CellName:
    """A dotted name of the cell: axis.X.actual."""

    name: str


class Kind(Enum):
    """What an operand of a PLC program is; the value is its letter in a German program."""

    INPUT = "E"
    OUTPUT = "A"
    FLAG = "M"
    TIMER = "T"
    COUNTER = "Z"


@dataclass(frozen=True, slots=True)
class Operand:
    """An operand of a PLC program other than a single input or output: flags, timers, counters, and bytes to double words of them.

    `number` is the byte, or the number of a timer or counter; `bit` None: `bytes` bytes from there (0 for timers and counters).
    """

    kind: Kind
    number: int
    bit: int | None = None
    bytes: int = 0

    def __str__(self) -> str:
        width = {0: "", 1: "B", 2: "W", 4: "D"}[self.bytes]
        return f"{self.kind.value}{width}{self.number}" + ("" if self.bit is None else f".{self.bit}")


Address = DataWord | DataBit | RcBit | Register | CellName | FlagBit

EXPECTED = (
    "expected DB10.DW2 (DL, DR, DD), DB10.D0.8, E/I 8.4, A/O 8.2, CL300 I6.4, RC 7.3, RC out 1.5, a bit number (66, RCO 66), "
    "a coordination flag M 6.4, "
    "a register number (00001, 10001, 30001, 40001), a signal such as K01_A_MN_RCI or a name such as axis.X.actual"
)
_BLOCK = re.compile(r"(?:DB\s*(\d+)\s*[., ]\s*)?(DW|DL|DR|DD)\s*(\d+)")
_BLOCK_BIT = re.compile(r"(?:DB\s*(\d+)\s*[., ]\s*)?D\s*(\d+)\.(\d+)")
_PLC = re.compile(r"(CL300\s+|PIC\s+)?([EIAOQ])\s*(\d+)\.(\d+)")
_RC = re.compile(r"RC\s*(IN|OUT)?\s*(\d+)\.(\d+)")
_NUMBER = re.compile(r"(?:(RCI|RCO|IN|OUT)\s*)?(\d{1,4})")
_REGISTER = re.compile(r"([0134])(\d{4,5})")
_NAME = re.compile(r"[a-z][\w]*(\.[\w*]+)+")
_FLAG = re.compile(r"[MF]\s*(\d+)\.(\d+)")
_NOT_SERVED = re.compile(r"(DX|M[BWD]?|T|Z|C|F[YWD]?)\s*\d+(\.\d+)?.*")
_OPERAND_BIT = re.compile(r"[MF]\s*(\d{1,4})\.(\d)")
_OPERAND_WIDE = re.compile(r"([EIAQOMF])([BWYD])\s*(\d{1,4})")
_MARKER_ALONE = re.compile(r"[MF]\s*(\d{1,4})")
_OPERAND_COUNT = re.compile(r"([TZC])\s*(\d{1,3})")
_KINDS = {
    "E": Kind.INPUT, "I": Kind.INPUT, "A": Kind.OUTPUT, "Q": Kind.OUTPUT, "O": Kind.OUTPUT, "M": Kind.FLAG, "F": Kind.FLAG,
    "T": Kind.TIMER, "Z": Kind.COUNTER, "C": Kind.COUNTER,
}  # fmt: skip
_WIDTHS = {"B": 1, "Y": 1, "W": 2, "D": 4}


def parse(text: str, symbols: Mapping[str, RcBit] | None = None, db: int | None = None) -> Address:
    """What `text` points at.  `symbols` knows signal names, `db` is the block for `D 10.3` and `DW 2`; AddressFault otherwise."""
    plain = " ".join(text.split())
    upper = plain.upper()
    if symbols and upper in symbols:
        return symbols[upper]
    for pattern, build in _FORMS:
        if found := pattern.fullmatch(upper):
            return build(text, found, db)
    if _NAME.fullmatch(plain):
        return CellName(plain)
    if _NOT_SERVED.fullmatch(upper):
        raise AddressFault(f"{text!r}: flag words, timers, counters and DX blocks have no address here; {EXPECTED}")
    raise AddressFault(f"{text!r}: {EXPECTED}")


def parse_operand(text: str, symbols: Mapping[str, RcBit] | None = None, db: int | None = None) -> Address | Operand:
    """As parse, for callers that have flags, timers and counters as well: M1020.4, F 6.3, MB 7, MD 944, EW 2, T 5, Z 5, C 5.

    German letters E A M T Z, English ones I Q (O) F T C.  Flags reach to byte 2047 (markers of the Reis), timers and counters to 255.
    """
    upper = " ".join(text.split()).upper()
    if found := _OPERAND_BIT.fullmatch(upper):
        byte, bit = int(found[1]), int(found[2])
        _check_operand(text, byte, LAST_FLAG, bit)
        return Operand(Kind.FLAG, byte, bit)
    if found := _OPERAND_WIDE.fullmatch(upper):
        kind, size = _KINDS[found[1]], _WIDTHS[found[2]]
        _check_operand(text, int(found[3]) + size - 1, LAST_FLAG if kind is Kind.FLAG else LAST_BIT // 8)
        return Operand(kind, int(found[3]), bytes=size)
    if found := _OPERAND_COUNT.fullmatch(upper):
        _check_operand(text, int(found[2]), 255)
        return Operand(_KINDS[found[1]], int(found[2]))
    if found := _MARKER_ALONE.fullmatch(upper):
        show = "axisgate plc show has the markers of a Reis PLC program"
        raise AddressFault(f"{text!r}: byte or bit missing: MB {found[1]} is the byte, M {found[1]}.0 a bit; {show}")
    return parse(text, symbols, db)


def _check_operand(text: str, number: int, last: int, bit: int = 0) -> None:
    if number > last or bit > 7:
        raise AddressFault(f"{text!r}: numbers are 0..{last} and bits 0..7")


def pic(signal: RcBit) -> str:
    """PIC address: bit 66 of the RC inputs is O8.2."""
    return f"{OFFSETS[signal.direction].letters[0]}{signal.number // 8}.{signal.number % 8}"


def cl300(signal: RcBit) -> str:
    """CL300 address: one byte less for RC inputs, two for RC outputs; AddressFault where there is none."""
    offsets = OFFSETS[signal.direction]
    return f"{offsets.letters[0]}{_shifted(signal, offsets.cl300, 0, 'CL300')}.{signal.number % 8}"


def rc(signal: RcBit) -> str:
    """The manual's own byte.bit, both counted from 1; AddressFault for bits below the first byte."""
    return f"{_shifted(signal, OFFSETS[signal.direction].rc, 1, 'RC')}.{signal.number % 8 + 1}"


def from_pic(letter: str, byte: int, bit: int) -> RcBit:
    """The signal at a PIC address; letters as in STEP 5 in German or English."""
    return _plc_bit(letter, byte, bit, shift=0)


def from_cl300(letter: str, byte: int, bit: int) -> RcBit:
    """The signal at a CL300 address."""
    return _plc_bit(letter, byte, bit, shift=OFFSETS[_direction(letter)].cl300)


def from_rc(direction: Direction, byte: int, bit: int) -> RcBit:
    """The signal at the manual's byte.bit, both counted from 1."""
    if byte < 1 or not 1 <= bit <= 8:
        raise AddressFault(f"RC {byte}.{bit}: RC bytes count from 1 and bits from 1 to 8")
    return _checked(RcBit(direction, (byte + OFFSETS[direction].rc) * 8 + bit - 1))


def from_number(direction: Direction, number: int) -> RcBit:
    """The signal with bit number N."""
    return _checked(RcBit(direction, number))


def bits_of(address: DataWord | DataBit) -> range:
    """The bits of the block an address covers, counted word * 16 + bit; DD covers two words."""
    start = address.word * 16
    if isinstance(address, DataBit):
        return range(start + address.bit, start + address.bit + 1)
    first, width = {Part.WORD: (0, 16), Part.LEFT: (8, 8), Part.RIGHT: (0, 8), Part.DOUBLE: (0, 32)}[address.part]
    return range(start + first, start + first + width)


def _shifted(signal: RcBit, shift: int, least: int, world: str) -> int:
    byte = signal.number // 8 - shift
    if byte < least:
        raise AddressFault(f"{signal.direction.value} {signal.number} has no {world} address: they begin at bit {(shift + least) * 8}")
    return byte


def _direction(letter: str) -> Direction:
    return Direction.INPUT if letter.upper() in OFFSETS[Direction.INPUT].letters else Direction.OUTPUT


def _plc_bit(letter: str, byte: int, bit: int, shift: int) -> RcBit:
    if not 0 <= bit <= 7:
        raise AddressFault(f"{letter}{byte}.{bit}: a PLC bit is 0..7")
    return _checked(RcBit(_direction(letter), (byte + shift) * 8 + bit))


def _checked(signal: RcBit) -> RcBit:
    if not 0 <= signal.number <= LAST_BIT:
        raise AddressFault(f"{signal.direction.value} {signal.number}: bit numbers are 0..{LAST_BIT}")
    return signal


def _block_number(text: str, found: str | None, db: int | None) -> int:
    number = int(found) if found else db
    if number is None:
        raise AddressFault(f"{text!r}: which data block? write it in front, as in DB10.{text.replace(' ', '')}")
    if not 1 <= number <= 255:
        raise AddressFault(f"{text!r}: data blocks are DB 1..DB 255")
    return number


def _block_word(text: str, found: re.Match[str], db: int | None) -> Address:
    word = int(found[3])
    if word > 255:
        raise AddressFault(f"{text!r}: data words are 0..255")
    return DataWord(_block_number(text, found[1], db), word, Part(found[2]))


def _block_bit(text: str, found: re.Match[str], db: int | None) -> Address:
    word, bit = int(found[2]), int(found[3])
    if word > 255 or bit > 15:
        raise AddressFault(f"{text!r}: data words are 0..255 and their bits 0..15")
    return DataBit(_block_number(text, found[1], db), word, bit)


def _plc(text: str, found: re.Match[str], db: int | None) -> Address:
    build = from_cl300 if (found[1] or "").startswith("CL300") else from_pic
    return build(found[2], int(found[3]), int(found[4]))


def _rc(text: str, found: re.Match[str], db: int | None) -> Address:
    direction = Direction.OUTPUT if found[1] == "OUT" else Direction.INPUT  # AX-120
    return from_rc(direction, int(found[2]), int(found[3]))


def _number(text: str, found: re.Match[str], db: int | None) -> Address:
    direction = Direction.OUTPUT if found[1] in ("RCO", "OUT") else Direction.INPUT  # AX-120
    return from_number(direction, int(found[2]))


def _register(text: str, found: re.Match[str], db: int | None) -> Address:
    number = int(found[2])
    if not 1 <= number <= 65536:
        raise AddressFault(f"{text!r}: register numbers count from {found[1]}0001 to {found[1]}65536")
    return Register(Table(int(found[1])), number - 1)


def _flag(text: str, found: re.Match[str], db: int | None) -> Address:
    byte, bit = int(found[1]), int(found[2])
    if byte > 254 or bit > 7:
        raise AddressFault(f"{text!r}: coordination flags are M 0.0..M 254.7")
    return FlagBit(byte, bit)


_FORMS = (
    (_BLOCK, _block_word),
    (_BLOCK_BIT, _block_bit),
    (_PLC, _plc),
    (_RC, _rc),
    (_NUMBER, _number),
    (_REGISTER, _register),
    (_FLAG, _flag),
)
