"""Errors as every part of axisgate tells them, and the exit codes of its commands (design.md 5)."""

from enum import IntEnum

from gateway.pure.image.error_list import ErrorList, ErrorRecord, EventLimit, Reset

__all__ = ["ErrorList", "ErrorRecord", "EventLimit", "Exit", "Reset"]


class Exit(IntEnum):
    """Exit codes of all commands."""

    OK = 0
    FINDING = 1  # the input was valid, but a figure failed or a goal was missed
    INVALID = 2  # command line, cell or file invalid
    ENVIRONMENT = 3  # port, permission, kernel or a part that is not there
