"""Confirmation before the first enable on real drives, and the zeros it depends on: files beside the cell, nothing ever taken out."""

import json
import pathlib
import subprocess
import sys
from collections.abc import Callable

import pytest

from gateway.assembly import axis_zeros as zeros
from gateway.assembly.axes import core_axes
from gateway.assembly.last_positions import judge, remember
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config
from gateway.pure.cell.cell import Cell
from gateway.pure.image.records.cell import AxisState, CellState
from gateway.tools.drives.first_enable import WORDS, confirm, fingerprint, log_of, needed, unconfirmed
from hil_tests.lab.cells.on_a_machine import on_a_machine


def answering(typed: str) -> Callable[[str], str]:
    return lambda _: typed


def real(folder: pathlib.Path, *changes: tuple[str, str]) -> Cell:
    """The S5 cell as somebody's own file on a real bus, without its couplers."""
    text = on_a_machine(find_config("s5-rk512", "cells").read_text())
    start, end = text.index("[[io]]"), text.index("# ---- drives")
    text = text[:start] + text[end:]
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file = folder / "mine.toml"
    file.write_text(text)
    return load_cell(str(file))


def test_the_words_and_a_name_are_asked_for_and_written_down(tmp_path: pathlib.Path) -> None:
    cell = real(tmp_path)
    assert needed(cell, simulated=True) == [] and needed(cell, simulated=False) == ["X", "Y", "Z"]
    said: list[str] = []
    for typed in ("", "yes", WORDS, f"{WORDS} x"):
        assert not confirm(cell, needed(cell, simulated=False), answering(typed), said.append)
    assert unconfirmed(cell) == ["X", "Y", "Z"]
    assert confirm(cell, ["X", "Y", "Z"], lambda _: f"{WORDS} A. Fitter", said.append)
    assert unconfirmed(cell) == [] and any("Emergency stop tested today" in text for text in said)
    entry = json.loads(log_of(cell).read_text().splitlines()[-1])
    assert entry["who"] == "A. Fitter" and set(entry["axes"]) == {"X", "Y", "Z"}


@pytest.mark.parametrize(
    "change",
    [
        ('gear = "10:1"', 'gear = "9:1"'),
        ("node = 1,", "node = 11,"),
        ('direction = "+" }\nlimits      = { min = -5.0', 'direction = "-" }\nlimits      = { min = -5.0'),
    ],
)
def test_another_drive_or_other_mechanics_are_asked_for_again(tmp_path: pathlib.Path, change: tuple[str, str]) -> None:
    cell = real(tmp_path)
    confirm(cell, ["X", "Y", "Z"], lambda _: f"{WORDS} A. Fitter", lambda _: None)
    assert unconfirmed(real(tmp_path, change)) == ["X"]
    (tmp_path / "drives").mkdir()
    (tmp_path / "drives" / "maker_x.eds").write_text("[DeviceInfo]\nVendorName=Maker X\n")
    assert unconfirmed(real(tmp_path)) == ["X", "Y", "Z"], "another data sheet"


def test_a_new_zero_is_kept_with_its_history_counts_at_the_next_start_and_is_asked_for_again(tmp_path: pathlib.Path) -> None:
    cell = real(tmp_path)
    z = cell.axis_named("Z")
    assert [axis.absolute for axis in core_axes(cell, 4, {}, simulated=False)] == [False, False, False]
    confirm(cell, ["X", "Y", "Z"], lambda _: f"{WORDS} A. Fitter", lambda _: None)
    before = fingerprint(cell)["Z"]
    zeros.append(cell, zeros.entry(cell, z, reading=20.0, at=5.0, who="A. Fitter"))
    zero = zeros.zero_inc(cell, "Z")
    assert zero == pytest.approx(15.0 / 20.0 * 16384, abs=1), "20 mm a turn: what read 20 mm reads 5 mm"
    plan = core_axes(cell, 4, {"Z": zero or 0.0}, simulated=False)[2]
    assert plan.absolute and plan.scaling.to_si(20.0 / 20.0 * 16384) == pytest.approx(0.005)
    zeros.append(cell, zeros.entry(cell, z, reading=5.0, at=5.0, who="A. Fitter"))
    assert [entry["zero_inc"] for entry in zeros.history(cell, "Z")] == pytest.approx([zero, zero], abs=1)
    assert fingerprint(cell)["Z"] != before and unconfirmed(cell) == ["Z"]


def test_an_encoder_that_counted_round_since_the_last_stop_is_reported_with_its_turns(tmp_path: pathlib.Path) -> None:
    cell = real(tmp_path)
    state = CellState(axes=[AxisState(actual=0.1) for _ in range(12)])
    remember(cell, state)
    assert judge(cell, state) == []
    state.axes[2].actual += 4096 * 0.020
    assert ["Z" in sentence and "+4096 turns" in sentence for sentence in judge(cell, state)] == [True]


def test_run_on_a_real_bus_without_a_terminal_shows_the_text_and_refuses(tmp_path: pathlib.Path) -> None:
    real(tmp_path)
    command = [sys.executable, "-m", "gateway", "run", str(tmp_path / "mine.toml")]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 3
    assert "1. Emergency stop tested today, with drives on." in done.stderr and "not confirmed for X, Y, Z" in done.stderr
