"""The pages that follow a telegram and a move through the program name functions that exist."""

import importlib
import re

import pytest

from hil_tests.unit.house.test_rooms import ROOT

NAMED = re.compile(r"`((?:gateway|drivers|motion|protocols)(?:\.\w+)+)(?::([\w.]+))?`")
PAGES = ("life-of-a-telegram.md", "life-of-a-move.md")


def named(page: str) -> list[tuple[str, str]]:
    return NAMED.findall((ROOT / "docs" / page).read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", PAGES)
def test_every_function_a_life_page_names_exists(page: str) -> None:
    found = named(page)
    assert len(found) >= 8
    missing = []
    for module, path in found:
        thing: object = importlib.import_module(module)
        for part in filter(None, path.split(".")):
            thing = getattr(thing, part, None)
        if thing is None:
            missing.append(f"{module}:{path}")
    assert missing == []
