"""A value by its name as people write it: nCount, sPart[2], nGrid[1,2], cPart[key], vPart[2].nCount, mSlow.vel."""

from collections.abc import Mapping

from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.values import Container, Grid, places

NOWHERE = (LookupError, ValueError, AttributeError, TypeError, Rte)  # a path to a value that is not there


def place_of(data: Mapping[str, Container], text: str) -> tuple[object, object]:
    """Container and key of a value.  NOWHERE: there is none."""
    steps = text.replace("]", "").replace("[", ".[").split(".")
    container: object = data[steps[0]]
    place: object = 0
    for step in steps[1:]:
        if step.startswith("["):
            container, place = _element(container, step[1:])
        else:
            value = places(container)[place]
            inner = getattr(value, f"u_{step}", None)
            container, place = (inner, 0) if inner is not None else (value, step)
    if isinstance(container, dict | Grid) and place == 0:
        raise LookupError(text)
    return container, place


def _element(container: object, text: str) -> tuple[object, object]:
    if isinstance(container, Grid):
        return container.flat, container.at(*(float(part) for part in text.split(",")))
    return (container, text.strip('"')) if isinstance(container, dict) else (container, int(text))
