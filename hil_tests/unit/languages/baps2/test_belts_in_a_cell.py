"""BAPS2 programs on the belts of a cell, in virtual time (rho 3 releases L1694-1752, L5998-6460, L11583-11672)."""

from dataclasses import replace

import pytest

from gateway.pure.cell.belts import Belt
from hil_tests.lab.virtual.baps2_bench import CELL, ProgramCell

SIMULATION, SET_COUNTER = 399, 376
BELTS = replace(
    CELL,
    belt=(
        Belt("ALONG", 0.1, simulated=100.0),
        Belt("TABLE", 0.1, simulated=100.0, type=2),
        Belt("CAM", 0.1, simulated=100.0, type=3),
    ),
)
STEP = 100 * 0.004  # mm of a belt at 100 mm/s in one cycle
HEAD = """;;CONTROL = RHO3
;;KINEMATICS : (1 = PORTAL)
;;PORTAL.JC_NAMES = A1, A2, A3, A4, B1, B2, B3
;;PORTAL.WC_NAMES = X, Y, Z, C, B1, B2, B3
PROGRAM P
SPC_FCT : 28 = SET_BELTCNT (VALUE INTEGER : NR VALUE REAL : V)
SPC_FCT : 21 = BELT_TYPE (VALUE INTEGER : NR VALUE INTEGER : KIND)
SPC_FCT : 15 = BELT_PARAM (VALUE INTEGER : NR VALUE REAL : S VALUE REAL : R VALUE INTEGER : MS)
PORTAL.BELT : 501 = ALONG, 502 = TABLE, 503 = CAM
INPUT : 1 = PART
OUTPUT : 3 = DONE
REAL : BEFORE, BEHIND
INTEGER : N
DEF POINT : SEEN
;;KINEMATICS = PORTAL
;;INT = LINEAR
BEGIN
"""


def cell_of(body: str, *, runs: bool = True) -> ProgramCell:
    cell = ProgramCell({"P.QLL": f"{HEAD}{body}\nPROGRAM_END\n"}, BELTS)
    cell.bench.permit(*range(SET_COUNTER, SET_COUNTER + 8), SIMULATION, value=False)
    cell.bench.permit(SIMULATION, value=runs)
    return cell


def test_sync_waits_for_the_belt_and_sets_its_counter_to_the_reset_value() -> None:
    cell = cell_of(
        "SET_BELTCNT (1, -40)\nSYNC ALONG >= 150\nBEFORE = ALONG\nDONE = 1\nWAIT UNTIL ALONG >= 60\nMOVE TO (100, 60, 40, 12, 0, 0, 0)"
    )
    run = cell.start("P")
    cell.until(lambda: cell.outputs != [])
    assert -40 <= cell.belt_counters()[0] < -40 + 3 * STEP, "the cycle that sets it, the one that switches the output, not a third"
    assert 150 <= cell.belt_counters()[1] < 150 + 3 * STEP, "no other counter is set"
    assert cell.ends(run)[:2] == ("ended", 0)
    assert cell.at()[0] == 100


def test_sync_on_an_input_and_the_set_belt_counter_signal_load_the_value() -> None:
    cell = cell_of("SET_BELTCNT (2, 500)\nSYNC TABLE, PART = 1\nDONE = 1")
    run = cell.start("P")
    cell.bench.run(1.0)
    assert run not in cell.hosted.results
    cell.give(1)
    cell.until(lambda: cell.outputs != [])
    assert 500 <= cell.belt_counters()[1] < 500 + 3 * STEP, "from the turn that sees the input to the one that switches the output"
    assert cell.ends(run)[:2] == ("ended", 0)
    cell.bench.run(1.0)
    cell.bench.permit(SET_COUNTER + 1)
    cell.bench.run(0.02)
    assert cell.belt_counters()[1] == pytest.approx(500 + 5 * STEP, abs=1.01 * STEP), "RC input 377, five cycles ago"


def test_on_a_belt_of_type_1_the_robot_rides_along_and_leaves_it() -> None:
    body = """V = 300
SYNC ALONG >= 20
MOVE TO (100, 60, 40, 12, 0, 0, 0)
SYNCHRON PORTAL ALONG
MOVE TO (150, 60, 40, 12, 60, 0, 0)
MOVE TO (150, 100, 40, 12, 60, 0, 0)
WAIT 1
SEEN = POS
SYNCHRON_END
WAIT 1
DONE = 1
MOVE TO (60, 60, 40, 12, 0, 0, 0)"""
    cell = cell_of(body)
    run = cell.start("P")
    cell.until(lambda: cell.outputs != [])
    last = cell.at()[0]
    steps = [(b[0] - a[0]) / 0.004 for a, b in zip(cell.places[-600:], cell.places[-599:], strict=False)]
    assert any(step == pytest.approx(100, abs=1) for step in steps), "mm/s: that of the belt"
    assert abs(steps[-1]) < 0.01, "beside the belt it rests"
    assert cell.ends(run)[:2] == ("ended", 0)
    seen = (cell.memory.text("P.PKT") or "").split("(")[1].split(")")[0].split(",")
    assert float(seen[0]) - float(seen[4]) == pytest.approx(150 - 60, abs=3 * STEP), "the point, where the belt has taken it"
    assert last > float(seen[0])


def test_type_2_reaches_each_point_with_the_belt_as_the_manuals_example_says() -> None:
    body = """belt_type (2, 2)
A = 3000, V = 500
SYNC TABLE >= 10
MOVE LINEAR VIA (60, 60, 40, 12, 0, 50, 0)
SYNCHRON PORTAL TABLE
MOVE LINEAR (160, 60, 40, 12, 0, 200, 0)
MOVE LINEAR (160, 60, 40, 12, 0, 240, 0)
MOVE LINEAR (60, 60, 40, 12, 0, 360, 0)
SYNCHRON_END
DONE = 1"""
    cell = cell_of(body)
    run = cell.start("P")
    at: dict[int, float] = {}
    for _ in range(3000):
        cell.bench.cycle()
        at[round(cell.belt_counters()[1])] = cell.at()[0]
        if run in cell.hosted.results:
            break
    assert cell.hosted.results[run][:2] == ("ended", 0), cell.hosted.results[run]

    def near(value: int) -> float:
        return at[min(at, key=lambda each: abs(each - value))]

    assert near(48) == pytest.approx(60, abs=0.5), "it waits for 50, the value of the last block before the part"
    half = 0.5 * 100 / 120  # belts are looked up by whole millimetres, and no section is steeper than the last
    assert near(200) == pytest.approx(160, abs=half)
    assert near(239) == pytest.approx(160, abs=half)
    assert near(280) == pytest.approx(160 - 100 * 40 / 120, abs=half)


def test_the_cam_has_its_sections_from_a_and_d_times_their_factors() -> None:
    body = """SYNC CAM >= 10
MOVE VIA (60, 60, 40, 12, 0, 0, 50)
SYNCHRON PORTAL CAM
A = 100
AFACTOR = 0.3
DFACTOR = 0.7
MOVE (160, 60, 40, 12, 0, 0, 200)
SYNCHRON_END"""
    cell = cell_of(body)
    run = cell.start("P")
    at: list[tuple[float, float]] = []
    for _ in range(3000):
        cell.bench.cycle()
        at.append((cell.belt_counters()[2], cell.at()[0]))
        if run in cell.hosted.results:
            break
    assert cell.hosted.results[run][:2] == ("ended", 0), cell.hosted.results[run]
    slope = 100 / (150 - (30 + 70) / 2)  # quadratic 50..80, linear 80..130, quadratic 130..200 (L6446-6450)
    assert all(x == pytest.approx(60 + slope * (30 / 2 + belt - 80), abs=1.5) for belt, x in at if 85 < belt < 125)
    assert all(x == pytest.approx(160 - slope / 140 * (200 - belt) ** 2, abs=1.5) for belt, x in at if 135 < belt < 195)


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("MOVE TO (60, 60, 40, 12, 0, 50, 0)\nSYNCHRON PORTAL TABLE\nMOVE PTP TO (70, 60, 40, 12, 0, 90, 0)\nSYNCHRON_END", 23),
        ("MOVE TO (60, 60, 40, 12, 0, 50, 0)\nSYNCHRON PORTAL TABLE\nMOVE TO (70, 60, 40, 12, 0, 50, 0)\nSYNCHRON_END", 89),
        ("SET_BELTCNT (4, 0)", 93),
        ("BELT_TYPE (1, 133)", 92),
        ("SYNCHRON PORTAL ALONG\nSYNCHRON PORTAL TABLE", 20),
    ],
)
def test_what_the_manual_forbids_ends_the_program_with_its_number(body: str, code: int) -> None:
    cell = cell_of(f"BELT_TYPE (2, 2)\n{body}")
    how, number, _, _ = cell.run("P")
    assert (how, number) == ("aborted", code)


def test_belts_running_the_wrong_way_end_the_program_with_the_number_of_its_kinematic() -> None:
    body = "MOVE TO (60, 60, 40, 12, 0, -50, 0)\nSYNCHRON PORTAL TABLE\nMOVE TO (70, 60, 40, 12, 0, -90, 0)\nSYNCHRON_END"
    how, number, text, _ = cell_of(body).run("P")
    assert (how, number) == ("aborted", 928) and "wrong belt direction" in text
