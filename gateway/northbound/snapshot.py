"""Values published northbound, by name: plain values out of the regions.  Cycle and services are not queried."""

from typing import Any

from gateway.observer.regions import Regions
from gateway.pure.image.records.cell import AxisFlag, Motion

Value = bool | int | float | str
FLAGS = {"enabled": AxisFlag.ENABLED, "fault": AxisFlag.FAULT, "lost": AxisFlag.LOST, "referenced": AxisFlag.REFERENCED}


def values(regions: Regions) -> dict[str, Value]:
    """Every value by its name, as `axisgate var` calls them where both know it."""
    head, found = regions.head(), dict[str, Value]()
    for name in ("ready", "emergency", "cycle_alive", "services_alive"):
        found[f"cell.{name}"] = bool(head[name])
    found["cell.motion"] = Motion(head["motion"]).name if head["cycle_alive"] else "UNKNOWN"
    found["cell.owner"], found["cell.forced"] = int(head["owner"]), int(head["forced"])
    found["cell.override"] = float(head["override"])
    errors = [error for error in head["errors"] if isinstance(error, dict)]
    found["cell.error"] = bool(errors)
    found["error.first.code"] = int(errors[0].get("code", 0)) if errors else 0
    found["error.first.text"] = str(errors[0].get("text", "")) if errors else ""
    for axis in regions.drives():
        for name in ("actual", "set", "lag", "torque"):
            found[f"axis.{axis['name']}.{name}"] = float(axis[name])
        for name, flag in FLAGS.items():
            found[f"axis.{axis['name']}.{name}"] = bool(axis["flags"] & flag)
    for source in sources(regions):
        found[f"command_source.{source['name']}.alive"] = bool(source.get("alive"))
    return found


def sources(regions: Regions) -> list[dict[str, Any]]:
    """Status of every command source, as last reported by the services."""
    listed = regions.status.get("command_sources", [])
    return [source for source in listed if isinstance(source, dict) and "name" in source] if isinstance(listed, list) else []
