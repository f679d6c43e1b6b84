"""Without the judges the other tests run, and a line says what was left out; a URDF says what it needs."""

import pathlib
import sys
from types import SimpleNamespace
from typing import cast

import pytest

from hil_tests import judges
from hil_tests.judges import ROOT, LeftOut, needs
from motion.errors import MotionError
from motion.robot import Robot, UrdfGeometry, _geometric


def test_a_module_needs_what_it_imports_and_what_its_lab_imports() -> None:
    assert {"eaik", "py_opw_kinematics", "pinocchio"} <= needs(ROOT / "hil_tests/unit/motion/kinematics/test_judges.py")
    assert "playwright" in needs(ROOT / "hil_tests/rig/web/test_page.py")
    assert needs(ROOT / "hil_tests/unit/gateway/recording/test_recorded_cycles.py") == frozenset()


def test_what_cannot_be_loaded_is_left_out_and_named(monkeypatch: pytest.MonkeyPatch) -> None:
    out = LeftOut()
    monkeypatch.setattr(judges, "absent", frozenset)
    page = ROOT / "hil_tests/rig/web/test_page.py"
    assert not out.ignored(page) and out.line() == ""
    monkeypatch.setattr(judges, "absent", lambda: frozenset(("playwright", "eaik")))
    assert out.ignored(page) and not out.ignored(ROOT / "hil_tests/unit/gateway/recording/test_recorded_cycles.py")
    assert not out.ignored(ROOT / "hil_tests/lab/running/web_running.py"), "not a module of tests"
    assert out.line() == "lane judges: 1 modules not collected (playwright not installed: make judges)"


def test_a_urdf_without_pinocchio_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    monkeypatch.delitem(sys.modules, "motion.kinematics.urdf", raising=False)
    robot = cast(Robot, SimpleNamespace(geometry=UrdfGeometry("<robot/>", "flange"), own=()))
    with pytest.raises(MotionError, match=r"needs pinocchio.*install .axisgate.urdf"):
        _geometric(robot)


def test_what_make_setup_installs_holds_no_judge() -> None:
    small = (ROOT / "requirements.lock").read_text().lower()
    assert not [name for name in ("pin==", "cmeel", "playwright", "scipy", "pandas", "matplotlib") if f"\n{name}" in small]
    assert pathlib.Path(ROOT / "hil_tests/requirements.lock").read_text().count("==") > 50
