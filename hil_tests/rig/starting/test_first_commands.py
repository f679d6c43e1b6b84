"""What somebody new types: the version, a value with its unit, who answers on the bus of a cell."""

import pathlib
import platform
import subprocess
import sys
from importlib.metadata import version

import pytest

from gateway.__main__ import main
from gateway.cell_file.load import load_cell
from gateway.commands import drive
from gateway.commands.var import sentence
from gateway.pure.cell.cell import Cell
from gateway.pure.image.addresses import DataWord, Part
from gateway.services.tool_server import entry_unit, name_unit
from hil_tests.lab.partners.durand_drive import DurandDrive
from hil_tests.lab.partners.hand_plc import words_of
from hil_tests.lab.running.bus_running import running_bus


@pytest.fixture(scope="module")
def cell() -> Cell:
    return load_cell("s5-rk512")


@pytest.mark.parametrize("asked", ["--version", "-V", "version"])
def test_the_version_is_said(asked: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([asked]) == 0
    assert capsys.readouterr().out.startswith(f"axisgate {version('axisgate')}, Python {platform.python_version()}, Linux ")


def test_values_have_the_unit_the_cell_gives_them(cell: Cell) -> None:
    assert name_unit(cell, "axis.X.actual") == {"unit": "mm"} and name_unit(cell, "cell.override") == {"unit": "%"}
    assert name_unit(cell, "cell.ready") == name_unit(cell, "axis.Q.actual") == name_unit(cell, "nothing.at.all") == {}
    assert entry_unit(cell, "plc", DataWord(10, 2, Part.WORD)) == {"unit": "0.1 mm"}
    assert entry_unit(cell, "plc", DataWord(10, 31, Part.WORD)) == entry_unit(cell, "plc", DataWord(99, 0, Part.WORD)) == {}
    assert sentence({"place": "axis.X.actual", "value": 12.5, "unit": "mm"}) == "axis.X.actual = 12.5 mm"
    assert sentence({"place": "DB10.DW2", "value": 1200, "KF": 1200, "unit": "0.1 mm"}) == "DB10.DW2 = 1200 x 0.1 mm   (KF 1200)"
    assert sentence({"place": "cell.ready", "value": 1}) == "cell.ready = 1"


def test_scan_takes_a_cell(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert drive.main(["scan", "demo-402"]) == 2 and 'has port = "sim"' in capsys.readouterr().err
    assert drive.main(["scan", "demo"]) == 2 and "no CANopen bus" in capsys.readouterr().err
    with running_bus(tmp_path, name="firstscan", log=False):
        device = DurandDrive("firstscan", 5)
        try:
            assert drive.main(["scan", "demo-402", "--port", "broker:firstscan"]) == 0
            assert "node   5:" in capsys.readouterr().out
        finally:
            device.stop()


def test_a_simulation_on_a_bus_that_is_not_there_ends_at_once() -> None:
    """Its drives would try the bus again and again, and the run would wait 20 s for them."""
    command = [sys.executable, "-m", "gateway", "run", "demo", "--die-with-parent", "--bus", "broker:not-there"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 3 and "broker:not-there: No such file or directory; start it with" in ended.stderr, ended.stderr
    assert "started, pid" not in ended.stdout + ended.stderr


def test_errors_of_the_hand_are_words() -> None:
    assert words_of(4) == "4 (target outside the limits)" and words_of(17) == "17 (no telegram from a drive)"
    assert words_of(9999) == "9999 (axisgate explain 9999)" and words_of(0) == "0"
