"""SERVODYN-GC: ENABLE LIMIT SWITCH (rho3 2.7), every state and fault in words, and the old list's numbers (robotstar 8.1)."""

import pytest

from drivers.drives.scaling import Scaling
from drivers.drives.servodyn import Drive, DriveSettings, Phase, Power
from drivers.drives.servodyn_words import FAULTS, STATES, diagnose, fault, sentence
from drivers.drives.tracking import Tracking
from drivers.emulator.servo.settings import ServoSettings
from drivers.emulator.servodyn.axis import Fault
from gateway.pure.arbitration.command_block import Code
from hil_tests.lab.virtual.cell_bench import CellBench
from hil_tests.lab.virtual.one_axis import OneAxis
from hil_tests.lab.virtual.servodyn_bus import CODEC

TURN = 16384
LIMITED = ServoSettings(soft_limit_min_inc=-2 * TURN, soft_limit_max_inc=2 * TURN, start_rad=1.0)


# ------------------------------------------------------------------------------------------------ ENABLE LIMIT SWITCH


@pytest.mark.requirement("RHO-CAN-21", by="gateway.pure.cycle.axis_loops:InPython.drive_axes")
@pytest.mark.requirement("RHO-CAN-21", by="gateway.pure.cycle.homing:Homings.step")
def test_the_bit_is_set_once_referencing_and_its_offset_are_done() -> None:
    """By the set values on the bus, axis by axis: the demo's A1 to A3 move 5 or 10 mm on from their reference point."""
    bench = CellBench()
    bits: list[list[bool]] = []
    places: list[list[float]] = []

    def heard() -> None:
        bits.append([CODEC.decode_set(frame)[1].limit_switch for frame in bench.burst[1:]])
        places.append([axis.set for axis in bench.core.state.axes[:6]])

    bench.each = heard
    bench.run(0.3)
    for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
        bench.settle(bench.give(code))
    assert not any(map(any, bits)), "drives on is not enough"
    bench.settle(bench.give(Code.REFERENCE))
    ends = [axis.set for axis in bench.core.state.axes[:6]]
    bench.run(0.1)
    for n, end in enumerate(ends):
        rises = [k for k in range(1, len(bits)) if bits[k][n] and not bits[k - 1][n]]
        assert len(rises) == 1 and bits[-1][n], f"axis {n + 1}: once, and it stays"
        assert places[rises[0]][n] == pytest.approx(end, abs=1e-6), f"axis {n + 1}: at the end of its way, the offset included"
    for code in (Code.DISABLE, Code.ENABLE):
        bench.settle(bench.give(code))
        bench.run(0.1)
        assert bits[-1] == [True] * 6, "drives off and on again do not take it away"


def guarded(axis: OneAxis, turns: float) -> float:
    """Goes `turns` beyond, as far as the booster lets it; the shaft's turns from the zero crossing."""
    axis.goal, axis.speed = axis.set + turns * 6.283185307, 12.0
    axis.run(abs(turns) / 1.9 + 1.5)
    return axis.shaft_rad / 6.283185307


@pytest.mark.requirement("RHO-CAN-21", by="drivers.emulator.servodyn.axis:ServodynAxis._activate")
def test_only_the_first_edge_has_effect_and_a_restart_of_the_control_keeps_it() -> None:
    axis = OneAxis(Scaling(), LIMITED)
    axis.enable()
    axis.limit_switch = True
    guarded(axis, 1.5)  # over the resolver zero at one turn: from here the limits are -1 and 3 turns
    axis.limit_switch = False
    axis.cycle(3)
    axis.limit_switch = True  # a second edge: would shift the limits by a turn
    axis.cycle(3)
    assert axis.drive.fault_code == 0
    axis.drive, axis.on, axis.limit_switch = Drive(DriveSettings()), False, False  # the control starts anew, the bit is 0
    axis.run(0.3)
    axis.enable()
    end = guarded(axis, 4.0)
    code = axis.drive.fault_code
    assert code == Fault.SOFTWARE_LIMIT and 3.0 < end < 3.3


def test_after_a_power_cycle_of_the_booster_nothing_is_guarded_until_the_bit_comes_again() -> None:
    axis = OneAxis(Scaling(), LIMITED)
    axis.enable()
    axis.limit_switch = True
    guarded(axis, 1.5)
    axis.on = axis.limit_switch = False
    axis.run(0.3)
    axis.slave.power_off(1)
    axis.run(0.1)
    axis.slave.power_on(1)
    axis.run(0.3)
    axis.enable()
    assert guarded(axis, 4.0) > 5.0 and axis.drive.fault_code == 0


# ------------------------------------------------------------------------------------------------ states and faults


def test_every_state_and_every_fault_has_words_in_both_languages() -> None:
    assert set(STATES) == set(Phase)
    assert set(FAULTS) == {int(code) for code in Fault} - {0, 99}
    for words in (*STATES.values(), *(row.what for row in FAULTS.values()), *(row.todo for row in FAULTS.values())):
        assert words.in_language("de") and words.in_language("en") and words.german != words.english
    assert sentence(1) == "code 1 = 667 CAN watchdog: SYNC missing" and sentence(6, "de") == "code 6 = Hardware-Endschalter erreicht"
    assert fault(200).number == 0 and "not in this list" in fault(200).what.english


def test_the_words_follow_the_drive_from_off_to_control_and_back() -> None:
    axis = OneAxis(Scaling())
    seen: list[str] = []
    for number in range(250):
        axis.on = 30 < number < 150
        axis.cycle()
        words = diagnose(axis.drive).text.english
        seen += [words] if not seen or seen[-1] != words else []
    order = [Phase.OFF, Phase.POWERING, Phase.ENABLING, Phase.RELEASING, Phase.ENABLED, Phase.DISABLING, Phase.UNPOWERING, Phase.OFF]
    assert [word for word in seen if word != STATES[Phase.LOST].english] == [STATES[phase].english for phase in order]


@pytest.mark.requirement("RSV-DRV-02", by=("drivers.drives.servodyn_words:diagnose", "drivers.emulator.servodyn.axis:ServodynAxis.fail"))
def test_stopped_bus_traffic_is_667_and_switches_the_drive_off() -> None:
    axis = OneAxis(Scaling())
    axis.enable()
    axis.goal, axis.speed = axis.set + 50.0, 20.0
    axis.run(0.3)
    axis.silent = True
    axis.run(0.5)
    lost, still = diagnose(axis.drive), abs(axis.slave.axis(1).servo.speed_rad_s) < 1e-3
    axis.silent = False
    axis.run(0.1)
    found, power, actual = diagnose(axis.drive), axis.drive.power, axis.actual
    assert lost.state is Phase.LOST and still
    assert (found.number, found.code, power) == (667, Fault.SYNC_LOST, Power.FAULT)
    assert found.text.english == "Servoregulator error 667: CAN watchdog: SYNC missing"
    assert found.text.german.startswith("Fehler Servoregler 667: CAN-Ueberwachung") and "120" in found.todo.german
    assert actual is not None and not actual.enabled and not actual.power_on


def test_the_first_fault_code_stays_in_words_until_it_is_acknowledged() -> None:
    axis = OneAxis(Scaling())
    axis.enable()
    axis.slave.force_fault(1, 8)
    axis.run(0.5)
    assert (diagnose(axis.drive).number, diagnose(axis.drive).text.english.split(": ")[0]) == (657, "Servoregulator error 657")
    axis.reset, axis.on = True, False
    axis.run(0.3)
    assert diagnose(axis.drive).state is Phase.OFF and diagnose(axis.drive).number == 0


# ------------------------------------------------------------------------------------------------ standstill and tracking


def watched(axis: OneAxis, watch: Tracking, seconds: float) -> int:
    """The first number told; what is computed now leaves in the next cycle, is active in the one after, reached in the third (AX-144)."""
    sets = [axis.set] * 4
    for _ in range(round(seconds * 1e9 / axis.period_ns)):
        axis.cycle()
        sets = [*sets[1:], axis.set]
        number = watch.check(sets[0], sets[0] - axis.position)
        if number:
            return number
    return 0


@pytest.mark.requirement("RSV-DRV-05", by="drivers.drives.tracking:Tracking.check")
def test_an_axis_pushed_out_of_standstill_is_648() -> None:
    axis = OneAxis(Scaling())
    axis.enable()
    watch = Tracking(standstill=0.02, trip=0.5, settle_cycles=25)
    assert watched(axis, watch, 0.5) == 0
    axis.slave.load_torque(1, 25.0)  # more than the motor has
    assert watched(axis, watch, 0.5) == 648
    assert watch.number == 648  # stays
    watch.clear()
    assert watch.number == 0


@pytest.mark.requirement("RSV-DRV-05", by="drivers.drives.tracking:Tracking.check")
def test_a_following_error_above_the_limit_is_647() -> None:
    for limit, number in ((0.3, 0), (0.2, 647)):  # 20 rad/s at Kv 80: 0.25 rad behind
        axis = OneAxis(Scaling())
        axis.enable()
        axis.goal, axis.speed = axis.set + 30.0, 20.0
        assert watched(axis, Tracking(0.02, limit, limit, 25), 1.0) == number, limit


def test_the_booster_says_647_itself_when_its_own_window_is_left() -> None:
    axis = OneAxis(Scaling(), ServoSettings(following_error_rad=0.2))
    axis.enable()
    axis.goal, axis.speed = axis.set + 30.0, 20.0
    axis.run(0.5)
    assert diagnose(axis.drive).number == 647


def test_what_is_no_number_is_never_well() -> None:
    watch = Tracking(0.02, 0.5, 0.5, 25)
    assert watch.check(0.0, float("nan")) == 647
