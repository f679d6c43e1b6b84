"""Two byte machines over a faulty line in virtual time.  One seed gives one run, bit for bit; an hour takes seconds.

A character takes `char_time` on the line.  Characters are handed over in bursts of at most `burst` of them, when the last of a burst has
come in, as a UART with a FIFO does; `sent` is called when the last character given out has left.  Knows no protocol; an exception inside a
machine is a failed assertion.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Generic, TypeVar

from protocols.base.machine import Damage, Machine, Ns

E = TypeVar("E")


@dataclass(frozen=True, slots=True)
class Faults:
    """Probabilities for each character."""

    drop: float = 0.0  # it never arrives
    flip: float = 0.0  # one or two of its bits arrive wrong, unnoticed by the parity
    damage: float = 0.0  # it arrives as a parity or framing error
    delay: float = 0.0  # it and all after it arrive later
    longest_delay: Ns = 0  # several delays in one telegram do not add up

    @property
    def any(self) -> float:
        return self.drop + self.flip + self.damage + self.delay


NO_FAULTS = Faults()
NEVER = 1 << 62
MOST_REPEATS = 1000  # moments without time passing


@dataclass(slots=True)
class Counts:
    """What happened on one direction."""

    characters: int = 0
    dropped: int = 0
    flipped: int = 0
    damaged: int = 0
    delayed: int = 0


@dataclass(slots=True)
class _Way:
    """One direction: what is under way, oldest first."""

    random: Random
    under_way: deque[tuple[Ns, bytes | Damage]] = field(default_factory=deque)
    free_at: Ns = 0  # the last character given out has left
    sent_at: Ns | None = None
    late: Ns = 0  # added to the arrivals of what is given out now
    last_arrival: Ns = 0  # characters never overtake one another
    next_fault: int = 0  # characters until then
    counts: Counts = field(default_factory=Counts)


class VirtualLine(Generic[E]):
    """`run(until)`; events of both sides go to `on_event(side, event, now)`, side 0 left, 1 right."""

    def __init__(
        self,
        left: Machine[E],
        right: Machine[E],
        on_event: Callable[[int, E, Ns], None],
        seed: int = 0,
        faults: Faults = NO_FAULTS,
        char_time: Ns = 11_000_000_000 // 9600,
        burst: int = 16,
    ) -> None:
        self.machines = (left, right)
        self.now: Ns = 0
        self._repeats = 0
        self._on_event = on_event
        self._faults, self._char_time, self._burst = faults, char_time, burst
        self._ways = (_Way(Random(2 * seed)), _Way(Random(2 * seed + 1)))
        for way in self._ways:
            way.next_fault = self._gap(way)

    def counts(self, side: int) -> Counts:
        """Return the counts of what this side sends."""
        return self._ways[side].counts

    def kick(self, side: int) -> None:
        """Its machine was given something to do."""
        self._speak(side)

    def run(self, until: Ns) -> None:
        """Everything that happens up to and including this moment."""
        while (moment := self._next()) <= until:
            self._play(moment)
        self.now = max(self.now, until)

    def step(self) -> None:
        """The next moment at which something happens; RuntimeError when nothing ever will."""
        moment = self._next()
        if moment == NEVER:
            raise RuntimeError("neither side waits for anything")
        self._play(moment)

    # ---- inside
    def _play(self, moment: Ns) -> None:
        self._repeats = self._repeats + 1 if moment <= self.now else 0
        assert self._repeats < MOST_REPEATS, f"at {self.now / 1e6:.3f} ms: a deadline stands still"
        self.now = max(self.now, moment)
        try:
            self._serve(0)
            self._serve(1)
        except Exception as error:
            error.add_note(f"at {self.now / 1e6:.3f} ms")
            raise

    def _next(self) -> Ns:
        moment = NEVER
        for side in (0, 1):
            way, due = self._ways[side], self.machines[side].deadline()
            if due is not None and due < moment:
                moment = due
            if way.sent_at is not None and way.sent_at < moment:
                moment = way.sent_at
            if way.under_way and way.under_way[0][0] < moment:
                moment = way.under_way[0][0]
        return moment

    def _serve(self, side: int) -> None:
        machine, now = self.machines[side], self.now
        own, partners = self._ways[side], self._ways[1 - side]
        if own.sent_at is not None and own.sent_at <= now:
            own.sent_at = None
            self._tell(side, machine.sent(now))
        while partners.under_way and partners.under_way[0][0] <= now:
            item = partners.under_way.popleft()[1]
            self._tell(side, machine.receive(item, now) if isinstance(item, bytes) else machine.damaged(item, now))
        due = machine.deadline()
        if due is not None and due <= now:
            self._tell(side, machine.wake(now))

    def _tell(self, side: int, events: Sequence[E]) -> None:
        self._speak(side)
        for event in events:
            self._on_event(side, event, self.now)

    def _speak(self, side: int) -> None:
        data = self.machines[side].take_output()
        if not data:
            return
        way = self._ways[side]
        start = max(self.now, way.free_at)
        way.late = max(0, way.last_arrival - start)
        way.free_at = way.sent_at = start + len(data) * self._char_time
        way.counts.characters += len(data)
        at = 0
        while at < len(data):
            clean = min(len(data) - at, self._burst, way.next_fault)
            if clean:
                way.under_way.append((start + (at + clean) * self._char_time + way.late, data[at : at + clean]))
                at += clean
                way.next_fault -= clean
            else:
                at += 1
                self._spoil(way, data[at - 1], start + at * self._char_time)
                way.next_fault = self._gap(way)
        if way.under_way:
            way.last_arrival = way.under_way[-1][0]

    def _spoil(self, way: _Way, byte: int, arrival: Ns) -> None:
        faults, random = self._faults, way.random
        choice = random.random() * faults.any
        if choice < faults.drop:
            way.counts.dropped += 1
            return
        choice -= faults.drop
        if choice < faults.flip:
            way.counts.flipped += 1
            bits = 1 << random.randrange(8) | 1 << random.randrange(8)
            way.under_way.append((arrival + way.late, bytes((byte ^ bits,))))
        elif choice < faults.flip + faults.damage:
            way.counts.damaged += 1
            way.under_way.append((arrival + way.late, random.choice((Damage.PARITY, Damage.FRAMING))))
        else:
            way.counts.delayed += 1
            way.late = max(way.late, random.randrange(faults.longest_delay + 1))
            way.under_way.append((arrival + way.late, bytes((byte,))))

    def _gap(self, way: _Way) -> int:
        """Good characters before the next fault."""
        return int(way.random.expovariate(self._faults.any)) if self._faults.any > 0 else NEVER
