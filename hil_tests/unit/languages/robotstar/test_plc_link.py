"""The robot program and the integrated PLC share markers, inputs and outputs."""

import pytest

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.languages.robotstar.plc_link import PlcLink, check_plc
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.script import NS, orders
from gateway.pure.languages.robotstar.virtual import VirtualCell
from hil_tests.unit.languages.robotstar.memory import WORDS, Ran, sources


def run(robot: str, plc: str, until: float | None, *at: str, mode: str = "auto", texts: str = "PLC 'PLCMSG_CNF'\nEND") -> Ran:
    faults = Faults()
    files = [*sources({"P.MPR": robot, "V.MPR": "VAR I1"}), Source("PLC/MAIN.PLC", plc), Source("PLC/PLCMSG_CNF.PLC", texts)]
    memory = Memory.read(files, WORDS, faults)
    cell = VirtualCell(memory, MODES[mode], PlcLink(memory.plc, "MAIN"))
    check(memory, faults, cell.system.names())
    cell.run(orders(at), None if until is None else round(until * NS), "P")
    return Ran(cell, [fault.text for fault in faults], cell.end("P"))


FOLLOW = "PLC 'MAIN'\nU M20.0\n= A5.3\nU E0.1\n= M21.0\nEND"
MESSAGES = 'PLC \'PLCMSG_CNF\'\nI 5, 0, "part \\d"\nI 6, 3, "door open"\nI 7, 7, "no air"\nEND'


def test_markers_go_both_ways() -> None:
    robot = "WRITE_BIT #MERKER,1,20,0\nWAIT_BIT #AUSGANG,1,5,3\nWAIT_BIT #MERKER,1,21,0\nCOPY 1,I1\nSTOP"
    ran = run(robot, FOLLOW, 5, "2 E0.1=1")
    assert ran.when("state") == [(0.0, "RUN")] and ran.when("A5") == [(0.01, 8)] and ran.when("M21") == [(2.0, 1)]
    assert ran.value("I1") == 1 and ran.state == "stopped"


def test_the_plc_goes_before_the_robot_at_an_output_both_write() -> None:
    ran = run("WRITE_BIT #AUSGANG,1,5,3\nWRITE_BIT #AUSGANG,1,5,4\nWAIT 1\nSTOP", FOLLOW, 1)
    assert [value for _, value in ran.when("A5")] == [16]
    ran = run("WAIT 0.1\nCOPY -1,_IBIN_OUT[2]\nWRITE_BIT #MERKER,1,2013,3\nSTOP", FOLLOW, 1)
    assert [value for _, value in ran.when("A5")] == [255 - 8]


def test_the_robot_writes_no_input_by_its_marker() -> None:
    for step in ("WRITE_BIT #MERKER,1,1968,0", "COPY 1,_SPS[493]"):
        assert run(f"{step}\nSTOP", FOLLOW, 1).texts() == ["an input is not written"]


def test_messages_by_m948() -> None:
    robot = "COPY 42,_SPS[239]\nCOPY 80000005H,_SPS[238]\nWAIT 1\nCOPY 80000006H,_SPS[238]\nWAIT 1\nCOPY 1,I1\nSTOP"
    ran = run(robot, FOLLOW, 5, texts=MESSAGES)
    assert ran.texts() == ["part 42", "door open"] and ran.message()["class"] == "message"
    assert (ran.state, ran.value("I1")) == ("error", None)
    ran = run(robot, FOLLOW, 9, "3 START", "4 ACK", "4.5 START", texts=MESSAGES)
    assert ran.texts()[2:] == ["START is refused: the error is not acknowledged; ACK acknowledges it"]
    assert (ran.state, ran.value("I1")) == ("stopped", 1)


def test_m948_is_0_again_behind_the_end_of_the_scan() -> None:
    """L2857: the PLC deletes M948; the log shows it, so that a second message is seen as one."""
    ran = run("COPY 80000005H,_SPS[238]\nWAIT 1\nCOPY 5,_SPS[238]\nWAIT 0.1\nSTOP", FOLLOW, 3, texts=MESSAGES)
    assert ran.when("M948") == [(0.0, 5), (0.01, 0), (1.0, 5), (1.01, 0)] and ran.when("M951") == [(0.0, 128), (0.01, 0)]


@pytest.mark.parametrize("mode", ["auto", "test4"])
def test_l2937_m996_has_the_input_and_the_level_a_program_waits_for(mode: str) -> None:
    robot = "WAIT 0.1\nWAIT_BIT #EINGANG,0,3,6,0.5,L\nLABEL L\nWAIT_BIT #EINGANG,1,4,1\nWAIT 1\nSTOP"
    plc = "PLC MAIN\nLD M996\nTD M100\nEND"
    ran = run(robot, plc, 5, "0 E3.6=1", "2 E4.1=1" if mode == "auto" else "2 F2", mode=mode)
    assert ran.when("M100") == [(0.11, 30), (0.61, 33), (2.01, 0)]
    assert ran.when("M102") == [(0.61, 1), (2.01, 0)] and ran.when("M103") == [(0.11, 128), (2.01, 0)]


def test_l2973_the_plc_and_the_program_see_how_far_the_robot_is_on_its_path() -> None:
    """100 mm at 100 mm/s with ramps of 0.05 s: half the way in the middle of 1.05 s."""
    robot = "TOOL T\nMOVE_MODE #LINEAR\nPATH_SPEED 100\nPATH_ACCEL 100\nPOSITION #N, X:100, Y:0, Z:0, A:0, B:0, C:0\n"
    plc = "PLC MAIN\nU E0.0\nSP N,0\nLD M1464\nTD M100\nLD M1468\nTD M104\nLD M1472\nTD M108\nLD M1476\nTD M112\nM N\nEND"
    ran = run(f"{robot}COPY _RPATH_DIST[1],I1\nADD _RTIME_DIST[1],I1\nADD _RPATH_DIST[2],I1\nSTOP", plc, 3, "0.51 E0.0=1", "0.53 E0.0=0")
    halves = [int.from_bytes(ran.cell.image[place : place + 4], "little") for place in range(100, 116, 4)]
    assert halves == pytest.approx([5000, 5000, 52, 52], abs=200) and halves[0] + halves[1] == 10000
    assert ran.value("I1") == 101, "of the position before: 100 mm and 1.05 s, nothing left"
    ends = [int.from_bytes(ran.cell.image[place : place + 4], "little") for place in range(1464, 1480, 4)]
    assert ends == [10000, 0, 105, 0]


def test_an_error_of_the_plc_stops_all() -> None:
    ran = run("WRITE_BIT #AUSGANG,1,0,0\nWAIT 100", "PLC 'MAIN'\nM L\nU E0.0\nSP L,1\nEND", 2, "1 E0.0=1")
    assert (ran.message()["number"], ran.state) == (7000, "error")
    assert ran.when("state") == [(0.0, "RUN"), (ran.message()["at"], "STOP")] and ran.when("drives")[0][1] == "OFF"
    assert ran.when("A0")[-1][1] == 0


def test_auto_start_and_override_by_the_plc() -> None:
    ran = run(
        "WAIT 1\nWRITE_BIT #AUSGANG,1,0,0\nSTOP",
        "PLC 'MAIN'\nU E0.0\n= M968.1\nU E0.2\n= M968.2\nEND",
        9,
        "0.5 E0.2=1",
        "2 E0.2=0",
        "3 E0.0=1",
    )
    assert [value for _, value in ran.when("A0")] == [1] and isinstance(at := ran.when("A0")[0][0], float) and 3.4 < at < 3.6


def test_l2946_the_plc_sees_that_a_held_robot_does_not_move() -> None:
    robot = "TOOL T\nPOSITION #N, X:0, Y:0, Z:500, A:0, B:0, C:0\nSTOP"
    plc = "PLC 'MAIN'\nU M1021.5\n= A0.0\nU E0.0\n= M1020.7\nL 100\nTD M1436\nU E0.1\nSP S,0\nL 0\nTD M1436\nM S\nEND"
    ran = run(robot, plc, 9, "0.5 E0.0=1", "1 E0.0=0", "1.5 E0.1=1", "2 E0.1=0")
    assert [level for _, level in ran.when("A0")] == [1, 0, 1, 0, 1, 0]
    assert [at for at, _ in ran.when("A0")][1:5] == pytest.approx([0.51, 1.01, 1.51, 2.01], abs=1e-6)
    assert ran.targets() == [(0, 0, 500)] and ran.state == "stopped"


def test_faults_of_plc_programs_are_named_by_file() -> None:
    faults = Faults()
    memory = Memory.read([Source("PLC/MAIN.PLC", "PLC 'MAIN'\nSU NONE\nNONSENSE\nEND")], WORDS, faults)
    check_plc(memory.plc, memory.plc_files, faults)
    assert {fault.position.file for fault in faults} == {"PLC/MAIN.PLC"} and "Subprogram not found" in " ".join(
        fault.text for fault in faults
    )


def test_the_run_ends_soon_after_the_program() -> None:
    ran = run("WAIT 3\nWRITE_BIT #MERKER,1,20,0\nSTOP", FOLLOW, None)
    assert ran.when("A5") == [(3.01, 8)] and ran.cell.now <= 5 * NS


WATCHES = """PLC MAIN
LD M944
TD M100
U M1021.0
= M104.0
U M1021.1
= M104.1
END
"""


def test_an_error_of_the_robot_program_is_in_the_markers_until_it_is_acknowledged() -> None:
    """M944, M1021.0 and M1021.1 (L2915, L2947, L2948), also where the PLC has no message of its own."""
    no_radius = "TOOL T\nBEWEG_ART #LINEAR\nUEBERSCHL #EIN\nBAHN_RADIUS 0\nPOSITION #N, X:9, Y:0, Z:0, A:0, B:0, C:0\nSTOP"
    ran = run(no_radius, WATCHES, 4, "1 ACK", "2 START", "3 ACK")
    assert [message for message in ran.texts() if "102" not in str(message)] == []
    assert ran.when("M104") == [(0.01, 1), (1.0, 2), (2.01, 1), (3.0, 2)]
    assert ran.when("M100") == [(0.01, 102), (1.0, 0), (2.01, 102), (3.0, 0)]
