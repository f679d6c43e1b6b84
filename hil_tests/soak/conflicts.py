"""Both stations send at the same moment, round after round: with opposite priorities every block arrives once, in order, both ways."""

from collections.abc import Iterator

from hil_tests.lab.virtual.virtual_line import VirtualLine
from protocols.base.machine import Ns, ms
from protocols.p3964r.events import BlockReceived, BlockSent, Event, SamePriority, SendFailed
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, Priority, Profile


class Meeting:
    """Two links with the priorities given; what each got, and what its own jobs came to."""

    def __init__(self, left: Profile, right: Profile, priorities: tuple[Priority, Priority]) -> None:
        self.name = f"{left.name} {priorities[0].name} / {right.name} {priorities[1].name}"
        self.links = Link(left, priorities[0]), Link(right, priorities[1])
        self.got: tuple[list[bytes], list[bytes]] = ([], [])
        self.sent = [0, 0]
        self.failed = [0, 0]
        self.named: list[Priority] = []  # what "both stations have the same priority" was said of
        self._line = VirtualLine[Event](*self.links, self._note)

    def _note(self, side: int, event: Event, now: Ns) -> None:
        if isinstance(event, BlockReceived):
            self.got[side].append(event.data)
        elif isinstance(event, SamePriority):
            self.named.append(event.priority)
        self.sent[side] += isinstance(event, BlockSent)
        self.failed[side] += isinstance(event, SendFailed)

    def rounds(self, count: int, each: Ns = ms(300)) -> "Meeting":
        for number in range(count):
            for side in (0, 1):
                self.links[side].send(number.to_bytes(2, "big"), self._line.now)
            for side in (0, 1):
                self._line.kick(side)
            self._line.run(self._line.now + each)
        return self

    def complete(self, count: int) -> bool:
        """Every block arrived once and in order, and its sender knows."""
        wanted = [number.to_bytes(2, "big") for number in range(count)]
        return self.got == (wanted, wanted) and self.sent == [count, count] and self.failed == [0, 0]


def by_default() -> Iterator[tuple[Profile, Profile]]:
    """The pairs whose own priorities differ: the left one has it."""
    yield from ((a, b) for a in PROFILES.values() for b in PROFILES.values() if a.priority is Priority.HIGH and b.priority is Priority.LOW)


def all_pairs() -> Iterator[tuple[Profile, Profile]]:
    """Any station set to high against any set to low."""
    yield from ((a, b) for a in PROFILES.values() for b in PROFILES.values())


def conflicts(rounds: int) -> tuple[int, list[str]]:
    """Over all pairs; how many pairs, and which were not complete."""
    pairs = list(all_pairs())
    meetings = (Meeting(left, right, (Priority.HIGH, Priority.LOW)).rounds(rounds) for left, right in pairs)
    return len(pairs), [meeting.name for meeting in meetings if not meeting.complete(rounds)]
