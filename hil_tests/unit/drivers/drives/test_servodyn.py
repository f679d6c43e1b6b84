"""AX-001 drives from the gateway's side: order of the bits, what is refused, what a loss or a fault means."""

from itertools import pairwise

import pytest

from drivers.drives.servodyn import LOST_AFTER, Demand, Drive, DriveSettings, Event, Phase, Power
from hil_tests.unit.drivers.drives.booster import Booster
from protocols.servodyn.codec import ActualValue, SetValue

OFF = Demand()


class Rig:
    """Drive and booster, one cycle at a time."""

    def __init__(self, settings: DriveSettings | None = None, position_inc: int = 1000) -> None:
        self.drive, self.booster = Drive(settings), Booster(position_inc)
        self.events: list[Event] = []
        self.cycles(OFF)

    def cycles(self, demand: Demand, count: int = 1, *, dead: bool = False) -> SetValue:
        value = SetValue()
        for _ in range(count):
            value = self.drive.step(None if dead else self.booster.actual, demand)
            self.events += self.drive.events
            if not dead:
                self.booster.hear(value)
        return value

    def power(self) -> Power:
        return self.drive.power

    def on(self) -> "Rig":
        for _ in range(20):
            self.cycles(Demand(on=True, position_inc=self.drive.set_inc))
        assert self.power() is Power.ENABLED
        self.events.clear()
        return self


def test_the_order_of_switching_on() -> None:
    rig = Rig()
    bits, phases = [], []
    for _ in range(12):
        value = rig.cycles(Demand(on=True, position_inc=1000))
        bits.append((value.drive_on, value.enable, value.brake_open))
        phases.append(rig.drive.phase)
    assert list(dict.fromkeys(bits)) == [(True, False, False), (True, True, True)]
    assert list(dict.fromkeys(phases)) == [Phase.POWERING, Phase.ENABLING, Phase.RELEASING, Phase.ENABLED]
    assert rig.booster.actual.brake_open
    assert rig.events == [Event.ENABLED]


def test_enable_is_never_sent_before_power_is_on() -> None:
    rig = Rig()
    rig.booster.deaf = True
    assert not rig.cycles(Demand(on=True), 50).enable
    assert rig.power() is Power.SWITCHING_ON


def test_a_demand_that_is_set_at_the_start_is_no_command() -> None:
    rig = Rig.__new__(Rig)
    rig.drive, rig.booster, rig.events = Drive(), Booster(), []
    assert not rig.cycles(Demand(on=True), 50).drive_on
    rig.cycles(OFF)
    rig.cycles(Demand(on=True, position_inc=1000), 20)
    assert rig.power() is Power.ENABLED


def test_the_order_of_switching_off() -> None:
    rig = Rig().on()
    bits = []
    for _ in range(8):
        value = rig.cycles(OFF)
        bits.append((value.drive_on, value.enable, value.brake_open))
    assert list(dict.fromkeys(bits)) == [(True, False, False), (False, False, False)]
    assert rig.power() is Power.OFF
    assert rig.events == [Event.OFF]


def test_switched_on_again_while_switching_off_comes_on_after_it() -> None:
    rig = Rig().on()
    rig.cycles(OFF)
    assert rig.power() is Power.SWITCHING_OFF
    rig.cycles(Demand(on=True, position_inc=1000), 20)
    assert rig.power() is Power.ENABLED


def test_the_set_position_follows_the_actual_one_until_enabled() -> None:
    rig = Rig()
    for position in (5, -77, 2_000_000):
        rig.booster.actual = rig.booster.actual._replace(position_inc=position)
        assert rig.cycles(Demand(position_inc=123)).position_inc == position
    while rig.drive.power is not Power.ENABLED:
        assert rig.cycles(Demand(on=True, position_inc=2_000_100)).position_inc in (2_000_000, 2_000_100)
    assert rig.cycles(Demand(on=True, position_inc=2_000_100)).position_inc == 2_000_100


def test_a_first_position_outside_the_jump_window_is_refused_and_reported_once() -> None:
    rig = Rig(DriveSettings(jump_inc=100)).on()
    rig.cycles(OFF, 20)
    rig.events.clear()
    value = rig.cycles(Demand(on=True, position_inc=1101, speed_rpm=50), 30)
    assert (value.position_inc, value.speed_rpm) == (1000, 0)
    assert rig.events == [Event.ENABLED, Event.JUMP]
    assert rig.cycles(Demand(on=True, position_inc=1100)).position_inc == 1100
    assert rig.cycles(Demand(on=True, position_inc=1300)).position_inc == 1300, "the window of later steps is the wider one"


def test_a_later_jump_is_held_back_too() -> None:
    rig = Rig(DriveSettings(step_inc=500)).on()
    assert rig.cycles(Demand(on=True, position_inc=1501)).position_inc == 1000
    assert rig.events == [Event.JUMP]
    assert rig.cycles(Demand(on=True, position_inc=1500)).position_inc == 1500


def test_positions_beyond_int32_are_refused() -> None:
    for edge, beyond in ((2**31 - 1, 2**31), (-(2**31), -(2**31) - 1)):
        rig = Rig(position_inc=edge - 10 if edge > 0 else edge + 10).on()
        assert rig.cycles(Demand(on=True, position_inc=edge)).position_inc == edge
        assert rig.cycles(Demand(on=True, position_inc=beyond)).position_inc == edge
        assert rig.events == [Event.RANGE]


def test_feed_forward_beyond_int16_is_cut() -> None:
    rig = Rig().on()
    assert rig.cycles(Demand(on=True, position_inc=1000, speed_rpm=-1500.4)).speed_rpm == -1500
    assert rig.cycles(Demand(on=True, position_inc=1000, speed_rpm=1e6)).speed_rpm == 32767


def test_no_feed_forward_without_control() -> None:
    assert Rig().cycles(Demand(speed_rpm=100)).speed_rpm == 0


def test_the_life_counter_rises_by_one_in_every_cycle_also_without_answers() -> None:
    rig = Rig()
    lives = [rig.cycles(OFF, dead=n % 3 == 0).life for n in range(600)]
    assert all((b - a) % 256 == 1 for a, b in pairwise(lives))


def test_one_missing_actual_value_is_survived_two_are_a_loss() -> None:
    rig = Rig().on()
    demand = Demand(on=True, position_inc=1010)
    assert rig.cycles(demand, LOST_AFTER - 1, dead=True).enable
    rig.cycles(demand)
    assert rig.drive.missing == 0
    value = rig.cycles(demand, LOST_AFTER, dead=True)
    assert (value.drive_on, value.enable, value.brake_open) == (False, False, False)
    assert (rig.drive.power, rig.events) == (Power.LOST, [Event.LOST])
    assert rig.drive.missing == LOST_AFTER


def test_after_a_loss_a_demand_that_is_still_set_starts_nothing_a_fresh_edge_does() -> None:
    rig = Rig().on()
    standing = Demand(on=True, position_inc=1000)
    rig.cycles(standing, 5, dead=True)
    rig.cycles(OFF, dead=True)
    rig.cycles(standing, dead=True)  # an edge while lost is none
    rig.cycles(standing, 50)
    assert (rig.drive.power, rig.events) == (Power.OFF, [Event.LOST, Event.RETURNED, Event.OFF])
    rig.cycles(OFF)
    rig.cycles(standing, 20)
    assert rig.power() is Power.ENABLED


def test_a_loss_opens_a_new_epoch_so_references_are_void() -> None:
    rig = Rig().on()
    before = rig.drive.epoch
    rig.cycles(OFF, LOST_AFTER - 1, dead=True)
    assert rig.drive.epoch == before
    rig.cycles(OFF, 10, dead=True)
    assert rig.drive.epoch == before + 1


def test_a_fault_takes_everything_back_and_needs_an_edge_of_reset_and_one_of_on() -> None:
    rig = Rig().on()
    standing = Demand(on=True, reset=True, position_inc=1000)
    rig.cycles(standing)  # reset stands from before the fault
    rig.booster.trip(42)
    value = rig.cycles(standing, 20)
    assert (value.drive_on, value.enable, value.fault_reset) == (False, False, False)
    assert (rig.drive.power, rig.drive.fault_code) == (Power.FAULT, 42)
    rig.cycles(Demand(on=True))
    assert rig.cycles(standing).fault_reset
    rig.cycles(standing, 20)
    assert rig.power() is Power.OFF
    assert rig.events == [Event.FAULT, Event.FAULT_CLEARED, Event.OFF]
    rig.cycles(OFF)
    rig.cycles(standing, 20)
    assert rig.power() is Power.ENABLED


def test_a_reset_pulse_of_one_cycle_lasts_long_enough_to_be_heard_and_ends() -> None:
    rig = Rig().on()
    rig.booster.trip(7)
    rig.cycles(OFF)
    rig.booster.deaf = True  # a fault that does not go
    sent = [rig.cycles(Demand(reset=True)).fault_reset] + [rig.cycles(OFF).fault_reset for _ in range(20)]
    assert sent.count(True) == 5
    assert sent[0]


def test_a_drive_that_leaves_control_by_itself_is_switched_off() -> None:
    rig = Rig().on()
    rig.booster.actual = rig.booster.actual._replace(enabled=False)
    rig.cycles(Demand(on=True, position_inc=1000), 30)
    assert (rig.drive.power, rig.events) == (Power.OFF, [Event.DROPPED, Event.OFF])


def test_a_phase_that_lasts_too_long_ends_in_off() -> None:
    rig = Rig(DriveSettings(timeout_cycles=10))
    rig.booster.brake_delay = 1000
    value = rig.cycles(Demand(on=True, position_inc=1000), 40)
    assert (rig.drive.power, rig.events) == (Power.OFF, [Event.TIMEOUT, Event.OFF])
    assert not value.drive_on


def test_a_drive_without_a_brake_does_not_wait_for_one() -> None:
    rig = Rig(DriveSettings(brake=False, timeout_cycles=10))
    rig.booster.brake_delay = 1000
    rig.cycles(Demand(on=True, position_inc=1000), 10)
    assert rig.power() is Power.ENABLED


def test_enable_limit_switch_is_passed_on() -> None:
    rig = Rig()
    assert rig.cycles(Demand(limit_switch=True)).limit_switch
    assert not rig.cycles(OFF).limit_switch


def without(actual: ActualValue, name: str) -> ActualValue:
    match name:
        case "power_on":
            return actual._replace(power_on=False)
        case "enabled":
            return actual._replace(enabled=False)
        case _:
            return actual._replace(brake_open=False)


@pytest.mark.parametrize("name", ["power_on", "enabled", "brake_open"])
def test_values_and_not_names_decide(name: str) -> None:
    """Without one of the three answers the drive is never enabled."""
    rig = Rig(DriveSettings(timeout_cycles=30))
    for _ in range(25):
        value = rig.drive.step(without(rig.booster.actual, name), Demand(on=True, position_inc=1000))
        rig.booster.hear(value)
        assert rig.power() is not Power.ENABLED
