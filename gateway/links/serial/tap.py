"""Keeps the last few thousand characters received and sent by a line's command source, for pages that decode them; costs one append."""

from collections import deque
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from protocols.base.machine import Damage, Machine, Ns

E = TypeVar("E")
KEPT = 512  # pieces of the traffic, a few characters each
KEPT_CHARACTERS = 16_384  # of all pieces: those of a flooded line are long, and a page requests all of them at once
Piece = tuple[int, Ns, str, bytes | Damage]  # number, stamp, side (A: the partner, B: axisgate), characters


class Tap(Generic[E]):
    """A machine between loop and command source that keeps the traffic."""

    def __init__(self, machine: Machine[E], said: Callable[[Ns, str, bytes], None] = lambda now, side, data: None) -> None:
        """`said` receives every good character at once."""
        self._said = said
        self._machine = machine
        self._kept: deque[Piece] = deque()
        self._number = 0
        self._characters = 0  # kept
        self._latest: Ns = 0

    def since(self, number: int) -> list[Piece]:
        """Pieces after that one, as far as they are kept; all of them for a number of a predecessor, which restarted the count."""
        number = number if number <= self._number else 0
        return [piece for piece in self._kept if piece[0] > number]

    def receive(self, data: bytes, now: Ns) -> Sequence[E]:
        self._keep(now, "A", data)
        return self._machine.receive(data, now)

    def damaged(self, kind: Damage, now: Ns) -> Sequence[E]:
        self._keep(now, "A", kind)
        return self._machine.damaged(kind, now)

    def sent(self, now: Ns) -> Sequence[E]:
        return self._machine.sent(now)

    def wake(self, now: Ns) -> Sequence[E]:
        self._latest = now
        return self._machine.wake(now)

    def lost(self, now: Ns) -> Sequence[E]:
        return self._machine.lost(now)

    def deadline(self) -> Ns | None:
        return self._machine.deadline()

    def take_output(self) -> bytes:
        output = self._machine.take_output()
        if output:
            self._keep(self._latest, "B", output)  # it answers the last piece received
        return output

    def _keep(self, now: Ns, side: str, what: bytes | Damage) -> None:
        self._number += 1
        self._latest = max(now, self._latest)
        if len(self._kept) == KEPT:
            self._forget()
        self._kept.append((self._number, self._latest, side, what))
        self._characters += _size(what)
        while self._characters > KEPT_CHARACTERS and len(self._kept) > 1:
            self._forget()
        if isinstance(what, bytes):
            self._said(self._latest, side, what)

    def _forget(self) -> None:
        self._characters -= _size(self._kept.popleft()[3])


def _size(what: bytes | Damage) -> int:
    return len(what) if isinstance(what, bytes) else 1
