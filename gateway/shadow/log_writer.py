"""Writes the findings of a shadow's process to a file in the run's folder, completely or not at all."""

import json
import os
import pathlib
from collections.abc import Mapping


def keep(path: pathlib.Path, found: Mapping[str, object]) -> None:
    """Replaces the present contents."""
    half = path.with_suffix(".half")
    half.write_text(json.dumps(found))
    os.replace(half, path)


def kept(path: pathlib.Path) -> dict[str, object]:
    """Empty where nothing was found yet."""
    try:
        found = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}
