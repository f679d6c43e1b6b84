"""Stable ids of the types that a recording stores.  A type keeps its id when its module or its class gets another name.

An id is "module:Class" as it was when the type was first recorded.  A module that moves gets a row here, so that old recordings
still replay.
"""

from collections.abc import Mapping

MODULES: Mapping[str, str] = {}  # module in the id -> module today
CLASSES: Mapping[str, str] = {}  # id -> "module:Class" today, for classes renamed or moved out of their module

_HOMES = {now: home for home, now in MODULES.items()}
_IDS = {now: kind for kind, now in CLASSES.items()}


def id_of(kind: type) -> str:
    """The stable id of a type."""
    now = f"{kind.__module__}:{kind.__qualname__}"
    return _IDS.get(now) or f"{_HOMES.get(kind.__module__, kind.__module__)}:{kind.__qualname__}"


def location_of(stable_id: str) -> tuple[str, str]:
    """Module and class, today, of a stable id."""
    module, _, path = CLASSES.get(stable_id, stable_id).partition(":")
    return (module if stable_id in CLASSES else MODULES.get(module, module)), path
