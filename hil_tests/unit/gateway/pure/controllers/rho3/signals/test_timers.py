"""Timers and counters behind flags.  rho 3 release manual, TO03 chapter 10 (L4070-4113)."""

import pytest

from gateway.pure.controllers.rho3.signals.timers import TimersAndCounters, flags_of, unit_of
from gateway.pure.image.records.cell import get_bit, set_bit
from protocols.base.machine import ms


def m(byte: int, bit: int) -> int:
    return byte * 8 + bit


class Pic:
    def __init__(self, count: int = 32, reset_as_printed: bool = False) -> None:
        self.flags = bytearray(128)
        self.unit = TimersAndCounters(count, [3] * count, [2] * count, ms(10), reset_as_printed)

    def pulse(self, flag: int) -> None:
        for value in (False, True, True):
            set_bit(self.flags, flag, value)
            self.unit.step(self.flags, ms(10))

    def holds(self, flag: int, value: bool, times: int = 1) -> None:
        set_bit(self.flags, flag, value)
        for _ in range(times):
            self.unit.step(self.flags, ms(10))


@pytest.mark.requirement("RHO-PLC-27", by="gateway.pure.controllers.rho3.signals.timers:TimersAndCounters._count")
def test_10_1_stage_1_counter_11() -> None:
    pic = Pic(16)
    pic.pulse(m(6, 3))
    assert pic.unit.counters[11] == 1 and not get_bit(pic.flags, m(7, 3))
    pic.pulse(m(6, 3))
    assert pic.unit.counters[11] == 0 and get_bit(pic.flags, m(7, 3))
    pic.pulse(m(6, 3))
    assert pic.unit.counters[11] == 0
    pic.holds(m(11, 3), True)
    assert pic.unit.counters[11] == 2 and not get_bit(pic.flags, m(7, 3))
    pic.pulse(m(6, 3))
    assert pic.unit.counters[11] == 2  # the reset flag stands
    assert pic.unit.counters[10] == pic.unit.counters[3] == 2


@pytest.mark.requirement("RHO-PLC-27", by="gateway.pure.controllers.rho3.signals.timers:flags_of")
def test_10_1_flags_of_every_stage() -> None:
    table = {0: (0, 1, 2, 3, 4, 5), 8: (6, 7, 8, 9, 10, 11), 16: (12, 13, 14, 15, 16, 17), 24: (18, 19, 20, 21, 22, 23)}
    for first, at in table.items():
        for bit in range(8):
            own = flags_of(first + bit)
            told = (own.decrement, own.ready, own.start, own.timer_ready, own.active, own.reset)
            assert told == tuple(m(byte, bit) for byte in at)
    assert flags_of(27, reset_as_printed=True).reset == m(17, 3)
    with pytest.raises(ValueError, match=r"0\.\.31"):
        flags_of(32)


@pytest.mark.requirement("RHO-PLC-27", by="gateway.pure.controllers.rho3.signals.timers:TimersAndCounters._time")
def test_10_1_a_timer_is_active_then_ready() -> None:
    pic = Pic(24)
    start, ready, active = m(14, 5), m(15, 5), m(16, 5)  # timer 21
    pic.holds(start, True)
    assert (get_bit(pic.flags, active), get_bit(pic.flags, ready)) == (True, False)
    pic.holds(start, True, 2)
    assert (get_bit(pic.flags, active), get_bit(pic.flags, ready)) == (True, False)
    pic.holds(start, True)
    assert (get_bit(pic.flags, active), get_bit(pic.flags, ready)) == (False, True)
    pic.holds(start, False)
    assert (get_bit(pic.flags, active), get_bit(pic.flags, ready)) == (False, False)
    pic.holds(start, True, 2)
    pic.holds(start, False)
    assert not get_bit(pic.flags, active)
    pic.holds(start, True)
    assert pic.unit.left[21] == ms(30)  # it begins anew


@pytest.mark.requirement("RHO-PLC-28", by="gateway.pure.controllers.rho3.signals.timers:unit_of")
def test_10_the_unit_of_time_depends_on_the_control() -> None:
    assert unit_of("rho3.1", ms(20)) == ms(20)
    assert unit_of("rho3.2", ms(20)) == ms(10)
    assert unit_of("rho3.2", ms(20), ms(12)) == ms(12)
    for control, cycles in (("rho3.1", 4), ("rho3.2", 2)):
        unit = TimersAndCounters(8, [2], [], unit_of(control, ms(20)))
        flags = bytearray(128)
        set_bit(flags, m(2, 0), True)
        for _ in range(cycles):
            unit.step(flags, ms(10))
            assert not get_bit(flags, m(3, 0)), (control, cycles)
        unit.step(flags, ms(10))
        assert get_bit(flags, m(3, 0)), (control, cycles)
    with pytest.raises(ValueError, match=r"rho3\.0"):
        unit_of("rho4", ms(20))


def test_wrong_numbers_are_refused() -> None:
    for count, values in ((7, []), (8, [1] * 9), (8, [-1])):
        with pytest.raises(ValueError, match=r"P3|P13/P14"):
            TimersAndCounters(count, values, [], ms(10))
    fresh = Pic(8)
    set_bit(fresh.flags, 0, True)
    fresh.unit.step(fresh.flags, ms(10))
    assert fresh.unit.counters[0] == 2  # a decrement flag that stands at start is no pulse
