"""The hand-held unit of an old controller as described by the services: size, keys by name, and their keyboard keys."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

ARROWS = {"UP": "↑", "DOWN": "↓", "LEFT": "←", "RIGHT": "→"}
NARROW, WIDE = 5, 10  # columns of a key on the screen


@dataclass(frozen=True, slots=True)
class Unit:
    """As gateway.pure.controllers.unit has it."""

    title: str = ""
    columns: int = 20
    lines: int = 4
    keypad: tuple[tuple[str, ...], ...] = ()
    typed: Mapping[str, str] = field(default_factory=dict)
    names: frozenset[str] = frozenset()
    held: frozenset[str] = frozenset()
    faces: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, facts: Mapping[str, Any]) -> "Unit":
        """From the `unit` of an answer."""
        keypad = tuple(tuple(row) for row in facts["keypad"])
        names = frozenset(name for row in keypad for name in row if name) | frozenset(facts["more"])
        rest = facts["typed"], names, frozenset(facts["held"]), facts["faces"]
        return cls(facts["title"], facts["columns"], facts["lines"], keypad, *rest)

    @property
    def across(self) -> int:
        """Keys in a row."""
        return max((len(row) for row in self.keypad), default=1)

    @property
    def key_columns(self) -> int:
        """Columns of a key on the screen."""
        return WIDE if self.across <= NARROW else NARROW + 3


def key_of(typed: str, character: str | None, unit: Unit) -> str | None:
    """The unit's key for one of the keyboard; None: no key of the unit."""
    if typed in unit.typed:
        return unit.typed[typed]
    name = (character or "").upper()
    return name if name in unit.names else None


def keys_of(words: str, unit: Unit) -> list[str]:
    """`MODE 7.3.2 ENTER`: names and characters in the order pressed.  ValueError names what is not a key."""
    keys: list[str] = []
    for word in words.upper().split():
        parts = [word] if word in unit.names else list(word)
        wrong = [part for part in parts if part not in unit.names]
        if wrong:
            shown = ", ".join(name for row in unit.keypad for name in row if name)
            raise ValueError(f"{wrong[0]!r} in {word!r} is not a key; keys are {shown} and letters")
        keys += parts
    return keys
