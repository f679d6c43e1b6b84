"""How old programs start a move and receive its outcome: one table for each pattern, one machine for all (AX-403).

A telegram gives the machine its bits; the machine decides whether a move starts and what the answering bits show.  A telegram that
equals the one before is never an event, and the first one after a start or a lost link only sets the state of the bits: no
pattern starts twice on a repeated telegram.

start-busy-done is gateway.pure.arbitration.data_blocks's own; its table is here for `check` and for the page.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import Enum, auto

from gateway.pure.image.reasons import CommandState


class Pattern(Enum):
    """The value is the word in the cell."""

    START_BUSY_DONE = "start-busy-done"
    LEVEL_ACK = "level-ack"  # request is set until the acknowledgement is; that falls with the request
    TOGGLE = "toggle"  # every change of the bit is a request; the answer copies the bit when it is done
    STROBE_PARITY = "strobe-parity"  # a code with its parity, taken at the strobe's rising edge
    NUMBER_SELECT = "number-select"  # a number other than 0 selects a position or a program; 0 lies between two of them


class State(Enum):
    """State of one exchange."""

    IDLE = auto()
    BUSY = auto()  # started, no final outcome yet
    TAKEN = auto()  # accepted, acknowledged
    DONE = auto()
    FAILED = auto()  # refused or ended badly


class Event(Enum):
    """Event from a telegram or the job."""

    ASKS = auto()  # rising edge, change, a number
    WRONG = auto()  # the same with a wrong parity or an unknown number
    LETS_GO = auto()  # falling edge, number 0
    ACCEPTED = auto()
    ENDED_WELL = auto()
    ENDED_BADLY = auto()


class Act(Enum):
    """The action that accompanies the new state."""

    NOTHING = auto()
    START = auto()
    COPY = auto()  # the answering bit copies the request's level


Table = Mapping[tuple[State, Event], tuple[State, Act]]
NOT, GO, COPY = Act.NOTHING, Act.START, Act.COPY
_FALL: Table = {
    (State.TAKEN, Event.LETS_GO): (State.IDLE, NOT),
    (State.DONE, Event.LETS_GO): (State.IDLE, NOT),
    (State.FAILED, Event.LETS_GO): (State.IDLE, NOT),
}
_ASK: Table = {(State.IDLE, Event.ASKS): (State.BUSY, GO), (State.IDLE, Event.WRONG): (State.FAILED, NOT)}
_END: Table = {(State.BUSY, Event.ENDED_WELL): (State.DONE, NOT), (State.BUSY, Event.ENDED_BADLY): (State.FAILED, NOT)}
_TAKE: Table = {
    (State.BUSY, Event.ACCEPTED): (State.TAKEN, NOT),
    (State.BUSY, Event.ENDED_WELL): (State.TAKEN, NOT),
    (State.BUSY, Event.ENDED_BADLY): (State.FAILED, NOT),
    (State.BUSY, Event.LETS_GO): (State.IDLE, NOT),
}
TABLES: Mapping[Pattern, Table] = {
    Pattern.START_BUSY_DONE: {**_ASK, **_END, **_FALL},
    Pattern.LEVEL_ACK: {**_ASK, **_TAKE, **_FALL},
    Pattern.TOGGLE: {
        (State.IDLE, Event.ASKS): (State.BUSY, GO),
        (State.FAILED, Event.ASKS): (State.BUSY, GO),
        (State.BUSY, Event.ENDED_WELL): (State.IDLE, COPY),
        (State.BUSY, Event.ENDED_BADLY): (State.FAILED, COPY),
    },
    Pattern.STROBE_PARITY: {**_ASK, **_TAKE, **_FALL},
    Pattern.NUMBER_SELECT: {
        **_ASK,
        **_END,
        **_FALL,
        (State.DONE, Event.ASKS): (State.FAILED, NOT),  # another number without 0 between them
        (State.DONE, Event.WRONG): (State.FAILED, NOT),
    },
}
ENDS = {
    CommandState.ACCEPTED: Event.ACCEPTED,
    CommandState.RUNNING: Event.ACCEPTED,
    CommandState.DONE: Event.ENDED_WELL,
    CommandState.REFUSED: Event.ENDED_BADLY,
    CommandState.ABORTED: Event.ENDED_BADLY,
}


@dataclass(frozen=True, slots=True)
class Asked:
    """The request as one telegram carries it."""

    start: bool = False
    number: int = 0
    parity: bool = False
    fault: str = ""  # why number or parity cannot be used: refused, or not written since the link began


class Handshaking:
    """One exchange after the other with one partner."""

    def __init__(self, pattern: Pattern, numbers: Collection[int] = (), *, odd: bool = False) -> None:
        """`numbers`: positions and programs that exist; `odd`: number and parity bit together have an odd count of ones."""
        self.pattern, self._table = pattern, TABLES[pattern]
        self._numbers, self._odd = frozenset(numbers), odd
        self.state = State.IDLE
        self.wrong = ""  # why the last request was refused before it became a command
        self._before: Asked | None = None
        self._copied = False

    def restart(self) -> None:
        """Start of services or return of the link: the next telegram only sets the state of the bits."""
        self._before, self.state = None, State.IDLE

    @property
    def selects(self) -> bool:
        """The request carries a number that means something."""
        return self.pattern in (Pattern.NUMBER_SELECT, Pattern.STROBE_PARITY)

    def see(self, asked: Asked) -> bool:
        """One telegram; True: start now, with the targets or the number it carries."""
        before, self._before = self._before, asked
        self.wrong = ""
        if before is None:
            self._copied = asked.start  # nothing is owed
            return False
        event, was = self._event(before, asked), self.state
        started = event is not None and self._go(event)
        if self.state is State.FAILED and was is not State.FAILED:
            self.wrong = self._why(asked)
        return started

    def hear(self, state: CommandState) -> None:
        """What became of the job this exchange started."""
        event = ENDS.get(state)
        if event is not None:
            self._go(event)

    def bit(self, key: str) -> bool:
        """busy, done (the acknowledgement where the pattern has one), refused."""
        match key:
            case "busy":
                return self.state is State.BUSY
            case "refused":
                return self.state is State.FAILED
        return self._copied if self.pattern is Pattern.TOGGLE else self.state in (State.DONE, State.TAKEN)

    def _event(self, before: Asked, asked: Asked) -> Event | None:
        match self.pattern:
            case Pattern.NUMBER_SELECT:
                if (asked.number, asked.fault) == (before.number, before.fault):
                    return None
                return self._judged(asked) if asked.number or asked.fault else Event.LETS_GO
            case Pattern.TOGGLE:
                return Event.ASKS if asked.start is not before.start else None
        if asked.start is before.start:
            return None
        return self._judged(asked) if asked.start else Event.LETS_GO

    def _judged(self, asked: Asked) -> Event:
        if not self.selects:
            return Event.ASKS
        return Event.WRONG if asked.fault or not self._even(asked) or not self._exists(asked) else Event.ASKS

    def _even(self, asked: Asked) -> bool:
        return self.pattern is not Pattern.STROBE_PARITY or (asked.number.bit_count() + asked.parity) % 2 == self._odd

    def _exists(self, asked: Asked) -> bool:
        judged = self._numbers or self.pattern is Pattern.NUMBER_SELECT
        return not judged or asked.number in self._numbers

    def _why(self, asked: Asked) -> str:
        """What was wrong with a request that failed at once."""
        if asked.fault:
            return asked.fault
        if not self._even(asked):
            return f"move.number {asked.number} with move.parity {int(asked.parity)}: {'odd' if self._odd else 'even'} parity is expected"
        if not self._exists(asked):
            known = ", ".join(map(str, sorted(self._numbers))) or "none"
            return f"move.number {asked.number} selects nothing; this cell has {known}"
        return f"move.number {asked.number}: 0 is expected between two numbers"

    def _go(self, event: Event) -> bool:
        found = self._table.get((self.state, event))
        if found is None:
            return False
        self.state, act = found
        if act is Act.COPY and self._before is not None:
            self._copied = self._before.start
        return act is Act.START
