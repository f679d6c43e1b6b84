"""Is the partner alive?  Judged by silence and by its life word, never by the link layer's own patience.

Source: users.md, "A stop over the line is not a stop".
"""

from dataclasses import dataclass
from enum import Enum, auto

from protocols.base.machine import Ns


class LinkEvent(Enum):
    """Event of a supervision."""

    ALIVE = auto()  # the first sign of life after a silence, or the very first
    SILENT = auto()


@dataclass(slots=True)
class LinkWatch:
    """A link is alive from its first telegram until `max_silence` without a changed life word (or, without one, without a telegram)."""

    max_silence: Ns
    has_life_word: bool
    alive: bool = False
    last_ns: Ns = 0
    losses: int = 0
    _life: int | None = None

    def telegram(self, now: Ns, life: int | None = None) -> LinkEvent | None:
        """A good telegram came; `life` is the life word's value if this telegram wrote it."""
        if self.has_life_word:
            if life is None or life == self._life:
                return None
            fresh = self._life is not None  # the first value only sets the counter
            self._life = life
            if not fresh:
                return None
        self.last_ns = now
        if self.alive:
            return None
        self.alive = True
        return LinkEvent.ALIVE

    def wake(self, now: Ns) -> LinkEvent | None:
        """Call at deadline(): reports once that the partner fell silent."""
        if not self.alive or now - self.last_ns < self.max_silence:
            return None
        self.alive = False
        self.losses += 1
        return LinkEvent.SILENT

    def deadline(self) -> Ns | None:
        """When silence would become a loss."""
        return self.last_ns + self.max_silence if self.alive else None
