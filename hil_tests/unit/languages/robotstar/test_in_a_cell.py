"""ROBOTstar programs in a cell of emulated drives, in virtual time: movement, bits, modes, stops, deaths (AX-940)."""

import math
import pathlib

import pytest

import configs
from gateway.files.robotstar import words
from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.records.cell import Motion
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.memory import Memory, Source
from hil_tests.lab.virtual.reis_bench import AUTO, ReisCell, at, main

MEMORY = pathlib.Path(configs.__file__).parent / "cells" / "reis-palletiser"
LINE = "MOVE_MODE #LINEAR\nPATH_SPEED 500\n"
FAR, BACK = at(900, 250, 590), at(900, -50, 590)


def near(cell: ReisCell, *place: float, by: float = 0.05) -> bool:
    return math.dist(cell.where(), place) < by


def speeds(cell: ReisCell) -> list[float]:
    """mm/s in each cycle."""
    return [math.dist(a[:3], b[:3]) / 0.004 for a, b in zip(cell.places, cell.places[1:], strict=False)]


def when(cell: ReisCell, byte: str) -> list[tuple[int, int]]:
    """Cycle and value of each change."""
    return [(round((t - 1000.0) / 0.004), value) for t, name, value in cell.bits if name == byte]


def test_speeds_modes_and_displacement_are_those_at_each_step() -> None:
    body = f"{at(884, 100, 500)}\n{LINE}RELATIVE V1\n{at(884, 0, 500)}\nPATH_SPEED 100\nRELATIVE _VNULL\n{at(884, 30, 500)}\nSTOP"
    cell = ReisCell(main(body.replace("POSITION", "COPY 20, V1.Z\nPOSITION", 1)) | main("VAR V1, X:0, Y:0, Z:0, A:0, B:0, C:0", "V"))
    began = len(cell.places)
    assert cell.run()[:2] == ("ended", 0) and near(cell, 884, 30, 500)
    ran = cell.places[began:]
    assert any(math.dist(place[:3], (884, 0, 520)) < 0.05 for place in ran), "RELATIVE"
    turn = next(n for n, place in enumerate(ran) if math.dist(place[:3], (884, 0, 520)) < 0.05)
    found = speeds(cell)[began:]
    assert max(found[turn + 3 :]) == pytest.approx(100, rel=0.01)
    assert [line.split()[0] for line in cell.lines if " pose " in line] == ["ptp", "linear", "linear"]


@pytest.mark.requirement("RSV-PLC-37", by="gateway.pure.controllers.reis.programs:ReisPrograms.tcp")
def test_a_tool_moves_its_own_centre_and_the_markers_have_it() -> None:
    files = main(f"TOOL T1\n{LINE}{at(884, 0, 500)}\nACT_POS P1\nSTOP") | main("VAR T1, X:0, Y:0, Z:100, RX:0, RY:0, RZ:0\nVAR P1", "V")
    cell = ReisCell(files)
    assert cell.run()[0] == "ended" and near(cell, 884, 0, 600)
    assert [float(str(cell.value(f"P1.{name}"))) for name in "XYZ"] == pytest.approx([884, 0, 500], abs=0.05)
    cell.bench.run(0.5)
    flags = cell.control.flag_bytes()
    tcp = [int.from_bytes(flags[1124 + 4 * n : 1128 + 4 * n], "little", signed=True) / 100 for n in range(3)]
    assert flags[1120] & 1 and tcp == pytest.approx([884, 0, 500], abs=0.2), "as the drives report it"


def test_a_bit_acts_at_the_end_of_its_position_and_in_the_middle_of_its_corner() -> None:
    """WRITE_BIT behind a point that stops, and behind one that is approximated, which it does not stop."""
    corner = "UEBERSCHL #EIN\nBAHN_RADIUS 60\n"
    body = f"{LINE}{at(884, 0, 500)}\nWRITE_BIT #AUSGANG,1,1,0\n{corner}{at(884, 300, 500)}\n"
    cell = ReisCell(main(f"{body}WRITE_BIT #AUSGANG,1,1,1\nUEBERSCHL #AUS\n{at(884, 300, 700)}\nSTOP"))
    assert cell.run()[0] == "ended"
    (first, one), (second, three) = when(cell, "A1")
    assert (one, three) == (1, 3)
    assert math.dist(cell.places[first][:3], (884, 0, 500)) < 15 and cell.places[first - 12][1] < 0.01
    middle = min(range(len(cell.places)), key=lambda n: math.dist(cell.places[n][:3], (884, 300, 500)))
    assert middle <= second <= middle + 12, "at most 50 ms behind the middle"
    assert min(speeds(cell)[middle - 20 : middle + 20]) > 50, "the corner is passed without a stop"


def test_a_bit_behind_an_auxiliary_point_acts_where_the_tool_passes_it() -> None:
    """As in virtual time, not where the circle begins; a WAIT there does not wait for an end that the program has not given yet."""
    arcs = f"{at(884, 50, 550)}\nWRITE_BIT #AUSGANG,1,1,0\n{at(884, 100, 500)}\nWRITE_BIT #AUSGANG,1,1,1\n"
    body = f"{LINE}{at(884, 0, 500)}\nMOVE_MODE #ZIRK_BAHN_ORI\n{arcs}"
    cell = ReisCell(main(f"{body}{at(884, 150, 450)}\nWAIT 0.1\n{at(884, 200, 500)}\nSTOP"))
    assert cell.run()[0] == "ended"
    (first, one), (second, three) = when(cell, "A1")
    assert (one, three) == (1, 3)
    assert math.dist(cell.places[first][:3], (884, 50, 550)) < 20 and math.dist(cell.places[second][:3], (884, 100, 500)) < 20


def test_what_reads_the_cell_waits_for_the_position_before() -> None:
    body = f'{LINE}{FAR}\nTEST_BIT #EINGANG,#=1,0,3,"YES"\nWRITE_BIT #MERKER,1,20,0\nLABEL "YES"\n{BACK}\nSTOP'
    cell = ReisCell(main(body))
    run = cell.start()
    cell.until(lambda: cell.places[-1][1] > 100)
    cell.give(0, 3)
    assert cell.ends(run)[0] == "ended"
    assert when(cell, "M20") == [], "the input is read where the position is reached"


def test_wait_bit_times_out_at_its_label_and_timers_begin_at_rest() -> None:
    late = 'WAIT_BIT #EINGANG,1,0,3,0.3,"LATE"\nLABEL "LATE"\n'
    body = f"{LINE}{at(884, 100, 591)}\n{late}WRITE_BIT #MERKER,1,20,0\nWAIT 0.2\nWRITE_BIT #MERKER,1,20,1\nSTOP"
    cell = ReisCell(main(body))
    run = cell.start()
    cell.until(lambda: cell.control.flag_bytes()[999] == 128)
    assert cell.control.flag_bytes()[996:999] == bytes((3, 0, 1)), "the input that is waited for (L2937)"
    assert cell.ends(run)[0] == "ended" and not any(cell.control.flag_bytes()[996:1000])
    (first, _), (second, _) = when(cell, "M20")
    there = next(n for n, place in enumerate(cell.places) if place[1] > 99.99)
    assert (first - there) * 0.004 == pytest.approx(0.3, abs=0.06)
    assert (second - first) * 0.004 == pytest.approx(0.2, abs=0.03)


def test_a_program_reads_back_what_it_wrote_and_counts_on() -> None:
    body = f"{LINE}{at(884, 40, 591)}\nCOPY 1234567, _SPS[8]\nCOPY _SPS[8], I1\nADD 1, I1\nANA_OUTP 5.0, 3\nSTOP"
    cell = ReisCell(main(body) | main("VAR I1", "V"))
    assert cell.run()[0] == "ended" and cell.value("I1") == "1234568"
    cell.bench.cycle(3)
    assert cell.control.value("reis.analog.output.3") == pytest.approx(5.0, abs=1e-3)


def test_stop_on_the_path_shows_the_step_and_start_goes_on() -> None:
    cell = ReisCell(main(f"{LINE}{FAR}\n{BACK}\nSTOP"))
    run = cell.start()
    cell.until(lambda: cell.places[-1][1] > 100)
    cell.stop()
    assert cell.ends(run) == ("stopped", 0, "", "P step 5")
    assert cell.bench.core.state.motion is Motion.STOPPED
    here = cell.where()
    cell.bench.run(0.5)
    assert cell.where() == here and cell.step() == 5 and cell.language.rows()[0].state == "stopped"
    again = cell.start()
    assert cell.ends(again)[0] == "ended" and near(cell, 900, -50, 590)
    assert max(place[1] for place in cell.places) == pytest.approx(250, abs=0.1), "the interrupted position is reached"


@pytest.mark.parametrize("how", ["other", "edited", "given up"])
def test_the_rest_of_the_path_is_not_run_where_another_program_or_step_begins(how: str) -> None:
    elsewhere = f"{LINE}{at(884, 0, 640)}\nSTOP"
    cell = ReisCell(main(f"{LINE}{FAR}\n{BACK}\nSTOP") | main(elsewhere, "Q"))
    run = cell.start()
    cell.until(lambda: cell.places[-1][1] > 60)
    cell.stop()
    cell.ends(run)
    if how == "edited":
        cell.language.replaced(Memory.read([Source(*each) for each in main(elsewhere).items()], words(), Faults()))
    elif how == "given up":
        cell.stop()
        cell.bench.cycle(5)
        assert not cell.language.rows()
    assert cell.run("P" if how == "edited" else "Q")[0] == "ended"
    assert near(cell, 884, 0, 640) and max(place[1] for place in cell.places) < 200


def test_after_jogging_start_leads_back_to_the_path_and_completes_it() -> None:
    cell = ReisCell(main(f"{LINE}{at(900, 0, 590)}\n{at(900, 250, 590)}\nWRITE_BIT #AUSGANG,1,1,0\nSTOP"))
    run = cell.start()
    cell.until(lambda: cell.places[-1][1] > 100)
    cell.stop()
    cell.ends(run)
    left = cell.where()
    cell.bench.permit(AUTO, value=False)
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE)
    job = cell.bench.settle(cell.bench.give(Code.PTP_RELATIVE, mask=1, velocity=0.3, targets=(-20.0,)))
    assert job.state.name == "DONE" and math.dist(cell.where(), left) > 100
    assert "error" in cell.hosted.answer({"do": "start", "name": "P"}, 0), "HAND"
    cell.bench.permit(AUTO)
    cell.bench.cycle(3)
    began = len(cell.places)
    assert cell.run()[0] == "ended" and near(cell, 900, 250, 590) and when(cell, "A1")
    back = cell.places[began:]
    there = min(range(len(back)), key=lambda n: math.dist(back[n][:3], left))
    assert math.dist(back[there][:3], left) < 0.5, "first back to where it was interrupted"
    assert all(abs(place[0] - 900) < 0.5 and abs(place[2] - 590) < 0.5 for place in back[there:]), "then along its line"


def test_a_wait_goes_on_where_the_program_was_stopped_after_jogging() -> None:
    """Nothing was under way: what follows the WAIT acts at its place, and the way back does not count as time of the WAIT."""
    cell = ReisCell(main(f"{LINE}{at(900, 100, 590)}\nWAIT 0.6\nWRITE_BIT #AUSGANG,1,1,0\nSTOP"))
    run = cell.start()
    cell.until(lambda: any(row.waits for row in cell.language.rows()))
    cell.stop()
    assert cell.ends(run)[0] == "stopped" and near(cell, 900, 100, 590)
    cell.bench.permit(AUTO, value=False)
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE)
    cell.bench.settle(cell.bench.give(Code.PTP_RELATIVE, mask=1, velocity=0.3, targets=(-20.0,)))
    assert not near(cell, 900, 100, 590, by=100)
    cell.bench.permit(AUTO)
    cell.bench.cycle(3)
    assert cell.run()[0] == "ended" and near(cell, 900, 100, 590)
    ((written, _),) = when(cell, "A1")
    there = next(n for n in range(len(cell.places) - 1, 0, -1) if math.dist(cell.places[n][:3], (900, 100, 590)) > 0.05)
    assert (written - there) * 0.004 == pytest.approx(0.6, abs=0.1)


def test_an_arc_that_was_left_is_completed_on_its_circle() -> None:
    circle = f"MOVE_MODE #ZIRK_MIN_ORI\n{at(900, 100, 590)}\n{at(800, 0, 590)}"
    cell = ReisCell(main(f"{LINE}{at(1000, 0, 590)}\n{circle}\nSTOP"))
    run = cell.start()
    cell.until(lambda: cell.places[-1][1] > 50 and cell.places[-1][0] < 880)  # behind the auxiliary point
    cell.stop()
    cell.ends(run)
    left = cell.where()
    cell.bench.permit(AUTO, value=False)
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE)
    cell.bench.settle(cell.bench.give(Code.PTP_RELATIVE, mask=1, velocity=0.3, targets=(5.0,)))
    cell.bench.permit(AUTO)
    cell.bench.cycle(3)
    began = len(cell.places)
    assert cell.run()[0] == "ended" and near(cell, 800, 0, 590)
    back = cell.places[began:]
    there = min(range(len(back)), key=lambda n: math.dist(back[n][:3], left))
    assert all(abs(math.dist(place[:2], (900, 0)) - 100) < 0.2 for place in back[there:])


def test_emergency_stop_leaves_the_program_stopped_and_start_goes_on() -> None:
    cell = ReisCell(main(f"{LINE}{FAR}\n{BACK}\nSTOP"))
    run = cell.start()
    cell.until(lambda: cell.places[-1][1] > 100)
    cell.bench.permit(24, value=False)
    how, code, text, place = cell.ends(run)
    assert how == "aborted" and code and "EMERGENCY" in text.upper() and place == "P step 5"
    assert "EMERGENCY" in cell.errors.records[0].where.upper()
    cell.bench.run(0.5)
    here = cell.where()
    assert "drives are off" in str(cell.hosted.answer({"do": "start", "name": "P"}, 0))
    cell.bench.permit(24)
    cell.bench.run(0.2)
    cell.ready()
    cell.bench.run(0.5)
    assert math.dist(cell.where(), here) < 0.1, "nothing moves by itself"
    again = cell.start()
    assert cell.ends(again)[0] == "ended" and near(cell, 900, -50, 590)
    assert max(place[1] for place in cell.places) == pytest.approx(250, abs=0.1)


def test_a_dead_interpreter_stops_the_axes_on_their_path_and_nothing_restarts() -> None:
    cell = ReisCell(main(f'LABEL "L"\n{LINE}{FAR}\n{BACK}\nADD 1, I1\nBRANCH "L"') | main("VAR I1, value:5", "V"))
    run = cell.start()
    cell.until(lambda: cell.places[-1][1] > 240)
    cell.until(lambda: cell.places[-1][1] < 150)
    cell.dies()
    assert cell.ends(run)[0] == "lost"
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE)
    here = cell.where()
    assert -50 < here[1] < 150 and any("the interpreter ended" in line for line in cell.told)
    cell.born(2)
    cell.bench.run(0.5)
    assert cell.where() == here and not cell.language.rows()
    count = int(str(cell.value("I1")))
    cell.start()
    cell.until(lambda: math.dist(cell.where(), here) > 20)
    assert count >= 5, "values outlive it"


def test_auto_repeats_under_one_order_and_a_place_between_end_and_head_is_passed() -> None:
    corner = "UEBERSCHL #EIN\nBAHN_RADIUS 30\n"
    cell = ReisCell(main(f"{LINE}{corner}{at(900, 100, 590)}\n{at(900, 100, 690)}\n{at(900, 0, 590)}"))
    cell.start()
    cell.until(lambda: sum(line.startswith("linear") for line in cell.lines) > 8)
    cell.until(lambda: cell.places[-1][1] > 80)
    cell.until(lambda: cell.places[-1][1] < 60 and cell.places[-1][2] < 640)
    began = len(cell.places)
    cell.bench.run(1.2)
    assert min(speeds(cell)[began:]) > 20, "neither END nor step 1 stops it"
    assert cell.lines.count("angles reis") == 1, "one order"
    cell.stop()
    cell.bench.run(0.5)
    assert cell.bench.core.state.motion is Motion.STOPPED


def test_test_1_steps_once_a_start_moves_while_it_is_held_and_switches_no_output() -> None:
    cell = ReisCell(main(f"{LINE}{FAR}\nWRITE_BIT #AUSGANG,1,1,0\nWAIT_BIT #EINGANG,1,0,3\nSTOP"))
    cell.bench.permit(AUTO, value=False)
    cell.control.put("reis.mode", 1.0)
    cell.bench.cycle(3)
    assert cell.control.flag_bytes()[1022:1024] == bytes.fromhex("0201")
    cell.hosted.answer({"do": "start", "name": "P"}, 0)
    for step in (3, 4, 5):  # TOOL, MOVE_MODE, PATH_SPEED are executed
        cell.until(lambda: not cell.hosted.run)
        cell.key("start")
        cell.key("start", level=False)
        cell.until(lambda: not cell.hosted.run)
        assert cell.step() == step
    cell.until(lambda: not cell.hosted.run)
    cell.key("start")
    cell.until(lambda: cell.places[-1][1] > 60)
    cell.key("start", level=False)
    cell.until(lambda: cell.bench.core.state.motion is Motion.STOPPED)
    here = cell.where()
    cell.bench.run(0.3)
    assert cell.where() == here and here[1] < 240, "it moves while START is held"
    cell.key("start")
    cell.until(lambda: not cell.hosted.run)
    assert near(cell, 900, 250, 590)
    cell.key("start", level=False)
    cell.key("start")  # WRITE_BIT
    cell.until(lambda: not cell.hosted.run)
    cell.key("start", level=False)
    cell.key("start")
    cell.bench.run(0.2)
    assert cell.language.rows()[0].waits == "F1 or F2"
    cell.key("f2")
    cell.until(lambda: not cell.hosted.run)
    assert when(cell, "A1") == []


def test_the_sequence_test_moves_at_cal_sync_only_while_start_is_held() -> None:
    cell = ReisCell(main(f"{LINE}{FAR}\n{BACK}"))
    cell.bench.permit(AUTO, value=False)
    cell.control.put("reis.mode", 2.0)
    cell.control.put("reis.selector", 1.0)
    cell.bench.cycle(3)
    run = cell.start()
    cell.key("start")
    cell.until(lambda: cell.places[-1][1] > 60)
    cell.key("start", level=False)
    assert cell.ends(run)[0] == "stopped" and cell.where()[1] < 240
    cell.key("start")
    cell.until(lambda: not cell.hosted.run)
    assert near(cell, 900, -50, 590), "END returns to step 1 and stops"


def test_exec_alone_executes_a_step_of_test_5_and_refuses_a_position() -> None:
    cell = ReisCell(main(f"ADD 1, I1\n{FAR}") | main("VAR I1, value:5", "V"))
    cell.bench.permit(AUTO, value=False)
    cell.control.put("reis.mode", 5.0)
    cell.bench.cycle(3)
    cell.start()
    for _ in range(3):
        cell.until(lambda: not cell.hosted.run)
        cell.key("start")
        cell.key("start", level=False)
        assert not cell.hosted.run, "START does nothing"
        cell.key("exec")
        cell.key("exec", level=False)
    cell.until(lambda: not cell.hosted.run)
    assert cell.value("I1") == "6" and any("not executable in Test 5" in line for line in cell.told)


def test_a_message_is_in_the_list_with_its_number_until_it_is_acknowledged() -> None:
    cell = ReisCell(main("WRITE_BIT #MERKER,1,20,0", "SUB", "SPR"))
    how, code, text, place = cell.run("SUB")
    assert (how, code, text, place) == ("aborted", 4017, "Operating error 4017", "SUB step 4")
    assert [(record.code, record.source) for record in cell.errors.records] == [(4017, "reis")]
    flags = cell.control.flag_bytes()
    assert int.from_bytes(flags[944:948], "little") == 4017 and flags[1021] & 1
    assert cell.run("SUB")[2].startswith("START is refused: the error is not acknowledged; acknowledge it with RC input 62")
    cell.bench.permit(62)
    cell.bench.cycle(4)
    flags = cell.control.flag_bytes()
    assert not cell.errors.records and not flags[1021] & 1 and flags[1021] & 2


def test_a_position_out_of_reach_is_an_error_of_its_step_at_rest_where_the_one_before_ends() -> None:
    cell = ReisCell(main(f"{LINE}{at(900, 100, 590)}\n{at(3000, 0, 590)}\nSTOP"))
    how, _, text, place = cell.run()
    assert how == "aborted" and place == "P step 6" and text
    assert near(cell, 900, 100, 590)


@pytest.mark.requirement("RSV-PLC-35", by="gateway.pure.controllers.reis.programs:ReisPrograms._markers")
def test_the_plc_starts_and_stops_the_robot_by_markers_in_auto() -> None:
    cell = ReisCell(main(f'LABEL "L"\n{LINE}{FAR}\n{BACK}\nBRANCH "L"'))
    run = cell.start()
    cell.until(lambda: cell.places[-1][1] > 60)
    assert cell.control.write_flags(968, b"\x04\0\0\0")
    assert cell.ends(run)[0] == "stopped"
    assert cell.control.write_flags(968, b"\x02\0\0\0")
    here = cell.where()
    cell.until(lambda: math.dist(cell.where(), here) > 30)
    assert cell.control.write_flags(1020, b"\x80")
    cell.until(lambda: cell.bench.core.state.motion is Motion.STOPPED)
    assert cell.hosted.run, "hold is not an Auto Stop"
    assert cell.control.write_flags(1020, b"\x00")
    held = cell.where()
    cell.until(lambda: math.dist(cell.where(), held) > 30)
    cell.bench.permit(AUTO, value=False)
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE)
    for level in (b"\0\0\0\0", b"\x02\0\0\0"):
        assert cell.control.write_flags(968, level)
        cell.bench.cycle(5)
    assert not cell.hosted.run, "in HAND they do nothing"


def test_hold_motion_stops_a_program_that_moves_for_another_command_source() -> None:
    cell, page = ReisCell(main(f"{LINE}{FAR}\n{BACK}\nSTOP")), 2
    for code, source in ((Code.RELEASE_CONTROL, 1), (Code.REQUEST_CONTROL, page), (Code.OVERRIDE, page)):
        assert cell.bench.settle(cell.bench.give(code, source=source)).state.name == "DONE"
    assert "run" in cell.hosted.answer({"do": "start", "name": "P"}, page)
    cell.until(lambda: cell.places[-1][1] > 60)
    assert cell.control.write_flags(1020, b"\x80")
    cell.until(lambda: cell.bench.core.state.motion is Motion.STOPPED)
    assert cell.control.write_flags(1020, b"\x00")
    held = cell.where()
    cell.until(lambda: math.dist(cell.where(), held) > 30)
    assert cell.hosted.run and not cell.errors.records


def test_a_spline_goes_through_its_points_and_a_dense_path_keeps_its_speed() -> None:
    """Both need many positions ahead: a spline all of its own, points half a millimetre apart as many as the robot brakes in."""
    points = [(884 + 40 * math.sin(n / 2), 20 * n, 560) for n in range(1, 6)]
    dense = "\n".join(at(884, 100 - 0.5 * n, 560) for n in range(1, 120))
    body = f"{LINE}{at(884, 0, 560)}\nPATH_SPEED 200\nMOVE_MODE #SPLINE\n" + "\n".join(at(*point) for point in points)
    body += f"\n{LINE}PATH_SPEED 100\n{at(884, 100, 560)}\nUEBERSCHL #EIN\nBAHN_RADIUS 0.2\n{dense}\nSTOP"
    cell = ReisCell(main(body))
    assert cell.run()[0] == "ended" and near(cell, 884, 40.5, 560)
    assert all(min(math.dist(place[:3], point) for place in cell.places) < 0.5 for point in points)
    found = [speed for speed, place in zip(speeds(cell), cell.places, strict=False) if abs(place[0] - 884) < 0.01 and 55 < place[1] < 85]
    assert min(found) == pytest.approx(100, rel=0.1)


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("a_cycle", [1, 64])
def test_short_rounded_moves_are_run_however_slowly_the_cycle_takes_their_pieces(a_cycle: int, way: int) -> None:
    """A new tail that comes behind others in the ring has to wait for them; one that came too late aborted the program."""
    places = [way * sum(1 + k % 3 for k in range(n)) for n in range(1, 31)]
    body = "\n".join(at(884, place, 500 + place % 2) for place in places)
    cell = ReisCell(main(f"MOVE_MODE #PTP\n{at(884, 0, 500)}\nUEBERSCHL #EIN\nBAHN_RADIUS 1\n{body}\nSTOP"))
    cell.a_cycle = a_cycle
    assert cell.run()[:2] == ("ended", 0) and near(cell, 884, places[-1], 500 + places[-1] % 2)


def test_values_live_with_their_program_and_constants_do_not() -> None:
    body = 'ADD 1, I1\nCOPY 3, I_A[2]\nCOPY 2.5, R1\nCOPY "GRIP", S1\nCOPY 7, V1.X\nSTOP'
    definitions = "VAR I1, value:5\nVAR I_A[3]\nLOC_VAR R9\nVAR R1\nVAR S1(10)\nVAR V1\nCONST I9, value:3"
    cell = ReisCell(main(body) | main(definitions, "V"))
    assert cell.run()[0] == "ended"
    values = cell.language.values()
    assert values["V.MPR"].splitlines() == ["I1 = 6", "I_A[2] = 3", "R1 = 2.5", 'S1 = "GRIP"', "V1.X = 7.0"]
    again = ReisCell(main(body) | main(definitions, "V"), values)
    assert again.run()[0] == "ended" and again.value("I1") == "7"
    assert again.language.restore("V.MPR", 'I2 = 4\nI9 = 4\nI1 = "x"\nnonsense') == ["I2 = 4", 'I1 = "x"', "nonsense"]


def test_values_of_a_program_stay_where_trafo_6d_has_made_another_of_it() -> None:
    corners = "\n".join(f"POSITION #N, X:{x}, Y:{y}, Z:0, A:0, B:0, C:0" for x, y in ((0, 0), (100, 0), (0, 100)))
    texts = main("COPY 1, IK\nCOPY 7, I7\nTRAFO_6D R, R2, SRC, ZDST, IK\nSTOP") | main(corners, "R") | main(corners, "R2")
    cell = ReisCell(texts | {"SRC.MPR": "MPR SRC\nVAR I7\nWAIT 1\nEND\n"} | main("VAR IK", "V"))
    assert cell.run()[0] == "ended" and cell.value("IK") == "1"
    assert cell.language.memory.find("ZDST") is not None and cell.language.values()["SRC.MPR"] == "I7 = 7\n"


def test_the_shipped_palletiser_lays_its_parts_down() -> None:
    cell = ReisCell({path.name: path.read_text() for path in MEMORY.iterdir() if path.is_file()})
    assert not cell.language.faults.rows() and not cell.faults.rows()
    run = cell.start("PALTEST")
    cell.until(lambda: cell.value("ACTVALUE1") == "1", 60)
    assert cell.control.write_flags(10, b"\x01")
    assert cell.ends(run, 60)[0] == "ended"
    laid = [math.dist(place[:3], (850, 100, 250)) for place in cell.places]
    assert min(laid) < 0.05 and near(cell, 884, 0, 590)
    assert [value for _, value in when(cell, "A1")] == [1, 0] * (len(when(cell, "A1")) // 2)
    assert int(str(cell.value("I_PICKED"))) == len(when(cell, "A1")) // 2 >= 1
