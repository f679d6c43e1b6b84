"""Exit codes of the commands and of their child processes (docs/errors.md)."""

from enum import IntEnum


class Exit(IntEnum):
    """Exit codes of all commands."""

    OK = 0
    FINDING = 1  # the input was valid, but a figure failed or a goal was missed
    INVALID = 2  # command line, cell or file invalid
    ENVIRONMENT = 3  # port, permission, kernel or a part that is not there
