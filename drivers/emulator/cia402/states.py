"""Power states of a CiA 402 drive: commands, transitions 0..16, statusword.

Source: CiA 402-2 (IEC 61800-7-201), finite state automaton, tables "controlword", "transition events and actions", "statusword".
Written for the emulated drive from the standard alone, never from the gateway's side of it.
"""

from collections.abc import Mapping
from enum import Enum, IntEnum, auto


class State(IntEnum):
    """Order of the standard; the numbers are those of the servo record."""

    NOT_READY = 0  # not ready to switch on
    DISABLED = 1  # switch on disabled
    READY = 2  # ready to switch on
    ON = 3  # switched on
    ENABLED = 4  # operation enabled
    QUICK_STOP = 5  # quick stop active
    REACTION = 6  # fault reaction active
    FAULT = 7


class Command(Enum):
    """The command in bits 0..3 and 7 of the controlword; fault reset is an edge and is judged separately."""

    NONE = auto()
    SHUTDOWN = auto()
    SWITCH_ON = auto()  # in operation enabled: disable operation
    ENABLE = auto()
    DISABLE_VOLTAGE = auto()
    QUICK_STOP = auto()


RESET_BIT, HALT_BIT = 0x80, 0x100

# (state, command) -> (transition of the standard, state it leads to)
TRANSITIONS: Mapping[tuple[State, Command], tuple[int, State]] = {
    (State.DISABLED, Command.SHUTDOWN): (2, State.READY),
    (State.READY, Command.SWITCH_ON): (3, State.ON),
    (State.READY, Command.ENABLE): (3, State.ON),  # 3, then 4 automatically
    (State.ON, Command.ENABLE): (4, State.ENABLED),
    (State.ENABLED, Command.SWITCH_ON): (5, State.ON),
    (State.ON, Command.SHUTDOWN): (6, State.READY),
    (State.READY, Command.QUICK_STOP): (7, State.DISABLED),
    (State.READY, Command.DISABLE_VOLTAGE): (7, State.DISABLED),
    (State.ENABLED, Command.SHUTDOWN): (8, State.READY),
    (State.ENABLED, Command.DISABLE_VOLTAGE): (9, State.DISABLED),
    (State.ON, Command.QUICK_STOP): (10, State.DISABLED),
    (State.ON, Command.DISABLE_VOLTAGE): (10, State.DISABLED),
    (State.ENABLED, Command.QUICK_STOP): (11, State.QUICK_STOP),
    (State.QUICK_STOP, Command.DISABLE_VOLTAGE): (12, State.DISABLED),
    (State.QUICK_STOP, Command.ENABLE): (16, State.ENABLED),
}

# Bits 0..3, 5 and 6 of the statusword
STATUS: Mapping[State, int] = {
    State.NOT_READY: 0x00,
    State.DISABLED: 0x40,
    State.READY: 0x21,
    State.ON: 0x23,
    State.ENABLED: 0x27,
    State.QUICK_STOP: 0x07,
    State.REACTION: 0x0F,
    State.FAULT: 0x08,
}
VOLTAGE, WARNING, REMOTE, TARGET, LIMIT, BIT12, BIT13 = 0x10, 0x80, 0x200, 0x400, 0x800, 0x1000, 0x2000


def command_of(controlword: int) -> Command:
    """Table "command coding"; bit 7 must be 0 in all of them."""
    if controlword & RESET_BIT:
        return Command.NONE
    if not controlword & 0x02:
        return Command.DISABLE_VOLTAGE
    if not controlword & 0x04:
        return Command.QUICK_STOP
    if not controlword & 0x01:
        return Command.SHUTDOWN
    return Command.ENABLE if controlword & 0x08 else Command.SWITCH_ON
