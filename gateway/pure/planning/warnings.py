"""Blocks whose programmed speed an axis cannot keep: "Interpolator Stop", reported once a block when it is under way (AX-571).  Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from motion.planner.path_checks import Slowed


@dataclass
class Slowing:
    """Slowings of the successive parts of a program.  heard: sentences not taken yet."""

    heard: list[str] = field(default_factory=list)
    _passed: int = 0  # blocks of the program that were looked at
    _reported: int = 0  # the last block that was reported

    def begin(self) -> None:
        """Another program."""
        self._passed = self._reported = 0

    def look(self, slowed: Mapping[int, Slowed], before: int, block: int, rate: float, lines: Sequence[int]) -> str:
        """Return the warning of the current block, or "".  slowed: of the part, whose blocks follow `before`; block: of the part; rate:
        requested share of the programmed speed; lines: of each block of the program, 0: none.
        """
        words = ""
        for number in range(max(min(self._passed, before + block - 1), before) + 1, before + block + 1):
            found = slowed.get(number - before)
            if found is None or found.share * rate <= 1.0:
                words = ""
                continue
            line = lines[number - 1] if number <= len(lines) else 0
            words = (f"line {line}: " if line else "") + found.of(number)
            if number > self._reported:
                self._reported = number
                self.heard.append(words)
        self._passed = before + block
        return words

    def take(self) -> list[str]:
        """Once each."""
        heard, self.heard = self.heard, []
        return heard
