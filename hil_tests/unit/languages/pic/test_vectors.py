"""Every PIC program the manual prints: it is read without a fault and does what the text says."""

import pytest

from hil_tests.unit.languages.pic.pics import Bench

DRIVES = [f"DRIVE_{n}_RCI" for n in (1, 2, 3, 4)]


def test_drives_on_by_the_program_or_by_switches() -> None:
    bench = Bench.of("DRIVES")
    bench.set("USER_9_DI", "USER_11_DI", "USER_2_RCO")
    assert bench.bits(*DRIVES) == "1010", "output 17 is off: the switches"
    assert bench.bits(*(f"USER_{n}_RCI" for n in (25, 26, 27, 28))) == "1010"
    bench.set("USER_17_RCO")
    assert bench.bits(*DRIVES) == "0100", "output 17 is on: the program"


def test_a_moving_axis_is_not_switched() -> None:
    bench = Bench.of("INPOS")
    bench.set(*(f"INPOS_{n}_RCO" for n in (1, 2, 3, 4)), *(f"USER_{n}_DI" for n in (9, 10, 11, 12)))
    assert bench.bits(*DRIVES) == "1111"
    bench.set("INPOS_2_RCO", "USER_9_DI", "USER_10_DI", value=False)
    assert bench.bits(*DRIVES) == "0111", "the second moves: it stays on; the first stands: it goes off"
    bench.set("USER_9_DI")
    assert bench.bits(*DRIVES) == "0111", "nothing is switched on while an axis moves"
    bench.set("INPOS_2_RCO")
    assert bench.bits(*DRIVES) == "1011"


@pytest.mark.parametrize(("switch", "seen"), [(True, "010"), (False, "101")])
def test_coupling_and_serial_line_share_one_interface(switch: bool, seen: str) -> None:
    bench = Bench.of("COUPL")
    bench.set("COUPL_ON_DI", value=switch)
    assert bench.bits("DISCOUPL_RCI", "DISSER_1_RCI", "USER_1_RCI") == seen


def test_the_program_switches_the_interface() -> None:
    bench = Bench.of("V24")
    assert bench.bits("DISCOUPL_RCI", "DISSER_1_RCI") == "01"
    bench.set("USER_1_RCO")
    assert bench.bits("DISCOUPL_RCI", "DISSER_1_RCI") == "10"


def test_one_program_for_two_machine_configurations() -> None:
    bench = Bench.of("MACHTYPE")
    bench.set("M1_END4_P", "ANGRUP_1", "JOG1MPHG", "JOG3PPHG", "ANGRUP_2", "JOG4PPHG")
    assert bench.bits("USER_42_RCI", "USER_43_RCI", "USER_7_RCI", "USER_8_RCI") == "1000"
    assert bench.bits("JOG_1_M", "JOG_3_P", "JOG_8_P") == "110", "control 1 jumps over the keys of control 2"
    bench.set("MA_TYP_1_RCO")
    assert bench.bits("USER_42_RCI", "USER_43_RCI", "USER_7_RCI", "USER_8_RCI") == "0101"
    assert bench.bits("JOG_8_P") == "1"
    bench.set("FAHRVER1", "SVE_BETN", "M1_ANTRB")
    assert bench.bits("FAHRVER1") == "1"
    bench.set("M1_ANTRB", value=False)
    assert bench.bits("FAHRVER1") == "0"
