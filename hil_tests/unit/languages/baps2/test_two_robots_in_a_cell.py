"""BAPS2 programs of a cell of two portals, in virtual time: branches and programs move both at once (AX-861, AX-920)."""

import pathlib
import re

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults
from hil_tests.lab.cells.many_robots import FEEDER
from hil_tests.lab.virtual.baps2_bench import CELL, ProgramCell

HEAD = """;;CONTROL = RHO3
;;KINEMATICS : (1 = PORTAL, 2 = LOADER)
;;PORTAL.JC_NAMES = A1, A2, A3, A4
;;PORTAL.WC_NAMES = X, Y, Z, C
;;LOADER.JC_NAMES = B1, B2
;;LOADER.WC_NAMES = U, V
"""
NAMES = {"X": "U", "Y": "V"}


def two_portals(folder: pathlib.Path, kinematics: int = 2) -> Cell:
    """The palletiser with a loader of two axes beside its portal."""
    text = pathlib.Path(CELL.file).read_text()
    at = text.index("[robot]"), text.index("[[bus]]")
    robot = text[at[0] : at[1]].replace("[robot]", "[[robot]]")
    loader = robot.replace('"PORTAL"', '"LOADER"').replace('model      = "portal"', 'model      = "feeder.toml"')
    axes = text[text.index("[[axis]]") : text.index('[[axis]]\nname   = "Z"')].replace("max = 1500.0", "max = 499.0")
    plants = text[text.index("[plant.axis.X]") : text.index("[plant.axis.Z]")]
    for old, new in NAMES.items():
        axes = axes.replace(f'name   = "{old}"', f'name   = "{new}"')
        plants = plants.replace(f"[plant.axis.{old}]", f"[plant.axis.{new}]")
    axes = re.sub(r"module = (\d)", lambda found: f"module = {int(found[1]) + 4}", axes)
    text = text[: at[0]] + robot + loader + text[at[1] :]
    text = text.replace('axes     = "1..4"', 'axes     = "1..6"').replace("[plant]", f"{axes}\n[plant]", 1)
    text = text.replace('kind   = "rho3"', f'kind   = "rho3"\nkinematics = {kinematics}')
    (folder / "feeder.toml").write_text(FEEDER)
    (folder / "palletiser").mkdir()
    return load_cell(str(folder / "cell.toml"), f"{text.rstrip()}\n\n{plants}")


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    return two_portals(tmp_path_factory.mktemp("two"))


def memory(body: str, declared: str = "", name: str = "P") -> dict[str, str]:
    return {f"{name}.QLL": f"{HEAD}PROGRAM {name}\n{declared}\nBEGIN\n{body}\nPROGRAM_END\n"}


def together(cell: ProgramCell) -> int:
    """Cycles in which X and U both move."""
    pairs = zip(cell.places, cell.places[1:], strict=False)
    return sum(abs(b[0] - a[0]) > 1e-3 and abs(b[4] - a[4]) > 1e-3 for a, b in pairs)


PORTAL = "MOVE PORTAL PTP TO @(600, 55, 40, 12)\nMOVE PORTAL PTP TO @(100, 55, 40, 12)"
LOADER = "MOVE LOADER PTP TO @(400, 55)\nMOVE LOADER PTP TO @(200, 55)"


@pytest.mark.requirement("RHO-BAP-11", by="gateway.pure.languages.base.path:Paths.of")
def test_branches_of_parallel_move_two_robots_at_once(two: Cell) -> None:
    cell = ProgramCell(memory(f"PARALLEL\n{PORTAL}\nALSO\n{LOADER}\nPARALLEL_END"), two)
    assert cell.run("P", 60.0)[0] == "ended"
    assert (cell.at()[0], cell.at()[4]) == pytest.approx((100, 200), abs=0.01)
    assert together(cell) > 100


def test_one_process_moves_its_robots_one_after_the_other(two: Cell) -> None:
    cell = ProgramCell(memory(f"{PORTAL}\n{LOADER}"), two)
    assert cell.run("P", 60.0)[0] == "ended"
    assert (cell.at()[0], cell.at()[4]) == pytest.approx((100, 200), abs=0.01)
    assert together(cell) == 0


def test_a_program_that_is_taken_off_stops_its_own_robot_alone(two: Cell) -> None:
    cell = ProgramCell(memory(PORTAL) | memory(f"{LOADER}\n{LOADER}", name="Q"), two)
    first, second = cell.start("P"), cell.start("Q")
    cell.until(lambda: cell.at()[0] > 200 and cell.at()[4] > 100)
    process = cell.control.processes.named("P")
    assert process is not None and cell.control.processes.stop(process.number)
    assert cell.ends(second)[0] == "ended"
    assert cell.at()[4] == pytest.approx(200, abs=0.01) and cell.at()[0] not in (100.0, 600.0)
    assert cell.hosted.results[first][0] == "stopped"


def test_check_wants_as_many_kinematics_as_programs_have_robots(tmp_path: pathlib.Path) -> None:
    with pytest.raises(CellFaults, match=r"controller.kinematics = \"?1.*programs move the 2 robots of the cell"):
        two_portals(tmp_path, kinematics=1)
