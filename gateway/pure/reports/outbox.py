"""Messages that wait for a partner: bounded, oldest dropped, counted; each is sent until it was confirmed (AX-428)."""

from collections import OrderedDict
from dataclasses import dataclass, field


@dataclass(slots=True)
class Outbox:
    """`keep` messages at most; `window` of them at once on their way."""

    keep: int
    window: int = 20
    dropped: int = 0  # since the start
    number: int = 0  # of the newest
    _waiting: OrderedDict[int, str] = field(default_factory=OrderedDict)
    _sent: OrderedDict[int, str] = field(default_factory=OrderedDict)

    def put(self, number: int, text: str) -> None:
        """A new message; the oldest that is not on its way is dropped when there are too many."""
        self.number = number
        self._waiting[number] = text
        while len(self._waiting) + len(self._sent) > self.keep and self._waiting:
            self._waiting.popitem(last=False)
            self.dropped += 1

    def next(self) -> tuple[int, str] | None:
        """The oldest message that may go now; it counts as on its way."""
        if not self._waiting or len(self._sent) >= self.window:
            return None
        number, text = self._waiting.popitem(last=False)
        self._sent[number] = text
        return number, text

    def confirmed(self, number: int) -> None:
        """The partner has it."""
        self._sent.pop(number, None)

    def __len__(self) -> int:
        return len(self._waiting) + len(self._sent)
