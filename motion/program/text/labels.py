"""The text form of labels: where a program continues when an input never came, or nothing was measured (`error=`)."""

from dataclasses import dataclass, field

from motion.program.errors import TextError
from motion.program.text.words import Fault, name, one


@dataclass(slots=True)
class Labels:
    """label: before the next block; blocks: number so far."""

    label: str = ""
    blocks: int = 0
    _known: dict[str, int] = field(default_factory=dict)  # blocks before it
    _asked: list[tuple[int, str, int]] = field(default_factory=list)  # line, label, number of the block that names it

    def line(self, head: str, rest: list[str], *, acting: bool = False) -> None:
        """acting: sync or a belt function precedes it already."""
        self.label = name(head, one(head, rest))
        if acting:
            raise Fault(head, f"{self.label} must be before sync, mach_pos and belt functions: they belong to the block after it")
        if self.label in self._known:
            raise Fault(head, f"{self.label} is defined twice")
        self._known[self.label] = self.blocks

    def asked(self, line: int, label: str) -> None:
        """Note that the block of this line, which comes next, may continue there (empty: nowhere)."""
        if label:
            self._asked.append((line, label, self.blocks + 1))

    def added(self) -> None:
        """One more block."""
        self.label, self.blocks = "", self.blocks + 1

    def ended(self) -> None:
        """Check that labels named by blocks follow them.  Raise TextError."""
        for line, asked, block in self._asked:
            if self._known.get(asked, -1) < block:
                raise TextError(line, "error", f"label {asked} does not follow the block")
