"""Figures of issue 3 in small: 20,000 telegrams over all dialect pairs, every single fault, both stations at once (whole: make soak)."""

import pytest

from hil_tests.soak.conflicts import Meeting, by_default
from hil_tests.soak.exhaustive import exhaust
from hil_tests.soak.pairs import PAYLOADS, soak
from protocols.base.machine import ms
from protocols.p3964r.profiles import PROFILES, Priority, Profile

ROUNDS = 1000
SPOILED = "a spoiled character reads 10h"  # the one way in which a telegram may be acknowledged and not taken


def test_20000_telegrams_over_all_dialect_pairs_nothing_detectable_wrong_or_lost(capsys: pytest.CaptureFixture[str]) -> None:
    checked, plain = soak(20_000)
    telegrams, faulted = checked.telegrams + plain.telegrams, checked.faulted + plain.faulted
    with capsys.disabled():
        print(f"\nsoak: {telegrams} telegrams, {faulted} of them faulted, {checked.link_missed} unseen by the block check")
    assert telegrams >= 20_000 and faulted >= telegrams / 10
    for tally in (checked, plain):
        assert tally.wrong == [] and tally.lost == []
        assert len(tally.faults) == 8 and set(tally.link_acknowledged) <= {SPOILED}
        assert len(tally.roles) == 9 and min(tally.roles.values()) > 10
        assert max(tally.payloads.values()) < 1.2 * min(tally.payloads.values()) and set(tally.payloads) == set(PAYLOADS)
    assert 0 < checked.link_missed < checked.faulted / 8 and plain.link_missed > plain.faulted / 8  # counted, not excluded
    assert sum(checked.rk512_missed.values()) < checked.jobs / 200
    assert all("without reactions" in why for why in checked.rk512_missed)  # RK512's own lengths and sequence show the rest


def test_every_single_fault_at_every_place_of_every_golden_telegram(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = exhaust()
    with capsys.disabled():
        print(f"\n{outcome.cases} single faults in golden telegrams, {outcome.link} unseen by the block check, {outcome.rk512} by RK512")
    assert outcome.cases == 52_983 and outcome.bad == []
    assert outcome.link == 274 and outcome.rk512 == 0  # a lost, doubled or added 00h; RK512 sees each by its length


@pytest.mark.parametrize("left, right", list(by_default()), ids=lambda profile: profile.name)
def test_both_send_at_once_1000_rounds(left: Profile, right: Profile) -> None:
    """Every pair of dialects whose own priorities differ."""

    meeting = Meeting(left, right, (Priority.HIGH, Priority.LOW)).rounds(ROUNDS)
    assert meeting.complete(ROUNDS), f"{meeting.name}: {meeting.sent} sent, {meeting.failed} failed"
    # the Linux discipline takes the other's NAK at the start for an answer, and gives way in the repeat, as the other does (AX-653)
    both_give_way = left.yields_to_second_conflict and right.nak_at_start
    assert meeting.named == ([Priority.LOW] if both_give_way else [])


@pytest.mark.parametrize("name", sorted(PROFILES))
def test_both_send_at_once_1000_rounds_same_dialect(name: str) -> None:
    meeting = Meeting(PROFILES[name], PROFILES[name], (Priority.LOW, Priority.HIGH)).rounds(ROUNDS)
    assert meeting.complete(ROUNDS), f"{meeting.name}: {meeting.sent} sent, {meeting.failed} failed"


@pytest.mark.parametrize("priority", list(Priority))
def test_the_same_priority_at_both_ends_is_named_and_every_job_ends(priority: Priority) -> None:
    for left, right in by_default():
        meeting = Meeting(left, right, (priority, priority)).rounds(3, ms(90_000))
        assert set(meeting.named) == {priority}, meeting.name
        assert [sum(each) for each in zip(meeting.sent, meeting.failed, strict=True)] == [3, 3], meeting.name
