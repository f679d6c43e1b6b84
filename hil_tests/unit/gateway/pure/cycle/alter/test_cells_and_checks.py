"""[alter] in a cell file: what does not fit is told; `axisgate motion check` with alterable blocks."""

import pathlib

import pytest

from gateway.assembly.alter import alter_of_cell
from gateway.cell_file.load import load_cell
from gateway.commands import motion
from gateway.pure.cell.faults import CellFaults
from gateway.pure.cycle.alter import AlterFacts, Correction
from gateway.pure.image.records.cell import InputImage, Quality
from hil_tests.lab.virtual.alter_bench import ALTER, HEAD, PORTAL, with_alter

SAYS = {
    "input = 520": "six INT from here: whole words of the image",
    "input = 944": "six INT from here: whole words of the image",
    "input = 16": "RC input byte 2 holds enabling inputs",
    "input = 640": "RC input byte 80 has no writer",
    "life = 520": "the first RC input of a byte outside the correction",
    "life = 617": "the first RC input of a byte outside the correction",
    "status = 520": "two whole words of the image",
    "status = 64": "axisgate itself, or a [[path_output]], writes one of these outputs",
    'type = "WORD"': "INT",
    "every_ms = 0": "1",
}


@pytest.mark.parametrize("line", SAYS)
def test_what_does_not_fit_is_reported(line: str) -> None:
    key = line.partition(" ")[0]
    lines = [each for each in ALTER.splitlines() if not each.startswith(f"{key} =")]
    with pytest.raises(CellFaults) as told:
        load_cell(str(PORTAL), with_alter(PORTAL.read_text(), "\n".join([*lines, line, "", ""])))
    assert f"alter.{key}" in str(told.value) and SAYS[line] in str(told.value)


def test_a_correction_without_a_robot_is_refused() -> None:
    text = with_alter(PORTAL.read_text())
    with pytest.raises(CellFaults, match="alter"):
        load_cell(str(PORTAL), text.replace('model      = "portal"', 'model      = ""'))


def test_words_become_mm_and_deg_and_reals_are_taken_as_they_are() -> None:
    image = InputImage()
    image.values[64:76] = bytes.fromhex("0064 FF9C 0000 0001 0000 2328")
    assert Correction(AlterFacts(64)).read(image) == pytest.approx((1.0, -1.0, 0.0, 0.01, 0.0, 90.0))
    image.values[64:88] = bytes.fromhex("3F800000 BF800000 00000000 00000000 00000000 42B40000")
    assert Correction(AlterFacts(64, real=True)).read(image) == pytest.approx((1.0, -1.0, 0.0, 0.0, 0.0, 90.0))


def test_life_is_a_byte_that_changes_or_bytes_that_are_written() -> None:
    image, by_life, by_stamp = InputImage(), Correction(AlterFacts(64, life=77)), Correction(AlterFacts(64))
    ms = 1_000_000
    for octet in (*range(64, 76), 77):
        image.quality[octet] = Quality.GOOD
    assert not by_life.alive(image, 0) and not by_stamp.alive(image, 0), "what stands there at the start is no life"
    image.values[77] = 1
    assert by_life.alive(image, 10 * ms) and by_life.alive(image, 110 * ms) and not by_life.alive(image, 111 * ms)
    image.stamps[64:76] = [50 * ms] * 12
    assert by_stamp.alive(image, 150 * ms) and not by_stamp.alive(image, 151 * ms)
    image.stamps[64:75] = [200 * ms] * 11
    assert not by_stamp.alive(image, 210 * ms), "one byte of it is old"
    image.stamps[75] = 200 * ms
    image.quality[70] = Quality.STALE
    assert not by_stamp.alive(image, 210 * ms)


def test_a_clock_slower_than_4_ms_takes_one_correction_a_cycle() -> None:
    cell = load_cell(str(PORTAL), with_alter(PORTAL.read_text(), ALTER.replace("every_ms = 16", "")))
    for p5_ms, every in ((1, 4e-3), (2, 4e-3), (4, 4e-3), (8, 8e-3), (10, 10e-3)):
        made = alter_of_cell(cell, p5_ms)
        assert made is not None and made.alter.every_s == pytest.approx(every)


def test_check_and_plot_take_alterable_blocks_and_say_what_the_cell_lacks(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = tmp_path / "it.txt"
    program.write_text(HEAD + "alter frame - path=500\nlinear pose 400 100 50 0 0 0\nalter_end\nlinear pose 400 200 50 0 0 0\n")
    cell = tmp_path / "portal.toml"
    cell.write_text(with_alter(PORTAL.read_text()))
    assert motion.main(["check", str(program)]) == 0
    assert motion.main(["check", str(program), "--cell", str(cell)]) == 0
    assert capsys.readouterr().out == "2 blocks: all can be run\n" * 2
    assert motion.main(["check", str(program), "--cell", "portal"]) == 1
    assert "line 6: block 1: alterBegin: option not enabled; the cell has no [alter] for the robot (VAL 3 -2)" in capsys.readouterr().out
    assert motion.main(["plot", str(program), "--cell", str(cell), "--out", str(tmp_path / "it.html")]) == 0
    assert "Alterable, drawn without a correction: block 1." in (tmp_path / "it.html").read_text()
