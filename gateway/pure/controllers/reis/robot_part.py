"""What a Reis control keeps for the robot's programs, whether it has any: keys of the pendant, messages.  Pure.

The programs themselves need the kinematics of the robot; only cells that have some load them.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from gateway.pure.image.error_list import ErrorList
from protocols.base.machine import Ns

if TYPE_CHECKING:
    from gateway.pure.controllers.reis.programs import ReisPrograms

KEYS = ("start", "stop", "f1", "f2", "exec", "quit")
REIS = "reis"  # whose numbers they are, in the list of errors


@dataclass(slots=True)
class Keys:
    """Of the pendant, as levels; a command source, a wire or a tool presses them."""

    test: int = 0  # operating mode while it is not AUTO: 0 HAND, 1..6 Test
    middle: bool = False  # the key selector is at Cal/Sync: START is held while the robot moves (L1214)
    levels: dict[str, bool] = field(default_factory=lambda: dict.fromkeys(KEYS, False))
    before: dict[str, bool] = field(default_factory=lambda: dict.fromkeys(KEYS, False))

    def edges(self) -> dict[str, bool]:
        """Keys that were pressed (True) or released since the last call."""
        found = {key: level for key, level in self.levels.items() if level is not self.before[key]}
        self.before = dict(self.levels)
        return found

    def put(self, name: str, value: float) -> None:
        """mode, selector or key.NAME; KeyError, ValueError."""
        if name == "mode":
            if value not in range(7):
                raise ValueError(f"reis.mode {value:g}: 0 HAND, 1..6 Test")
            self.test = int(value)
        elif name == "selector":
            self.middle = bool(value)
        else:
            key = name.removeprefix("key.")
            if key not in self.levels:
                raise KeyError(name)
            self.levels[key] = bool(value)

    def value(self, name: str) -> float:
        """The same, read; KeyError."""
        if name in ("mode", "selector"):
            return float(self.test if name == "mode" else self.middle)
        return float(self.levels[name.removeprefix("key.")])

    @staticmethod
    def names() -> list[str]:
        """Behind `reis.`."""
        return ["mode", "selector", *(f"key.{key}" for key in KEYS)]


@dataclass(slots=True)
class RobotPart:
    """What a control keeps for the robot's programs.  programs: of the interpreter, where the cell has a memory; shown: messages that are
    not acknowledged, number and text."""

    keys: Keys = field(default_factory=Keys)
    programs: "ReisPrograms | None" = None
    errors: ErrorList | None = None
    shown: list[tuple[int, str]] = field(default_factory=list)
    acknowledged: bool = True  # level of RC input 62; one at start is no edge

    def report(self, number: int, words: str, now: Ns) -> None:
        """An error of a program."""
        self.shown.append((number, words))
        if self.errors is not None:
            self.errors.report(number, words, now, source=REIS)

    def clear(self) -> None:
        """They are acknowledged."""
        for number, words in self.shown:
            if self.errors is not None:
                self.errors.drop(number, words, REIS)
        self.shown.clear()
