"""Attributes of recorded classes that have another name or place today, so that old recordings still replay.

`Moved`: attributes that belong to a part of the class today, which is an attribute of it or the only one in a list of it.  `Renamed`:
another name in the class.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

from gateway.recording.kinds import id_of

GONE = ""


@dataclass(frozen=True, slots=True)
class Moved:
    """`attributes`: name when it was recorded -> name in the part."""

    of: str  # ids, as in gateway.recording.kinds
    into: str
    under: str  # attribute of the class: the part, or the list with the part
    attributes: dict[str, str]
    listed: bool = False


@dataclass(frozen=True, slots=True)
class Renamed:
    """`attributes`: name in the recording -> present name, GONE: it has none any more."""

    of: str
    attributes: dict[str, str]


def moved() -> tuple[Moved, ...]:
    """All rows of parts."""
    from drivers.drives.cia402 import Cia402Drive, ReferenceRun
    from drivers.drives.demand_edges import DemandEdges
    from drivers.drives.held import HeldPosition
    from drivers.drives.servodyn import Drive
    from gateway.pure.cycle.alter import CoreAlter, Correction
    from gateway.pure.cycle.belt_encoders import BeltEncoders
    from gateway.pure.cycle.belt_parts import BeltRide, BeltRobots, BeltWay
    from gateway.pure.cycle.belts import CoreBelts
    from gateway.pure.cycle.core import CycleLogic
    from gateway.pure.cycle.core_watch import DriveWatch, Permissions, ServicesWatch
    from gateway.pure.cycle.lane import Lane
    from motion.execution.chain import Tail, TimedChain
    from motion.execution.follower import Follower, _Place
    from motion.execution.piece_run import PieceRun
    from motion.execution.stepper import Stepper
    from motion.timing.foresight import Foresight, Horizon

    own = {"_homings": "homings", "_mover": "mover", "_override": "override", "_ramp": "ramp"}
    inputs = {"_enabling_inputs": "inputs", "_permits": "permits", "_settled": "chain_seen", "_lost_cycles": "lost_cycles"}
    drives = {"_drive_axes": "drive", "_watch_axes": "watch", "_settled_axes": "settled", "_eventful": "eventful"}
    ahead = {"_ramp": "ramp", "_probe": "probe", "_dt": "apart", "_places": "places", "_used": "used", "_half": "half"}
    plan = {name: name for name in ("_profile", "_motion", "_time", "_goal", "_speed", "_slow")}
    kept = {"_kept": "_kept", "_stood": "_kept", "_restored": "_restored", "_told": "_restored", "_zeros": "_zeros"}
    spoken = {"counts": "counts", "heard": "heard", "_encoders": "_present", "_silent": "silent"}
    ride = {"_bearing": "bearing", "_carried": "carried", "_rig": "rig", "_waited": "waited", "_reference": "reference"}
    edges = {"_asked": "asked", "_on_before": "on_before", "_reset_before": "reset_before", "_reset_left": "reset_left"}
    sent = {"_following": "fresh", "_refused": "refused", "set_inc": "inc"}
    asked = {"_home_before": "demand_before", "_home_asked": "asked", "_home_cycles": "cycles"}
    run = {**asked, "_homing": "outcome", "_homed": "attained", "_mode": "mode"}
    place = {"_index": "index", "_interval": "interval", "_held": "held"}
    return (
        Moved(id_of(CycleLogic), id_of(Lane), "lanes", own, listed=True),
        Moved(id_of(CycleLogic), id_of(Permissions), "_permissions", inputs),
        Moved(id_of(CycleLogic), id_of(ServicesWatch), "_services", {"_finish": "finish", "_services_alive": "alive"}),
        Moved(id_of(CycleLogic), id_of(DriveWatch), "_drives", drives),
        Moved(id_of(Drive), id_of(DemandEdges), "_edges", edges),
        Moved(id_of(Drive), id_of(HeldPosition), "_held", sent),
        Moved(id_of(Cia402Drive), id_of(DemandEdges), "_edges", edges),
        Moved(id_of(Cia402Drive), id_of(ReferenceRun), "_run", run),
        Moved(id_of(CoreAlter), id_of(Correction), "_source", {"_alive": "fresh", "_answer": "answer"}),
        Moved(id_of(CoreBelts), id_of(BeltEncoders), "encoders", {**spoken, **kept}),
        Moved(id_of(CoreBelts), id_of(BeltRobots), "_robot", {"_robots": "numbered", "_limits": "limits", "_kinematics": "now"}),
        Moved(id_of(CoreBelts), id_of(BeltRide), "_ride", ride),
        Moved(id_of(CoreBelts), id_of(BeltWay), "_way", {"_part": "part", "_rotation": "rotation"}),
        Moved(id_of(Stepper), id_of(PieceRun), "_run", {"_piece": "piece", "_own": "_tables", "_stale": "stale", **plan}),
        Moved(id_of(Follower), id_of(TimedChain), "_chain", {"_pieces": "pieces", "_begins": "begins", "_end": "end"}),
        Moved(id_of(Follower), id_of(Tail), "_tail", {"_pending": "pieces", "_rows": "rows", "_next": "next"}),
        Moved(id_of(Follower), id_of(_Place), "_at", place),
        Moved(id_of(Foresight), id_of(Horizon), "horizon", {**ahead, "most_u": "most_u", "most_c": "most_c"}),
    )


def renamings() -> tuple[Renamed, ...]:
    """All rows of names."""
    from drivers.drives.cia402 import Cia402Drive
    from drivers.drives.held import HeldPosition
    from drivers.drives.servodyn import Drive
    from drivers.drives.tracking import Tracking
    from gateway.pure.controllers.rho3.can.family import RhoFamily
    from gateway.pure.cycle.alter import CoreAlter
    from gateway.pure.cycle.alter_mover import AlterBeltMover, AlterMover
    from gateway.pure.cycle.belt_mover import BeltMover
    from gateway.pure.cycle.belts import CoreBelts
    from gateway.pure.cycle.inputs import Armed
    from gateway.pure.cycle.mover import Mover

    movers = (Mover, BeltMover, AlterMover, AlterBeltMover)
    return (
        Renamed(id_of(Drive), {"power": GONE, "saturated": GONE, "configured": GONE}),
        Renamed(id_of(Cia402Drive), {"torque_permille": GONE, "warning": GONE}),
        Renamed(id_of(HeldPosition), {"_fresh": "fresh", "_refused": "refused", "_jump": "jump", "_step": "step"}),
        Renamed(id_of(Tracking), {"_standing": "_standstill"}),
        Renamed(id_of(RhoFamily), {"_told": "_reported"}),
        Renamed(id_of(CoreBelts), {"_arm": GONE}),
        Renamed(id_of(Armed), {"told": "reported"}),
        Renamed(id_of(CoreAlter), {"_arm": GONE}),
        *(Renamed(id_of(each), {"_period": GONE, "_foresight": GONE}) for each in movers),
    )


def renamed(tree: Any) -> Any:
    """The tree of a recorded state with its attributes where they are today.  Changed in place."""
    rows: dict[str, list[Moved]] = {}
    for row in moved():
        rows.setdefault(row.of, []).append(row)
    _move(rows, tree, count(_free(tree)))
    _rename({row.of: row.attributes for row in renamings()}, tree)
    return tree


def _rename(names: dict[str, dict[str, str]], tree: Any) -> None:
    if isinstance(tree, list):
        for each in tree:
            _rename(names, each)
    elif isinstance(tree, dict):
        kind = tree.get("object")
        if kind in names:
            tree["has"] = {now: value for name, value in tree["has"].items() if (now := names[kind].get(name, name)) != GONE}
        for each in tree.values():
            _rename(names, each)


def _move(rows: Mapping[str, Sequence[Moved]], tree: Any, numbers: Iterator[int]) -> None:
    if isinstance(tree, list):
        for each in tree:
            _move(rows, each, numbers)
    elif isinstance(tree, dict):
        for row in rows.get(tree.get("object", ""), ()):
            if any(name in tree["has"] for name in row.attributes) and not (row.listed and row.under in tree["has"]):
                tree["has"] = _with_part(row, tree["has"], numbers)
        for each in tree.values():
            _move(rows, each, numbers)


def _with_part(row: Moved, attributes: Mapping[str, Any], numbers: Iterator[int]) -> dict[str, Any]:
    """A new part is where the first of its attributes was; one that was there already has more of them now."""
    there = attributes.get(row.under, {}).get("has")
    has, part = dict[str, Any](), dict[str, Any]() if there is None else there
    for name, value in attributes.items():
        if name not in row.attributes:
            has[name] = value
            continue
        if row.under not in attributes and row.under not in has:
            made = {"object": row.into, "has": part, "number": next(numbers)}
            has[row.under] = {"list": [made], "number": next(numbers)} if row.listed else made
        part[row.attributes[name]] = value
    return has


def _free(tree: Any) -> int:
    """The first number that no part of the tree has."""
    if isinstance(tree, dict):
        own = tree["number"] + 1 if isinstance(tree.get("number"), int) else 0
        return max([own, *(_free(each) for each in tree.values())])
    return max((_free(each) for each in tree), default=0) if isinstance(tree, list) else 0
