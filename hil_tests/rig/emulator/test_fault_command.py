"""Faults ordered from the shell at a running emulator: frames lost, a quiet controller, drives; what is not a fault is refused in words."""

import json

import pytest

from gateway.commands.fault import main
from hil_tests.rig.emulator.test_emulator_process import Rig, rig  # noqa: F401  a fixture


def told(capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    answer: dict[str, object] = json.loads(capsys.readouterr().out)
    return answer


def test_lost_syncs_stop_the_drives(rig: Rig, capsys: pytest.CaptureFixture[str]) -> None:  # noqa: F811
    rig.switch_on()
    assert main(["drop", "way=in", "id=100", "count=6"]) == 0
    capsys.readouterr()
    for _ in range(10):
        rig.cycle()
    assert main(["state"]) == 0
    state = told(capsys)
    assert state["frames"] == {"drop": 6, "delay": 0, "duplicate": 0, "corrupt": 0, "silenced": 0}
    axes = state["axes"]
    assert isinstance(axes, dict) and {axis["fault"] for axis in axes.values()} == {1}, "SYNC lost"


def test_a_quiet_controller_is_heard_again(rig: Rig, capsys: pytest.CaptureFixture[str]) -> None:  # noqa: F811
    rig.switch_on()
    assert main(["quiet", "ms=100"]) == 0
    rig.heard.clear()
    rig.listen(0.08)
    assert not rig.heard
    capsys.readouterr()
    rig.listen(0.1)
    rig.cycle()
    rig.until(lambda: bool(rig.heard), 2.0, "an answer")


def test_what_is_no_fault_is_refused_in_words(rig: Rig, capsys: pytest.CaptureFixture[str]) -> None:  # noqa: F811
    cases = {
        ("explode",): (1, "'explode' is not a command; known:"),
        ("drop", "way=sideways"): (1, "way: 'sideways'"),
        ("delay", "ms=0"): (1, "expected more than 0"),
        ("drop", "count=0"): (1, "count: 0; expected a whole number 1..1000000"),
        ("drop", "count"): (2, "KEY=VALUE"),
        ("--emulator", "other", "state"): (3, "active: rig"),
    }
    for arguments, (code, words) in cases.items():
        assert main(list(arguments)) == code, arguments
        assert words in capsys.readouterr().err, arguments
