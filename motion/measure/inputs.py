"""Inputs that can stop or start a movement: channel numbers, servo boards, and the instant at which a position is stored.

Source: rho 3 Releases part 1, section 2 (L1100-1290).  6x0 probe of servo board x, 6xy its y-th high-speed input, 7x0 the probe with
the modified MOVE UNTIL (L6768); 1 .. 120 normal inputs.  Accuracy: probe v/100000 mm (10 us), high-speed input v/1000 x LRTAKT.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple

from motion.errors import MotionError
from motion.measure.errors import INADMISSABLE_INPUT, ProgramFault

PROBE_RESPONSE_NS = 10_000  # L1272
HIGHEST_NORMAL = 120
BOARDS = 9  # x of 6xy


class InputKind(Enum):
    """How an input is seen."""

    NORMAL = auto()  # once an interpolation cycle
    HIGH_SPEED = auto()  # once a position-controller cycle
    PROBE = auto()  # by its edge, within 10 us
    MODIFIED = auto()  # the probe again: MOVE UNTIL continues by the distance of SF 42


@dataclass(frozen=True, slots=True)
class MeasuringInput:
    """A channel as a program names it; board and number are 0 for normal inputs' board and for probes' number."""

    channel: int
    kind: InputKind
    board: int
    number: int

    @property
    def by_edge(self) -> bool:
        """Whether only a change during the block counts."""
        return self.kind in (InputKind.PROBE, InputKind.MODIFIED)

    @property
    def wire(self) -> int:
        """Channel whose edges are meant: 7x0 and 6x0 are one wire."""
        return 600 + self.board * 10 if self.by_edge else self.channel


@dataclass(frozen=True, slots=True)
class Board:
    """One servo board.  axes: numbers (from 0) of the control's axes on it; incremental: those with such an encoder;
    high_speed: inputs applied by P11; probe: fitted."""

    axes: frozenset[int]
    incremental: frozenset[int]
    high_speed: int = 8
    probe: bool = True


def input_of(channel: int) -> MeasuringInput:
    """Return the input of a channel number.  Raise ProgramFault inadmissable input for an unassigned number."""
    if 1 <= channel <= HIGHEST_NORMAL:
        return MeasuringInput(channel, InputKind.NORMAL, 0, channel)
    hundreds, rest = divmod(channel, 100)
    board, number = divmod(rest, 10)
    if 1 <= board <= BOARDS and hundreds == 6:
        return MeasuringInput(channel, InputKind.HIGH_SPEED if number else InputKind.PROBE, board, number)
    if 1 <= board <= BOARDS and hundreds == 7 and number == 0:
        return MeasuringInput(channel, InputKind.MODIFIED, board, number)
    raise ProgramFault(INADMISSABLE_INPUT, f"channel {channel}: 1 .. {HIGHEST_NORMAL}, 6x0, 6xy or 7x0 with board x = 1 .. {BOARDS}")


def admitted(channel: int, boards: Mapping[int, Board]) -> MeasuringInput:
    """input_of() for an input that is there: its board is fitted, P11 applied it."""
    asked = input_of(channel)
    if asked.kind is InputKind.NORMAL:
        return asked
    board = boards.get(asked.board)
    if board is None:
        raise ProgramFault(INADMISSABLE_INPUT, f"channel {channel}: servo board {asked.board} does not exist")
    if asked.by_edge and not board.probe:
        raise ProgramFault(INADMISSABLE_INPUT, f"channel {channel}: servo board {asked.board} has no probe input")
    if asked.number > board.high_speed:
        raise ProgramFault(INADMISSABLE_INPUT, f"channel {channel}: P11 states board {asked.board} {board.high_speed} high-speed inputs")
    return asked


def stored_at(kind: InputKind, edge_ns: int, cycle_ns: int, incremental: bool = True) -> int:
    """Instant whose position is stored for an edge.  cycle_ns: LRTAKT, position-controller cycle, its grid starts at 0.

    A probe stores at the stamp itself (finer than the 10 us of the old board, AX-456); a high-speed input, and a probe
    on an axis without incremental encoder, in the next position-controller cycle (L1238, L1290).
    """
    if kind in (InputKind.PROBE, InputKind.MODIFIED) and incremental:
        return edge_ns
    if not cycle_ns > 0:
        raise MotionError(f"position-controller cycle {cycle_ns} ns: above 0 is needed")
    return -(-edge_ns // cycle_ns) * cycle_ns


def greatest_error(kind: InputKind, speed: float, cycle_ns: int) -> float:
    """Error of a stored position by the manual, in the unit of speed times s (mm for mm/s): v/100000 or v/1000 x LRTAKT[ms]."""
    return abs(speed) * (PROBE_RESPONSE_NS if kind in (InputKind.PROBE, InputKind.MODIFIED) else cycle_ns) * 1e-9


class Edge(NamedTuple):
    """A change on the wire of a measuring input."""

    channel: int  # 6x0 or 6xy
    stamp_ns: int
    value: bool  # after the change
