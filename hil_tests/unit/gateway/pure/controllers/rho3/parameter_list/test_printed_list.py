"""`axisgate import p-list`: the printed machine-parameter list becomes a cell, and says what it took, assumed and left aside (AX-272)."""

import pathlib

import pytest

from gateway.cell_file.load import CellFaults, load_cell
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.rho3.parameter_list.cell_file import Report, import_list
from gateway.pure.controllers.rho3.parameter_list.lines import Entry, Unread, read

LIST = (pathlib.Path(__file__).parents[6] / "vectors" / "rho3_plist.txt").read_text()


def imported(text: str = LIST) -> tuple[Cell, Report]:
    file, report = import_list(text, "robot2")
    return load_cell("robot2.toml", file), report


def test_the_whole_list_becomes_a_cell_that_check_passes() -> None:
    cell, report = imported()
    assert report.missing == []
    assert [(bus.name, bus.protocol, bus.axes, bus.bitrate) for bus in cell.bus] == [
        ("can0", "servodyn", "1..3", "1 Mbit/s"),
        ("can1", "rho3-io", "", "500 kbit/s"),
    ]
    assert cell.cycle_ms == 8 and cell.rho3 is not None
    assert (cell.rho3.P2, cell.rho3.P9, cell.rho3.P15, cell.rho3.P20, cell.rho3.P21) == (3, 40, (3, 0, 0), 15, (0, 44, 0, 44))
    assert [(each.bus, each.start, each.length, each.id) for each in (*cell.rho3.P31, *cell.rho3.P32)] == [
        (2, 88, 8, 541),
        (2, 96, 4, 542),
        (2, 88, 8, 471),
    ]


def test_axes_have_the_numbers_of_the_list() -> None:
    cell, _ = imported()
    one, two, three = cell.axis
    assert [(axis.limits.min, axis.limits.max, axis.limits.speed, axis.limits.accel) for axis in (one, two)] == [
        (-165.0, 165.0, 120.0, 300.0),
        (-60.0, 110.0, 110.0, 280.0),
    ]
    assert [axis.drive.inc_per_turn for axis in cell.axis] == [16384, 8192, 4096]
    assert [axis.home.mode for axis in cell.axis] == [0, 1, 2]
    assert [axis.mechanics.direction for axis in cell.axis] == ["+", "-", "+"]
    assert two.mechanics.ratio == 4.1 and three.home.speed == 20.0 and two.home.position == 90.0


def test_p306_gives_the_monitoring_of_axis_speeds_for_each_kinematic_and_nothing_else() -> None:
    """L5582-5589: sub-query 6, "Monitoring axis WC"."""
    cell, report = imported(LIST + "P306 ROBI_1\nRobot type : 3\nMonitoring axis WC : 3\nP306 ROBI_2\nMonitoring axis WC : 1\n")
    assert cell.rho3 is not None and [each.monitoring for each in cell.rho3.P306] == [3, 1]
    assert any("P306 'Robot type'" in each for each in report.ignored)


def test_drive_parameters_are_kept_but_the_download_stays_off() -> None:
    cell, report = imported()
    assert cell.rho3 is not None and not cell.rho3.P601
    assert cell.rho3.others["P606"] == (60.0, 60.0, 80.0)
    assert cell.rho3.others["P607"] == ((250.0, 150.0, 300.0), (250.0, 150.0, 300.0), (200.0, 100.0, 300.0))
    assert cell.rho3.others["P615"] == (True, True, False)
    assert any(each.startswith("P601 = TRUE in the list: written as false") for each in report.assumed)


def test_what_the_list_does_not_say_is_reported_as_an_assumption() -> None:
    """The control asks for the gear factor in modes 1 and 3 only (L7383)."""
    _, report = imported()
    said = "\n".join(report.assumed)
    assert "P401 of axis 1: gear factor 360: read out of the evaluation 16384 as degrees a motor turn x 16384; measure it" in said
    assert "P401 of axis 3: gear factor 18000:" in said and "axis 2: gear" not in said
    assert "every axis turns (deg)" in said and "P31 block 1: on bus 2" in said


def test_lines_nobody_needs_are_named_with_their_number() -> None:
    _, report = imported()
    ignored = "\n".join(report.ignored)
    assert "line 7: P18 're-entered': axisgate does not use it" in ignored
    assert "line 2: 'MACHINE PARAMETERS                                     page 1': comes before the first parameter" in ignored
    assert "'end of list': no value in it" in ignored
    assert len(report.taken) + len(report.ignored) == sum(isinstance(each, Entry | Unread) for each in read(LIST))


def test_a_number_changed_in_the_list_is_changed_in_the_cell() -> None:
    cell, _ = imported(LIST.replace("A_2 : 110,0", "A_2 : 111,5").replace("A_1 CAN input	:	1", "A_1 CAN input	:	6"))
    assert cell.axis[1].limits.speed == 111.5 and cell.axis[0].drive.module == 6


@pytest.mark.parametrize(("number", "key"), [("P204", "limits"), ("P103", "limits"), ("P108", "home.speed")])
def test_what_is_missing_is_reported_and_check_asks_for_it(number: str, key: str) -> None:
    lines = LIST.splitlines()
    start = next(n for n, line in enumerate(lines) if line.startswith(number))
    end = next(n for n in range(start + 1, len(lines)) if lines[n].startswith("P"))
    file, report = import_list("\n".join(lines[:start] + lines[end:]), "robot2")
    assert f"{number} of axis 1, 2, 3: axisgate check reports it as missing" in report.missing
    with pytest.raises(CellFaults) as found:
        load_cell("robot2.toml", file)
    assert all(key in fault.key for fault in found.value.faults), [str(fault) for fault in found.value.faults]


def test_twelve_axes_become_two_buses() -> None:
    text = ["P5 : 8", "P15 : 3"]
    for number, value in ((103, 100), (104, 300), (108, 10), (204, 90), (205, 90)):
        text.append(f"P{number} : " + " ".join([f"{value}.0"] * 12))
    text.append("P401")
    for axis in range(1, 13):
        text += [
            f"A_{axis} CAN input : {axis}",
            f"A_{axis} Pulse/rotation : 16384",
            f"A_{axis} MBewert : 16384.0",
            f"A_{axis} Setpoint output : {axis}",
        ]
    cell, _ = imported("\n".join(text))
    assert [(bus.protocol, bus.axes) for bus in cell.bus] == [("servodyn", "1..6"), ("servodyn", "1..6")]
    assert [(axis.drive.bus, axis.drive.module) for axis in cell.axis][5:8] == [("can0", 6), ("can1", 1), ("can1", 2)]


@pytest.mark.parametrize("text", ["", "nothing here", "P", "P999 x : y", "P401\nA_1 CAN input : X51", "\0\xff", "P31\nIdentifier : 541"])
def test_junk_gives_a_report_and_never_an_exception(text: str) -> None:
    file, report = import_list(text, "junk")
    assert "[cell]" in file and report.missing


def test_a_heading_in_the_form_of_the_manual_is_understood() -> None:
    entries = list(read("### **P5 clock start time**\n8\n#### **P15 servo board types**\n3 5\nP21\nI.START : 0"))
    values = [(each.parameter, each.label, each.values) for each in entries if isinstance(each, Entry)]
    assert values == [(5, "", (8,)), (15, "", (3, 5)), (21, "I.START", (0,))]


FOUR = """P5 8
P103 170.0 110.0 160.0 200.0
P104 -170.0 -60.0 -160.0 -200.0
P108 120.0 110.0 100.0 90.0
P204 60.0 60.0 60.0 60.0
P205 300.0 300.0 300.0 300.0
P109 10.0
P401
A_1
Eingang auf Modul : 1
Impulse/Umdrehung : 16384
MBewert : 16384.0
Getriebefaktor : 121.0
A_2
Eingang auf Modul : 2
Impulse/Umdrehung : 8192
MBewert : -8192.0
Getriebefaktor : 80.5
Farbe : 3
"""


def test_axes_without_a_measuring_system_are_named_with_the_values_they_lose() -> None:
    _, report = import_list(FOUR, "four")
    said = [each for each in report.missing if each.startswith("P401 of axis")]
    assert [each.split(":")[0] for each in said] == ["P401 of axis 3", "P401 of axis 4"]
    assert all("P103, P104, P108, P204, P205 have values of it" in each for each in said)
    assert any(each.startswith("P109 of axis 2: values of axis 1 only are not written") for each in report.missing)


def test_a_german_list_gives_its_gear_factors() -> None:
    file, report = import_list(FOUR, "four")
    assert "gear_factor = 121.0" in file and "gear_factor = 80.5" in file and not any("gear factor" in each for each in report.assumed)
    assert [each for each in report.ignored if "P401" in each] == ["line 19: P401 'Farbe': no entry of a measuring system that is known"]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("P401\nGetriebefaktor : 121.0\n", "P401 'Getriebefaktor': no axis precedes it"),
        ("P401\nA_1 Gear factor : all\n", "P401 'Gear factor': its value is not a number"),
        ("P401\nA_1 Gear factor : 1.0 2.0\n", "one value is expected, there are 2"),
        ("P5 8 16\n", "one value is expected, there are 2"),
        ("P9 40.5\n", "a whole number is expected"),
        ("P2 3\nP2 4\n", "given above as 3, which is used"),
        ("P103 all\n", "its value is not a number"),
        ("P21\nX.START : 3\n", "neither one of I.START"),
        ("P30\nColour : 3\n", "neither input blocks"),
        ("P31\nColour : 3\n", "neither address"),
    ],
)
def test_every_line_that_is_left_aside_says_why(more: str, words: str) -> None:
    _, report = import_list(more, "x")
    assert any(words in each for each in report.ignored), report
    assert not any(each in report.taken for each in report.ignored)


def test_halves_of_ranges_and_blocks_are_named() -> None:
    _, report = import_list("P21\nI.START : 0\nO.END : 44\nP31\nAddress : 88\nLength : 8\nP30\nBUS 2\nBaud rate : 2\n", "x")
    said = "\n".join(report.missing)
    assert "P21: I.END, O.START; what the list has of P21 is not written" in said
    assert "P31 block 1: identifier; the block is not written" in said
    assert "P30 of bus 2: input blocks, output blocks not in the list: 0" in "\n".join(report.assumed)


def test_several_numbers_of_a_measuring_system_are_one_for_each_axis() -> None:
    file, _ = import_list("P401\nGear factor : 121.0 80.5\n", "x")
    assert file.index("gear_factor = 121.0") < file.index("gear_factor = 80.5") and file.count("[[rho3.P401]]") == 2


def test_every_entry_is_taken_or_left_aside_once() -> None:
    for text in (LIST, FOUR):
        _, report = import_list(text, "x")
        assert len(report.taken) + len(report.ignored) == sum(isinstance(each, Entry | Unread) for each in read(text))
