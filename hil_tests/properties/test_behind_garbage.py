"""Garbage on the line, then a foreign station with a block: it is delivered as it was sent, within 2 s, and at most once."""

from collections.abc import Callable, Sequence
from random import Random

import pytest

from hil_tests.lab.partners.strict_station import StrictStation, framed
from hil_tests.lab.virtual.virtual_line import VirtualLine
from protocols.base.machine import Damage, Machine, Ns, ms
from protocols.p3964r.events import BlockReceived, Event
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, Priority

ROUNDS = 486
CHARACTER = 11_000_000_000 // 9600
LATE = ms(1) // 5
BLOCK = b"HELLO\x10"
CONTROLS = b"\x02\x10\x15\x03A"
PAUSES = (0, 0, ms(1), ms(2), ms(5), ms(100), ms(150), ms(215), ms(219), ms(220), ms(221), ms(222), ms(300), ms(1000))


class LateReport:
    """Our station at a port that reports a little late that all has left, as ports do: a character may come in between."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._left: Ns | None = None

    def sent(self, now: Ns) -> Sequence[Event]:
        self._left = now + LATE
        return []

    def wake(self, now: Ns) -> Sequence[Event]:
        events = list(self._report(now))
        return [*events, *self._link.wake(now)]

    def receive(self, data: bytes, now: Ns) -> Sequence[Event]:
        return [*self._report(now), *self._link.receive(data, now)]

    def damaged(self, kind: Damage, now: Ns) -> Sequence[Event]:
        return [*self._report(now), *self._link.damaged(kind, now)]

    def deadline(self) -> Ns | None:
        return min((due for due in (self._left, self._link.deadline()) if due is not None), default=None)

    def take_output(self) -> bytes:
        return self._link.take_output()

    def lost(self, now: Ns) -> Sequence[Event]:
        return self._link.lost(now)

    def _report(self, now: Ns) -> Sequence[Event]:
        if self._left is None or now < self._left:
            return []
        self._left = None
        return self._link.sent(now)


def controls(random: Random) -> bytes:
    return bytes(random.choice(CONTROLS) for _ in range(random.randint(1, 5)))


def noise(random: Random) -> bytes:
    return random.randbytes(random.randint(1, 40))


def torn(random: Random) -> bytes:
    """The front of a block, the middle of one, or one with a wrong check."""
    whole = b"\x02" + framed(bytes(random.choice(CONTROLS + b"\0") for _ in range(random.randint(1, 30))))
    spoiled = whole[:-1] + bytes((whole[-1] ^ 5,))
    begin = random.choice((0, 0, 1, 2))
    return random.choice((whole[: random.randint(1, len(whole))], spoiled))[begin:] or b"A"


KINDS: tuple[Callable[[Random], bytes], ...] = (controls, noise, torn)


def play(profile: str, seed: int) -> str:
    """One round; what is wrong with it."""
    random = Random(seed)
    high = random.random() < 0.5
    us = LateReport(Link(PROFILES[profile], Priority.LOW if high else Priority.HIGH))
    foreign = StrictStation(
        ms(random.choice((550, 2000))), ms(220), high, random.random() < 0.5, ms(random.choice((0, 0, 100))), random.random() < 0.3
    )
    taken = list[bytes]()

    def note(_side: int, event: object, _now: Ns) -> None:
        if isinstance(event, BlockReceived):
            taken.append(event.data)

    machines: tuple[Machine[object], Machine[object]] = (us, foreign)
    line = VirtualLine[object](*machines, note, char_time=CHARACTER, burst=random.choice((1, 1, 4, 16)))
    line.kick(0)
    line.run(ms(500))
    garbage = random.choice(KINDS)(random)
    while garbage.endswith(b"\x02\x02"):  # with a third STX at once behind it nothing tells two of them from data: they cancel in the check
        garbage = garbage[:-1]
    cut = random.randint(0, len(garbage)) if random.random() < 0.3 else 0
    if cut:
        foreign.out += garbage[:cut]
        line.kick(1)
        line.run(line.now + ms(random.choice((50, 215, 300))))
    foreign.out += garbage[cut:]
    line.kick(1)
    line.run(line.now + (len(garbage) - cut) * CHARACTER + random.choice(PAUSES) + random.randrange(CHARACTER))
    begun = line.now
    taken.clear()
    foreign.want(BLOCK)
    line.kick(1)
    line.run(begun + ms(4000))  # to its end: a second delivery counts
    if foreign.done_at is None or foreign.done_at - begun > ms(2000):
        return f"{garbage.hex(' ')}: after {foreign.done_at and (foreign.done_at - begun) // ms(1)} ms"
    return "" if taken == [BLOCK] else f"{garbage.hex(' ')}: {taken}"


@pytest.mark.parametrize("profile", ["siemens-cp341", "rho3", "vipa-cp240"])
def test_a_foreign_station_is_served_within_two_seconds_of_any_garbage(profile: str) -> None:
    assert [(seed, wrong) for seed in range(ROUNDS) if (wrong := play(profile, seed))] == []
