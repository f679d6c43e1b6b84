"""Finds a key written as people write it (axis.X.limits.min, db.10[DW 2]) in the tables of a file, and its line."""

import re
from collections.abc import Mapping
from typing import Any

from gateway.pure.reports.toml_lines import Path, nearest


def steps_of(key: str) -> list[str]:
    """The parts of a written key; the part in brackets is one part, dots included: db.10[D 0.8] -> db, 10, [D 0.8]."""
    return re.findall(r"\[[^\]]*\]|[^.\[]+", key)


def resolve(raw: Any, key: str) -> Path:
    """The path of as much of the key as exists; elements of lists are found by name, number or place."""
    path: list[str | int] = []
    here = raw
    for part in steps_of(key):
        steps = _locate(here, part)
        if steps is None:
            break
        for each in steps:
            path.append(each)
            here = here[each]
    return tuple(path)


def line_of(raw: Any, places: Mapping[Path, int], key: str) -> int | None:
    """The line of the key, or the closest table around it."""
    return nearest(dict(places), resolve(raw, key))


def written(raw: Any, key: str) -> bool:
    """Does the file itself hold this key?"""
    here = raw
    for part in steps_of(key):
        steps = _locate(here, part)
        if steps is None:
            return False
        for each in steps:
            here = here[each]
    return True


def _locate(here: Any, part: str) -> list[str | int] | None:
    if isinstance(here, dict):
        if part.startswith("[") and isinstance(here.get("entries"), list):
            inner = _locate(here["entries"], part)
            return None if inner is None else ["entries", *inner]
        return [part] if part in here else None
    for index, each in enumerate(here if isinstance(here, list) else ()):
        if part == f"[{index}]":  # telegram.ORDER.fields[2]: counted, where entries have no name
            return [index]
        if isinstance(each, dict) and part.strip("[]") in {str(each[name]) for name in ("name", "number", "at", "axis") if name in each}:
            return [index]
    return None
