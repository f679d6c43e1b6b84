"""The Reis and the VAL 3 view in a running cell: robotstar 4, 5.8, 5.9, 8.1; val3 3.5; AX-336, AX-337, AX-338."""

import dataclasses
from typing import Any

import pytest

from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.pure.arbitration.command_block import Code
from gateway.pure.controllers.reis.control import regulator_number
from gateway.pure.controllers.val3.io.control import Val3Control
from gateway.pure.controllers.val3.io.variables import Dio
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import RC_BYTES, AxisFlag, AxisState, CellState, Motion, Quality, set_bit
from hil_tests.unit.gateway.pure.arbitration.controls.bench import AUTO, PLC, ControlBench, cell_with

REIS = cell_with('kind = "reis"\nrobot_only = [7]\nplc_only = [8]')
POINTS = """
kind = "val3"
[[controller.point]]
name = "gripper"
board = "BasicIO-1"
module = "\\\\dout"
address = "3"
description = "Greifer zu"
output = true
bit = 705
[[controller.point]]
name = "part"
board = "BasicIO-1"
module = "\\\\din"
address = "0"
bit = 200
[[controller.point]]
name = "force"
board = "AnaIO"
module = "aout"
address = "0"
output = true
byte = 100
steps = 100
min = -50.0
max = 50.0
"""
VAL3 = cell_with(POINTS)
OVERRIDE, ERROR, ACTUAL = 1436, 944, 1024


@pytest.fixture
def robot() -> ControlBench:
    made = ControlBench(REIS)
    made.run(0.3)
    return made


def moving(robot: ControlBench) -> ControlBench:
    for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
        assert robot.settle(robot.give(code, 3)).state is CommandState.DONE
    robot.give(Code.PTP_ABSOLUTE, 1, 0.5, (800.0,))
    robot.run(0.5)
    return robot


def test_what_the_axes_do_is_in_the_system_markers(robot: ControlBench) -> None:
    moving(robot.put(AUTO))
    markers = robot.reis.markers
    assert markers.bit(1021, 2) and markers.bit(1021, 5) and markers.bit(1020, 6) and markers.bit(1020, 4)
    assert [markers.byte(1022), markers.byte(1023)] == [3, 0], "AUTO is 0300, high byte first"
    assert abs(markers.number(ACTUAL) - robot.place() * 100) < 500
    robot.put(off=(AUTO,))
    assert [markers.byte(1022), markers.byte(1023)] == [1, 1]


@pytest.mark.requirement("RSV-PLC-36", by="gateway.pure.controllers.reis.control:ReisControl._factor")
def test_the_override_marker_multiplies_the_override_in_auto(robot: ControlBench) -> None:
    moving(robot.put(AUTO))
    assert robot.core.state.override == 1.0, "a 0 that was never written is not a factor"
    robot.reis.markers.set_number(OVERRIDE, 50)
    robot.settle(robot.give(Code.OVERRIDE, velocity=0.5))
    robot.cycle(3)
    assert robot.core.state.override == 0.25
    robot.put(off=(AUTO,))
    robot.cycle(3)
    assert robot.core.state.override == 0.5, "HAND is not multiplied"
    robot.put(AUTO)
    robot.reis.markers.set_number(OVERRIDE, 0)
    robot.cycle(3)
    assert robot.core.state.override == 0.0, "once written, 0 holds the robot"
    robot.reis.markers.set_number(OVERRIDE, 100)
    robot.settle(robot.give(Code.RELEASE_CONTROL))
    robot.cycle(3)
    assert robot.core.state.override == 0.5, "whichever source has control"


def test_hold_motion_stops_on_the_path_and_goes_on(robot: ControlBench) -> None:
    moving(robot)
    assert robot.control.write_flags(1020, b"\x80")
    robot.run(1.0)
    assert robot.core.state.motion is Motion.STOPPED
    assert robot.control.flag_bytes()[1020] == 0b1101_0000, "bits of the robot stay its own"
    assert robot.control.write_flags(1020, b"\x0f")
    robot.run(4.0)
    assert abs(robot.place() - 800.0) < 0.1


def test_a_lost_drive_is_a_regulator_error(robot: ControlBench) -> None:
    moving(robot)
    robot.silent = {1}
    robot.run(0.3)
    markers = robot.reis.markers
    assert markers.number(ERROR) == 667 and markers.bit(1021, 0)
    assert any(line == "Servoregulator error 667: CAN-Watchdog, axis A1" for line in robot.told)
    robot.silent = set()
    robot.run(0.3)
    assert markers.number(ERROR) == 0 and not markers.bit(1021, 0)


@pytest.mark.requirement("RSV-UI-03", by="gateway.pure.controllers.reis.control:ReisControl.shown")
@pytest.mark.requirement("RSV-UI-03", by="gateway.pure.controllers.reis.control:ReisControl._look_at_drives")
def test_err_enab_hides_a_message_that_stays_until_the_drives_are_switched_on(robot: ControlBench) -> None:
    words = "Servoregulator error 667: CAN-Watchdog, axis A1"
    robot.silent = {1}
    robot.run(0.3)
    assert robot.reis.status()["message"] == words
    robot.reis.put("reis.err_enab", 1)
    robot.reis.message(4017, "Operating error 4017", robot.now)
    robot.silent = set()
    robot.run(0.3)
    robot.told.clear()
    robot.silent = {1}
    robot.run(0.3)
    assert robot.reis.status()["message"] == "" and words not in robot.told
    assert robot.reis.markers.bit(1021, 0), "hidden, not gone"
    robot.reis.put("reis.err_enab", 0)
    assert robot.reis.value("reis.err_enab") == 1, "only the drives end it"
    robot.silent = set()
    robot.run(0.3)
    for code in (Code.REQUEST_CONTROL, Code.FAULT_RESET, Code.OVERRIDE, Code.ENABLE):
        job = robot.settle(robot.give(code, mask=0b11))
        assert job.state.name == "DONE", job
    robot.run(0.1)
    assert robot.reis.value("reis.err_enab") == 0
    assert robot.reis.status()["message"] == "Operating error 4017", "it stays, and is shown again"


def test_an_axis_that_does_not_follow_is_647_until_it_is_acknowledged(robot: ControlBench) -> None:
    moving(robot)
    robot.core._axes[0].tracking.lag._trip = 1e-6
    robot.run(0.2)
    assert robot.reis.markers.number(ERROR) == 647 and robot.reis.markers.bit(1021, 0)
    assert "Servoregulator error 647: tracking distance too long, axis A1" in robot.told
    robot.settle(robot.give(Code.FAULT_RESET))
    robot.run(0.1)
    assert robot.reis.markers.number(ERROR) == 0 and not robot.reis.markers.bit(1021, 0)


@pytest.mark.parametrize(
    "code, number", [(0x8611, 647), (0x2310, 657), (0x3210, 653), (0x4310, 656), (0x4410, 658), (0x7305, 662), (0xFF00, 654)]
)
def test_fault_codes_of_drives_as_regulator_errors(code: int, number: int) -> None:
    assert regulator_number(code) == number


@pytest.mark.parametrize(
    "code, number",
    [
        (1, 667),
        (2, 667),
        (3, 647),
        (4, 646),
        (7, 671),
        (8, 657),
        (9, 658),
        (11, 653),
        (12, 673),
        (13, 656),
        (14, 662),
        (5, 654),
        (0xFF, 654),
    ],
)
def test_fault_codes_of_boosters_have_the_numbers_of_the_manual(code: int, number: int) -> None:
    assert regulator_number(code) == number


@pytest.mark.parametrize("code, number", [(1, 667), (9, 658), (12, 673)])
def test_a_booster_fault_is_in_the_marker_and_on_the_panel_with_its_number(robot: ControlBench, code: int, number: int) -> None:
    moving(robot)
    assert isinstance(robot.slave, ServodynSlave)
    robot.slave.force_fault(1, code)
    robot.run(0.3)
    assert robot.reis.markers.number(ERROR) == number and robot.reis.markers.bit(1021, 0)
    assert any(line.startswith(f"Servoregulator error {number}: ") and line.endswith("axis A1") for line in robot.told)


def test_a_booster_without_sync_is_667(robot: ControlBench) -> None:
    moving(robot)
    robot.now += 100_000_000
    robot.run(0.3)
    assert robot.reis.markers.number(ERROR) == 667


def test_outputs_are_shared_and_inputs_come_from_the_sources(robot: ControlBench) -> None:
    control = robot.control
    set_bit(robot.inputs.values, (88 + 3) * 8 + 2, True)
    control.put("reis.output.5.3", 1)
    robot.cycle(2)
    assert control.flag_bytes()[1971] == 0b100 and control.flag_bytes()[2013] == 0b1000
    assert control.value("reis.ibin_out.2") == 0x800 and control.outputs[88 + 5] == 0b1000
    control.put("reis.output.6.0", 0)
    assert control.write_flags(2008 + 6, b"\x01")
    robot.cycle(2)
    assert control.value("reis.output.6.0") == 1.0, "the PLC's value remains"
    assert not control.write_flags(2008 + 7, b"\x01"), "given to the robot alone"
    with pytest.raises(ValueError, match="belongs to the PLC"):
        control.put("reis.output.8.0", 1)
    assert not control.write_flags(1968, b"\x01") and not control.write_flags(944, b"\x01") and control.write_flags(0, b"\x07\x08")
    assert control.flag_bytes()[:2] == b"\x07\x08"


def test_points_are_values_and_a_lost_source_is_a_fault_of_its_board() -> None:
    bench = ControlBench(VAL3)
    bench.cycle(2)
    control = bench.control
    control.put("dio.gripper", 1)
    control.put("aio.force", 12.5)
    bench.put(200)
    assert bench.output(705) and int.from_bytes(control.outputs[100:102], "little", signed=True) == 1250
    assert [control.value(name) for name in ("dio.part", "aio.force", "dio.part.status")] == [1.0, 12.5, 0.0]
    bench.quality(Quality.BAD, 25)
    assert control.value("dio.part.status") == -3.0 == control.value("dio.gripper.status")
    with pytest.raises(ValueError, match="125"):
        control.value("dio.part")
    bench.quality(Quality.GOOD, 25)
    assert control.value("dio.part") == 1.0


def test_an_operator_locks_and_simulates() -> None:
    bench = ControlBench(VAL3)
    bench.put(200)
    control = bench.control
    control.put("dio.gripper.lock", 1)
    control.put("dio.gripper", 1)
    assert control.value("dio.gripper.status") == 1.0 and control.value("dio.gripper") == 0.0
    bench.cycle(2)
    assert not bench.output(705)
    control.put("dio.gripper.lock", 0)
    control.put("dio.gripper", 1)
    assert control.value("dio.gripper") == 1.0
    control.put("dio.part.simulate", 0)
    assert control.value("dio.part") == 0.0 and control.value("dio.part.status") == 2.0
    control.put("dio.part.real", 1)
    assert control.value("dio.part") == 1.0
    for name, kind in (("dio.part", ValueError), ("dio.part.status", KeyError), ("aio.part", KeyError), ("dio.other", KeyError)):
        with pytest.raises(kind):
            control.put(name, 1)
    assert bench.control.status()["not_working"] == {}


def test_the_outputs_of_the_cycle_reach_the_sources_of_every_kind(robot: ControlBench) -> None:
    moving(robot)
    val3 = ControlBench(VAL3)
    val3.run(0.3)
    assert robot.output(66) and robot.output(64) and val3.output(64) and robot.dispatcher.owner == PLC


def stepped(robot: ControlBench, *flags: AxisFlag) -> None:
    """One step of the control alone, with axes that stand so."""
    state = CellState(generation=1, axes=[AxisState(flags=flag) for flag in flags])
    robot.told += robot.control.step(robot.inputs, bytes(RC_BYTES), state, 0)


@pytest.mark.parametrize(("change", "number"), [({"home": 5.0}, 677), ({"offset": 7}, 678), ({"direction": -1}, 679)])
def test_machine_data_that_changed_over_power_off_make_their_axis_asynchronous_until_it_is_referenced(
    change: dict[str, Any], number: int
) -> None:
    """robotstar L4734-4740: 677, 678, 679 at the start, M1020.6 away; referencing again ends it."""
    robot = ControlBench(REIS)
    today = dict(robot.reis.setup.references)
    robot.reis.was_synchronised({**today, 2: dataclasses.replace(today[2], **change)})
    markers, on = robot.reis.markers, AxisFlag.REFERENCED
    stepped(robot, on, on)
    assert [told for told in robot.told if str(number) in told] and markers.number(ERROR) == number
    assert not markers.bit(1020, 6) and markers.bit(1021, 0), "the drive still says referenced: it was to the old place"
    stepped(robot, on, on)
    stepped(robot, AxisFlag(0), on)
    stepped(robot, on, on)
    assert not markers.bit(1020, 6), "the other axis is not meant"
    stepped(robot, on, AxisFlag(0))
    assert not markers.bit(1020, 6)
    stepped(robot, on, on)
    assert markers.bit(1020, 6) and not markers.bit(1021, 0) and markers.number(ERROR) == 0
    assert robot.reis.synchronised == today


def test_an_axis_that_was_never_synchronised_is_with_its_first_reference() -> None:
    robot = ControlBench(REIS)
    today = dict(robot.reis.setup.references)
    robot.reis.was_synchronised({})
    stepped(robot, AxisFlag.REFERENCED, AxisFlag(0))
    assert robot.reis.synchronised == {1: today[1]} and not robot.reis.markers.bit(1020, 6)
    stepped(robot, AxisFlag.REFERENCED, AxisFlag.REFERENCED)
    assert robot.reis.synchronised == today and robot.reis.markers.bit(1020, 6)


def test_the_description_of_a_point_is_the_text_of_the_cell() -> None:
    control = ControlBench(VAL3).control
    assert isinstance(control, Val3Control)
    assert control.instructions.io_description(Dio("gripper"))[1:] == ("Greifer zu", "BasicIO-1\\\\dout\\3")
    assert control.instructions.io_description(Dio("part"))[1] == ""
