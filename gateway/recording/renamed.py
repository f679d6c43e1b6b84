"""Attributes that a recorded class no longer has by itself: where they are today, so that old recordings still replay.

A row names attributes of a class that belong to a part of it today: the class has it in a list of one.
"""

from dataclasses import dataclass
from typing import Any

from gateway.recording.kinds import id_of


@dataclass(frozen=True, slots=True)
class Moved:
    """`attributes`: name when it was recorded -> name in the part."""

    of: str  # ids, as in gateway.recording.kinds
    into: str
    under: str  # attribute of the class: the list with the part
    attributes: dict[str, str]


def moved() -> tuple[Moved, ...]:
    """All rows."""
    from gateway.pure.cycle.core import CycleLogic
    from gateway.pure.cycle.lane import Lane

    own = {"_homings": "homings", "_mover": "mover", "_override": "override", "_ramp": "ramp"}
    return (Moved(id_of(CycleLogic), id_of(Lane), "lanes", own),)


def renamed(tree: Any) -> Any:
    """The tree of a recorded state with its attributes where they are today.  Changed in place."""
    for row in moved():
        _apply(row, tree)
    return tree


def _apply(row: Moved, tree: Any) -> None:
    if not isinstance(tree, dict) or tree.get("object") != row.of or row.under in tree["has"]:
        return
    has, part, under = dict[str, Any](), dict[str, Any](), [_free(tree), _free(tree) + 1]
    for name, value in tree["has"].items():
        if name not in row.attributes:
            has[name] = value
            continue
        has.setdefault(row.under, {"list": [{"object": row.into, "has": part, "number": under[0]}], "number": under[1]})
        part[row.attributes[name]] = value
    tree["has"] = has


def _free(tree: Any) -> int:
    """The first number that no part of the tree has."""
    if isinstance(tree, dict):
        own = tree["number"] + 1 if isinstance(tree.get("number"), int) else 0
        return max([own, *(_free(each) for each in tree.values())])
    return max((_free(each) for each in tree), default=0) if isinstance(tree, list) else 0
