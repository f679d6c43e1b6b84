"""Run-time errors of VAL 3 that sio can raise.  Source: VAL 3 manual, 3.7.3 and the table of run-time errors."""

from enum import IntEnum


class Rte(IntEnum):
    """Codes as the task status shows them."""

    INDEX_HIGH = 20  # array index above the size
    INDEX_LOW = 21  # array index negative
    BAD_VALUE = 70  # invalid parameter value
    WRITE_TO_INPUT = 122  # write to a UDP socket with address 0.0.0.0
    NOT_LINKED = 123  # the variable is not linked to a system I/O
    IO_FAULT = 125  # read or write error, also the time-out of the operators (AX-180)


class Val3Error(Exception):
    """The instruction stops its task with this code."""

    def __init__(self, code: Rte, text: str) -> None:
        super().__init__(f"VAL 3 run-time error {int(code)}: {text}")
        self.code, self.text = code, text
