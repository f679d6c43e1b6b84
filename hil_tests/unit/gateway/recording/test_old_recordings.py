"""A recording outlives the layout of the program: the types in it are named by stable ids, never by where their module is today."""

import importlib
import inspect
import json
import pathlib

import pytest

from gateway.commands.replay import main as replay
from gateway.pure.cycle.belts import CoreBelts
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.cycle.lane import Lane
from gateway.recording import kinds
from gateway.recording.kinds import id_of, location_of
from gateway.recording.renamed import renamed, renamings

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


def test_attributes_that_moved_into_a_part_of_their_class_are_carried_into_it() -> None:
    core = {"state": {"list": [], "number": 1}, "_homings": {"same": 1}, "_override": 0.25, "_reset": False}
    tree = renamed({"object": id_of(CycleLogic), "has": core, "number": 7})
    lane = {"homings": {"same": 1}, "override": 0.25}
    assert tree["has"]["_reset"] is False and "_override" not in tree["has"]
    assert tree["has"]["lanes"]["list"] == [{"object": id_of(Lane), "has": lane, "number": 8}]
    assert renamed(tree) == tree, "a recording of today is left as it is"


def test_attributes_with_another_name_are_carried_over_wherever_their_object_is() -> None:
    belts = {"_stood": {"dict": [], "number": 2}, "_told": {"list": [True], "number": 3}, "_silent": 0}
    tree = renamed([{"object": id_of(Lane), "has": {"belts": {"object": id_of(CoreBelts), "has": belts, "number": 1}}, "number": 0}])
    has = tree[0]["has"]["belts"]["has"]
    assert has == {"_kept": {"dict": [], "number": 2}, "_restored": {"list": [True], "number": 3}, "_silent": 0}


def test_each_renaming_leads_to_an_attribute_that_its_class_has() -> None:
    for row in renamings():
        module, name = location_of(row.of)
        source = inspect.getsource(getattr(importlib.import_module(module), name))
        assert all(each in source and before not in source for before, each in row.attributes.items()), row
