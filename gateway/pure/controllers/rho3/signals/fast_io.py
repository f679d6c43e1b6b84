"""High-speed inputs, probes and the multi-function I/O.  Source: rho3 3.7 (L1202-1259, L9114-9130, L11378-11422), AX-477, AX-508."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.analog import AnalogChannels
from gateway.pure.controllers.rho3.signals.user import INPUTS, OUTPUTS, UserPorts


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


class StartUpFault(ValueError):
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

    def wired(self, board: int, terminals: int) -> None:
        """All high-speed inputs of a board at once, bit 0 the first one."""
        for input_ in range(self.inputs(board)):
            self._values[600 + 10 * board + input_ + 1] = bool(terminals >> input_ & 1)

    @property
    def configured(self) -> bool:
        """There is a P11."""
        return bool(self._p11)

    def inputs(self, board: int) -> int:
        """Return the high-speed inputs that P11 assigns to this board."""
        return self._p11[board - 1].inputs if board <= len(self._p11) else 0

    def outputs(self, board: int) -> int:
        """Return the high-speed outputs that P11 assigns to this board."""
        return self._p11[board - 1].outputs if board <= len(self._p11) else 0

    def shown(self) -> list[str]:
        """Mode 7.13: a line for each board that has inputs; their order from the first one (the manual's figure is lost, AX-477)."""
        return [
            f"{board}: {''.join(str(int(self._values.get(600 + 10 * board + n, False))) for n in range(1, self.inputs(board) + 1))}"
            for board in self.boards()
        ]

    def read(self, channel: int) -> bool:
        """InputFault: not configured in P11."""
        if channel not in self.channels():
            raise InputFault(f"inadmissable input: {channel}")
        return self._values.get(channel, False)


MF_BITS = 0x0F  # the lower four bits are used, the entire byte is reserved
MF_INPUTS, MF_OUTPUTS = 26, 18  # P36 = 0
MF_NONE = -1  # only BAPS sees them
FREE_OUTPUTS = frozenset((18, 19, 20, 23, 32, 34, 35, 42, 43, 44, 45, 46, 48, 55, 56, 57, 73, 74, 75))  # L11420


class MultiFunction:
    """The 4 inputs and 4 outputs of rho3.0: BAPS channels 801..804, and unless P36 = -1 a byte at the interface."""

    def __init__(self, p36_in: int = 0, p36_out: int = 0, stand_alone: bool = False, occupied: Collection[int] = ()) -> None:
        """`occupied`: bytes of PLC inputs signals are in.  ValueError: an address that does not exist or is not free."""
        self._in, self._out = _place("input", p36_in, MF_INPUTS, stand_alone), _place("output", p36_out, MF_OUTPUTS, stand_alone)
        if self._in in occupied:
            raise ValueError(f"P36 input {self._in}: signals are in I{self._in}")
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


@dataclass(frozen=True, slots=True)
class FastParts:
    """Optional parts of a control in addition to its user inputs and outputs."""

    boards: tuple[str, ...] = ()  # servo boards 1..3, keys of BOARDS
    p11: tuple[Configured, ...] = ()
    p36: tuple[int, int] | None = None  # multi-function I/O: inputs, outputs; None: the control has none
    analog: bool = False  # programs have REAL channels


class Channels:
    """Binary channels of programs: 1.. the user's, 610..639 set by P11, 801..804 the multi-function I/O."""

    def __init__(self, parts: FastParts, user: UserPorts, occupied: Collection[int]) -> None:
        """StartUpFault, ValueError: the run-up is aborted."""
        self._user = user
        self.fast = FastInputs([BOARDS[name] for name in parts.boards], parts.p11)
        self.multi = None if parts.p36 is None else MultiFunction(*parts.p36, occupied=occupied)
        self.analog = AnalogChannels() if parts.analog else None
        self.terminals = 0  # wired inputs of the multi-function I/O, bits 0..3

    def step(self, image: PicImage) -> None:
        """Once per cycle; the four inputs of rho3.0 are its multi-function inputs (L11382)."""
        if self.multi is not None:
            self.multi.step(image, self.terminals)
            self.fast.wired(1, self.terminals)

    def read(self, channel: int) -> bool:
        """InputFault: there is none, or it is not in P11."""
        if 1 <= channel <= INPUTS:
            return self._user.read(channel)
        if self.multi is not None and channel >= 800:
            self._given("input", channel, self.fast.inputs(1))
            return self.multi.read(channel)
        return self.fast.read(channel)

    def _given(self, way: str, channel: int, count: int) -> None:
        """Check P11, which sets how many of the four a program may use; without P11 they belong to P36."""
        if self.fast.configured and channel - 800 > count:
            raise InputFault(f"inadmissable {way}: {channel}")

    def put(self, channel: int, value: float) -> None:
        """A program sets an output, whatever it carries; InputFault: there is none."""
        if self.analog is not None and self.analog.writes(channel):
            self.analog.write(channel, value)
        else:
            self.write(channel, bool(value))

    def write(self, channel: int, value: bool) -> None:
        """Write a channel.  Raise InputFault for an unknown output."""
        if 1 <= channel <= OUTPUTS:
            self._user.write(channel, value)
        elif self.multi is not None and channel >= 800:
            self._given("output", channel, self.fast.outputs(1))
            self.multi.write(channel, value)
        else:
            raise InputFault(f"inadmissable output: {channel}")

    def names(self) -> tuple[str, ...]:
        """Values of tools and routes."""
        terminals = [f"rho3.terminal.{way}.{n}" for way in ("input", "output") for n in range(1, 5)]
        return (*(f"rho3.fast.{channel}" for channel in self.fast.channels()), *(terminals if self.multi is not None else []))

    def value(self, name: str) -> float:
        """One of these names."""
        _, kind, *rest = name.split(".")
        number = int(rest[-1])
        if kind == "fast":
            return float(self.fast.read(number))
        carried = self.terminals if rest[0] == "input" or self.multi is None else self.multi.outputs
        return float(carried >> number - 1 & 1)

    def wire(self, name: str, value: bool) -> None:
        """What is connected to one of these inputs."""
        number = int(name.rpartition(".")[2])
        if self.multi is None or (".fast." in name and number == 610):
            self.fast.put(number, value)
            return
        bit = 1 << (number - 611 if ".fast." in name else number - 1)
        self.terminals = self.terminals | bit if value else self.terminals & ~bit
        self.fast.wired(1, self.terminals)
