"""The one-block buffer of the driver of 7.1: while it is full no further block is acknowledged."""

from protocols.base.machine import Ns


class BlockBuffer:
    """`keep_one`: a received block stays until it is read; otherwise its reader reports whether there is room."""

    def __init__(self, keep_one: bool, wait: Ns, poll: Ns) -> None:
        """`wait`: how long a wish to send waits for room, 0: not at all; `poll`: in which steps room is looked for, 0: at once."""
        self._keep_one, self.wait, self._poll = keep_one, wait, poll
        self.free = True
        self._asked_at: Ns = 0  # when STX found no buffer
        self._stored: bytes | None = None

    def store(self, block: bytes) -> None:
        """Received completely."""
        if self._keep_one:
            self._stored, self.free = block, False

    def take(self) -> bytes | None:
        """The stored block, once."""
        block, self._stored = self._stored, None
        return block

    def asked(self, now: Ns) -> Ns:
        """STX found no room; when the wait for it ends."""
        self._asked_at = now
        return self.last

    @property
    def last(self) -> Ns:
        """End of the wait."""
        return self._asked_at + self.wait

    def next_look(self, now: Ns) -> Ns | None:
        """There is room again: when that is noticed, this moment included; None: at once."""
        if self._poll == 0:
            return None
        return min(self.last, self._asked_at - (self._asked_at - now) // self._poll * self._poll)
