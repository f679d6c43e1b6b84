"""A recording outlives the layout of the program: the types in it are named by stable ids, never by where their module is today."""

import json
import pathlib

import pytest

from gateway.commands.replay import main as replay
from gateway.pure.cycle.core import CycleLogic
from gateway.recording import kinds
from gateway.recording.kinds import id_of, location_of

OLD = pathlib.Path(__file__).resolve().parents[3] / "vectors" / "recordings" / "demo.axrec"  # 2026-11-23, the demo cell, PTP there and back


def test_a_recording_made_before_modules_moved_replays_bit_for_bit(capsys: pytest.CaptureFixture[str]) -> None:
    code = replay([str(OLD), "--diff", "--json"])
    said = json.loads(capsys.readouterr().out)
    assert (code, said["cycles"]) == (0, 493)


def test_a_type_keeps_its_id_where_its_module_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kinds, "MODULES", {"gateway.pure.before": "gateway.pure.now"})
    monkeypatch.setattr(kinds, "CLASSES", {"gateway.pure.before:Old": "gateway.pure.other:New"})
    assert location_of("gateway.pure.before:Same") == ("gateway.pure.now", "Same")
    assert location_of("gateway.pure.before:Old") == ("gateway.pure.other", "New")


def test_id_and_location_of_a_recorded_type_are_inverse() -> None:
    assert location_of(id_of(CycleLogic)) == (CycleLogic.__module__, CycleLogic.__qualname__)
