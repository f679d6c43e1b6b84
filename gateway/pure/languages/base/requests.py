"""What a running program asks of its surroundings.  Requests are frozen; a process is resumed with the answer.

A language adds requests of its own (motion blocks, devices, files) as frozen dataclasses derived from `Request`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

Ns: TypeAlias = int


@dataclass(frozen=True, slots=True)
class Request:
    """Base of all requests.  Those that the scheduler does not know go to the host."""


@dataclass(frozen=True, slots=True)
class Turn(Request):
    """Gives up the processor: the process goes to the end of the queue of its priority."""


@dataclass(frozen=True, slots=True)
class Sleep(Request):
    """Resumed once `now` has reached `until`."""

    until: Ns


@dataclass(frozen=True, slots=True)
class Await(Request):
    """Resumed with True once `test` holds, with False at `deadline`.  `test` is asked once a turn and has no effect."""

    test: Callable[[], bool]
    deadline: Ns | None = None


@dataclass(frozen=True, slots=True)
class Stopped(Request):
    """The debugger holds the process before a line."""

    line: int


class Pending:
    """The host's answer to a request that it has not answered yet."""


PENDING = Pending()


class RuntimeFault(Exception):
    """A program cannot continue.  `code` is the manual's number, or one of axisgate's where the manual has none."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(f"{code} {text}")
        self.code, self.text = code, text
