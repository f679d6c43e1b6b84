"""Where programs come from: the user memory of the old controller, seen from the languages."""

from collections.abc import Iterable, Mapping
from typing import Protocol


class ProgramStore(Protocol):
    """Source texts by name; names are compared as the control compares them."""

    def names(self) -> Iterable[str]:
        """All names, sorted."""

    def text(self, name: str) -> str | None:
        """Return the text; None: unknown source."""

    def age(self, name: str) -> int | None:
        """A number that grows with each translation; None: never translated."""


class MemoryStore:
    """A store over texts in memory.  Names are compared without case, as the old controllers do."""

    def __init__(self, texts: Mapping[str, str], translated: Iterable[str] = ()) -> None:
        """`translated`: names in the order of their translation, the oldest first."""
        self._texts = {name.upper(): text for name, text in texts.items()}
        self._ages = {name.upper(): age for age, name in enumerate(translated)}

    def names(self) -> Iterable[str]:
        """All names, sorted."""
        return sorted(self._texts)

    def text(self, name: str) -> str | None:
        """The text of a name in any case."""
        return self._texts.get(name.upper())

    def age(self, name: str) -> int | None:
        """Its place in the order of translation."""
        return self._ages.get(name.upper())
