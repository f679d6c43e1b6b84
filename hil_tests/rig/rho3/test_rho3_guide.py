"""docs/guide/rho3-lines.md: both examples run as they stand."""

import pathlib
import re
import subprocess
import sys

import pytest

from hil_tests.purity import ROOT

GUIDE = ROOT / "docs" / "guide" / "rho3-lines.md"
EXAMPLES = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)


def test_the_worked_example() -> None:
    space: dict[str, object] = {}
    exec(compile(EXAMPLES[0], str(GUIDE), "exec"), space)
    assert space["second"] == 2


def test_the_example_on_ports(runtime: pathlib.Path) -> None:
    command = [sys.executable, "-m", "gateway.simulation.line.process", "--name", "bench", "--baud", "9600"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            space: dict[str, object] = {"__name__": "example"}
            exec(compile(EXAMPLES[1], str(GUIDE), "exec"), space)
            assert space["barcode"] == b"4711"
        finally:
            process.terminate()


@pytest.mark.parametrize("row", range(-11, 1))
def test_every_condition_is_in_the_guide(row: int) -> None:
    codes = {int(code) for line in re.findall(r"^\| (0|-\d+(?:, -\d+)*) \|", GUIDE.read_text(), re.MULTILINE) for code in line.split(", ")}
    assert row in codes
