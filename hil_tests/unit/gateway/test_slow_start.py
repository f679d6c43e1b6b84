"""How long a process may start: a busy machine makes it long, a process that hangs or spins is found all the same."""

import pytest

from gateway.runtime import start_watch
from gateway.runtime.start_watch import LONGEST_NS, READY_NS, StartWatch

S = 1_000_000_000
FROM = 1000 * S


def last_moment(monkeypatch: pytest.MonkeyPatch, wants: bool, share: float) -> int:
    """Seconds after which its first sign of life is due, looked at once a second; `share`: of a processor that it gets."""
    watch, now = StartWatch(FROM), FROM
    monkeypatch.setattr(start_watch, "wants_processor", lambda _pid: wants)
    monkeypatch.setattr(start_watch, "processor_ns", lambda _pid: round((now - FROM) * share))
    while not watch.due(now, 1):
        now += S
        assert now < 2 * FROM
    return (now - FROM) // S


def test_a_start_that_sleeps_or_spins_is_over_after_its_patience(monkeypatch: pytest.MonkeyPatch) -> None:
    assert last_moment(monkeypatch, wants=False, share=0.0) == READY_NS // S
    assert last_moment(monkeypatch, wants=True, share=1.0) == READY_NS // S


def test_time_without_a_processor_does_not_count_but_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    assert 60 < last_moment(monkeypatch, wants=True, share=0.1) < LONGEST_NS // S
    assert last_moment(monkeypatch, wants=True, share=0.0) == LONGEST_NS // S


def test_one_that_is_about_to_be_started_again_is_not_due() -> None:
    assert not StartWatch(FROM).due(FROM + LONGEST_NS, None)
