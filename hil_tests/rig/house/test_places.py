"""Every module has one place in a whole run; a name that is none would leave its module in the quiet half, unnoticed."""

import pathlib
from collections.abc import Iterator

import pytest

from hil_tests.test_folders import BESIDE, COMMANDS, OWN_TIME, of_one, unhurried

RIG = pathlib.Path(__file__).resolve().parents[1]


def modules(place: str) -> Iterator[pathlib.Path]:
    found = RIG / place
    yield from [found] if found.is_file() else found.glob("test_*.py")


def test_every_place_holds_tests_and_no_module_has_two() -> None:
    named = [module for places in (OWN_TIME, COMMANDS, BESIDE) for place in places for module in (list(modules(place)) or [RIG / place])]
    assert [str(module) for module in named if not module.is_file()] == []
    assert sorted(module for module in set(named) if named.count(module) > 1) == []


def test_a_place_is_a_folder_or_one_of_its_modules(request: pytest.FixtureRequest) -> None:
    assert of_one(request.node, ["house"]) and of_one(request.node, ["house/test_places.py"])
    assert not of_one(request.node, ["hous", "house/test_place", "test_places.py", "rig"])
    assert unhurried(request.node)
