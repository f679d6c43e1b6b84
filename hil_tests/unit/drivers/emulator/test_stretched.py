"""AX-681: simulated time waits for a SYNC that is late, and goes on without one that is missing."""

from hypothesis import given
from hypothesis import strategies as st

from drivers.emulator.servo.settings import INC_PER_TURN
from drivers.emulator.wire.stretched_time import HOLD_NS, StretchedTime
from hil_tests.lab.virtual.servodyn_bus import DriveBus
from protocols.base.machine import Frame, ms

P5, SYNC, OTHER = ms(10), 100, 7
SHORTEST, LONGEST = P5 - P5 // 8, P5 + P5 // 8


def heard(time: StretchedTime, stamp: int, identifier: int = SYNC) -> int:
    (frame,) = time.frames([Frame(identifier, b"", stamp)])
    return frame.stamp_ns


def test_a_late_sync_comes_one_period_and_a_little_after_the_one_before() -> None:
    time = StretchedTime(P5, {SYNC})
    assert heard(time, ms(100)) == ms(100) and heard(time, ms(110)) == ms(110)
    assert time.at(ms(115)) == ms(115) and not time.held(ms(121))
    assert time.at(ms(150)) == ms(110) + LONGEST and time.held(ms(150))
    assert heard(time, ms(150), OTHER) == ms(110) + LONGEST and time.cut_ns == 0
    assert heard(time, ms(160)) == ms(110) + LONGEST and time.cut_ns == ms(50) - LONGEST
    assert time.at(ms(163)) == ms(113) + LONGEST and not time.held(ms(163)), "and time goes on from there"
    assert heard(time, ms(170)) == ms(120) + LONGEST


def test_a_sync_right_behind_a_late_one_comes_a_period_after_it_less_a_little() -> None:
    """The cycle that waited for answers to a SYNC of 110 that arrived at 150 sends the next one at once."""
    time = StretchedTime(P5, {SYNC})
    heard(time, ms(100))
    assert heard(time, ms(150)) == ms(100) + LONGEST
    assert heard(time, ms(151)) == ms(100) + LONGEST + SHORTEST
    assert heard(time, ms(152)) == ms(100) + LONGEST + 2 * SHORTEST
    assert time.at(ms(155)) == ms(103) + LONGEST + 2 * SHORTEST, "and time goes on from there"


def test_no_more_time_comes_back_than_was_cut_out() -> None:
    time = StretchedTime(P5, {SYNC})
    heard(time, ms(100))
    assert heard(time, ms(113)) == ms(100) + LONGEST
    assert heard(time, ms(114)) == ms(114) and time.cut_ns == 0
    assert heard(time, ms(115)) == ms(115), "SYNCs that come too often are the sender's"


def test_drives_keep_to_a_fast_axis_on_a_machine_that_is_late() -> None:
    """Each tenth SYNC is 40 ms on its way and the next one follows at once: the set value goes a period further with each."""
    bus, time, count = DriveBus(p5_ms=10.0), StretchedTime(P5, {SYNC}), 0
    bus.enable()

    def path(_: float) -> float:
        """50 turns a second after one second; it counts SYNCs, as a cycle does."""
        seconds = count * P5 * 1e-9
        return INC_PER_TURN * (25.0 * seconds * seconds if seconds < 1.0 else 50.0 * seconds - 25.0)

    bus.move(path)
    wall = bus.now
    for count in range(300):
        late = ms(40) if count % 10 == 9 else 0
        (sync,) = time.frames([Frame(SYNC, b"", wall + late)])
        bus.now, wall = sync.stamp_ns, wall + late + (ms(1) if late else P5)
        bus.hand(sync)
        bus.hand(*bus.set_values())
        bus.slave.prepare()
        assert not bus.actual[1].fault_code, (count, bus.actual[1])


def test_a_sync_that_stays_away_is_missing_after_the_patience_with_it() -> None:
    time = StretchedTime(P5, {SYNC})
    heard(time, ms(100))
    stands = ms(100) + LONGEST
    assert time.at(ms(100) + HOLD_NS) == stands
    assert time.at(ms(100) + HOLD_NS + ms(1)) == stands + ms(1), "no time is lost twice"
    assert time.at(ms(100) + HOLD_NS + ms(500)) == stands + ms(500) and not time.held(ms(1_900))
    assert heard(time, ms(1_900)) == ms(1_900) - time.cut_ns and time.cut_ns == HOLD_NS - LONGEST


def test_before_the_first_sync_nothing_is_cut() -> None:
    time = StretchedTime(P5, {SYNC})
    assert time.at(ms(5_000)) == ms(5_000) and heard(time, ms(6_000), OTHER) == ms(6_000) and time.cut_ns == 0


@given(st.lists(st.tuples(st.sampled_from((SYNC, OTHER, 0)), st.integers(0, 400)), max_size=60))
def test_simulated_time_never_goes_back_and_never_runs_ahead(steps: list[tuple[int, int]]) -> None:
    time, now, before = StretchedTime(P5, {SYNC}), 0, 0
    for identifier, wait_ms in steps:
        now += ms(wait_ms)
        simulated = heard(time, now, identifier) if identifier else time.at(now)
        assert before <= simulated <= now
        before = simulated
