"""Common base of the registry's tables."""

from collections.abc import Mapping
from typing import Protocol, TypeVar


class Row(Protocol):
    """Every row has a name."""

    @property
    def name(self) -> str: ...


R = TypeVar("R", bound=Row)


def table(*rows: R) -> Mapping[str, R]:
    """Rows by their names."""
    return {row.name: row for row in rows}
