"""High-speed inputs, probes and the multi-function I/O.  Source: rho3 3.7 (L1202-1259, L9114-9130, L11378-11422), AX-508."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from gateway.pure.interface.image import PicImage


@dataclass(frozen=True, slots=True)
class Board:
    """What a servo board has."""

    inputs: int  # high-speed inputs
    probes: int
    outputs: int = 0  # high-speed outputs


BOARDS: Mapping[str, Board] = {
    "servo-3/5/8-wide": Board(8, 1),
    "servo-abs-5/8": Board(8, 0),
    "servo-inc6/poti": Board(8, 0),
    "servo-3/5-narrow": Board(0, 1),
    "servo-3is/4is/6is": Board(9, 1),
    "servo-abs-3i": Board(9, 1),
    "modular-i": Board(9, 1),
    "rho3.0": Board(4, 1, 4),
}


@dataclass(frozen=True, slots=True)
class Configured:
    """P11 for one board."""

    probes: int = 0  # 0/1
    inputs: int = 0  # 0..9
    outputs: int = 0  # rho3.0 only, 0..4


class StartUpFault(Exception):
    """The run-up is aborted; the text is the manual's."""


class InputFault(Exception):
    """Runtime error of the program that asked; the text is the manual's."""


class FastInputs:
    """The high-speed inputs of up to three boards, by channel 6xy (y = 0: probe)."""

    def __init__(self, boards: Sequence[Board], p11: Sequence[Configured]) -> None:
        """StartUpFault: P11 asks for more than there is."""
        for number, want in enumerate(p11):
            have = boards[number] if number < len(boards) else Board(0, 0)
            if want.inputs > have.inputs or want.probes > have.probes or want.outputs > have.outputs:
                raise StartUpFault(f"incorr. highspeed-io: board {number + 1}")
        self._p11 = tuple(p11)
        self._values: dict[int, bool] = {}

    def channels(self) -> tuple[int, ...]:
        """Channels a program may use."""
        return tuple(
            600 + 10 * board + input_
            for board, want in enumerate(self._p11, 1)
            for input_ in ([0] if want.probes else []) + list(range(1, want.inputs + 1))
        )

    def boards(self) -> tuple[int, ...]:
        """Boards mode 7.13 shows: those with high-speed inputs."""
        return tuple(board for board, want in enumerate(self._p11, 1) if want.inputs)

    def put(self, channel: int, value: bool) -> None:
        """What the hardware reads."""
        self._values[channel] = value

    def read(self, channel: int) -> bool:
        """InputFault: not configured in P11."""
        if channel not in self.channels():
            raise InputFault(f"inadmissable input: {channel}")
        return self._values.get(channel, False)


MF_BITS = 0x0F  # the lower four bits are used, the whole byte is reserved
MF_INPUTS, MF_OUTPUTS = 26, 18  # P36 = 0
MF_NONE = -1  # only BAPS sees them
FREE_OUTPUTS = frozenset((18, 19, 20, 23, 32, 34, 35, 42, 43, 44, 45, 46, 48, 55, 56, 57, 73, 74, 75))  # L11420


class MultiFunction:
    """The 4 inputs and 4 outputs of rho3.0: BAPS channels 801..804, and unless P36 = -1 a byte at the interface."""

    def __init__(self, p36_in: int = 0, p36_out: int = 0, stand_alone: bool = False, occupied: Collection[int] = ()) -> None:
        """`occupied`: bytes of PLC inputs signals stand in.  ValueError: an address that does not exist or is not free."""
        self._in, self._out = _place("input", p36_in, MF_INPUTS, stand_alone), _place("output", p36_out, MF_OUTPUTS, stand_alone)
        if self._in in occupied:
            raise ValueError(f"P36 input {self._in}: signals stand in I{self._in}")
        if self._out is not None and self._out < 88 and self._out not in FREE_OUTPUTS:
            raise ValueError(f"P36 output {self._out}: free are {sorted(FREE_OUTPUTS)}")
        self._baps = 0
        self._inputs = 0
        self.outputs = 0  # what the terminals carry, bits 0..3

    def step(self, image: PicImage, terminals: int) -> None:
        """Once per cycle: `terminals` bits 0..3 are the inputs as wired."""
        self._inputs = terminals & MF_BITS
        if self._in is not None:
            image.outputs[self._in] = self._inputs  # I26 is an input of the PLC: a byte of the RC outputs
        self.outputs = self._baps if self._out is None else image.inputs[self._out] & MF_BITS

    def read(self, channel: int) -> bool:
        """BAPS channel 801..804 (611..614 the same inputs)."""
        return bool(self._inputs >> _mf_bit(channel) & 1)

    def write(self, channel: int, value: bool) -> None:
        """BAPS output 801..804; PIC and PLC overwrite it unless P36 = -1."""
        bit = 1 << _mf_bit(channel)
        self._baps = self._baps | bit if value else self._baps & ~bit


def _place(what: str, p36: int, default: int, stand_alone: bool) -> int | None:
    if not MF_NONE <= p36 <= (127 if stand_alone else 87):
        raise ValueError(f"P36 {what} {p36}: -1, 0, 1..87{', 88..127' if stand_alone else ' (88..127 only stand-alone)'}")
    return None if p36 == MF_NONE else p36 or default


def _mf_bit(channel: int) -> int:
    for first in (801, 611):
        if first <= channel < first + 4:
            return channel - first
    raise InputFault(f"inadmissable input: {channel}")
