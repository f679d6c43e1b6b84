"""Special functions that a BAPS2 program of a cell has done between two movements: outputs led by a coordinate, machine positions, files of
set points (rho 3 releases L4119-4264, L6956-7212)."""

import struct
from dataclasses import replace

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.cell.belts import PathOutput
from gateway.pure.image.records.cell import AxisFlag, Motion
from hil_tests.lab.virtual.baps2_bench import CELL, ProgramCell, one

FIRST_OUTPUT = 416
OUTPUTS = replace(CELL, path_output=(PathOutput("iol", 2, FIRST_OUTPUT), PathOutput("ppo", 3, FIRST_OUTPUT + 8, bits=8)))
LOGIC = """SPC_FCT : 1 = IO_LOGIC (VALUE INTEGER : F, K, C VALUE REAL : P, V VALUE INTEGER : T)
SPC_FCT : 2 = PPO (VALUE INTEGER : F, K, C VALUE REAL : P, V VALUE INTEGER : T)"""


def bit(cell: ProgramCell, number: int) -> bool:
    outputs = cell.bench.core.outputs
    return bool(outputs[number >> 3] >> (number & 7) & 1)


def test_io_logic_switches_where_the_coordinate_is_and_a_negative_number_clears_it() -> None:
    body = """V = 200
IO_LOGIC(2, 1, 1, 160, 1, 0)
MOVE LINEAR TO (260, 60, 40, 12)
WAIT 0.5
IO_LOGIC(-2, 1, 1, 0, 0, 0)
WAIT 0.2
MOVE LINEAR TO (60, 60, 40, 12)"""
    cell = ProgramCell(one(body, LOGIC), OUTPUTS)
    run = cell.start("P")
    seen: list[tuple[float, bool]] = []
    for _ in range(3000):
        cell.bench.cycle()
        if not seen or seen[-1][1] != bit(cell, FIRST_OUTPUT):
            seen.append((cell.at()[0], bit(cell, FIRST_OUTPUT)))
        if run in cell.hosted.results:
            break
    assert cell.hosted.results[run][:2] == ("ended", 0), cell.hosted.results[run]
    assert [value for _, value in seen] == [False, True, False]
    assert seen[1][0] == pytest.approx(160, abs=1.5) and seen[2][0] == 260, "at its place, and cleared while the axes rest"


def test_a_function_that_no_movement_follows_keeps_the_program_from_nothing() -> None:
    cell = ProgramCell(one("MOVE LINEAR TO (80, 60, 40, 12)\nPPO(3, 1, 1, 160, 1, 0)\nWAIT 1\nPPO(-3, 1, 1, 0, 50, 0)", LOGIC), OUTPUTS)
    assert cell.run("P")[:2] == ("ended", 0)
    assert cell.bench.core.outputs[(FIRST_OUTPUT + 8) >> 3] == 50


def test_a_function_the_cell_does_not_have_ends_the_program_in_its_line() -> None:
    how, code, text, place = ProgramCell(one("IO_LOGIC(7, 1, 1, 160, 1, 0)\nMOVE LINEAR TO (80, 60, 40, 12)", LOGIC), OUTPUTS).run("P")
    assert (how, code, place) == ("aborted", 253, "P.QLL line 10") and "iol 7" in text.lower()


MACHINE = "SPC_FCT : 3 = MACH_POS (VALUE INTEGER : K JC_POINT : @P)\nDEF JC_POINT : @NOW, @THEN"


def test_the_machine_position_is_new_and_the_travel_belongs_to_it() -> None:
    body = """MOVE PTP TO @(100, 60, 40, 12)
@NOW = @POS
@NOW.A4 = @NOW.A4 - 100
MACH_POS(1, @NOW)
@THEN = @POS
MOVE_REL PORTAL @(0, 0, 0, 10)"""
    cell = ProgramCell(one(body, MACHINE))
    assert cell.run("P")[:2] == ("ended", 0)
    assert cell.at() == pytest.approx((100, 60, 40, -78), abs=0.001)
    assert "@THEN = @(100, 60, 40, -88)" in (cell.memory.text("P.PKT") or "")


def points(*rows: tuple[float, ...], version: int = 500, micros: int = 4000) -> bytes:
    """A BNR file for MOVE_FILE."""
    head = struct.pack("<6i", 80, 1, micros, 4, version, 0) + bytes(56)
    return head + b"".join(struct.pack("<4f", *row) for row in rows)


FILE = """SPC_FCT : 45 = MOVE_FILE (VALUE INTEGER : K BNR_FILE : F VALUE INTEGER : B JC_POINT : @M VALUE ARRAY[1..6] INTEGER : R)
BNR_FILE : CURVE
JC_POINT : @MODULO
ARRAY[1..6] INTEGER : R
OUTPUT : 3 = DONE"""
PLAY = """READ_BEGIN CURVE, 80
@MODULO = @(0, 0, 0, 0)
MOVE PTP TO @(60, 60, 40, 12)
MOVE_FILE(1, CURVE, 1, @MODULO, R)
DONE = 1
CLOSE CURVE
MOVE_REL LINEAR (0, 5, 0, 0)"""
WAY = [(60.0 + 20 * (1 - (1 - n / 250) ** 2) * (n / 250), 60.0, 40.0, 12.0) for n in range(251)]


def test_a_file_of_set_points_is_played_point_by_point() -> None:
    cell = ProgramCell({**one(PLAY, FILE), "CURVE.BNR": points(*WAY)})
    run = cell.start("P")
    cell.until(lambda: cell.outputs != [])
    assert cell.at() == pytest.approx((80, 60, 40, 12), abs=0.01)
    began = next(n for n, place in enumerate(cell.places) if place[0] > 60.0005)
    played = [place[0] for place in cell.places[began : began + 100]]
    first = min(range(3), key=lambda n: abs(WAY[n + 1][0] - played[0]))
    assert played == pytest.approx([place[0] for place in WAY[first + 1 : first + 101]], abs=0.01)
    assert cell.ends(run)[:2] == ("ended", 0) and cell.at()[1] == 65


@pytest.mark.parametrize(("data", "code"), [(points(*WAY, version=400), 95), (points(*WAY, micros=8000), 98), (points(*WAY)[:-3], 100)])
def test_a_file_the_control_refuses_moves_nothing_and_has_the_manuals_number(data: bytes, code: int) -> None:
    cell = ProgramCell({**one(PLAY, FILE), "CURVE.BNR": data})
    assert cell.run("P")[:2] == ("aborted", code)
    assert cell.at() == (60, 60, 40, 12)


def test_a_file_that_is_not_open_for_reading_is_error_63() -> None:
    cell = ProgramCell({**one(PLAY.partition("\n")[2], FILE), "CURVE.BNR": points(*WAY)})
    assert cell.run("P")[:2] == ("aborted", 63)


PORTAL = load_cell("portal")  # its axes have reference switches
REFERENCED = replace(CELL, plant=PORTAL.plant, axis=tuple(replace(a, home=b.home) for a, b in zip(CELL.axis, PORTAL.axis, strict=True)))


def test_ref_pnt_references_the_axes_of_the_kinematic_and_the_program_goes_on_behind_it() -> None:
    cell = ProgramCell(one("REF_PNT\nMOVE PTP TO @(70, 60, 40, 12)"), REFERENCED)
    assert not cell.bench.core.state.axes[0].flags & AxisFlag.REFERENCED
    run = cell.start("P")
    cell.until(lambda: cell.bench.core.state.motion is Motion.REFERENCING)
    assert cell.ends(run)[:2] == ("ended", 0), cell.hosted.results[run]
    assert all(axis.flags & AxisFlag.REFERENCED for axis in cell.bench.core.state.axes[:4])
    assert cell.at() == (70, 60, 40, 12)


def test_a_program_that_is_stopped_ends_its_reference_run() -> None:
    cell = ProgramCell(one("REF_PNT"), REFERENCED)
    cell.start("P")
    cell.until(lambda: cell.bench.core.state.motion is Motion.REFERENCING)
    process = cell.control.processes.named("P")
    assert process is not None
    cell.control.processes.stop(process.number)
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE, 2.0)
    assert cell.run("P")[:2] == ("ended", 0), "and it can be started again"
