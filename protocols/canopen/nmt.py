"""Network management: commands, states, heartbeat, boot-up and node guarding on the wire.  Source: CiA 301, 7.2.8."""

from enum import IntEnum

from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid


class Command(IntEnum):
    START = 1
    STOP = 2
    PRE_OPERATIONAL = 128
    RESET_NODE = 129
    RESET_COMMUNICATION = 130


class State(IntEnum):
    """As in a heartbeat; INITIALISING is the boot-up message."""

    INITIALISING = 0
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127


ALL_NODES = 0
TOGGLE = 0x80  # of an answer to node guarding


def command(what: Command, node: int = ALL_NODES) -> Frame:
    return Frame(cobid.NMT, bytes((what, node)))


def command_of(frame: Frame) -> tuple[Command, int] | None:
    """(command, node or ALL_NODES); None when it is none."""
    if frame.identifier != cobid.NMT or len(frame.data) != 2:
        return None
    try:
        return Command(frame.data[0]), frame.data[1]
    except ValueError:
        return None


def heartbeat(node: int, state: State) -> Frame:
    return Frame(cobid.heartbeat(node), bytes((state,)))


def heartbeat_of(frame: Frame) -> tuple[int, State] | None:
    """(node, state), also of an answer to node guarding (its toggle bit is left out); None when it is none."""
    node = frame.identifier - cobid.heartbeat(0)
    if not 1 <= node <= cobid.MAX_NODE or len(frame.data) != 1:
        return None
    try:
        return node, State(frame.data[0] & ~TOGGLE)
    except ValueError:
        return None
