"""The CiA 402 drive from the gateway's side against the emulated one: order, one controlword, held position, homing, faults, losses."""

import struct

import pytest

from drivers.drives.cia402 import Cia402Actual, Cia402Drive, Cia402Settings, Mode, Phase
from drivers.drives.cia402_boot import Parameter
from drivers.drives.family import Demand, Event, Homing, Power
from drivers.emulator.cia402.states import State
from drivers.emulator.servo.settings import ServoSettings
from hil_tests.lab.virtual.one_node import NODE, OneNode
from protocols.canopen import nmt

HOME = Parameter(0x6098, 0, b"\x21", "method 33: next index pulse, negative")
SPEEDS = (Parameter(0x6099, 1, (40_000).to_bytes(4, "little"), "fast"), Parameter(0x6099, 2, (8_000).to_bytes(4, "little"), "slow"))


def rpdo1(rig: OneNode) -> tuple[int, int]:
    """Controlword and target of the last burst."""
    frame = next(frame for frame in rig.frames if frame.identifier == 0x200 + NODE)
    word, target = struct.unpack("<Hi", frame.data)
    return word, target


def emulated(rig: OneNode) -> State:
    return rig.slave.axis(NODE).state


def blocked(rig: OneNode) -> None:
    """A fault whose cause is gone at once."""
    rig.slave.cause(NODE, "motor_blocked", True)
    rig.slave.cause(NODE, "motor_blocked", False)


def test_on_by_6_7_15_and_the_target_is_the_actual_position_until_the_first_block() -> None:
    rig = OneNode().start()
    seen: list[tuple[int, bool, State]] = []

    def note() -> None:
        word, target = rpdo1(rig)
        assert rig.actual is not None
        seen.append((word, abs(target - rig.actual.position_inc) <= 2, emulated(rig)))

    for _ in range(60):
        rig.cycle(Demand(on=True, position_inc=rig.drive.set_inc))
        note()
    assert list(dict.fromkeys(word for word, _, _ in seen)) == [0x00, 0x06, 0x07, 0x0F]
    assert all(same for _, same, _ in seen), "607Ah = 6064h before and after the drive is switched on"
    assert rig.power() is Power.ENABLED and seen[-1][2] is State.ENABLED
    held = rig.drive.set_inc
    rig.cycles(50, Demand(on=True, position_inc=held))
    assert rpdo1(rig)[1] == held


def test_from_switched_on_the_target_is_kept_whatever_the_shaft_does_and_far_away_it_gives_up() -> None:
    drive = Cia402Drive()
    drive.step(Cia402Actual(0x0240, 1000, mode=8), Demand())
    steps = ((0x0240, 1000), (0x0221, 1010), (0x0223, 1020), (0x0223, 1030), (0x0227, 1040))
    sent = [drive.step(Cia402Actual(word, position, mode=8), Demand(on=True, position_inc=1010)) for word, position in steps]
    assert [(value.controlword, value.position_inc) for value in sent] == [(6, 1000), (7, 1010), (15, 1010), (15, 1010), (15, 1010)]
    assert drive.power is Power.ENABLED
    sagging = Cia402Drive(Cia402Settings(jump_inc=500))
    for word, position in ((0x0240, 0), (0x0221, 0), (0x0223, 0), (0x0223, 600)):
        value = sagging.step(Cia402Actual(word, position, mode=8), Demand(on=word != 0x0240))
    assert value.controlword == 0 and sagging.power is Power.SWITCHING_OFF


def test_an_axis_that_is_pushed_before_it_is_enabled_is_not_torn_back() -> None:
    rig = OneNode(settings=Cia402Settings(jump_inc=1000)).start()
    rig.on().cycles(20)
    assert rig.power() in (Power.OFF, Power.SWITCHING_OFF)
    rig.slave.jump_encoder(NODE, 5000)  # the shaft stands elsewhere now
    rig.cycles(5)
    for _ in range(80):
        rig.cycle(Demand(on=True, position_inc=rig.drive.set_inc))
        assert rig.actual is None or abs(rig.drive.set_inc - rig.actual.position_inc) < 100


def test_the_controlword_is_in_one_frame_only_and_the_mode_is_sent_beside_it() -> None:
    rig = OneNode().start().on()
    identifiers = [frame.identifier for frame in rig.frames]
    assert identifiers.count(0x200 + NODE) == 1 and 0x300 + NODE not in identifiers
    assert identifiers[0] == 0x80


def test_a_jump_is_not_sent_but_reported_once() -> None:
    rig = OneNode().start().on()
    held = rig.drive.set_inc
    rig.cycles(5, Demand(on=True, position_inc=held + 1_000_000))
    assert rig.drive.set_inc == held and rig.events.count(Event.JUMP) == 1


def test_off_is_a_quick_stop_along_its_ramp_and_then_switch_on_disabled() -> None:
    rig = OneNode().start().on().move(200_000, 100)
    words, states = [], []

    def note() -> None:
        words.append(rpdo1(rig)[0])
        states.append(emulated(rig))

    rig.cycles(100, Demand(on=False), note)
    assert 0x02 in words and words[-1] == 0x00
    assert State.QUICK_STOP in states and states[-1] is State.DISABLED
    assert rig.power() is Power.OFF


def test_a_demand_that_is_still_set_switches_nothing_on_after_a_fault_and_reset_wants_its_edge() -> None:
    rig = OneNode().start().on()
    blocked(rig)
    rig.cycles(30, Demand(on=True, position_inc=rig.drive.set_inc))
    assert rig.power() is Power.FAULT and rig.drive.fault_code == 0x7121
    rig.cycles(30, Demand(on=True, reset=True, position_inc=rig.drive.set_inc))
    assert rig.power() is Power.OFF, "reset by its edge, and a demand that was set all the time is not a command"
    assert Event.FAULT_CLEARED in rig.events
    blocked(rig)
    rig.cycles(60, Demand(reset=True))
    assert rig.power() is Power.FAULT, "the standing bit resets no second fault"


@pytest.mark.parametrize("deaf_cycles", [1, 2])
def test_one_missing_telegram_is_forgiven_two_are_a_loss(deaf_cycles: int) -> None:
    rig = OneNode().start().on()
    epoch = rig.drive.epoch
    rig.deaf = True
    rig.cycles(deaf_cycles, Demand(on=True, position_inc=rig.drive.set_inc))
    rig.deaf = False
    assert rig.power() is (Power.LOST if deaf_cycles == 2 else Power.ENABLED)
    assert rig.drive.epoch == epoch + (deaf_cycles == 2)
    rig.cycles(100, Demand(on=True, position_inc=rig.drive.set_inc))
    assert rig.power() is (Power.OFF if deaf_cycles == 2 else Power.ENABLED), "nothing comes back by itself"
    assert emulated(rig) is (State.DISABLED if deaf_cycles == 2 else State.ENABLED)


def test_a_node_that_was_reset_is_not_spoken_to_until_it_is_configured_again() -> None:
    rig = OneNode().start().on()
    rig.slave.reset_node(NODE)
    rig.cycles(60)
    assert rig.family.expected == 0
    assert all(frame.identifier != 0x200 + NODE for frame in rig.frames)
    assert rig.power() is Power.LOST and not rig.drive.configured
    rig.start()
    assert rig.power() is Power.OFF


def test_the_heartbeat_leaves_with_a_burst_and_keeps_the_drive_from_stopping() -> None:
    rig = OneNode().start().on()
    beats = 0

    def count() -> None:
        nonlocal beats
        beats += nmt.heartbeat(127, nmt.State.OPERATIONAL) in rig.frames

    rig.cycles(120, Demand(on=True, position_inc=rig.drive.set_inc), count)
    assert beats == 10 and emulated(rig) is State.ENABLED
    rig.family._beat = 1_000_000  # no burst brings one any more
    rig.cycles(60, Demand(on=True, position_inc=rig.drive.set_inc))
    assert emulated(rig) is not State.ENABLED, "150 ms without our heartbeat: the drive quick-stops by itself"
    assert rig.power() is not Power.ENABLED


# ---- homing by the drive -------------------------------------------------------------------------------------------


def homing_rig(settings: Cia402Settings | None = None, servo: ServoSettings | None = None) -> OneNode:
    return OneNode(servo, settings).start(HOME, *SPEEDS).on()


def test_the_drive_references_by_itself_and_comes_back_to_csp_at_rest() -> None:
    rig = homing_rig()
    modes: list[int] = []
    follows: list[bool] = []
    for _ in range(1500):
        rig.cycle(Demand(on=True, position_inc=rig.drive.set_inc, home=rig.drive.homing is not Homing.DONE))
        assert rig.actual is not None
        modes.append(rig.actual.mode)
        follows.append(rig.drive.follows)
        if rig.drive.homing is Homing.DONE:
            break
    assert rig.drive.homing is Homing.DONE
    assert list(dict.fromkeys(modes)) == [Mode.CSP, Mode.HM] and modes[-1] == Mode.CSP
    assert not any(follows[5:-1]) and rig.drive.follows
    assert rig.actual is not None and abs(rig.actual.position_inc) < 400, "607Ch = 0: it stands at home, near zero"
    assert abs(rig.drive.set_inc - rig.actual.position_inc) <= 2
    before = rig.slave.axis(NODE).servo.position_rad
    rig.cycles(100, Demand(on=True, position_inc=rig.drive.set_inc))
    assert abs(rig.slave.axis(NODE).servo.position_rad - before) < 1e-3, "the change of mode moves nothing"


def test_bit_4_rises_only_in_homing_mode_and_falls_before_csp() -> None:
    rig = homing_rig()
    pairs: set[tuple[bool, int]] = set()
    for _ in range(1500):
        rig.cycle(Demand(on=True, position_inc=rig.drive.set_inc, home=True))
        assert rig.actual is not None
        pairs.add((bool(rpdo1(rig)[0] & 0x10), rig.actual.mode))
        if rig.drive.homing is Homing.DONE:
            break
    assert pairs == {(False, 8), (True, 6), (False, 6)}


def test_csp_is_asked_for_only_when_607ah_is_at_the_new_zero_already() -> None:
    rig = homing_rig()
    targets: list[int] = []
    asked_at: int | None = None
    for _ in range(1500):
        rig.cycle(Demand(on=True, position_inc=rig.drive.set_inc, home=True))
        targets.append(rpdo1(rig)[1])
        if any(frame.identifier == 0x300 + NODE and frame.data == b"\x08" for frame in rig.frames):
            asked_at = len(targets) - 1
            break
    assert asked_at is not None and max(abs(target) for target in targets[:50]) > 50_000, "far from its new zero before"
    assert all(abs(target) < 400 for target in targets[asked_at - 1 :]), targets[asked_at - 5 :]


def test_attained_of_an_older_run_is_not_believed() -> None:
    rig = homing_rig()
    for _ in range(2):
        rig.until(Phase.ENABLED, Demand(on=True, position_inc=rig.drive.set_inc))
        rig.until(Phase.HOMING, Demand(on=True, position_inc=rig.drive.set_inc, home=True))
        rig.cycle(Demand(on=True, position_inc=rig.drive.set_inc, home=True))
        assert rig.drive.phase is Phase.HOMING, "still under way: bit 12 stood from the run before"
        rig.until(Phase.ENABLED, Demand(on=True, position_inc=rig.drive.set_inc, home=True))
        assert rig.drive.homing is Homing.DONE


def test_giving_up_stops_the_axis_and_returns_to_csp_without_a_reference() -> None:
    rig = homing_rig(servo=ServoSettings(start_rad=400.0))
    rig.until(Phase.HOMING, Demand(on=True, position_inc=rig.drive.set_inc, home=True))
    rig.cycles(10, Demand(on=True, position_inc=rig.drive.set_inc, home=True))
    rig.until(Phase.ENABLED, Demand(on=True, position_inc=rig.drive.set_inc))
    assert rig.drive.homing in (Homing.FAILED, Homing.NONE)
    assert abs(rig.slave.axis(NODE).servo.speed_rad_s) < 0.1


def test_homing_that_takes_too_long_fails_and_leaves_the_drive_enabled() -> None:
    slow = (SPEEDS[0], Parameter(0x6099, 2, (10).to_bytes(4, "little"), "nearly nothing"))
    rig = OneNode(settings=Cia402Settings(homing_cycles=100)).start(HOME, *slow).on()
    rig.until(Phase.GIVING_UP, Demand(on=True, position_inc=rig.drive.set_inc, home=True))
    rig.until(Phase.ENABLED, Demand(on=True, position_inc=rig.drive.set_inc, home=True))
    assert rig.drive.homing is Homing.FAILED


def test_an_error_of_the_drive_while_it_references_fails_the_run() -> None:
    rig = OneNode().start(Parameter(0x6098, 0, b"\x03", "method 3: home switch that is not there"), *SPEEDS).on()
    rig.until(Phase.HOMING, Demand(on=True, position_inc=rig.drive.set_inc, home=True))
    blocked(rig)
    rig.cycles(20, Demand(on=True, position_inc=rig.drive.set_inc, home=True))
    assert rig.drive.homing is Homing.FAILED and rig.power() is Power.FAULT
