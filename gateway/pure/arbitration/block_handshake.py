"""The handshake of a line's data blocks: how a move is asked for and answered, in bits an old program has its words for.

start-busy-done is here; the other patterns are `gateway.pure.arbitration.handshakes`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from gateway.pure.arbitration.command_numbers import NUMBER, PARITY, START
from gateway.pure.arbitration.handshakes import Asked, Handshaking
from gateway.pure.image.reasons import CommandState


@dataclass(frozen=True, slots=True)
class HandshakeBits:
    """start-busy-done: the bits of one old program."""

    start: tuple[int, int, int] | None  # db, word, bit
    busy: tuple[int, int, int] | None
    done: tuple[int, int, int] | None
    refused: tuple[int, int, int] | None


class BlockHandshake:
    """`pattern`: None for start-busy-done; `bits`: where the answer is shown, None: no old program reads it."""

    def __init__(self, pattern: Handshaking | None, bits: HandshakeBits | None) -> None:
        self.pattern, self.bits = pattern, bits
        self.asked = Asked()  # the request, as received in telegrams since the link began
        self._move = CommandState.NONE
        self._answered = False  # the start bit has fallen: done and refused are taken back

    def restart(self) -> None:
        """Start of services or return of the link: the next telegram only sets the state of the bits (AX-141)."""
        self.asked = Asked()
        if self.pattern is not None:
            self.pattern.restart()

    def hear(self, levels: Mapping[str, float], fault: str) -> Asked:
        """Update the request from this telegram; values that it does not carry are unchanged.  fault: why its numbers are unusable."""
        old = self.asked
        self.asked = Asked(
            bool(levels.get(START, old.start)), round(levels.get(NUMBER, old.number)), bool(levels.get(PARITY, old.parity)), fault
        )
        return self.asked

    def begin(self) -> None:
        """A move or program is asked for."""
        self._answered = False

    def let_go(self) -> None:
        """The start bit has fallen."""
        self._answered = True

    def moved(self, state: CommandState) -> None:
        """What became of the last move; shown until the start bit falls."""
        self._move = state
        if self.pattern is not None:
            self.pattern.hear(state)

    def bit(self, key: str) -> bool:
        """busy, done, refused of the last move; done and refused fall with the start bit."""
        if self.pattern is not None:
            return self.pattern.bit(key)
        if key == "busy":
            return self._move in (CommandState.ACCEPTED, CommandState.RUNNING)
        if self._answered:
            return False
        return self._move is CommandState.DONE if key == "done" else self._move in (CommandState.REFUSED, CommandState.ABORTED)
