"""A hung process is found within its limit, one on a busy machine is not ended (gateway.pure.image.life_watch)."""

from gateway.pure.image.life_watch import BOUND, LifeWatch, Load
from protocols.base.machine import Ns, ms

LIMIT, LOOK = ms(250), ms(10)


def silent_until_dead(uses: float, *, wants: bool, look: Ns = LOOK, stamp: Ns = 0, bound: Ns = ms(60_000)) -> Ns:
    """When a process that beat at 0 and then uses that share of a processor is taken for dead."""
    watch, now, used = LifeWatch(LIMIT), 0, 0
    assert watch.look(0, 7, 0)
    while now < bound:
        now += look
        used += int(look * uses)
        load = Load(used, wants) if watch.wants_load(now, 7, stamp) else None
        if not watch.look(now, 7, stamp, load):
            return now
    return now


def test_one_that_sleeps_or_is_stopped_is_found_at_its_limit() -> None:
    assert LIMIT < silent_until_dead(0.0, wants=False) <= LIMIT + 2 * LOOK


def test_one_that_spins_is_found_at_its_limit() -> None:
    assert LIMIT < silent_until_dead(1.0, wants=True) <= LIMIT + 2 * LOOK


def test_one_that_gets_no_processor_is_not_ended_before_the_bound() -> None:
    assert LIMIT + BOUND < silent_until_dead(0.0, wants=True) <= LIMIT + BOUND + 2 * LOOK


def test_one_that_spins_on_a_busy_machine_is_found_when_it_has_used_its_limit() -> None:
    assert 4 * LIMIT * 0.7 < silent_until_dead(0.25, wants=True) <= 4 * LIMIT


def test_a_beat_begins_anew() -> None:
    watch, now = LifeWatch(LIMIT), 0
    for count in range(200):
        now += ms(200)  # each look finds it silent for 200 ms, then it beats
        assert watch.look(now - LOOK, count - 1, now - ms(200), None if count < 2 else Load(0, False))
        assert watch.look(now, count, now)
    assert watch.silence <= LOOK


def test_a_watcher_that_did_not_look_blames_nobody() -> None:
    watch = LifeWatch(LIMIT)
    assert watch.look(0, 7, 0)
    assert watch.look(ms(4_000), 7, 0, Load(0, False)), "the watcher was away, the process may have been, too"
    assert watch.starved == ms(3_950)


def test_without_a_figure_of_the_processor_silence_counts_as_before() -> None:
    watch, now = LifeWatch(LIMIT), 0
    assert watch.look(0, 7, 0)
    while watch.look(now := now + LOOK, 7, 0):
        pass
    assert LIMIT < now <= LIMIT + 2 * LOOK
