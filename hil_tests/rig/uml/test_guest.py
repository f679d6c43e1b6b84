"""The guest brings back what the command did, ends when it must, and a dead guest is never a green lane."""

import pathlib
import subprocess
import sys

import pytest

from hil_tests import lanes
from hil_tests.rig.uml.guest import Guest, GuestError

pytestmark = pytest.mark.skipif(lanes.missing("vcan") is not None, reason="no guest here; lane vcan says why")


def test_exit_code_output_environment_and_files_come_back(tmp_path: pathlib.Path) -> None:
    lines: list[str] = []
    guest = Guest(tmp_path, limit_s=60, environment={"COLOUR": "green"})
    code = guest.run(["sh", "-c", f"echo $COLOUR; ip -br link show vcan0; echo made > {tmp_path}/made; exit 7"], lines.append)
    assert code == 7
    assert lines[0] == "green" and "vcan0" in lines[1] and "UP" in lines[1]
    assert (tmp_path / "made").read_text() == "made\n"


def test_a_guest_that_takes_too_long_is_ended_and_says_so(tmp_path: pathlib.Path) -> None:
    with pytest.raises(GuestError, match=r"ended after [67].* \(limit 6 s\) without a result"):
        Guest(tmp_path, limit_s=6).run(["sh", "-c", "while :; do :; done"])


DYING = """
import ctypes, pytest
pytestmark = pytest.mark.vcan

def test_that_ends_well(): pass
def test_that_fails(): assert 1 == 2
def test_that_switches_the_guest_off(): ctypes.CDLL(None).reboot(0x4321FEDC)
def test_that_never_runs(): pass
"""


def test_every_guest_test_is_reported_and_those_of_a_dead_guest_have_failed(tmp_path: pathlib.Path) -> None:
    (tmp_path / "test_dying.py").write_text(DYING)
    (tmp_path / "conftest.py").write_text("from hil_tests.conftest import pytest_addoption, pytest_configure\n")
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n    requirement\n    vcan\n    mbpoll\n    cref\n")
    command = [sys.executable, "-m", "pytest", "-v", "--color=no", "-p", "no:cacheprovider", "test_dying.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    verdict = {
        line.split()[0].partition("::")[2]: line.split()[1] for line in done.stdout.splitlines() if line.startswith("test_dying.py::")
    }
    assert verdict == {
        "test_that_ends_well": "PASSED",
        "test_that_fails": "FAILED",
        "test_that_switches_the_guest_off": "FAILED",
        "test_that_never_runs": "FAILED",
    }
    assert "lane vcan: 1 passed, 3 failed" in done.stdout
    assert "assert 1 == 2" in done.stdout and "the guest did not report the end of this test" in done.stdout
    assert done.returncode == 1
