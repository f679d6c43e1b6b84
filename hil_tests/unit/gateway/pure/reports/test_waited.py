"""AX-915: a stretched simulation reports that its machine was late, and fills no journal with it."""

from gateway.pure.reports.waited import EVERY_NS, WaitedTime
from protocols.base.machine import ms

P5 = ms(4)


def test_what_drives_would_have_stopped_for_is_reported_at_once_and_then_each_minute_in_one_sentence() -> None:
    waited = WaitedTime(P5)
    assert waited.take_words(0) == ""
    waited.late(ms(38))
    assert waited.take_words(ms(100)) == "this machine was late: simulated time waited 38 ms, at most 38 ms at once"
    for by_ms in (8, 20, 12):
        waited.late(ms(by_ms))
        assert waited.take_words(ms(200)) == "", "not before a minute is over"
    assert waited.take_words(ms(100) + EVERY_NS) == "this machine was late: simulated time waited 40 ms, at most 20 ms at once"
    assert waited.take_words(ms(200) + 2 * EVERY_NS) == "", "in time since then"


def test_what_no_drive_notices_is_not_reported() -> None:
    waited = WaitedTime(P5)
    waited.late(2 * P5 - 1)
    assert waited.take_words(0) == ""
    waited.late(2 * P5)
    assert waited.take_words(0).endswith("at most 8 ms at once")
