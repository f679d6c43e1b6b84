"""The balancing machine of the manual in a cell of one axis that turns without end (rho 3 releases part 2, L6756-6863; AX-1680)."""

import pathlib
import re
from dataclasses import replace

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.cell.belts import Measuring
from gateway.pure.cell.cell import Cell
from gateway.pure.languages.baps2 import lines
from gateway.pure.languages.base.faults import Faults
from hil_tests.lab.virtual.baps2_bench import CELL, FIRST_INPUT, ProgramCell

PROBE = FIRST_INPUT + 8
SPINDLE = """format = 1
[robot]
name = "spindle"
kind = "identity"
angles = "rho3"
source = "assumed"
[[axis]]
name = "A"
unit = "deg"
lower = 0
upper = 360
speed = 1800
accel = 3600
jerk = 60000
source = "assumed"
"""
AXIS = """[[axis]]
name   = "A"
unit   = "deg"
modulo = 360.0
drive  = { type = "servodyn", bus = "drives", module = 1, inc_per_turn = 16384 }
mechanics       = { feed_per_turn = 360.0, gear = "1:1", direction = "+" }
limits          = { min = 0.0, max = 360.0, speed = 1800.0, accel = 3600.0, jerk = 60000.0 }
following_error = { warn = 40, trip = 50 }
home            = { by = "none" }

[plant]
seed = 1

"""
BALANCE = """;;Control = rho3
;;Kinematics: (1=balance)
;;Balance.JC_NAMES = A_1
;;Balance.WC_NAMES = X_K
Program balance
SPC_FCT : 3 = zero_reset (Value integer : KIN_NO JC_POINT : @Machpos)
SPC_FCT : 41 = poti_modify (Value integer : KIN_NO Value REAL : kin_poti)
SPC_FCT : 42 = move_dist (Value integer:KIN_NO Value REAL:move_dist)
JC_POINT : @Zeropos
DEF JC_POINT : @HIT, @THERE
Input : 1 = measure, 710 = probe
OUTPUT : 3 = LOST
Start
V_PTP = 0.5
@Zeropos = @(0.0)
Loop:
Wait until measure = 1
Zero_reset (1,@Zeropos)
parallel
VFACTOR = 1.0
Move until probe = 1 ERROR LOST = 1 after @({far})
also
wait until measure = 0
poti_modify (1,0.2)
move_dist (1,47.5)
parallel_end
IF LOST = 0 THEN @HIT = @MPOS
@THERE = @POS
JUMP Loop
program_end
"""


@pytest.fixture(scope="module")
def spindle(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    folder = tmp_path_factory.mktemp("spindle")
    (folder / "palletiser").mkdir()
    (folder / "spindle.toml").write_text(SPINDLE)
    text = pathlib.Path(CELL.file).read_text().replace('axes     = "1..4"', 'axes     = "1..1"').replace('"PORTAL"', '"BALANCE"')
    text = text.replace('"portal"', '"identity"', 1).replace('"portal"', '"spindle.toml"', 1)
    plant = re.split(r"(?=\[plant\.axis)", text)[1].replace("axis.X", "axis.A").replace("start                = 60.0", "start = 0.0")
    cell = load_cell(str(folder / "cell.toml"), text[: text.index("[[axis]]")] + AXIS + plant)
    return replace(cell, measuring=(Measuring(610, PROBE),))


def machine(spindle: Cell, far: float) -> ProgramCell:
    cell = ProgramCell({"BALANCE.QLL": BALANCE.replace("{far}", str(far))}, spindle)
    cell.bench.permit(PROBE, value=False)
    cell.start("BALANCE")
    cell.give(1)
    return cell


def speed(cell: ProgramCell) -> float:
    return (cell.places[-1][0] - cell.places[-2][0]) / 0.004


def test_it_turns_to_9999999_slows_down_and_ends_an_angle_past_the_pulse_twice(spindle: Cell) -> None:
    cell = machine(spindle, 9999999.0)
    for _ in range(2):
        cell.bench.run(1.2)
        assert speed(cell) == pytest.approx(900.0, abs=0.1), cell.told
        cell.give(1, value=False)
        cell.bench.run(0.6)
        assert speed(cell) == pytest.approx(180.0, abs=0.1)
        cell.bench.permit(PROBE)
        cell.bench.run(0.5)
        points = cell.memory.points("BALANCE", Faults())
        assert (points["@THERE"][0] - points["@HIT"][0]) % 360.0 == pytest.approx(47.5, abs=1e-3)
        assert speed(cell) == 0.0 and cell.outputs == []
        cell.bench.permit(PROBE, value=False)
        cell.give(1)


def test_without_a_pulse_it_goes_on_to_the_far_place_slowed_down_too_and_the_error_part_runs(
    spindle: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lines, "LEG_S", 1.0)
    cell = machine(spindle, 1500.0)
    cell.bench.run(1.0)
    cell.give(1, value=False)
    cell.until(lambda: cell.outputs != [])
    cell.bench.run(0.2)
    assert cell.memory.points("BALANCE", Faults()) == {"@THERE": (60.0,)}, "1500 deg of an endless axis"
    slow = sum(abs(b[0] - a[0]) / 0.004 == pytest.approx(180.0, abs=0.1) for a, b in zip(cell.places, cell.places[1:], strict=False))
    assert slow > 300, "what follows behind the stop has the new factor"
