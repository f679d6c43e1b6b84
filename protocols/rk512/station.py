"""Both roles on one link: assigns received blocks to a role, decides which telegram may leave.

Independent of the link: `block` accepts a received block, `take_block` returns the next one to send, `block_sent` and `block_failed` report
the outcomes in the same order.  Order of jobs: serial-protocols 2.6; repeated commands: AX-225; late reactions: AX-650.
"""

from collections import deque
from dataclasses import dataclass
from enum import Enum, auto

from protocols.base.machine import Ns
from protocols.rk512.active import Active, Trouble, Unasked
from protocols.rk512.active import Event as ActiveEvent
from protocols.rk512.dialects import Dialect
from protocols.rk512.header import FIRST, HEADER_BYTES, is_reaction
from protocols.rk512.passive import Event as PassiveEvent
from protocols.rk512.passive import Passive


@dataclass(frozen=True, slots=True)
class Repeated:
    """The same command again while its reaction is still on its way: the link repeated it; the one reaction answers both."""

    head: bytes


Event = ActiveEvent | PassiveEvent | Repeated


class _Out(Enum):
    COMMAND = auto()
    REACTION = auto()


class Station:
    """Pass received blocks to it; queue jobs at `active`."""

    def __init__(self, passive: Passive, active: Active, dialect: Dialect) -> None:
        self.passive, self.active, self._dialect = passive, active, dialect
        self._under_way: deque[_Out] = deque()
        self._last = b""  # the command whose reaction has not left
        self._untaken = False  # the last reaction was aborted

    def block(self, data: bytes, now: Ns, overtaken: bool = False) -> list[Event]:
        """A block of the link.  overtaken: the partner wished to send it before it had our last command (AX-242)."""
        if is_reaction(data):
            if overtaken:
                return [Unasked(data[:HEADER_BYTES])]  # the repeat of one we have, or too late for its own command
            return [*self.active.reaction(data, now)]
        events: list[Event] = []
        if self.active.awaiting and not self._looks_like_command(data):
            return [*self.active.reaction(data, now)]  # names the fault
        if not self._dialect.nesting:
            events += self.active.interrupted(now)
        if data and data == self._last:
            return [*events, Repeated(data[:HEADER_BYTES])]
        if data[:1] == bytes((FIRST,)) and (self._untaken or self.reactions):
            self.passive.forget()  # no sequence error: the partner does not know how far its last job came
        events += self.passive.telegram(data, now)
        self._last, self._untaken = data, False
        return events

    @property
    def reactions(self) -> int:
        """Pending reactions.  If more than one: all but the newest answer commands that their partner has aborted (AX-650)."""
        return self._under_way.count(_Out.REACTION)

    def replaced(self) -> None:
        """The link sends the latest block instead of the reaction before it."""
        self._under_way.pop()

    def take_block(self) -> bytes | None:
        """The next block for the link; a reaction goes before an own command."""
        for out, output in ((_Out.REACTION, self.passive.take_output), (_Out.COMMAND, self.active.take_output)):
            block = output()
            if block is not None:
                self._under_way.append(out)
                return block
        if _Out.REACTION not in self._under_way:
            self._last = b""  # nothing to send
        return None

    def block_sent(self, now: Ns) -> list[Event]:
        """The oldest block passed to the link is acknowledged."""
        if self._under_way.popleft() is _Out.COMMAND:
            return [*self.active.acknowledged(now)]
        self._last = b""
        return []

    def block_failed(self, now: Ns) -> list[Event]:
        """The oldest block passed to the link is aborted."""
        if self._under_way.popleft() is _Out.COMMAND:
            return [*self.active.unsent(now)]
        self._last, self._untaken = b"", True
        return []

    def lost(self) -> list[Event]:
        """The port is lost."""
        self.passive.lost()
        self._under_way.clear()
        self._last, self._untaken = b"", False
        return [*self.active.lost()]

    def _looks_like_command(self, data: bytes) -> bool:
        return len(data) > 2 and data[0] in (0x00, 0xFF) and data[2] in b"AEO"


__all__ = ["Event", "Repeated", "Station", "Trouble"]
