"""Bit coupling between PLC and control: I/O configuration P20, address ranges P21, the board in the rack, blocks for remote lines.

Source: rho3 3.6 (L7693-7767, L11073-11258, L11711-11713); doubts rho3 D-14, D-37 and the choices of AX-504, AX-505.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.image.addresses import Direction, RcBit

EXPANDED, NORMAL = 88, 46  # bytes (L11081)
BOARD_IN, BOARD_OUT = 8, 5  # bytes of the board 64/40; a smaller board still reserves them (L7760-7767)
REMOTE_MOST = 48  # bytes per transmission over a field bus (L11711)
FLAG_INDEX, IO_INDEX = 0x100, 0x2A0  # CL400 index addresses of M 0 and IO 0 (K15AH = M 90, K2C8H = IO 40)


class CouplingFault(ValueError):
    """P20 and P21 do not fit; the message gives the reason."""


@dataclass(frozen=True, slots=True)
class Ranges:
    """P21: where RC outputs begin and end in the PLC's inputs, and RC inputs in its outputs (ends included)."""

    i_start: int
    i_end: int
    o_start: int
    o_end: int


@dataclass(frozen=True, slots=True)
class _Kind:
    ranges: Ranges  # default
    skip_in: int = 0  # first byte of the RC inputs that goes over
    skip_out: int = 0  # first byte of the RC outputs
    board: bool = False
    most: int = EXPANDED
    zero_start: bool = False
    last_i: int = 255
    last_o: int = 255


KINDS: Mapping[int, _Kind] = {
    2: _Kind(Ranges(0, 87, 40, 127)),  # rho3.1, expanded; 2..89 and 2..89 in the extended field
    15: _Kind(Ranges(0, 44, 0, 44), skip_in=1, skip_out=2, board=True, most=NORMAL, last_i=247, last_o=250),  # CL300/CL500
    16: _Kind(Ranges(0, 87, 0, 87), board=True, last_i=247, last_o=250),  # PC600
    19: _Kind(Ranges(0, 87, 0, 87), zero_start=True),  # rho3.0 in the PLC rack, expanded
}
WITHOUT_MTB = Ranges(0, 63, 0, 81)  # configuration 16 as its shifted example has it (rho3 D-14)


class Coupling:
    """The frame that goes each way, and where each signal lies in the PLC."""

    def __init__(self, p20: int, p21: Ranges | None = None) -> None:
        """CouplingFault: configuration unknown, or ranges it does not allow."""
        if p20 not in KINDS:
            raise CouplingFault(f"P20 = {p20}: 2, 15, 16 or 19")
        self._kind = KINDS[p20]
        self.ranges = _checked(p20, self._kind, p21 or self._kind.ranges)
        self.rc_out_bytes = self.ranges.i_end - self.ranges.i_start + 1
        self.rc_in_bytes = self.ranges.o_end - self.ranges.o_start + 1

    @property
    def rc_in_first(self) -> int:
        """First byte of the RC inputs that goes over."""
        return self._kind.skip_in

    @property
    def to_plc_bytes(self) -> int:
        """Length of the frame RC -> PLC, the board's inputs included."""
        return self.rc_out_bytes + self._kind.board * BOARD_IN

    @property
    def from_plc_bytes(self) -> int:
        """Length of the frame PLC -> RC, the board's outputs included."""
        return self.rc_in_bytes + self._kind.board * BOARD_OUT

    def to_plc(self, image: PicImage, board: bytes = b"") -> bytes:
        """RC outputs, then the inputs of the board in the rack (missing bytes 0)."""
        first = self._kind.skip_out
        signals = bytes(image.outputs[first : first + self.rc_out_bytes])
        return signals + (board[:BOARD_IN].ljust(BOARD_IN, b"\0") if self._kind.board else b"")

    def from_plc(self, frame: bytes, image: PicImage) -> bytes:
        """Takes the RC inputs into the image; returns the outputs of the board.  CouplingFault: wrong length, nothing is taken."""
        if len(frame) != self.from_plc_bytes:
            raise CouplingFault(f"frame of {len(frame)} bytes, {self.from_plc_bytes} expected")
        first = self._kind.skip_in
        image.inputs[first : first + self.rc_in_bytes] = frame[: self.rc_in_bytes]
        return frame[self.rc_in_bytes :]

    def plc_address(self, signal: RcBit) -> str | None:
        """Where the PLC finds the signal ("O57.0"); None where it does not go over."""
        out = signal.direction is Direction.OUTPUT
        byte = signal.number // 8 - (self._kind.skip_out if out else self._kind.skip_in)
        if not 0 <= byte < (self.rc_out_bytes if out else self.rc_in_bytes):
            return None
        start = self.ranges.i_start if out else self.ranges.o_start
        return f"{'I' if out else 'O'}{start + byte}.{signal.number % 8}"

    def board_addresses(self) -> tuple[str, str] | None:
        """First and last address of the board's inputs and outputs in the PLC, as the manual prints them; None without board."""
        if not self._kind.board:
            return None
        i, o = self.ranges.i_end + 1, self.ranges.o_end + 1
        return f"I{i}.0-I{i + BOARD_IN - 1}.7", f"O{o}.0-O{o + BOARD_OUT - 1}.7"


def _checked(p20: int, kind: _Kind, ranges: Ranges) -> Ranges:
    for name, start, end, last in (("I", ranges.i_start, ranges.i_end, kind.last_i), ("O", ranges.o_start, ranges.o_end, kind.last_o)):
        if not 0 <= start <= end:
            raise CouplingFault(f"P21 {name}.START {start}, {name}.END {end}: from 0, and the end not before the start")
        if end > last:
            raise CouplingFault(f"P21 {name}.END {end}: at most {last} with P20 = {p20}")
        if end - start + 1 > kind.most:
            raise CouplingFault(f"P21 {name}: {end - start + 1} bytes, the interface has {kind.most} with P20 = {p20}")
        if kind.zero_start and start > 0:
            raise CouplingFault(
                f"P21 {name}.START {start}: a start above 0 would shift the signals once more, not allowed with P20 = {p20}"
            )
    return ranges


def flag_index(byte: int) -> int:
    """CL400 index address of flag byte M `byte`: M 90 is 15AH."""
    return FLAG_INDEX + byte


def io_index(byte: int) -> int:
    """CL400 index address of I/O byte `byte`: IO 40 is 2C8H."""
    return IO_INDEX + byte


def flag_byte(index: int) -> int:
    """The reverse of flag_index; CouplingFault below M 0."""
    if index < FLAG_INDEX:
        raise CouplingFault(f"index {index:X}H lies before M 0")
    return index - FLAG_INDEX


@dataclass(frozen=True, slots=True)
class Block:
    """Part `number` of `count` of one frame (numbering: AX-505)."""

    number: int
    count: int
    data: bytes


def in_blocks(frame: bytes) -> list[Block]:
    """A frame as blocks of at most 48 bytes."""
    parts = [frame[at : at + REMOTE_MOST] for at in range(0, len(frame), REMOTE_MOST)]
    return [Block(number, len(parts), part) for number, part in enumerate(parts)]


class BlockJoiner:
    """Joins blocks; only a complete frame is returned, and one with a missing block is discarded."""

    def __init__(self) -> None:
        self._parts: list[Block] = []

    def take(self, block: Block) -> bytes | None:
        """The frame with its last block, None before."""
        if block.number == 0:
            self._parts = []
        if len(block.data) > REMOTE_MOST or block.number != len(self._parts) or any(part.count != block.count for part in self._parts):
            self._parts = []
            return None
        self._parts.append(block)
        if len(self._parts) < block.count:
            return None
        frame, self._parts = b"".join(part.data for part in self._parts), []
        return frame


@dataclass(frozen=True, slots=True)
class Coupled:
    """The bit coupling of a running control: frame, image, and the bytes of the board in the rack (filled in place)."""

    coupling: Coupling
    image: PicImage
    board_in: bytearray
    board_out: bytearray
