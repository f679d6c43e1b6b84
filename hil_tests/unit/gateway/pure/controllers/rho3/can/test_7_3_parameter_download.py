"""rho 3 Releases part 5, 7 (L7529-7592): numbers 1..24 go to the boosters at start-up when P601 is TRUE, and what they do there."""

from typing import Any

import pytest

from drivers.drives.scaling import Scaling
from drivers.drives.servodyn import Power
from drivers.drives.servodyn_download import ATTEMPTS, WAIT_CYCLES, Download, DownloadState
from drivers.emulator.servo.settings import ServoSettings
from gateway.cell_file.load import CellFaults, load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.rho3.can import download as table
from gateway.pure.controllers.rho3.can.download import DownloadGap, download, position_scaling
from hil_tests.lab.virtual.one_axis import OneAxis
from protocols.base.errors import ProtocolError
from protocols.base.machine import Frame
from protocols.servodyn.parameters import Answer, Request, Status, Value, decode_answer, decode_request, encode_answer, encode_request

P600 = """P114 = [ 30.0, 30.0, 30.0, 60.0, 60.0, 90.0 ]
P602 = [ 11, 12, 13, 14, 15, 16 ]
P603 = 7
P604 = [ 1.25, 1.25, 1.25, 1.0, 1.0, 0.75 ]
P605 = 20.0
P606 = [ 60.0, 80.0, 80.0, 80.0, 80.0, 80.0 ]
P607 = [ [250.0, 150.0, 300.0], 250.0, 250.0, 250.0, 250.0, 250.0 ]
P608 = 19000.0
P609 = 10.0
P610 = 200
P611 = 0.05
P612 = 300.0
P613 = 0.7
P614 = 0
P615 = true
"""


def cell(switched_on: bool = True, *edits: tuple[str, str]) -> Cell:
    text = read_text(find_config("rho3-servodyn", "cells"))
    on = f"P601 = true\n{P600}" if switched_on else f"P601 = false\n{P600}"
    for old, new in (("P601 = false ", f"{on}# "), *edits):
        assert old in text
        text = text.replace(old, new, 1)
    return load_cell("cell.toml", text)


def numbers(of: Cell, axis: int = 1) -> dict[int, Value]:
    assert of.rho3 is not None
    found = download(of.rho3, of.axis[axis - 1], axis - 1)
    return {each.row.number: each.value for each in found}


@pytest.mark.requirement(
    "RHO-CAN-16", by=("gateway.pure.controllers.rho3.can.download:download", "gateway.pure.controllers.rho3.can.download:_computed")
)
def test_numbers_1_to_24_come_from_p600_and_from_what_the_control_has_anyway() -> None:
    sent = numbers(cell())
    limit = 165.0 * 121.0 * 16384 / 360  # P204 = P205 = 165, P207 = P208 = 0, GF 121
    rpm = 120.0 * 121.0 / 6.0  # P103 = 120 deg/s at the axis
    by_hand = {
        1: True, 2: 11, 3: 7, 4: 8, 5: 1.25, 6: 20.0, 7: 60.0, 8: round(limit), 9: round(limit), 10: 250.0, 11: 150.0,
        12: pytest.approx(rpm), 13: pytest.approx(30.0 * 121.0 / 6.0), 14: 300.0, 15: 19000.0, 16: 10.0, 17: 200, 18: 0.05, 19: 300.0,
        20: 0.7, 21: 1, 22: 0, 23: True, 24: True,
    }  # fmt: skip
    assert sent == by_hand
    assert list(sent) == list(range(1, 25))


@pytest.mark.requirement("RHO-CAN-16", by="gateway.pure.controllers.rho3.can.download:download")
def test_p601_false_sends_none() -> None:
    assert numbers(cell(switched_on=False)) == {}
    assert numbers(cell()) != {}


@pytest.mark.requirement("RHO-CAN-16", by="drivers.drives.servodyn_download:Download.step")
def test_all_of_them_are_sent_in_order_one_at_a_time_and_read_back() -> None:
    wanted = numbers(cell())
    run, sent, answer = Download(list(wanted.items())), [], None
    for _ in range(100):
        request = run.step(answer)
        if not isinstance(request, Request):
            break
        sent.append((request.number, request.value))
        answer = Answer(request.number, Status.TAKEN, request.value, request.sequence)
    assert sent == list(wanted.items())
    assert (run.state, run.taken) == (DownloadState.DONE, wanted)


@pytest.mark.requirement("RHO-CAN-17", by="gateway.pure.controllers.rho3.can.download:position_scaling")
def test_position_scaling_of_the_pulses_in_p401() -> None:
    assert [position_scaling(pulses) for pulses in (16384, 8192, 4096)] == [1, 2, 3]
    with pytest.raises(ValueError, match="knows 16384, 8192, 4096"):
        position_scaling(1000)


@pytest.mark.requirement("RHO-CAN-18", by="gateway.pure.controllers.rho3.can.download:direction_flag")
def test_the_download_always_carries_true_and_the_reversal_is_ours() -> None:
    whole = cell()
    assert [axis.mechanics.direction for axis in whole.axis[:2]] == ["+", "-"]  # P401 of axis 2: -16384.0 and -2
    flags = [numbers(whole, axis).get(23) for axis in (1, 2)]
    assert flags == [True, True]


def test_a_reversed_axis_has_its_limits_exchanged() -> None:
    sent = numbers(cell(), 2)  # P204 = 110, P205 = 60, P207 = 90: 20 degrees up, 150 down, at the motor the other way round
    per_degree = 153.0 * 16384 / 360
    assert (sent[8], sent[9]) == (round(150 * per_degree), round(20 * per_degree))


def test_check_names_what_a_download_lacks() -> None:
    with pytest.raises(CellFaults) as found:
        cell(True, ("P606 = [ 60.0, 80.0, 80.0, 80.0, 80.0, 80.0 ]\n", "P606 = [ 60.0 ]\n"))
    said = "\n".join(map(str, found.value.faults))
    assert "rho3.P601" in said and "P606 of axis 2" in said and "P606 of axis 1" not in said


def test_a_gap_is_raised_where_nobody_checked() -> None:
    whole = cell(switched_on=True)
    assert whole.rho3 is not None
    bare: dict[str, Any] = {name: getattr(whole.rho3, name) for name in whole.rho3.__dataclass_fields__}
    with pytest.raises(DownloadGap, match="P602 of axis 1"):
        download(type(whole.rho3)(**{**bare, "others": {}}), whole.axis[0], 0)


def test_the_table_is_the_manuals() -> None:
    """L7552-7575, typed by hand: number, source, BOSCHTRM command."""
    by_hand = (
        "1 P601 -|2 P602 -|3 P603 SM|4 P5 SC|5 P604 SP|6 P605 SI|7 P606 SG|8 P204 OL|9 P205 OL|10 P607 ST|11 P607 ST|12 P103 SL|13 P114 SL|"
        "14 P607 ST|15 P608 SE|16 P609 SL|17 P610 SS|18 P611 SF|19 P612 SW|20 P613 SZ|21 P401 OR|22 P614 OO|23 P401 OD|24 P615 OW"
    )
    assert "|".join(f"{row.number} {row.source} {row.command or '-'}" for row in table.ROWS) == by_hand


# ------------------------------------------------------------------------------------------------ what the booster does


def downloaded(axis: OneAxis, parameters: list[tuple[int, Value]]) -> Download:
    """Gateway's side against the emulated drive, over the frames."""
    run, answer = Download(parameters), None
    for _ in range(1000):
        request = run.step(answer)
        if run.state is not DownloadState.RUNNING:
            return run
        answer = axis.send(request) if request is not None else None
        axis.cycle()
    raise AssertionError("the download never ends")


def test_the_emulated_booster_takes_a_whole_download_and_acts_on_it() -> None:
    wanted = numbers(cell())
    axis = OneAxis(Scaling())
    run = downloaded(axis, list(wanted.items()))
    assert (run.state, run.error) == (DownloadState.DONE, None)
    settings = axis.slave.axis(1).settings
    assert settings.kv_per_s == 60.0 and settings.soft_limit_max_inc == wanted[8] and settings.soft_limit_min_inc == -int(wanted[9])
    assert settings.torque_limit_nm == pytest.approx(settings.rated_torque_nm * 2.5)
    assert settings.quick_stop_rad_s2 == pytest.approx(19000 * 0.10471975512)


def test_the_position_loop_follows_the_downloaded_gain() -> None:
    def lag(gain: float) -> float:
        axis = OneAxis(Scaling())
        downloaded(axis, [(1, False), (7, gain)])
        axis.enable()
        axis.goal, axis.speed = axis.set + 100.0, 10.0
        axis.run(1.0)
        return axis.set - axis.position

    assert lag(40.0) - lag(80.0) == pytest.approx(10.0 / 40 - 10.0 / 80, rel=0.02)


@pytest.mark.parametrize(("code", "per_turn"), [(1, 16384), (2, 8192), (3, 4096)])
def test_the_booster_scales_both_ways(code: int, per_turn: int) -> None:
    axis = OneAxis(Scaling(inc_per_turn=per_turn))
    downloaded(axis, [(21, code)])
    axis.enable()
    axis.zero_here()
    shaft = axis.shaft_rad
    axis.goal, axis.speed = 12.0, 20.0
    axis.run(1.5)
    assert axis.shaft_rad - shaft == pytest.approx(12.0, abs=0.01) and axis.position == pytest.approx(12.0, abs=0.01)
    assert axis.drive.position_inc == pytest.approx(12.0 / 6.283185307 * per_turn + axis.scaling.zero_inc, abs=8)


def test_the_downloaded_limit_stops_the_axis_once_limit_switches_are_enabled() -> None:
    axis = OneAxis(Scaling())
    downloaded(axis, [(8, 16384), (9, 16384)])
    axis.enable()
    axis.limit_switch = True
    axis.goal, axis.speed = axis.set + 20.0, 6.0
    axis.run(3.0)
    assert axis.drive.fault_code == 5 and axis.shaft_rad < 3 * 6.3  # a turn behind the zero it crossed


@pytest.mark.requirement(
    "RSV-DRV-04", by=("drivers.emulator.servodyn.parameters:ParameterStore.take", "drivers.drives.servodyn_download:Download.step")
)
def test_parameters_are_not_changed_with_drives_on_645() -> None:
    axis = OneAxis(Scaling())
    assert downloaded(axis, [(7, 50.0)]).state is DownloadState.DONE
    axis.enable()
    run = downloaded(axis, [(7, 90.0)])
    kept, power = axis.slave.axis(1).settings.kv_per_s, axis.drive.power
    assert run.error is not None and (run.error.number, run.error.parameter) == (645, 7)
    assert "drives active" in run.error.english and "eingeschalteten" in run.error.german
    assert (kept, power) == (50.0, Power.ENABLED)


def test_unknown_numbers_and_values_no_drive_can_have_change_nothing() -> None:
    axis = OneAxis(Scaling())
    axis.run(0.1)
    assert axis.send(Request(30, 1)).status is Status.UNKNOWN
    for request in (Request(7, 0.0), Request(7, 80), Request(21, 4), Request(23, 1), Request(9, -(2**31)), Request(12, 1e9)):
        assert axis.send(request).status is Status.RANGE, request
    assert axis.slave.axis(1).settings == ServoSettings()


def test_what_was_stored_survives_the_supply_and_what_was_not_is_gone() -> None:
    axis = OneAxis(Scaling())
    downloaded(axis, [(1, True), (7, 50.0), (1, False), (15, 12000.0)])
    axis.slave.power_off(1)
    axis.run(0.1)
    assert axis.slave.axis(1).parameter(Request(7, 50.0)) is None
    axis.slave.power_on(1)
    axis.run(0.2)
    settings = axis.slave.axis(1).settings
    assert settings.kv_per_s == 50.0 and settings.quick_stop_rad_s2 == ServoSettings().quick_stop_rad_s2


def test_a_silent_drive_is_asked_three_times_and_then_reported() -> None:
    run, asked = Download([(7, 50.0)]), 0
    for _ in range(4 * (WAIT_CYCLES + 1)):
        asked += run.step(None) is not None
    assert (asked, run.state) == (ATTEMPTS, DownloadState.FAILED)
    assert run.error is not None and run.error.english == "no answer to parameter 7"


def test_an_answer_to_an_older_request_is_nobodys_and_another_value_is_an_error() -> None:
    run = Download([(7, 50.0), (8, 100)])
    assert run.step(None) == Request(7, 50.0, 0)
    assert run.step(Answer(8, Status.TAKEN, 100, 0)) is None and run.state is DownloadState.RUNNING
    assert run.step(Answer(7, Status.TAKEN, 50.0, 9)) is None and run.state is DownloadState.RUNNING
    assert run.step(Answer(7, Status.TAKEN, 50.0, 0)) == Request(8, 100, 1)
    run.step(Answer(8, Status.TAKEN, 101, 1))
    assert run.error is not None and "101 read back" in run.error.english


@pytest.mark.parametrize("value", [True, False, 0, -(2**31), 2**31 - 1, 0.5, -1.0e9])
def test_requests_and_answers_survive_the_wire(value: Value) -> None:
    request = Request(24, value, 255)
    assert decode_request(encode_request(6, request)) == (6, request)
    for status in Status:
        answer = Answer(1, status, value, 3)
        assert decode_answer(encode_answer(1, answer)) == (1, answer)
    assert encode_request(6, request).identifier == 360 and encode_answer(1, Answer(1, Status.TAKEN, 0)).identifier == 710


def test_what_is_no_parameter_telegram_is_refused() -> None:
    for bad in (Frame(310, bytes(7)), Frame(310, b"\x07\x03\x00\x00" + bytes(4)), Frame(310, b"\x07\x02\x00\x00\x00\x00\xc0\x7f")):
        with pytest.raises(ProtocolError):
            decode_request(bad)
    for answer in (Frame(710, b"\x07\x0f\x00\x00" + bytes(4)), Frame(610, bytes(8))):
        with pytest.raises(ProtocolError):
            decode_answer(answer)
    for request in (Request(0, 1), Request(57, 1), Request(1, 2**31), Request(1, 1e39)):
        with pytest.raises(ProtocolError):
            encode_request(1, request)
