"""The debug adapter's interface to a language: one run of a program in virtual time."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from gateway.pure.languages.base.debug import Step

Row = dict[str, Any]


class AdapterFault(Exception):
    """A request cannot be answered: one sentence."""


@dataclass(frozen=True, slots=True)
class Call:
    """One routine or program of a thread, the innermost first.  scopes: variables by the name of their group."""

    number: int
    thread: int
    name: str
    line: int
    source: Path
    scopes: Mapping[str, dict[str, object]]


class Debugged(Protocol):
    """One program under the debugger."""

    def begin(self, *, entry: bool) -> None:
        """It starts; `entry`: held before its first statement."""

    def go_on(self) -> bool:
        """One round of the cell; False: nothing can happen any more."""

    def held(self) -> int | None:
        """The thread the debugger holds."""

    def resume(self, thread: int, how: Step) -> None:
        """Continue it in this way."""

    def pause(self) -> None:
        """Holds each thread before its next statement."""

    def breakpoints(self, path: Path, lines: Sequence[int]) -> tuple[list[int | None], str]:
        """Where they are set, each at the line or the next one with a statement; why one is nowhere."""

    def threads(self) -> list[tuple[int, str]]:
        """Number and name of each."""

    def calls(self) -> Iterator[Call]:
        """Calls of all threads."""

    def output(self) -> list[str]:
        """Output since the last look, one line each."""


def next_lines(lines: Sequence[int], wanted: Sequence[int]) -> list[int | None]:
    """For each wanted line the first of `lines` at or after it."""
    return [next((line for line in lines if line >= each), None) for each in wanted]
