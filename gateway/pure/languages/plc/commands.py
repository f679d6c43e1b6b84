"""The compiled form of a PLC program, the same for all old controllers.  It knows bits of one memory, cells, two accumulators and calls."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum


class Code(Enum):
    """What a command does.  The comment names its operand."""

    AND = "and"  # bit: byte, mask; or cell
    AND_NOT = "and not"
    OR = "or"
    OR_NOT = "or not"
    XOR = "xor"
    XOR_NOT = "xor not"
    OPEN_AND = "open and"
    OPEN_OR = "open or"
    OPEN_XOR = "open xor"
    CLOSE = "close"
    SET = "set"  # bit
    RESET = "reset"
    ASSIGN = "assign"
    LOAD = "load"  # number
    LOAD_BYTE = "load byte"  # byte
    LOAD_LONG = "load long"
    STORE_BYTE = "store byte"
    STORE_LONG = "store long"
    ACCU_AND = "accu and"
    ACCU_OR = "accu or"
    ACCU_XOR = "accu xor"
    EQUAL = "equal"
    UNEQUAL = "unequal"
    NOT_LESS = "not less"
    GREATER = "greater"
    NOT_GREATER = "not greater"
    LESS = "less"
    SHIFT_RIGHT = "shift right"  # number
    SHIFT_LEFT = "shift left"
    ROTATE_RIGHT = "rotate right"
    ROTATE_LEFT = "rotate left"
    PLUS = "plus"
    MINUS = "minus"
    TIMES = "times"
    DIVIDE = "divide"
    ONES = "ones complement"
    TWOS = "twos complement"
    EXCHANGE = "exchange"
    TO_BCD = "to bcd"
    FROM_BCD = "from bcd"
    ADD_NUMBER = "add number"  # number, may be negative
    TIMER = "timer"  # cell, name: kind of the timer
    COUNT_UP = "count up"  # cell
    COUNT_DOWN = "count down"
    COUNTER_SET = "counter set"
    CELL_RESET = "cell reset"
    JUMP = "jump"  # name: label
    JUMP_IF = "jump if"
    JUMP_IF_NOT = "jump if not"
    CALL = "call"  # name: routine
    CALL_IF = "call if"
    CALL_IF_NOT = "call if not"
    LABEL = "label"  # name
    BEGIN = "begin"  # a new chain, the result is 1


class Operand(Enum):
    """What a bit operand of a chain is."""

    BIT = "bit"
    TIMER = "timer"
    COUNTER = "counter"


@dataclass(frozen=True, slots=True)
class Command:
    """One command of a routine; `line` is its step in the source."""

    code: Code
    line: int
    operand: Operand = Operand.BIT
    byte: int = 0
    mask: int = 0
    cell: int = 0
    number: int = 0
    name: str = ""


@dataclass(frozen=True, slots=True)
class Routine:
    """A program without its head and its end; `last` is the step of its end."""

    name: str
    commands: tuple[Command, ...]
    last: int


@dataclass(frozen=True, slots=True)
class Program:
    """All routines that the start routine reaches; each comes after those that it calls, the start routine is last."""

    start: str
    routines: Mapping[str, Routine]

    @property
    def size(self) -> int:
        """Commands of all routines."""
        return sum(len(routine.commands) for routine in self.routines.values())


LOGIC = (Code.AND, Code.AND_NOT, Code.OR, Code.OR_NOT, Code.XOR, Code.XOR_NOT)
OPENERS = (Code.OPEN_AND, Code.OPEN_OR, Code.OPEN_XOR)
JUMPS = (Code.JUMP, Code.JUMP_IF, Code.JUMP_IF_NOT)
CALLS = (Code.CALL, Code.CALL_IF, Code.CALL_IF_NOT)
COMPARES = (Code.EQUAL, Code.UNEQUAL, Code.NOT_LESS, Code.GREATER, Code.NOT_GREATER, Code.LESS)
CELL_CODES = (Code.TIMER, Code.COUNT_UP, Code.COUNT_DOWN, Code.COUNTER_SET, Code.CELL_RESET)
STORES = (Code.SET, Code.RESET, Code.ASSIGN, Code.STORE_BYTE, Code.STORE_LONG)
ENDS_CHAIN = (Code.SET, Code.RESET, Code.ASSIGN, *CELL_CODES, *JUMPS, *CALLS)
