"""The tool of the block under way, for drawing the robot: as the blocks of a program name it, and the last one at rest."""

from dataclasses import dataclass, field

from motion.geometry.frames import Pose

Shown = tuple[float, ...]  # position (m), nine floats of the rotation; (): no program has named one yet


@dataclass(slots=True)
class ToolShown:
    """Of kinematic 1, the one that the page draws."""

    shown: Shown = ()
    _coming: list[tuple[int, Shown]] = field(default_factory=list)  # block from which on it counts
    _read: Pose | None = None  # of the last block that was read

    def begin(self) -> None:
        """A program begins; the tool of the one before stays until its first block."""
        self._coming, self._read = [], None

    def placed(self, number: int, tool: Pose, kinematic: int) -> None:
        """Block `number` was read."""
        if kinematic == 1 and tool != self._read:
            self._read = tool
            self._coming.append((number, (*tool.position, *tool.rotation)))

    def reached(self, block: int) -> None:
        """So many blocks have begun."""
        while self._coming and self._coming[0][0] <= block:
            self.shown = self._coming.pop(0)[1]
