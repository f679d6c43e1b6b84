"""A wheel brings the cycle's parts in C for the Python that built it."""

import pathlib
import shutil
import subprocess
import sys
import zipfile

import pytest

from gateway.cycle.native import built

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler: the wheel says so and has none")
def test_a_wheel_has_the_parts_in_c_and_their_sources(tmp_path: pathlib.Path) -> None:
    tree = tmp_path / "tree"
    tree.mkdir()
    for name in ("gateway", "drivers", "protocols", "motion", "configs"):
        shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("*.so", "__pycache__"))
    shutil.copytree(ROOT / "docs" / "decisions.d", tree / "docs" / "decisions.d")
    (tree / "hil_tests").mkdir()
    for name in ("pyproject.toml", "hatch_build.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tree)
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", str(tmp_path), str(tree)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=240)
    assert done.returncode == 0, done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {f"gateway/cycle/native/{built.library(part).name}" for part in built.PARTS} <= names
    assert {f"gateway/cycle/native/{part}.c" for part in built.PARTS} <= names and "none-any" not in wheel.name
    assert "configs/decisions/AX-334-declared-processes.md" in names, "axisgate explain AX-334"
