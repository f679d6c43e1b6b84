"""`axisgate demo` on the local bus: exit 0 only if every verdict of the witnesses holds."""

import json
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
VERDICTS = 15


def demo(folder: pathlib.Path, *options: str) -> subprocess.CompletedProcess[str]:
    command = [
        sys.executable,
        "-m",
        "gateway",
        "demo",
        "--records",
        str(folder / "records"),
        "--name",
        f"demo-{folder.name[-8:]}",
        *options,
    ]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=600, check=False)


@pytest.mark.timeout(650)
def test_the_whole_scenario_holds_by_the_witnesses(tmp_path: pathlib.Path) -> None:
    done = demo(tmp_path, "--json", "--seed", "3")
    assert done.returncode == 0, done.stderr[-3000:]
    verdicts = json.loads(done.stdout)
    assert len(verdicts) == VERDICTS
    assert [verdict for verdict in verdicts if not verdict["ok"]] == []
    page = (tmp_path / "records" / "demo.html").read_text()
    assert page.count("<svg") == 4 and "SCARA" in page and "Six-axis arm" in page and "FAILS" not in page
    assert {path.name for path in (tmp_path / "records").iterdir()} >= {"bus-drives.log", "emulator-drives.rec", "line-plc1.rec"}


def test_a_clock_out_of_range_is_a_usage_error(tmp_path: pathlib.Path) -> None:
    done = demo(tmp_path, "--p5", "33")
    assert (done.returncode, "2..32" in done.stderr) == (2, True)


def test_a_bus_that_is_not_there_is_the_environments_fault(tmp_path: pathlib.Path) -> None:
    done = demo(tmp_path, "--bus", "socketcan:nosuch0")
    assert done.returncode == 3
    assert "nosuch0" in done.stderr
