"""What a running BAPS2 program asks of its surroundings; the answers are named at each."""

from collections.abc import Callable
from dataclasses import dataclass

from gateway.pure.languages.base.process import Body, Process
from gateway.pure.languages.base.requests import Request

Point = tuple[float | None, ...]


@dataclass(frozen=True, slots=True)
class ReadInput(Request):
    """Value of an input, synchronous with the motion of the process (asynchronous from 1000): int or float."""

    channel: int


@dataclass(frozen=True, slots=True)
class WriteOutput(Request):
    channel: int
    value: int | float


@dataclass(frozen=True, slots=True)
class ReadPosition(Request):
    """`name`: POS, @POS, @MPOS.  A point."""

    kinematic: str
    name: str


@dataclass(frozen=True, slots=True)
class Until:
    """Ends a movement.  `channel` of the input; `test` without effect; `limit` in seconds; `level` of the input that ends it."""

    channel: int
    test: Callable[[], bool]
    limit: float | None = None
    level: bool = True


@dataclass(frozen=True, slots=True)
class MoveTo(Request):
    """One target.  Whether UNTIL was met; False without UNTIL."""

    kinematic: str
    way: str
    via: bool
    joint: bool
    relative: bool
    target: Point
    until: Until | None = None
    factors: tuple[tuple[str, float], ...] = ()  # after WITH


@dataclass(frozen=True, slots=True)
class Dwell(Request):
    seconds: float


@dataclass(frozen=True, slots=True)
class WaitFor(Request):
    """True once `test` holds, False at the end of `limit`.  `fast`: a separate block, the program continues at once; then `channel` is
    that of its high-speed input, `level` the value it waits for.
    """

    test: Callable[[], bool]
    limit: float | None = None
    fast: bool = False
    channel: int = 0
    level: bool = True


@dataclass(frozen=True, slots=True)
class Late(Request):
    """The next block begins two P5 from now at the earliest: a wait for a high-speed input was not directly before it (L4752-4764)."""


@dataclass(frozen=True, slots=True)
class ReadDevice(Request):
    """One item: its type, components of a point, elements of an array (0: none).  The value, a list of an array."""

    unit: str
    base: str
    size: int = 0
    count: int = 0


@dataclass(frozen=True, slots=True)
class WriteDevice(Request):
    """`open`: the output continues with the next WRITE."""

    unit: str
    items: tuple[tuple[str, object], ...]
    open: bool


@dataclass(frozen=True, slots=True)
class FileAction(Request):
    """READ_BEGIN, WRITE_BEGIN, WRITE_END, CLOSE (with offset), ASSIGN (with name)."""

    word: str
    unit: str
    value: int | str | None = None


@dataclass(frozen=True, slots=True)
class Condition(Request):
    """Condition of a unit or a file, or a system signal (`'I88.0'`): int."""

    unit: str
    signal: bool = False


@dataclass(frozen=True, slots=True)
class StartProgram(Request):
    program: str


@dataclass(frozen=True, slots=True)
class StopProgram(Request):
    program: str


@dataclass(frozen=True, slots=True)
class Branches(Request):
    """Runs the branches of a PARALLEL; answered when all are over."""

    bodies: tuple[Callable[[Process], Body], ...]


@dataclass(frozen=True, slots=True)
class Enter(Request):
    semaphore: tuple[str, str]


@dataclass(frozen=True, slots=True)
class Leave(Request):
    semaphore: tuple[str, str]


@dataclass(frozen=True, slots=True)
class GiveUp(Request):
    """BREAK: continues after the other processes of its priority."""


@dataclass(frozen=True, slots=True)
class Halt(Request):
    """Ends the entire program; never answered."""


@dataclass(frozen=True, slots=True)
class Drain(Request):
    """Answered when all that the process prepared is done."""


@dataclass(frozen=True, slots=True)
class SyncBelt(Request):
    """`test`: of an input, or None with `at`: the belt value and the comparison that is waited for.  `input`: where the condition is one
    input alone, its channel, else 0; `level`: its value then."""

    channel: int
    test: Callable[[], bool] | None
    sign: str = ""
    at: float = 0.0
    input: int = 0
    level: bool = True


@dataclass(frozen=True, slots=True)
class Synchronise(Request):
    """SYNCHRON (`channel` of the belt), SYNCHRON_END (0; `belt`: the one it names, 0: none)."""

    kinematic: str
    channel: int
    belt: int = 0


@dataclass(frozen=True, slots=True)
class Reference(Request):
    kinematic: str


@dataclass(frozen=True, slots=True)
class Special(Request):
    """A special function; values passed by reference are a list."""

    number: int
    values: tuple[object, ...]
