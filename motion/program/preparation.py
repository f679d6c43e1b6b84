"""Block preparation of the rho 3: how far the program runs ahead of the axes, and what stops it.

Source: rho 3 Releases part 2, section 13 (L7949-8028): up to 11 blocks are prepared while one runs; BLOCK_SEARCH (SF 46) sets
fewer; reading a normal input stops preparation until 2 interpolation cycles before the end point of the last prepared block;
asynchronous inputs (channel + 1000) are read at preparation time.  WAIT UNTIL on high-speed inputs does not stop it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from motion.errors import MotionError
from motion.program.blocks import Block

MOST = 11  # blocks prepared while one runs (L7953)
CYCLES = 2  # of P5 before the end point (L7994)
ASYNCHRONOUS = 1000


class InputKind(Enum):
    """First and last channel of the synchronous form (L7966-7973)."""

    BINARY = (1, 120)
    DEC = (201, 224)
    INTEGER = (401, 408)


@dataclass(frozen=True, slots=True)
class Channel:
    """An input as a program names it."""

    kind: InputKind
    number: int  # the physical one
    asynchronous: bool


def channel(number: int) -> Channel:
    """1 .. 120, 201 .. 224, 401 .. 408, or one of these + 1000; MotionError for others."""
    asynchronous = number > ASYNCHRONOUS
    plain = number - ASYNCHRONOUS if asynchronous else number
    for kind in InputKind:
        if kind.value[0] <= plain <= kind.value[1]:
            return Channel(kind, plain, asynchronous)
    raise MotionError(f"input channel {number}: 1..120, 201..224, 401..408, asynchronous 1000 higher")


@dataclass(frozen=True, slots=True)
class Read:
    """A statement that reads an input; take: gets its value."""

    channel: int
    take: Callable[[float], None]


class Kinematic(Protocol):
    """What the blocks are prepared for."""

    @property
    def prepared(self) -> int:
        """Blocks added that have not begun."""
        ...

    @property
    def remaining_s(self) -> float:
        """Time to the end of everything added."""
        ...

    def add(self, block: Block) -> int:
        """The next block."""
        ...

    def finish(self) -> None:
        """Nothing follows for the time being: the last block is run to its end point."""
        ...


@dataclass(slots=True)
class Preparation:
    """Runs a program's statements ahead of one kinematic; call `turn` once a cycle.  p5_s: interpolation cycle."""

    kinematic: Kinematic
    statements: Iterator[Block | Read]
    read: Callable[[int], float]  # physical input -> value now
    p5_s: float
    limit: int = MOST
    ended: bool = False
    _waits: Read | None = None

    def block_search(self, blocks: int) -> None:
        """SF 46: at most so many blocks are prepared from now on."""
        if not 1 <= blocks <= MOST:
            raise MotionError(f"BLOCK_SEARCH {blocks}: 1 .. {MOST} blocks")
        self.limit = blocks

    def turn(self) -> None:
        """As many statements as may be prepared now."""
        while not self.ended:
            if self._waits is not None and not self._now_read(self._waits):
                return
            if self.kinematic.prepared >= self.limit:
                return
            statement = next(self.statements, None)
            if statement is None:
                self.ended = True
                self.kinematic.finish()
            elif isinstance(statement, Block):
                self.kinematic.add(statement)
            else:
                self._begin(statement)

    def _begin(self, statement: Read) -> None:
        asked = channel(statement.channel)
        if asked.asynchronous:
            statement.take(self.read(asked.number))
            return
        self._waits = statement
        self.kinematic.finish()

    def _now_read(self, statement: Read) -> bool:
        """A normal input is read 2 cycles before the end point of what is prepared."""
        if self.kinematic.remaining_s > CYCLES * self.p5_s + 1e-9:
            return False
        self._waits = None
        statement.take(self.read(channel(statement.channel).number))
        return True
