"""axisgate motion: check tells every block that cannot be run, plot writes one page without anything from outside."""

import json
import pathlib
import re

import pytest

from gateway.commands.motion import main
from gateway.files.find import find_config, read_text
from gateway.pure.reports.svg import Chart, Line, draw, thinned, ticks
from hil_tests.lab.virtual.belt_bench import HEAD, TEXT

WRONG = """
program wrong
robot tx60-like
start 0 30 90 0 60 0
ptp joints 0 140 90 0 60 0
ptp pose 350 0 200 180 0 0
linear pose 2000 0 200 180 0 0
circular via pose 350 0 200 180 0 0 to pose 350 100 200 180 0 0
linear pose 350 50 200 180 0 0 path=100
"""


@pytest.fixture
def wrong(tmp_path: pathlib.Path) -> str:
    path = tmp_path / "wrong.txt"
    path.write_text(WRONG)
    return str(path)


@pytest.mark.parametrize("name", ["scara-pick-and-place", "arm-u-cycle"])
def test_the_shipped_programs_can_be_run(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", name]) == 0
    assert "all can be run" in capsys.readouterr().out


def test_check_names_line_block_axis_and_number_of_each_fault(wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", wrong]) == 1
    out = capsys.readouterr().out
    assert re.search(r"line 5: block 1, axis J2: .*140 deg.*\(VAL 3 520\)", out)
    assert re.search(r"line 7: block 3.*mm along the path \(VAL 3 53\d\)", out)
    assert re.search(r"line 8: block 4: .*too close \(VAL 3 552\)", out)
    assert "5 blocks: 3 cannot be run" in out


def test_check_as_json(wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", wrong, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert (found[0]["block"], found[0]["line"], found[0]["code"], found[0]["axis"]) == (1, 5, 520, "J2")


def test_check_warns_of_a_path_that_an_axis_of_the_cell_slows_down_and_it_can_be_run_all_the_same(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cell, program = (str(tmp_path / name) for name in ("cell.toml", "fast.txt"))
    pathlib.Path(cell).write_text(read_text(find_config("portal", "cells")).replace("[robot]\n", "[robot]\ntoo_fast = 3\n"))
    pathlib.Path(program).write_text("axes mm mm mm deg\nstart 50 50 50 0\nlinear pose 450 50 50 0 0 0 path=1600\n")
    assert main(["check", program, "--cell", cell]) == 0
    assert capsys.readouterr().out.startswith("line 3: warning: block 1, axis X: Interpolator Stop: 2 times its speed, 0 % along the path")
    assert main(["check", program, "--cell", cell, "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert (found["block"], found["line"], found["axis"], found["warning"]) == (1, 3, "X", True)
    pathlib.Path(cell).write_text(pathlib.Path(cell).read_text().replace("too_fast = 3", "too_fast = 1"))
    assert main(["check", program, "--cell", cell]) == 1
    assert "block 1, axis X: Ax-Velocity exceeded" in capsys.readouterr().out


def test_a_program_with_belts_is_looked_at_in_its_cell(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell, program, page = (str(tmp_path / name) for name in ("cell.toml", "belt.txt", "belt.html"))
    pathlib.Path(cell).write_text(TEXT)
    lines = ("synchron B1 at=60mm", "linear pose 150 150 50 0 0 0 belt=60mm path=60", "synchron_end", "linear pose 100 100 50 0 0 0", "")
    pathlib.Path(program).write_text(HEAD + "\n".join(lines))
    assert main(["check", program]) == 2 and "line 6: belt B1 belongs to a cell: name it with --cell" in capsys.readouterr().err
    assert main(["check", program, "--cell", cell]) == 0
    assert main(["plot", program, "--cell", cell, "--out", page]) == 0
    assert "belt B1 while blocks lie on it" in pathlib.Path(page).read_text()
    capsys.readouterr()
    assert main(["plot", program, "--cell", cell, "--belt-speed", "1500", "--out", str(tmp_path / "none.html")]) == 1
    assert "line 6: block 1, axis X: the axis cannot keep up with the belt (axisgate 65003)" in capsys.readouterr().out
    assert main(["check", program, "--cell", "nowhere"]) == 2


def test_plot_of_a_program_with_faults_reports_them_instead(wrong: str, tmp_path: pathlib.Path) -> None:
    assert main(["plot", wrong, "--out", str(tmp_path / "page.html")]) == 1
    assert not (tmp_path / "page.html").exists()


def test_text_and_robot_faults_are_exit_2(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = tmp_path / "bad.txt"
    bad.write_text("start 0\nfoo\nlinear pose 1\n")
    assert main(["check", str(bad)]) == 2
    err = capsys.readouterr().err
    assert "line 2" in err and "line 3" in err
    bad.write_text("robot nobody\nstart 0\n")
    assert main(["check", str(bad)]) == 2
    assert main(["check", "no-such-program"]) == 2
    assert main(["check", "arm-u-cycle", "--robot", "sr60-like"]) == 2


def test_plot_writes_one_page_with_all_pictures(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "page.html"
    assert main(["plot", "scara-pick-and-place", "--out", str(page), "--json"]) == 0
    text = page.read_text()
    assert text.count("<svg") == 10 and text.count("</svg>") == 10
    assert not re.search(r"(src|href)=|https?:", text), "nothing from outside"
    for title in ("seen from above", "speed of the tool", "jerk of the axes", "Corners"):
        assert title in text
    found = json.loads(capsys.readouterr().out)
    assert 2.0 < found["seconds"] < 3.0
    assert found["loads"]["speed"] <= 1.001 and found["loads"]["acceleration"] <= 1.02 and found["loads"]["jerk"] <= 1.05
    assert [round(c["missed_mm"], 2) for c in found["corners"]] == [3.31, 3.31]


def test_charts_keep_peaks_and_round_ticks() -> None:
    many = [(float(k), 0.0) for k in range(20_000)]
    many[7777] = (7777.0, 5.0)
    kept = thinned(many)
    assert len(kept) < 3000 and (7777.0, 5.0) in kept
    assert ticks(0.0, 1.0) == pytest.approx([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
    assert draw(Chart("<a&b>", "x", "y", [Line("one", [0.0, 1.0], [1.0, 1.0])])).count("&lt;a&amp;b&gt;") == 2
