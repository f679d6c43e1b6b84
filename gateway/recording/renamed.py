"""Attributes of recorded classes that have another name or place today, so that old recordings still replay.

`Moved`: attributes that belong to a part of the class today, which the class has in a list of one.  `Renamed`: another name in the class.
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


@dataclass(frozen=True, slots=True)
class Renamed:
    """`attributes`: name when it was recorded -> name today."""

    of: str
    attributes: dict[str, str]


def moved() -> tuple[Moved, ...]:
    """All rows of parts."""
    from gateway.pure.cycle.core import CycleLogic
    from gateway.pure.cycle.lane import Lane

    own = {"_homings": "homings", "_mover": "mover", "_override": "override", "_ramp": "ramp"}
    return (Moved(id_of(CycleLogic), id_of(Lane), "lanes", own),)


def renamings() -> tuple[Renamed, ...]:
    """All rows of names."""
    from drivers.drives.tracking import Tracking
    from gateway.pure.controllers.rho3.can.family import RhoFamily
    from gateway.pure.cycle.belts import CoreBelts
    from gateway.pure.cycle.inputs import Armed

    return (
        Renamed(id_of(Tracking), {"_standing": "_standstill"}),
        Renamed(id_of(RhoFamily), {"_told": "_reported"}),
        Renamed(id_of(CoreBelts), {"_stood": "_kept", "_told": "_restored"}),
        Renamed(id_of(Armed), {"told": "reported"}),
    )


def renamed(tree: Any) -> Any:
    """The tree of a recorded state with its attributes where they are today.  Changed in place."""
    for row in moved():
        _apply(row, tree)
    _rename({row.of: row.attributes for row in renamings()}, tree)
    return tree


def _rename(names: dict[str, dict[str, str]], tree: Any) -> None:
    if isinstance(tree, list):
        for each in tree:
            _rename(names, each)
    elif isinstance(tree, dict):
        kind = tree.get("object")
        if kind in names:
            tree["has"] = {names[kind].get(name, name): value for name, value in tree["has"].items()}
        for each in tree.values():
            _rename(names, each)


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
