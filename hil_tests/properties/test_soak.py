"""Figures of issue 3 in small: 50,000 telegrams over all dialect pairs, every single fault, both stations at once (whole: make soak)."""

from itertools import pairwise

from hil_tests.lab.virtual_line import VirtualLine
from hil_tests.soak.exhaustive import exhaust
from hil_tests.soak.pairs import soak
from protocols.base.machine import Ns, ms
from protocols.p3964r.events import BlockReceived, BlockSent, Event
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, RHO3, Priority


def test_50000_telegrams_over_all_dialect_pairs_nothing_detectable_wrong_or_lost() -> None:
    tally = soak(50_000)
    assert tally.telegrams >= 50_000 and tally.faulted >= tally.telegrams / 10 and len(tally.faults) == 8
    assert tally.wrong == [] and tally.lost == []
    assert 0 < tally.rk512_missed < tally.jobs / 200 and tally.link_missed < tally.faulted / 8  # counted, not excluded


def test_every_single_fault_at_every_place_of_every_golden_telegram() -> None:
    outcome = exhaust()
    assert outcome.cases == 52_983 and outcome.bad == []
    assert outcome.link == 274 and outcome.rk512 == 0  # a lost, doubled or added 00h; RK512 sees each by its length


def test_both_send_at_once_1000_rounds() -> None:
    names = sorted(PROFILES)
    for left, right in ((RHO3, RHO3), *((PROFILES[a], PROFILES[b]) for a, b in pairwise(names))):
        rounds = 1000 if left is right else 60
        links = Link(left, Priority.HIGH), Link(right, Priority.LOW)
        got: tuple[list[bytes], list[bytes]] = ([], [])
        sent = [0, 0]

        def note(side: int, event: Event, now: Ns, got: tuple[list[bytes], list[bytes]] = got, sent: list[int] = sent) -> None:
            if isinstance(event, BlockReceived):
                got[side].append(event.data)
            sent[side] += isinstance(event, BlockSent)

        line = VirtualLine[Event](*links, note)
        for number in range(rounds):
            for side in (0, 1):
                links[side].send(number.to_bytes(2, "big"), line.now)
            for side in (0, 1):
                line.kick(side)
            line.run(line.now + ms(300))
        wanted = [number.to_bytes(2, "big") for number in range(rounds)]
        assert got == (wanted, wanted) and sent == [rounds, rounds], f"{left.name} / {right.name}"
