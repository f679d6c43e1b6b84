"""What a Reis control keeps for the robot's programs, whether it has any: keys of the pendant, messages.  Pure.

The programs themselves need the kinematics of the robot; only cells that have some load them.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from gateway.pure.controllers.reis.keys import Keys
from gateway.pure.image.error_list import ErrorList
from protocols.base.machine import Ns

if TYPE_CHECKING:
    from gateway.pure.controllers.reis.programs import ReisPrograms

REIS = "reis"  # whose numbers they are, in the list of errors


@dataclass(slots=True)
class RobotPart:
    """What a control keeps for the robot's programs.  programs: of the interpreter, where the cell has a memory; shown: messages that are
    not acknowledged, number and text."""

    keys: Keys = field(default_factory=Keys)
    programs: "ReisPrograms | None" = None
    errors: ErrorList | None = None
    shown: list[tuple[int, str]] = field(default_factory=list)
    suppressed: bool = False  # Err Enab (L1359)
    drives_on: bool = True  # all of them; those that are on at start are not switched on
    acknowledged: bool = True  # level of RC input 62; a level at start is not an edge

    def report(self, number: int, words: str, now: Ns) -> None:
        """An error of a program."""
        self.shown.append((number, words))
        if self.errors is not None and not self.suppressed:
            self.errors.report(number, words, now, source=REIS)

    def suppress(self) -> None:
        """Err Enab: messages that stay are not shown until the drives are switched on."""
        self.suppressed = True
        for number, words in self.shown:
            if self.errors is not None:
                self.errors.drop(number, words, REIS)

    def show_again(self, now: Ns) -> None:
        """The drives are switched on."""
        if not self.suppressed:
            return
        self.suppressed = False
        for number, words in self.shown:
            if self.errors is not None:
                self.errors.report(number, words, now, source=REIS)

    def clear(self) -> None:
        """They are acknowledged."""
        for number, words in self.shown:
            if self.errors is not None:
                self.errors.drop(number, words, REIS)
        self.shown.clear()
