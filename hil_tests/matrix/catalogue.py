"""The rows of docs/requirements/*.csv and the marks that point at them."""

import csv
import functools
import importlib
import inspect
import pathlib
import types
from collections.abc import Iterator
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
REQUIREMENTS = ROOT / "docs" / "requirements"
OURS = ("gateway", "drivers", "protocols", "motion")
MOST_IDS = 3


class MarkError(ValueError):
    """A requirement mark that cannot be counted; the message names the fault."""


@dataclass(frozen=True, slots=True)
class Row:
    """One demand of a manual."""

    identifier: str
    source: str  # list it stands in: rho3, robotstar, val3
    feature: str


@dataclass(frozen=True, slots=True)
class Claim:
    """Content of a mark: these rows, proved through these functions."""

    ids: tuple[str, ...]
    by: tuple[str, ...]


@functools.cache
def rows() -> dict[str, Row]:
    return {row.identifier: row for path in sorted(REQUIREMENTS.glob("*.csv")) for row in _rows(path)}


def _rows(path: pathlib.Path) -> Iterator[Row]:
    with path.open(newline="", encoding="utf-8") as file:
        for line in csv.DictReader(file):
            yield Row(line["id"], path.stem.removesuffix("_features"), line["feature"])


def claim(args: tuple[object, ...], kwargs: dict[str, object]) -> Claim:
    """The claim of one mark, checked.  Raises MarkError."""
    by = kwargs.get("by")
    functions = (by,) if isinstance(by, str) else tuple(by) if isinstance(by, (tuple, list)) else ()
    if not functions or set(kwargs) != {"by"}:
        raise MarkError('a requirement mark has ids and by="module:function", nothing else')
    if not 1 <= len(args) <= MOST_IDS:
        raise MarkError(f"a requirement mark names 1..{MOST_IDS} ids, this one {len(args)}")
    unknown = [name for name in args if name not in rows()]
    if unknown:
        raise MarkError(f"{', '.join(map(str, unknown))}: no row of docs/requirements has this id")
    for name in functions:
        resolve(str(name))
    return Claim(tuple(map(str, args)), tuple(map(str, functions)))


def resolve(name: str) -> types.FunctionType:
    """Return the plain function of "module:qualname", without its wrappers.  Raises MarkError."""
    module_name, _, qualname = name.partition(":")
    if module_name.partition(".")[0] not in OURS or not qualname:
        raise MarkError(f"by={name!r}: module:function of {', '.join(OURS)} expected")
    try:
        found: object = importlib.import_module(module_name)
        for part in qualname.split("."):
            found = inspect.getattr_static(found, part)
    except (ImportError, AttributeError) as error:
        raise MarkError(f"by={name!r}: {error}") from error
    return plain(found, name)


def plain(found: object, name: str) -> types.FunctionType:
    for _ in range(8):
        if isinstance(found, types.FunctionType) and not hasattr(found, "__wrapped__"):
            return found
        if isinstance(found, property):
            found = found.fget
        elif isinstance(found, (staticmethod, classmethod)):
            found = found.__func__
        else:
            found = getattr(found, "func", None) or getattr(found, "__wrapped__", None)
    raise MarkError(f"by={name!r}: is not a function of Python")
