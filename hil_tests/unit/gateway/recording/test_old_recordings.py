"""A recording outlives the layout of the program: the types in it are named by stable ids, never by where their module is today."""

import importlib
import inspect
import json
import pathlib

import pytest

from drivers.drives.servodyn import Drive
from drivers.drives.tracking import Tracking
from gateway.commands.replay import main as replay
from gateway.pure.cycle.alter import CoreAlter, Correction
from gateway.pure.cycle.belts import CoreBelts
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.cycle.lane import Lane
from gateway.recording import kinds
from gateway.recording.kinds import id_of, location_of
from gateway.recording.renamed import GONE, moved, renamed, renamings
from motion.execution.stepper import Stepper
from motion.timing.foresight import Foresight, Horizon

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


def test_attributes_that_moved_into_a_part_which_is_no_list_are_carried_into_it_wherever_their_class_is() -> None:
    has = {"begun": False, "_dt": 0.002, "room": 0.5, "most_u": 4.0}
    tree = renamed([{"object": id_of(Stepper), "has": {"_ahead": {"object": id_of(Foresight), "has": has, "number": 1}}, "number": 0}])
    horizon = {"object": id_of(Horizon), "has": {"apart": 0.002, "most_u": 4.0}, "number": 2}
    assert tree[0]["has"]["_ahead"]["has"] == {"begun": False, "horizon": horizon, "room": 0.5}
    assert renamed(tree) == tree


def test_a_part_that_was_there_gets_attributes_of_its_class_and_what_is_gone_is_left_out() -> None:
    source = {"object": id_of(Correction), "has": {"_life": 3}, "number": 1}
    tree = renamed(
        {"object": id_of(CoreAlter), "has": {"_source": source, "_arm": 6, "_alive": True, "_answer": -1, "on": True}, "number": 0}
    )
    assert tree["has"] == {"_source": {**source, "has": {"_life": 3, "fresh": True, "answer": -1}}, "on": True}


def test_attributes_with_another_name_are_carried_over_wherever_their_object_is() -> None:
    tracking = {"object": id_of(Tracking), "has": {"_standing": 7, "lag": 0.5}, "number": 1}
    tree = renamed([{"object": id_of(Lane), "has": {"axis": tracking}, "number": 0}])
    assert tree[0]["has"]["axis"]["has"] == {"_standstill": 7, "lag": 0.5}


def test_a_drive_recorded_with_all_in_one_has_its_demand_and_its_position_in_parts() -> None:
    has = {"_asked": True, "_reset_left": 3, "_phase": 5, "_following": False, "set_inc": 700, "power": 2, "configured": True}
    tree = renamed({"object": id_of(Drive), "has": has, "number": 0})["has"]
    assert {name: part["has"] if isinstance(part, dict) else part for name, part in tree.items()} == {
        "_edges": {"asked": True, "reset_left": 3},
        "_phase": 5,
        "_held": {"fresh": False, "inc": 700},
    }


def test_belts_that_were_recorded_under_their_first_names_have_them_in_their_encoders() -> None:
    belts = {"_stood": {"dict": [], "number": 2}, "_told": {"list": [True], "number": 3}, "_silent": 0}
    tree = renamed({"object": id_of(CoreBelts), "has": belts, "number": 1})
    has = tree["has"]["encoders"]["has"]
    assert has == {"_kept": {"dict": [], "number": 2}, "_restored": {"list": [True], "number": 3}, "silent": 0}


def test_each_move_leads_to_an_attribute_of_a_part_that_its_class_has() -> None:
    for row in moved():
        whole, part = (inspect.getsource(class_of(each)) for each in (row.of, row.into))
        assert row.under in whole and all(each in part for each in row.attributes.values()), row


def test_each_renaming_leads_to_an_attribute_that_its_class_has() -> None:
    for row in renamings():
        source = inspect.getsource(class_of(row.of))
        gone = {before for before, each in row.attributes.items() if each == GONE}
        assert all(each in source and before not in source for before, each in row.attributes.items() if before not in gone), row
        assert not any(f"self.{before} = " in source or f'"{before}"' in source for before in gone), "a property at most"


def class_of(stable_id: str) -> type:
    module, name = location_of(stable_id)
    found = getattr(importlib.import_module(module), name)
    assert isinstance(found, type)
    return found
