"""3964R: complete stations with one fault each, and what they answer instead (used by peers.p3964r)."""

from collections.abc import Sequence

from gateway.conformance.peers.p3964r_senders import LateDleOpens
from gateway.conformance.peers.stations import (
    DLE,
    NAK,
    OWN_BLOCK,
    STX,
    Built,
    fresh_link,
)
from gateway.conformance.serial.partners import (
    DropsItsJob,
    NeverDoubles,
    counts_once,
)
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char, check_of
from protocols.p3964r.events import BlockReceived, BlockRefused, BlockSent, SendFailed
from protocols.p3964r.profiles import RHO3, Priority
from protocols.p3964r.sender import State as Saying


class LateDle(Built):
    """A DLE after it gave up brings the block."""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        sender = self.link._sender
        if data == DLE and not sender.busy and not self.link._receiver.busy and isinstance(sender, LateDleOpens) and sender._lost_block:
            lost, sender._lost_block = sender._lost_block, b""
            self.link._box.output += lost + DLE + bytes((Char.ETX,))
            return []
        return super().receive(data, now)


class GivesUpForEver(Built):
    """After a job that it gave up no job is sent any more."""

    _over = False

    def _handle(self, events: Sequence[object], now: Ns) -> Sequence[object]:
        self._over = self._over or any(isinstance(event, SendFailed) for event in events)
        return super()._handle(events, now)

    def stimulate(self, now: Ns, block: bytes = OWN_BLOCK) -> None:
        if not self._over:
            super().stimulate(now, block)


class BreakHangs(Built):
    """After a BREAK in idle it receives nothing any more."""

    _hung = False

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        self._hung = self._hung or kind is Damage.BREAK
        return super().damaged(kind, now)

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return [] if self._hung else super().receive(data, now)


class BreakUnheard(Built):
    """A BREAK is not seen at all."""

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        return [] if kind is Damage.BREAK else super().damaged(kind, now)


class ResetsOnConflict(Built):
    """Forgets the line when both send STX: no answer, no job."""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        if data == STX and self.link._sender.state is Saying.CONNECT:
            fresh_link(self, self.priority)
            return []
        return super().receive(data, now)


# ---- what is sent
def seven_bits(byte: int) -> bytes:
    return bytes((byte & 0x7F,))


def extra(output: bytes) -> bytes:
    return output + b"\r" if is_block(output) else output


def is_block(output: bytes) -> bool:
    return len(output) >= 4 and bytes((Char.DLE, Char.ETX)) in output


def complement(block: bytes) -> int:
    return block[-1] ^ 0xFF


def wrong_own_check(output: bytes) -> bytes:
    return output[:-1] + bytes((output[-1] ^ 0x40,)) if is_block(output) else output


def wrong_reaction_check(output: bytes) -> bytes:
    return output[:-1] + bytes((output[-1] ^ 0x01,)) if is_block(output) and output[:3] == bytes(3) else output


def wrong_long_check(output: bytes) -> bytes:
    return output[:-1] + bytes((output[-1] ^ 0x01,)) if is_block(output) and len(output) > 100 else output


def check_counts_once(output: bytes) -> bytes:
    return output[:-1] + bytes((counts_once(output),)) if is_block(output) else output


def check_doubled(output: bytes) -> bytes:
    return output + output[-1:] if is_block(output) and output[-1] == Char.DLE else output


def check_without_end(output: bytes) -> bytes:
    return output[:-1] + bytes((check_of(output[:-3]),)) if is_block(output) else output


def no_check(output: bytes) -> bytes:
    return output[:-1] if is_block(output) else output


def no_end(output: bytes) -> bytes:
    return output[:-3] if is_block(output) else output


class DeafAfter(Built):
    """Ignores STX for a while after such an event."""

    def __init__(self, event: type[BlockSent] | type[BlockRefused], how_long: Ns) -> None:
        super().__init__(RHO3, Priority.LOW)
        self._event, self._how_long, self._until = event, how_long, 0

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        if now < self._until and data == STX:
            return []
        events = super().receive(data, now)
        if any(isinstance(event, self._event) for event in events):
            self._until = now + self._how_long
        return events


class _OddStx(Built):
    """Every other STX, from the first one on, is not accepted: the answer is `reply` instead of DLE."""

    reply = b""
    _heard = b""
    _count = 0

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        self._heard = data
        return super().receive(data, now)

    def take_output(self) -> bytes:
        output = super().take_output()
        if self._heard == STX and output == DLE:
            self._count += 1
            if self._count % 2:
                fresh_link(self, Priority.LOW)
                return self.reply
        return output


class NaksFirstStx(_OddStx):
    """NAK to an STX, DLE to the one that follows."""

    reply = NAK


class EverySecondStx(_OddStx):
    """One STX of two is not received."""


class DleTwice(Built):
    """Acknowledges a block with two DLE."""

    _good = False

    def _handle(self, events: Sequence[object], now: Ns) -> Sequence[object]:
        self._good = self._good or any(isinstance(event, BlockReceived) for event in events)
        return super()._handle(events, now)

    def take_output(self) -> bytes:
        output = super().take_output()
        twice = self._good and output[:1] == DLE
        self._good = self._good and not output
        return DLE + output if twice else output


class Hurried(Built):
    """Correct; its commands of RK512 do not wait for the reaction to the one before."""

    def stimulate(self, now: Ns, block: bytes = b"\0\0ED\x05\0\0\x02\xff\xff") -> None:
        super().stimulate(now, block)


class NakTwice(Built):
    """Refuses with two NAK."""

    def take_output(self) -> bytes:
        output = super().take_output()
        return NAK + NAK if output == NAK else output


class WedgesInARow(Built):
    """The twelfth job within ten seconds, and all after it, are not sent."""

    def __init__(self) -> None:
        super().__init__(RHO3, Priority.LOW)
        self._moments: list[Ns] = []

    def stimulate(self, now: Ns, block: bytes = OWN_BLOCK) -> None:
        self._moments = [moment for moment in self._moments if now - moment < ms(10_000)] + [now]
        if len(self._moments) < 12:
            super().stimulate(now, block)


class FlipsPriority(Built):
    """Each conflict changes its priority."""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        met = data == STX and self.link._sender.state is Saying.CONNECT
        events = super().receive(data, now)
        if met:
            self._met += 1
            self.link._sender._priority = Priority.HIGH if self._met % 3 == 0 else Priority.LOW
        return events

    _met = 0


class NeverDoublesDle(NeverDoubles, Built):
    """Sends a DLE of its data once."""


class NakOpens(Built):
    """NAK in idle makes it send STX, and nothing after it."""

    _opens = False

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        idle = self.link.deadline() is None and not self.link.pending
        self._opens = data == NAK and idle
        return super().receive(data, now)

    def take_output(self) -> bytes:
        output = super().take_output()
        opens, self._opens = self._opens, False
        return output or (STX if opens else b"")


class Echoes(Built):
    """Echoes each character, as on a line whose wires touch."""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        self._back = data
        return super().receive(data, now)

    def take_output(self) -> bytes:
        back, self._back = self._back, b""
        return back + super().take_output()

    _back = b""


class Crowded(Built):
    """Correct; queues three jobs of its own."""

    def stimulate(self, now: Ns, block: bytes = OWN_BLOCK) -> None:
        for number in range(3):
            super().stimulate(now, block + bytes((number,)))


class NaksSecondDle(Built):
    """Correct; a second DLE to its STX is a stray character, answered with NAK after its block."""

    _opened: Ns = -ms(100)
    _second = _due = False

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        if data == DLE and self.link._sender.state is Saying.CONNECT:
            self._opened = now
        elif data == DLE and now - self._opened < ms(3):
            self._second = True
            return []
        events = super().receive(data, now)
        self._due = self._second and any(isinstance(event, BlockSent) for event in events)
        self._second = self._second and not self._due
        return events

    def take_output(self) -> bytes:
        due, self._due = self._due, False
        return super().take_output() + (NAK if due else b"")


class Drops(DropsItsJob, Built):
    pass
