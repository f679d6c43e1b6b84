"""The catalogue of errors: configs/errors/*.toml, one file for each number space.  Log, page, commands and docs/errors.md read their
words from here; a house test compares it with the texts of the pure parts (AX-422).
"""

import functools
import tomllib
from collections.abc import Mapping

from gateway.files.find import PACKAGED, read_text
from gateway.pure.image.error_entries import Entry, Family, family_of, find

FOLDER = PACKAGED / "errors"
ORDER = ("axisgate", "rho3", "reis", "val3", "servodyn", "cia402", "rk512", "3964r")


@functools.cache
def family(name: str) -> Family:
    """One number space.  KeyError: no such file."""
    path = FOLDER / f"{name}.toml"
    if not path.is_file():
        raise KeyError(f"family of errors {name!r}; there are {', '.join(names())}")
    return family_of(tomllib.loads(read_text(path)))


def names() -> list[str]:
    """All number spaces, axisgate's first."""
    return sorted((path.stem for path in FOLDER.glob("*.toml")), key=lambda name: (_rank(name), name))


def catalogue() -> Mapping[str, Family]:
    """All of them."""
    return {name: family(name) for name in names()}


def lookup(name: str, number: int) -> Entry | None:
    """Entry of the catalogue; None for a number or a family it does not have."""
    return family(name).entries.get(number) if name in names() else None


def explain(key: str) -> list[Entry]:
    """Meaning of `647`, `reis 647`, `rk512 14h`, `system error 133` or words of a text."""
    return find(catalogue().values(), key)


def _rank(name: str) -> int:
    return next((rank for rank, first in enumerate(ORDER) if name == first or name.startswith(first + "-")), len(ORDER))
