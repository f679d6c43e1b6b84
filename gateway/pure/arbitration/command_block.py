"""The own command and status block (AX-011), for PLCs that may be reprogrammed.

Words are 16 bit; 32-bit values high word first; REAL is IEEE single.  A block is processed as a unit: one RK512 telegram or one FC16/FC23;
a PLC that can only write single registers writes word 0 with the toggle last.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

from gateway.pure.image.reasons import CommandState, Reason, Refusal

AXES, MASKED = 12, 15  # axes the block has targets and positions of; axes that have a bit of their own in its masks (AX-572)

COMMAND_WORDS = 4 + 2 * AXES  # W0 toggle/code, W1 mask, W2 velocity, W3 acceleration, W4.. targets REAL
STATUS_WORDS = 10 + 4 * AXES  # W0 toggle/state .. W8 owner, W9 reserved, W10.. per axis actual, lag REAL
TOGGLE = 0x8000


class Code(IntEnum):
    """Bits 0-7 of command word 0."""

    ENABLE = 1
    DISABLE = 2
    REFERENCE = 3
    PTP_ABSOLUTE = 4
    PTP_RELATIVE = 5
    STOP = 6
    RESUME = 7
    ABANDON = 8
    FAULT_RESET = 9
    OVERRIDE = 10
    REQUEST_CONTROL = 11
    RELEASE_CONTROL = 12
    PROGRAM = 13  # W1: number of a program of the cell (AX-322)
    AXES_OVERRIDE = 14  # OVERRIDE of the kinematics with the axes in W1 alone (AX-1787)


@dataclass(frozen=True, slots=True)
class Command:
    """One command; code as written (may be unknown); mask: of axes, for PROGRAM its number; rates 0..1; targets of the first axes, in the
    axes' own units (mm, deg)."""

    code: int
    mask: int = 0
    velocity: float = 1.0
    acceleration: float = 1.0
    targets: tuple[float, ...] = ()


def real(high: int, low: int) -> float:
    """IEEE single from two words, high word first (AX-010)."""
    value: float = struct.unpack(">f", struct.pack(">HH", high, low))[0]
    return value


def real_words(value: float) -> tuple[int, int]:
    """Two words of an IEEE single; values beyond its range become infinity, as a PLC would see them."""
    try:
        data = struct.pack(">f", value)
    except OverflowError:
        data = struct.pack(">f", float("inf") if value > 0 else float("-inf"))
    high, low = struct.unpack(">HH", data)
    return high, low


def mask_word(mask: int, axes: int, *, every: bool = True) -> int:
    """Axes of a cell as encoded in the block: bits 0..14 are axes 1..15, bit 15 means all further ones (`every`: it is set
    when all of them are in the mask, else when one is)."""
    own, behind = (1 << MASKED) - 1, ((1 << axes) - 1) >> MASKED
    rest = mask >> MASKED & behind
    return mask & own | (rest == behind if every and behind else rest != 0) << MASKED


def mask_of_word(word: int, axes: int) -> int:
    """Reverse the mapping; in a cell of fewer than 16 axes bit 15 is not an axis and is kept."""
    return word & (1 << MASKED) - 1 | (word >> MASKED) * max(((1 << axes) - 1) >> MASKED, 1) << MASKED


_REALS, _WORDS = struct.Struct(f">{2 * AXES}f"), struct.Struct(f">{4 * AXES}H")


def _all_words(values: Sequence[float]) -> Sequence[int]:
    """`real_words` of all actual values and lags at one go: each command source asks for them with every tick."""
    try:
        return _WORDS.unpack(_REALS.pack(*values))
    except OverflowError:
        return [word for value in values for word in real_words(value)]


@dataclass(slots=True)
class Status:
    """Contents of the status block."""

    state: CommandState = CommandState.NONE
    reason: Reason = Reason.NONE
    enabled: int = 0
    in_position: int = 0
    referenced: int = 0
    fault: int = 0
    override: float = 0.0  # 0..1
    life: int = 0
    owner: int = 0
    actual: list[float] = field(default_factory=lambda: [0.0] * AXES)  # mm, deg
    lag: list[float] = field(default_factory=lambda: [0.0] * AXES)


class CommandBlock:
    """Command words of one command source and the toggle that confirms the one taken."""

    def __init__(self, words: Sequence[int] = (), axes: int = AXES) -> None:
        """`words`: left by a predecessor and never executed.  `axes`: number of axes of the cell."""
        self._axes = axes
        self.words = [*words, *[0] * COMMAND_WORDS][:COMMAND_WORDS]
        self._toggle = self.words[0] & TOGGLE
        self._adopt = True
        self._since = bytearray(COMMAND_WORDS)  # 1: written since the link began

    def link_returned(self) -> None:
        """What the next telegram holds was meant for an earlier time: adopt its toggle, do not carry it out (AX-141)."""
        self._adopt = True
        self._since[:] = bytes(COMMAND_WORDS)

    @property
    def acknowledged(self) -> bool:
        """The toggle as it was last taken."""
        return bool(self._toggle)

    def write(self, first: int, values: Sequence[int]) -> Command | Refusal | None | Reason:
        """Put words into the block; a Command when it is a fresh one, RESYNCHRONISED when it was only adopted, else None.

        Refusal: the fresh one counts on words of an earlier link (AX-610)."""
        if first < 0 or first + len(values) > COMMAND_WORDS:
            raise IndexError(f"words {first}..{first + len(values) - 1} of the command block; it has 0..{COMMAND_WORDS - 1}")
        self.words[first : first + len(values)] = values
        self._since[first : first + len(values)] = b"\1" * len(values)
        if first > 0:
            return None  # the toggle word was not part of it
        toggle = self.words[0] & TOGGLE
        if self._adopt:
            self._adopt = False
            changed = toggle != self._toggle or self.words[0] & 0xFF != 0
            self._toggle = toggle
            return Reason.RESYNCHRONISED if changed else None
        if toggle == self._toggle:
            return None
        self._toggle = toggle
        command = self._command()
        void = [n for n in self._needed(command) if not self._since[n]]
        if void:
            return Refusal(Reason.FORMAT_SUSPICION, f"word {void[0]} has not been written since the link began; write it before the toggle")
        return command

    @staticmethod
    def _needed(command: Command) -> Sequence[int]:
        """Words without which this command would move by those of an earlier time."""
        match command.code:
            case Code.PTP_ABSOLUTE | Code.PTP_RELATIVE:
                return [1, 2, 3, *(4 + 2 * n + half for n in range(AXES) if command.mask >> n & 1 for half in (0, 1))]
            case Code.PROGRAM:
                return [1, 2, 3]
            case Code.REFERENCE:
                return [1]
            case Code.OVERRIDE:
                return [2]
            case Code.AXES_OVERRIDE:
                return [1, 2]
        return []

    def _command(self) -> Command:
        w = self.words
        targets = tuple(real(w[4 + 2 * n], w[5 + 2 * n]) for n in range(AXES))
        code = w[0] & 0xFF
        mask = w[1] if code == Code.PROGRAM else mask_of_word(w[1], self._axes)
        return Command(code, mask, w[2] / 10_000, w[3] / 10_000, targets)

    def status_words(self, status: Status) -> list[int]:
        """STATUS_WORDS words as the PLC reads them."""
        head = [
            self._toggle | status.state,
            int(status.reason),
            status.enabled,
            status.in_position,
            status.referenced,
            status.fault,
            round(status.override * 10_000),
            status.life & 0xFFFF,
            status.owner,
            0,
        ]
        return [*head, *_all_words([value for pair in zip(status.actual, status.lag, strict=True) for value in pair])]
