"""check, explain and doctor: what they print, and their exit codes (users.md 3.4, 4; design.md 5).

Each command runs once and more as a real process; the other cases call it in this one, which spares them half a second each.
"""

import json
import os
import pathlib
import subprocess
import sys
from typing import Protocol

import pytest

from gateway.__main__ import main
from hil_tests.unit.gateway.cell_file.test_load import MANY

LIMIT_S = 60.0


def axisgate(*arguments: str, folder: pathlib.Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    """One command in a process of its own, its output piped."""
    return subprocess.run(
        [sys.executable, "-m", "gateway", *arguments],
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        cwd=folder,
        env={**os.environ, **environment},
        check=False,
    )


class Called(Protocol):
    def __call__(self, *arguments: str, folder: pathlib.Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]: ...


@pytest.fixture
def called(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Called:
    """`axisgate` with this command line, in this process."""

    def call(*arguments: str, folder: pathlib.Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
        with monkeypatch.context() as patch:
            if folder is not None:
                patch.chdir(folder)
            for name, value in environment.items():
                patch.setenv(name, value)
            try:
                code = main(arguments)
            except SystemExit as ended:
                code = ended.code if isinstance(ended.code, int) else 1
        told = capsys.readouterr()
        return subprocess.CompletedProcess(arguments, code, told.out, told.err)

    return call


@pytest.mark.parametrize(
    ("name", "head"),
    [
        ("demo", "demo: 6 axes, 1 line, 1 bus: 0 errors, 0 warnings, 4 notes"),
        ("s5-rk512", "s5-rk512: 3 axes, 1 line, 1 bus: 0 errors, 4 warnings, 4 notes"),
        ("rho3-servodyn", "rho3-servodyn: 6 axes, 1 line, 2 buses: 0 errors, 1 warning, 7 notes"),
    ],
)
def test_the_shipped_cells_pass(name: str, head: str) -> None:
    done = axisgate("check", name)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0] == head
    assert lines[-1].startswith("next: axisgate ")
    assert "\033" not in done.stdout


def test_a_file_with_many_faults_names_all_of_them(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "cell.toml"
    file.write_text(MANY, encoding="utf-8")
    done = axisgate("check", "cell.toml", folder=tmp_path)
    assert (done.returncode, done.stderr) == (2, "")
    lines = done.stdout.splitlines()
    assert lines[0] == "cell.toml: 12 errors (6 in single keys, 6 between keys)"
    assert [line.split()[0] for line in lines[1:-1]] == ["error"] * 12
    assert 'error    cell.toml:5: cell.target = "maschine": allowed machine | simulation: did you mean machine?' in lines
    assert lines[-1] == "next: correct them, then: axisgate check cell.toml"


def test_faults_as_json(called: Called, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "cell.toml"
    file.write_text(MANY, encoding="utf-8")
    done = called("check", str(file), "--json")
    told = json.loads(done.stdout)
    assert done.returncode == 2 and told["valid"] is False and len(told["errors"]) == 12
    assert set(told["errors"][0]) == {"file", "key", "value", "range", "unit", "hint", "line", "kind"}


def test_a_valid_cell_as_json(called: Called) -> None:
    done = called("check", "s5-rk512", "--json")
    told = json.loads(done.stdout)
    assert done.returncode == 0 and told["valid"] is True and told["axes"] == ["X", "Y", "Z"]
    assert len(told["warnings"]) == 4 and told["not_playable"] == []


def test_strict_turns_warnings_into_a_finding(called: Called) -> None:
    assert called("check", "s5-rk512", "--strict").returncode == 1
    assert called("check", "demo", "--strict").returncode == 0


def test_a_run_reports_the_ports_it_does_not_use() -> None:
    """The cell's target is the simulation: whoever starts it without --sim believes that its line is open."""
    command = [sys.executable, "-m", "gateway", "run", "rho3-servodyn", "--name", f"unused-{os.getpid()}", "--die-with-parent"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as run:
        assert run.stdout is not None
        said = next((line for line in run.stdout if "not used" in line), "")
        run.terminate()
        run.stdout.read()
    assert said.strip().endswith("not used: line V24_1 (/dev/ttyS0), bus drives (socketcan:can0), bus io (socketcan:can1)")


def test_the_file_with_semicolons_gets_the_hint(called: Called, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "device.toml"
    file.write_text('[device]\nname = "Checkweigher CW-4"; serial = "..."\n', encoding="utf-8")
    done = called("check", "device.toml", folder=tmp_path)
    assert done.returncode == 2
    assert "device.toml:2: TOML" in done.stdout and "TOML has no semicolons: one key on each line" in done.stdout


@pytest.mark.parametrize(
    "content", [b"", b"\xff\xfe\x00", b"x = \xfc\n", b"[[cell]]\n", b"format = 1\ncell = 5\naxis = [1, 2]\n", b"\x00" * 100]
)
def test_rubbish_is_refused_in_words(called: Called, tmp_path: pathlib.Path, content: bytes) -> None:
    (tmp_path / "cell.toml").write_bytes(content)
    done = called("check", "cell.toml", folder=tmp_path)
    assert (done.returncode, done.stderr) == (2, "")
    assert "error    cell.toml" in done.stdout


def test_a_missing_file_says_where_it_was_looked_for(called: Called, tmp_path: pathlib.Path) -> None:
    done = called("check", "nothing", folder=tmp_path, AXISGATE_CONFIGS=str(tmp_path / "mine"))
    assert done.returncode == 2 and done.stdout == ""
    assert str(tmp_path / "nothing") in done.stderr and str(tmp_path / "mine" / "cells") in done.stderr and "demo" in done.stderr


def test_own_configs_come_before_the_packaged_ones(called: Called, tmp_path: pathlib.Path) -> None:
    (tmp_path / "cells").mkdir()
    (tmp_path / "cells" / "demo.toml").write_text('format = 1\n[cell]\nname = "mine"\n', encoding="utf-8")
    done = called("check", "demo", AXISGATE_CONFIGS=str(tmp_path))
    assert done.stdout.startswith("demo: 0 axes, 0 lines, 0 buses: 0 errors")


def test_a_command_line_that_is_none(called: Called) -> None:
    assert called("check").returncode == 2
    assert called("explain", "no.such.thing", "--cell", "demo").returncode == 2
    assert "the rho 3 has no machine parameter P9999" in called("explain", "P9999").stderr
    assert "decision" in called("explain", f"AX-{999}").stderr
    assert called("doctor", "--nonsense").returncode == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("axis.1", "--cell", "rho3-servodyn"), ("axis.1.limits.speed", "120 deg/s", "rho3.P103[1], rho3-servodyn:34", "AX-123")),
        (("axis.A1.limits.speed", "--cell", "demo"), ("800 mm/s", "demo:")),
        (("axis.1.home", "--cell", "demo"), ("axis.A1.home.speed",)),
        (("P5", "--cell", "rho3-servodyn"), ("8 ms", "clock", "bus.drives.cycle_ms", "from rho3.P5")),
        (("QVZ", "--cell", "s5-rk512"), ("ADT", "2000 ms", "550 ms", "line.plc")),
        (("DB10.DW2", "--cell", "demo"), ("move.A1.target", "KF")),
        (("RC 7.3",), ("66", "O8.2", "O7.2", "7.3", "drive on, all axes")),
        (("P303",), ("rho3.P303", "axis type", "--cell")),
        (("AX-334",), ("AX-334", "EXPROG.DAT")),
        (("ax-001",), ("AX-001", "SERVODYN")),
        (("READY_RCO",), ("64", "I8.0", "axisgate (AX-002)")),
    ],
)
def test_explain(called: Called, arguments: tuple[str, ...], words: tuple[str, ...]) -> None:
    done = called("explain", *arguments)
    assert (done.returncode, done.stderr) == (0, "")
    assert [word for word in words if word not in done.stdout] == []


def test_explain_of_an_invalid_cell_points_to_check(tmp_path: pathlib.Path) -> None:
    (tmp_path / "cell.toml").write_text("format = 9\n", encoding="utf-8")
    done = axisgate("explain", "axis.1", folder=tmp_path)
    assert done.returncode == 2 and "axisgate check cell.toml names them" in done.stderr


def test_doctor_says_what_to_do() -> None:
    done = axisgate("doctor", "--json")
    findings = json.loads(done.stdout)
    assert done.returncode in (0, 1)
    assert {"real time", "memory lock"} <= {finding["what"] for finding in findings}
    assert all(finding["todo"] for finding in findings if finding["level"] == "warn")
    assert done.returncode == (1 if any(finding["level"] == "warn" for finding in findings) else 0)


def test_doctor_of_things_that_are_not_there(tmp_path: pathlib.Path) -> None:
    done = axisgate("doctor", "--port", str(tmp_path / "tty"), "--can", "nocan7")
    assert done.returncode == 3
    assert f"missing  port {tmp_path / 'tty'}: does not exist" in done.stdout
    assert "missing  can" in done.stdout and "do: " in done.stdout
