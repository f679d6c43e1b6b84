"""How far a robot in a cell of emulated drives is on its way: M1464 to M1479, _RPATH_DIST (AX-1833)."""

import pytest

from hil_tests.lab.virtual.reis_bench import ReisCell, at, main

LINE = "MOVE_MODE #LINEAR\nPATH_SPEED 500\n"


def path_markers(cell: ReisCell) -> list[float]:
    """M1464 to M1479."""
    flags = cell.control.flag_bytes()
    return [int.from_bytes(flags[place : place + 4], "little", signed=True) / 100 for place in range(1464, 1480, 4)]


def test_l2973_markers_have_the_way_done_and_left_of_the_position_under_way() -> None:
    files = main(f"{LINE}{at(884, 0, 500)}\n{at(884, 250, 500)}\nCOPY _RPATH_DIST[1],R1\nSTOP") | main("VAR R1", "V")
    cell = ReisCell(files)
    run = cell.start()
    cell.until(lambda: cell.places[-1][1] > 100)
    cell.bench.run(0.03)
    done, left, took, rest = path_markers(cell)
    assert done == pytest.approx(cell.where()[1], abs=40) and done + left == pytest.approx(250, abs=0.02)
    assert took > 0 and rest > 0
    cell.stop()
    cell.ends(run)
    cell.bench.run(0.2)
    rests = path_markers(cell)
    cell.bench.run(0.2)
    assert path_markers(cell) == rests and 0 < rests[0] < 250, "a stopped robot is where it is"
    assert cell.run()[0] == "ended" and float(str(cell.value("R1"))) == pytest.approx(250, abs=0.02), "START goes on with the same way"
    cell.bench.run(0.2)
    assert path_markers(cell)[1::2] == [0, 0]
