"""`make demo` builds no kernel by itself, and a build of one that is interrupted leaves nothing behind."""

import os
import pathlib
import shutil
import signal
import subprocess
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
KERNEL = ROOT / "hil_tests/rig/uml/kernel.sh"
SOURCES = sorted(pathlib.Path("/usr/src").glob("linux-source-6.*.tar.xz"))
PATIENCE_S = 20.0


def program(path: pathlib.Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


@pytest.fixture
def tree(tmp_path: pathlib.Path) -> pathlib.Path:
    """The Makefile on a machine whose demo ends as one that was too slow."""
    shutil.copy(ROOT / "Makefile", tmp_path)
    for name in ("requirements.lock", "pyproject.toml"):
        (tmp_path / name).touch()
    program(tmp_path / ".venv/bin/axisgate", 'echo "axisgate $*"; case "$*" in *--own-time*) exit 0;; esac; exit 4')
    program(tmp_path / ".venv/bin/python", "exit 0")
    (tmp_path / ".venv/installed.stamp").touch()
    return tmp_path


def make(tree: pathlib.Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(["make", "demo"], cwd=tree, capture_output=True, text=True, check=False, timeout=60)


def test_on_a_slow_machine_make_demo_says_what_to_type(tree: pathlib.Path) -> None:
    said = make(tree)
    assert said.returncode == 2 and "Error 4" in said.stderr and "make kernel" in said.stdout and "DEMO=--own-time" in said.stdout
    assert "--own-time" not in said.stdout.partition("type:")[0] and not (tree / "build").exists()


def test_where_the_kernel_is_built_the_demo_is_played_in_the_guest(tree: pathlib.Path) -> None:
    program(tree / "build/guest-kernel", "exit 0")
    said = make(tree)
    assert said.returncode == 0 and "axisgate demo --own-time" in said.stdout


@pytest.mark.skipif(not SOURCES, reason="no linux-source here: nothing would be built")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_build_leaves_nothing_behind(tmp_path: pathlib.Path, number: signal.Signals) -> None:
    work, cache = tmp_path / "work", tmp_path / "cache"
    work.mkdir()
    program(tmp_path / "bin/tar", f"echo $$ > {tmp_path}/tar.pid; exec sleep 300")
    surroundings = os.environ | {"PATH": f"{tmp_path}/bin:{os.environ['PATH']}", "TMPDIR": str(work), "XDG_CACHE_HOME": str(cache)}
    build = subprocess.Popen(["sh", str(KERNEL), str(tmp_path / "link")], env=surroundings, start_new_session=True)
    try:
        end = time.monotonic() + PATIENCE_S
        while not ((tmp_path / "tar.pid").exists() and (tmp_path / "tar.pid").read_text().strip()):
            assert time.monotonic() < end and build.poll() is None
            time.sleep(0.02)
        assert list(work.iterdir()), "it builds in a folder of its own"
        os.killpg(build.pid, number)
        assert build.wait(PATIENCE_S) == 130
    finally:
        if build.poll() is None:
            os.killpg(build.pid, signal.SIGKILL)
    assert not list(work.iterdir()) and not list(cache.rglob("*.new")) and not (tmp_path / "link").exists()
    builder = pathlib.Path(f"/proc/{(tmp_path / 'tar.pid').read_text().strip()}")
    while builder.exists() and "Z" not in (builder / "stat").read_text().rpartition(")")[2]:
        assert time.monotonic() < end + PATIENCE_S, "what built goes on"
        time.sleep(0.02)
