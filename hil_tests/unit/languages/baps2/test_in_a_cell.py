"""BAPS2 programs in a cell of emulated drives, in virtual time: movement, outputs, processes, stops, deaths (AX-860, AX-861)."""

import pathlib
from collections.abc import Callable
from dataclasses import replace

import pytest

import configs
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.rho3 import ParamValue, Rho3
from gateway.pure.controllers.rho3.signals.hosted import HostedPrograms
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.virtual.baps2_bench import ABORT, ACKNOWLEDGE, AUTOMATIC, CELL, CODE, KEEP, PARITY, RESET, SELECT, ProgramCell, one
from motion.paths.corner import MISS

MEMORY = pathlib.Path(configs.__file__).parent / "cells" / "palletiser"


def near(cell: ProgramCell, *place: float) -> bool:
    return cell.at() == pytest.approx(place, abs=0.01)


def test_the_shipped_palletiser_lays_four_parts_down() -> None:
    cell = ProgramCell({path.name: path.read_text() for path in MEMORY.iterdir()})
    assert cell.run("PALLET", 120.0) == ("ended", 0, "", "PALLET.QLL line 40")
    assert near(cell, 60, 60, 150, 0)
    switched = [(channel, value) for _, channel, value in cell.outputs]
    assert switched == [(1, True), (1, False)] * 4 + [(2, True)]
    laid = [place for place in cell.places if abs(place[2] - 60.0) < 0.01 and place[0] > 300]
    assert {(round(x), round(y)) for x, y, _, _ in laid} == {(400, 200), (400, 350), (520, 200), (520, 350)}
    assert "LAST = (520, 350, 60, 90)" in (cell.memory.text("PALLET.PKT") or "")


def test_world_and_joint_points_relative_moves_and_circles() -> None:
    cell = ProgramCell(
        one("""
MOVE PTP TO @(100, 100, 100, 10)
MOVE LINEAR TO (200, 150, 120, 20)
MOVE_REL LINEAR (10, 0, -20, 5)
MOVE_REL PTP @(0, 5, 0, 0)
MOVE CIRCULAR VIA (260, 205, 100, 25) TO (310, 155, 100, 25)
""")
    )
    assert cell.run("P")[0] == "ended"
    assert near(cell, 310, 155, 100, 25)
    assert any(place[:3] == pytest.approx((210, 155, 100), abs=0.01) for place in cell.places)
    assert max(place[1] for place in cell.places) == pytest.approx(205, abs=0.5), "the circle goes through its first point"


def test_speeds_of_lines_and_of_ptp_are_those_of_the_program() -> None:
    body = "V = {v}\nVFACTOR = {f}\nMOVE LINEAR TO (500, 60, 40, 12)\nV_PTP = {p}\nMOVE PTP TO @(60, 60, 40, 12)"
    cell = ProgramCell(one(body.format(v=400, f=0.5, p=0.25)))
    assert cell.run("P")[0] == "ended"
    steps = [abs(b[0] - a[0]) / 0.004 for a, b in zip(cell.places, cell.places[1:], strict=False)]
    out = cell.places.index(max(cell.places, key=lambda place: place[0]))
    assert max(steps[:out]) == pytest.approx(200, rel=0.01)
    assert max(steps[out:]) == pytest.approx(0.25 * 0.5 * 800, rel=0.01)


def speeds(cell: ProgramCell, test: Callable[[float, float], bool]) -> list[float]:
    """mm/s in the plane where the test of x and y holds."""
    pairs = zip(cell.places, cell.places[1:], strict=False)
    return [((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2) ** 0.5 / 0.004 for a, b in pairs if test(a[0], a[1])]


def test_with_acts_on_its_block_alone_and_via_is_passed_with_r() -> None:
    body = "V = 300\n"
    body += "MOVE PTP TO @(60, 60, 40, 12)\nMOVE LINEAR WITH V = 100 TO (100, 60, 40, 12)\nMOVE LINEAR WITH R = 60 VIA (300, 60, 40, 12)\n"
    cell = ProgramCell(one(body + "MOVE LINEAR TO (300, 260, 40, 12)"))
    assert cell.run("P")[0] == "ended"
    assert max(speeds(cell, lambda x, y: 60.5 < x < 99)) == pytest.approx(100, abs=5)
    assert max(speeds(cell, lambda x, y: 150 < x < 200)) == pytest.approx(300, rel=0.02)
    assert min(speeds(cell, lambda x, y: x > 280 and y < 100)) > 50, "the point is passed without a stop"
    assert min((300 - x) ** 2 + (60 - y) ** 2 for x, y, _, _ in cell.places) > 4.0


CORNER = """V = 300
V_PTP = 0.5
{before}MOVE {way} {with_}VIA @(300, 60, 40, 12)
MOVE {way} {with_}VIA @(300, 260, 40, 12)
MOVE {way} TO @(100, 260, 40, 12)"""


def missed(before: str = "", way: str = "LINEAR", with_: str = "", **parameters: ParamValue) -> tuple[float, float]:
    """How far the path leaves the first and the second corner aside, mm; parameters: of [rho3]."""
    cell = ProgramCell(one(CORNER.format(before=before, way=way, with_=with_)), replace(CELL, rho3=Rho3(others=parameters)))
    assert cell.run("P")[0] == "ended"
    first, second = (min(((x - 300) ** 2 + (y - at) ** 2) ** 0.5 for x, y, _, _ in cell.places) for at in (60, 260))
    return first, second


@pytest.mark.requirement("RHO-MOT-08", by="motion.program.passing:Passing.block")
def test_p212_holds_without_r_in_the_program_and_p214_takes_one_value_for_the_kinematic() -> None:
    assert max(missed()) < 0.01, "nothing is given: the points are reached"
    first, second = missed(P212=((40.0, 0.0),))
    assert first > 2 and second == pytest.approx(first, rel=0.1)
    by_axes, _ = missed(way="PTP", P212=((0.0, 1.0),), P213=((40.0, 40.0, 40.0, 40.0),))
    in_space, _ = missed(way="PTP", P212=((0.0, 0.5),), P213=((40.0,),), P214=(1,))
    assert by_axes > 2 and 1 < in_space < by_axes


@pytest.mark.requirement("RHO-MOT-09", by="motion.program.passing:Passing.set_radius")
def test_r_stays_with_r_holds_for_its_block_and_zero_switches_passing_off() -> None:
    first, second = missed("R = 50\n")
    assert first == pytest.approx(second, rel=0.15) and first > 2
    there, with_20 = "MOVE LINEAR TO @(60, 60, 40, 12)\n", "MOVE LINEAR WITH R = 20 TO @(60, 60, 40, 12)\n"
    assert missed(f"R = 50\n{with_20}") == pytest.approx(missed(f"R = 50\n{there}"), abs=0.01), "R = 50 again after the block"
    smaller = missed("R = 50\n", with_="WITH R = 20 ")
    half_step = 300 * 0.004 / 2  # mm: the place nearest to the corner is looked for among those of the cycles
    aside = half_step**2 / (2 * 0.4 * first)
    assert smaller == pytest.approx((0.4 * first, 0.4 * second), abs=aside), "the way past a corner grows with R"
    assert smaller[1] == pytest.approx(MISS * 2**0.5 * 20, abs=aside), "a right angle"
    assert max(missed("R = 0\n", P212=((40.0, 0.0),))) < 0.01


def test_r_ptp_outside_its_range_is_a_runtime_error() -> None:
    cell = ProgramCell(one("R_PTP = 101\nMOVE PTP VIA @(80, 60, 40, 12)\nMOVE PTP TO @(80, 80, 40, 12)"))
    assert cell.run("P")[1:3] == (218, "value out of range: R_PTP 101 is outside 0.01 .. 100 (0: off)")


def test_outputs_and_waits_act_where_the_block_before_ends() -> None:
    cell = ProgramCell(
        one(
            """
MOVE PTP TO @(120, 60, 40, 12)
LAMP = 1
WAIT 0.5
LAMP = 0
MOVE PTP TO @(60, 60, 40, 12)
""",
            "OUTPUT : 3 = LAMP",
        )
    )
    began = len(cell.places)
    assert cell.run("P")[0] == "ended"
    (on, _, _), (off, _, _) = cell.outputs
    at = {t: round((t * 1e9 - 1e12) / 4e6) - 0 for t in (on, off)}
    assert off - on == pytest.approx(0.5, abs=0.03)
    there = [n for n, place in enumerate(cell.places) if abs(place[0] - 120) < 0.001]
    assert began < there[0] <= at[on] <= there[0] + 12, "at most 50 ms behind the end of the block"
    assert at[off] <= there[-1] + 1


def test_an_input_is_read_when_the_program_comes_to_it() -> None:
    cell = ProgramCell(
        one(
            """
MOVE PTP TO @(160, 60, 40, 12)
IF PART = 1 THEN MOVE PTP TO @(160, 100, 40, 12) ELSE MOVE PTP TO @(160, 20, 40, 12)
WAIT UNTIL GO = 1
MOVE PTP TO @(60, 60, 40, 12)
""",
            "INPUT : 1 = PART, 2 = GO",
        )
    )
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 100)
    cell.give(1)
    cell.until(lambda: near(cell, 160, 100, 40, 12))
    cell.bench.run(1.0)
    assert near(cell, 160, 100, 40, 12), "it waits"
    cell.give(2)
    assert cell.ends(run)[0] == "ended" and near(cell, 60, 60, 40, 12)


@pytest.mark.requirement("RHO-MOT-51", by="gateway.pure.languages.baps2.control:Control._read_input")
def test_a_normal_input_stops_the_preparation_and_its_asynchronous_twin_is_read_at_once() -> None:
    body = "V = 100\nMOVE LINEAR TO (160, 60, 40, 12)\nN = EARLY\nM = LATE\nIF N = 1 THEN LAMP = 1\nIF M = 1 THEN HORN = 1"
    cell = ProgramCell(one(body, "INPUT : 1 = LATE, 1001 = EARLY\nBINARY : N, M\nOUTPUT : 3 = LAMP, 4 = HORN"))
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 80)
    cell.give(1)
    assert cell.ends(run)[0] == "ended"
    assert [channel for _, channel, _ in cell.outputs] == [4], "1001 was 0 when the movement was prepared"


def test_stop_on_the_path_and_resume_go_on_with_the_program() -> None:
    cell = ProgramCell(one("V = 100\nMOVE LINEAR TO (400, 60, 40, 12)\nMOVE LINEAR TO (400, 160, 40, 12)"))
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 200)
    assert cell.bench.settle(cell.bench.give(Code.STOP)).state.name == "DONE"
    assert cell.bench.core.state.motion is Motion.STOPPED
    here = cell.at()
    cell.bench.run(1.0)
    assert cell.at() == here and run not in cell.hosted.results
    cell.bench.give(Code.RESUME)
    assert cell.ends(run)[0] == "ended" and near(cell, 400, 160, 40, 12)


def test_override_and_feed_hold_act_as_on_any_motion() -> None:
    cell = ProgramCell(one("V = 200\nMOVE LINEAR TO (500, 60, 40, 12)"))
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 100)
    cell.bench.give(Code.OVERRIDE, velocity=0.5)
    cell.bench.run(1.0)
    before = cell.at()[0]
    cell.bench.run(0.4)
    assert (cell.at()[0] - before) / 0.4 == pytest.approx(100, rel=0.05)
    cell.bench.permit(27, value=False)
    cell.bench.run(1.0)
    held = cell.at()
    cell.bench.run(0.5)
    assert cell.at() == held
    cell.bench.permit(27)
    assert cell.ends(run)[0] == "ended" and near(cell, 500, 60, 40, 12)


def test_emergency_stop_ends_the_process_with_its_reason() -> None:
    cell = ProgramCell(one("V = 100\nMOVE LINEAR TO (400, 60, 40, 12)"))
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 150)
    cell.bench.permit(24, value=False)
    how, code, text, place = cell.ends(run)
    assert (how, code) == ("aborted", 253) and "EMERGENCY" in text.upper() and place.startswith("P.QLL line ")
    assert 140 < cell.at()[0] < 200
    assert [process.state.name for process in cell.control.processes.processes] == ["FAULTY"]
    cell.bench.permit(24)
    cell.bench.permit(ACKNOWLEDGE)
    cell.bench.run(0.1)
    assert not cell.control.processes.processes, "acknowledged"


def test_a_process_that_is_stopped_stops_on_the_path_and_gives_its_rest_up() -> None:
    cell = ProgramCell(one("V = 100\nMOVE LINEAR TO (400, 60, 40, 12)"))
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 150)
    cell.control.processes.stop(cell.control.processes.processes[0].number)
    assert cell.ends(run)[0] == "stopped"
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE)
    assert 150 < cell.at()[0] < 200
    assert cell.run("P")[0] == "ended" and near(cell, 400, 60, 40, 12)


def test_the_death_of_the_interpreter_ends_processes_and_lets_the_axes_rest() -> None:
    cell = ProgramCell(one("V = 400\nAGAIN:\nMOVE LINEAR TO (300, 60, 40, 12)\nMOVE LINEAR TO (100, 60, 40, 12)\nJUMP AGAIN"))
    cell.start("P")
    cell.until(lambda: cell.at()[0] > 150)
    cell.dies()
    cell.bench.run(0.1)
    assert not cell.control.processes.processes
    assert [each.code for each in cell.errors.records] == [1276]
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE, 60.0)
    assert round(cell.at()[0]) in (100, 300), "at the end of what was handed on"
    cell.born(2)
    cell.bench.run(1.0)
    assert not cell.control.processes.processes and cell.bench.core.state.motion is Motion.IDLE, "nothing starts by itself"
    assert "P" in cell.control.processes.programs


def test_manual_bars_programs_and_ends_one_that_moves() -> None:
    cell = ProgramCell(one("V = 100\nMOVE LINEAR TO (400, 60, 40, 12)"))
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 150)
    cell.bench.permit(AUTOMATIC, value=False)
    assert cell.ends(run)[1] == 251
    cell.bench.permit(ACKNOWLEDGE)
    cell.bench.run(0.2)
    cell.bench.permit(ACKNOWLEDGE, value=False)
    assert cell.run("P")[1] == 250


def test_a_target_out_of_reach_names_its_line() -> None:
    cell = ProgramCell(one("MOVE PTP TO @(100, 60, 40, 12)\n\nMOVE PTP TO @(5000, 60, 40, 12)"))
    how, code, text, place = cell.run("P")
    assert (how, code, place) == ("aborted", 253, "P.QLL line 10") and "5000" in text
    assert cell.at()[0] < 100.01, "on the way to the point before"


def test_branches_and_started_programs_move_one_after_the_other() -> None:
    files = one(
        """
START OTHER
PARALLEL
MOVE_REL PTP @(40, 0, 0, 0)
MOVE_REL PTP @(20, 0, 0, 0)
ALSO
LAMP = 1
PARALLEL_END
MOVE_REL PTP @(-60, 0, 0, 0)
""",
        "OUTPUT : 3 = LAMP\nEXTERNAL : OTHER",
    )
    files |= one("REPEAT 2 TIMES\nMOVE_REL PTP @(0, 35, 0, 0)\nMOVE_REL PTP @(0, -30, 0, 0)\nREPEAT_END", name="OTHER")
    cell = ProgramCell(files)
    before = cell.at()
    run = cell.start("P")
    cell.bench.run(0.1)
    assert {process.name: process.kind.name for process in cell.control.processes.processes} == {"P": "NORMAL", "OTHER": "SUB"}
    assert cell.ends(run)[0] == "ended"
    cell.until(lambda: not cell.control.processes.processes)
    ways = [sum(abs(b[n] - a[n]) > 1e-6 for n in (0, 1)) for a, b in zip(cell.places, cell.places[1:], strict=False)]
    assert max(ways) == 1 and cell.at()[:2] == pytest.approx((before[0], before[1] + 10), abs=0.01)


def test_points_and_positions_come_from_the_axes_and_stay() -> None:
    cell = ProgramCell(
        one(
            """
MOVE PTP TO @(150, 60, 40, 30)
HERE = POS
@THERE = @POS
HERE.Z = HERE.Z + 25
MOVE PTP TO @(60, 60, 40, 12)
MOVE LINEAR TO HERE
""",
            "DEF POINT : HERE\nDEF JC_POINT : @THERE",
            points="HERE = (1, 2, 3, 4) ; taught\n",
        )
    )
    assert cell.run("P")[0] == "ended"
    assert near(cell, 150, 60, 65, 30)
    assert (cell.memory.text("P.PKT") or "").splitlines() == ["HERE = (150, 60, 65, 30) ; taught", "@THERE = @(150, 60, 40, 30)"]


def test_move_until_ends_at_its_input_and_says_whether_it_came() -> None:
    cell = ProgramCell(
        one(
            """
V = 100
MOVE PTP TO @(60, 60, 40, 12)
MOVE LINEAR UNTIL PROBE = 1 ERROR LAMP = 1 TO (300, 60, 40, 12)
HERE = POS
MOVE_REL LINEAR (0, 0, 30, 0)
MOVE LINEAR UNTIL PROBE = 0 ERROR LAMP = 1 TO (300, 100, 70, 12)
""",
            "INPUT : 1 = PROBE\nOUTPUT : 3 = LAMP\nDEF POINT : HERE",
        )
    )
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 150)
    cell.give(1)
    assert cell.ends(run)[0] == "ended"
    assert near(cell, 300, 100, 70, 12), "the second input never came"
    assert [(channel, value) for _, channel, value in cell.outputs] == [(3, True)]
    here = (cell.memory.text("P.PKT") or "").partition("(")[2].partition(",")[0]
    assert 150 < float(here) < 165, "it stopped on its path"


@pytest.mark.requirement("RHO-MOT-11", by="gateway.pure.cycle.mover:Mover.judge")
@pytest.mark.parametrize("when", ["before", "on the way", "never"])
def test_the_error_part_of_move_until_is_run_only_where_the_input_never_came(when: str) -> None:
    body = "MOVE LINEAR UNTIL PROBE = 1 ERROR JUMP MISSED TO (300, 60, 40, 12)\nFOUND = 1\nHALT\nMISSED:\nLOST = 1"
    cell = ProgramCell(one(f"MOVE PTP TO @(60, 60, 40, 12)\n{body}", "INPUT : 1 = PROBE\nOUTPUT : 3 = FOUND, 4 = LOST"))
    if when == "before":
        cell.give(1)
    run = cell.start("P")
    if when == "on the way":
        cell.until(lambda: cell.at()[0] > 150)
        cell.give(1)
    assert cell.ends(run)[0] == "ended"
    assert [channel for _, channel, _ in cell.outputs] == [4 if when == "never" else 3]
    assert (cell.at()[0] == 60) is (when == "before"), "an input that has the value already: no movement (L1126)"
    assert (cell.at()[0] == 300) is (when == "never")


def test_a_point_outside_the_travel_ends_the_program_in_the_words_of_the_rho_3_alone() -> None:
    how, code, text, place = ProgramCell(one("MOVE LINEAR TO (100000, 60, 60, 0)")).run("P")
    assert (how, code, place) == ("aborted", 253, "P.QLL line 8")
    assert "axis X: point not reachable" in text and "VAL 3" not in text


def test_a_calculated_angle_of_nothing_is_kept_as_0() -> None:
    cell = ProgramCell(one("MOVE LINEAR TO (50, 60, 70, 0)\nHERE = POS", "DEF POINT : HERE"))
    assert cell.run("P")[0] == "ended"
    assert (cell.memory.text("P.PKT") or "").strip() == "HERE = (50, 60, 70, 0)"


@pytest.mark.requirement("RHO-BAP-12", by="gateway.pure.controllers.rho3.signals.hosted:HostedPrograms._program")
def test_a_permanent_process_outlasts_a_control_reset_and_ends_by_the_abort_of_the_plc() -> None:
    files = one("AGAIN:\nLAMP = 1\nWAIT 0.1\nLAMP = 0\nWAIT 0.1\nJUMP AGAIN", "OUTPUT : 3 = LAMP", name="PALLET")
    files["PALLET.QLL"] = ";;PROCESS_KIND = PERMANENT\n" + files["PALLET.QLL"]
    cell = ProgramCell(files)
    cell.bench.permit(CODE, PARITY)
    cell.bench.run(0.1)
    cell.bench.permit(SELECT)
    cell.bench.run(1.0)
    assert [(process.name, process.kind.name) for process in cell.control.processes.processes] == [("PALLET", "PERMANENT")]
    assert len(cell.outputs) >= 6
    cell.bench.permit(SELECT, value=False)
    cell.bench.permit(KEEP, RESET)
    cell.bench.run(0.5)
    assert cell.control.processes.processes, "RC input 61 keeps it"
    cell.bench.permit(ABORT)
    cell.bench.run(0.2)
    assert not cell.control.processes.processes and not cell.language.rows()


def test_runtime_errors_have_the_manuals_number_text_and_line() -> None:
    cell = ProgramCell(one("N = 0\nN = 5 / N", "INTEGER : N"))
    how, code, text, place = cell.run("P")
    assert (how, code, text, place) == ("aborted", 209, "division by zero", "P.QLL line 9")
    assert [(each.code, each.where) for each in cell.errors.records] == [(209, "P.QLL line 9")]
    assert "P: 209 division by zero (P.QLL line 9)" in cell.told


def test_what_a_cell_cannot_do_ends_the_program_in_words() -> None:
    cell = ProgramCell(one("MIRROR(1)", "SPC_FCT : 17 = MIRROR (VALUE INTEGER : K)"))
    assert cell.run("P")[1:3] == (204, "option not found: special function 17 is only named in the manual")
    cell = ProgramCell(one("IF X = 1 THEN WAIT 1", "INPUT : 150 = X"))
    assert cell.run("P")[1:3] == (206, "inadmissable input: 150")


@pytest.mark.requirement("RHO-SER-33", by="gateway.pure.languages.baps2.outside:Outside.condition")
def test_condition_of_a_file_is_0_where_it_is_and_minus_1_where_it_is_not() -> None:
    body = "IF CONDITION(HERE) = 0 THEN A = 1\nIF CONDITION(GONE) = -1 THEN B = 1\nASSIGN GONE, 'HERE'\nIF CONDITION(GONE) = 0 THEN C = 1"
    files = one(body, "FILE : HERE, GONE\nOUTPUT : 3 = A, 4 = B, 5 = C")
    cell = ProgramCell({**files, "HERE.DAT": "1\r\n"})
    assert cell.run("P")[:2] == ("ended", 0)
    assert [channel for _, channel, _ in cell.outputs] == [3, 4, 5]


def test_an_endless_loop_delays_nobody() -> None:
    files = one("N = 0\nAGAIN:\nN = (N + 1) MOD 1000\nJUMP AGAIN", "INTEGER : N", name="BUSY")
    files |= one("MOVE PTP TO @(100, 60, 40, 12)")
    cell = ProgramCell(files)
    cell.start("BUSY")
    assert cell.run("P")[0] == "ended" and near(cell, 100, 60, 40, 12)


def test_services_that_begin_anew_find_no_process_and_can_start_one() -> None:
    cell = ProgramCell(one("V = 100\nMOVE LINEAR TO (300, 60, 40, 12)\nMOVE LINEAR TO (100, 60, 40, 12)"))
    cell.start("P")
    cell.until(lambda: cell.at()[0] > 150)
    for process in cell.control.processes.processes:
        cell.control.processes.stop(process.number)
    cell.hosted = cell.control.hosted = HostedPrograms(cell.control)
    cell.language.stop_all(cell.bench.now)
    assert not cell.language.rows() and not cell.language.paths.stretches
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE, 60.0)
    assert cell.run("P")[0] == "ended" and near(cell, 100, 60, 40, 12)
