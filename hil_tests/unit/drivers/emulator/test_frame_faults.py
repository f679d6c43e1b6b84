"""Frames spoilt on order: which, how many, how; what is late comes at its time."""

from drivers.emulator.wire.frame_faults import FrameFaults, Kind, Order, Way
from protocols.base.machine import Frame, ms

SYNC = Frame(100, b"", ms(10))
SET = Frame(210, b"\1\2\3", ms(10))


def test_without_orders_everything_passes_untouched() -> None:
    faults = FrameFaults()
    assert faults.through(Way.IN, [SYNC, SET], ms(10)) == [SYNC, SET] and faults.idle and faults.due() is None


def test_drop_counts_and_ends() -> None:
    faults = FrameFaults()
    faults.order(Order(Kind.DROP, Way.IN, 2, 100))
    assert faults.through(Way.IN, [SYNC, SET, SYNC, SYNC], ms(10)) == [SET, SYNC]
    assert faults.idle and faults.spoilt[Kind.DROP] == 2


def test_the_other_way_is_not_touched() -> None:
    faults = FrameFaults()
    faults.order(Order(Kind.DROP, Way.OUT, 1))
    assert faults.through(Way.IN, [SYNC], ms(10)) == [SYNC]
    assert faults.through(Way.OUT, [SET], ms(10)) == []


def test_a_late_sync_comes_at_its_time_and_says_so_by_its_stamp() -> None:
    faults = FrameFaults()
    faults.order(Order(Kind.DELAY, Way.IN, 1, 100, ms(1.5)))
    assert faults.through(Way.IN, [SYNC, SET], ms(10)) == [SET]
    assert faults.due() == ms(11.5) and faults.through(Way.IN, [], ms(11)) == []
    later = Frame(220, b"", ms(11.2))
    assert faults.through(Way.IN, [later], ms(11.5)) == [later, SYNC._replace(stamp_ns=ms(11.5))]
    assert faults.idle


def test_late_answers_leave_when_due() -> None:
    faults = FrameFaults()
    faults.order(Order(Kind.DELAY, Way.OUT, 1, None, ms(2)))
    own = Frame(610, b"\0" * 8)
    assert faults.through(Way.OUT, [own], ms(10)) == [] and faults.due() == ms(12)
    assert [frame.data for frame in faults.through(Way.OUT, [], ms(12))] == [own.data]


def test_duplicate_and_corrupt() -> None:
    faults = FrameFaults()
    faults.order(Order(Kind.DUPLICATE, Way.IN, 1, 210))
    faults.order(Order(Kind.CORRUPT, Way.IN, 1, 210, byte=1, bits=0x10))
    assert faults.through(Way.IN, [SET, SET], ms(10)) == [SET, SET, SET._replace(data=b"\x01\x12\x03")]
    faults.order(Order(Kind.CORRUPT, Way.IN, 1, 100))
    assert faults.through(Way.IN, [SYNC], ms(10)) == [SYNC], "no data, nothing to alter"


def test_a_quiet_controller_hears_and_says_nothing_until_its_time() -> None:
    faults = FrameFaults()
    faults.quiet(ms(20))
    assert faults.through(Way.IN, [SYNC], ms(10)) == faults.through(Way.OUT, [SET], ms(15)) == []
    assert faults.silenced == 2
    assert faults.through(Way.IN, [SYNC], ms(20)) == [SYNC] and faults.idle


def test_clear_takes_orders_back() -> None:
    faults = FrameFaults()
    faults.order(Order(Kind.DROP, Way.IN, 100))
    faults.clear()
    assert faults.through(Way.IN, [SYNC], ms(10)) == [SYNC]
