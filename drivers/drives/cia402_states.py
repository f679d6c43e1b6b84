"""Master's side of the power state machine of a CiA 402 drive.  Source: IEC 61800-7-201, finite state automaton and its tables."""

from collections import deque
from enum import Enum, auto


class State(Enum):
    """State reported by a statusword."""

    NOT_READY = auto()
    DISABLED = auto()  # switch on disabled
    READY = auto()  # ready to switch on
    SWITCHED_ON = auto()
    ENABLED = auto()  # operation enabled
    QUICK_STOP = auto()  # quick stop active
    REACTING = auto()  # fault reaction active
    FAULT = auto()


class Command(Enum):
    """Value: low byte of the controlword."""

    SHUTDOWN = 0x06
    SWITCH_ON = 0x07  # in ENABLED: disable operation
    ENABLE = 0x0F
    DISABLE_VOLTAGE = 0x00
    QUICK_STOP = 0x02
    RESET = 0x80


STATUS = (  # (mask, value, state); at most one row fits any statusword
    (0x4F, 0x00, State.NOT_READY),
    (0x4F, 0x40, State.DISABLED),
    (0x6F, 0x21, State.READY),
    (0x6F, 0x23, State.SWITCHED_ON),
    (0x6F, 0x27, State.ENABLED),
    (0x6F, 0x07, State.QUICK_STOP),
    (0x4F, 0x0F, State.REACTING),
    (0x4F, 0x08, State.FAULT),
)
MOVES = {  # remark: number of the transition in the standard
    (State.DISABLED, Command.SHUTDOWN): State.READY,  # 2
    (State.READY, Command.SWITCH_ON): State.SWITCHED_ON,  # 3
    (State.SWITCHED_ON, Command.ENABLE): State.ENABLED,  # 4
    (State.ENABLED, Command.SWITCH_ON): State.SWITCHED_ON,  # 5
    (State.SWITCHED_ON, Command.SHUTDOWN): State.READY,  # 6
    (State.READY, Command.DISABLE_VOLTAGE): State.DISABLED,  # 7
    (State.ENABLED, Command.SHUTDOWN): State.READY,  # 8
    (State.ENABLED, Command.DISABLE_VOLTAGE): State.DISABLED,  # 9
    (State.SWITCHED_ON, Command.DISABLE_VOLTAGE): State.DISABLED,  # 10
    (State.ENABLED, Command.QUICK_STOP): State.QUICK_STOP,  # 11
    (State.QUICK_STOP, Command.DISABLE_VOLTAGE): State.DISABLED,  # 12
    (State.FAULT, Command.RESET): State.DISABLED,  # 15; the drive needs a rising edge of bit 7
}
_LOW = {status: next((state for mask, value, state in STATUS if status & mask == value), None) for status in range(0x80)}


def state_of(statusword: int) -> State | None:
    """None: a pattern the table does not have."""
    return _LOW[statusword & 0x6F]


def next_command(state: State, goal: State) -> Command | None:
    """First command on the shortest way from `state` to `goal`; None: already there, or not reachable."""
    return _FIRST.get((state, goal))


def _first_commands() -> dict[tuple[State, State], Command]:
    found: dict[tuple[State, State], Command] = {}
    for start in State:
        waiting = deque([(after, command) for (before, command), after in MOVES.items() if before is start])
        while waiting:
            state, first = waiting.popleft()
            if state is start or (start, state) in found:
                continue
            found[start, state] = first
            waiting.extend((after, first) for (before, _), after in MOVES.items() if before is state)
    return found


_FIRST = _first_commands()
