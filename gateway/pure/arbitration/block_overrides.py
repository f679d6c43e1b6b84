"""The override of a data block: of the cell, or of single kinematics (AX-1787).

A level, but taken only when it changed or the drives were just asked on: it must not fight the other command sources.
"""

from collections.abc import Mapping

from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.command_numbers import OVERRIDE, MoveNumbers


class BlockOverrides:
    """Overrides set by the PLC's data blocks."""

    def __init__(self, numbers: MoveNumbers, axes: int) -> None:
        self.robots: Mapping[str, int] = {}  # by name, the axes (bit n-1 = axis n) of each
        self._numbers, self._every = numbers, (1 << axes) - 1
        self._levels: dict[str, float] = {}
        self._primed: set[str] = set()
        self._owed = False  # drives were asked on before their override was known

    @property
    def names(self) -> list[str]:
        """Those the blocks have an entry for."""
        return [name for name in (OVERRIDE, *self._single()) if self._numbers.declared(name)]

    @property
    def refused(self) -> str:
        """Why the first refused one was refused; empty: none was."""
        return next((fault for name in self.names if (fault := self._numbers.refused(name))), "")

    def restart(self) -> None:
        """The next telegram only sets the state of the entries."""
        self._primed.clear()
        self._owed = False

    def take(self, levels: Mapping[str, float], *, fresh: bool, control: bool) -> list[Command] | str:
        """Commands to be given; words: why drives that were just asked on have none.  fresh: they were asked on in this telegram."""
        names = self.names
        if not names:
            return [Command(Code.OVERRIDE, velocity=1.0)] if fresh else []  # these blocks have none: full programmed speed
        self._owed |= fresh
        fault = self._numbers.missing(names)
        if fault:  # the set override stays; motion is refused until a valid one is written
            return fault if fresh and all(self._numbers.seen(name) for name in names) else []
        changed = False
        for name in names:
            before = self._levels.get(name)
            now = levels.get(name, before)
            if now is None:
                return []
            changed |= name in self._primed and now != before
            self._levels[name] = now
            self._primed.add(name)
        if not (fresh or ((self._owed or changed) and control)):
            return []
        self._owed = False
        return self._commands(names)

    def _commands(self, names: list[str]) -> list[Command]:
        """That of a kinematic is a share of that of the cell; each lane gets one order, so that none is faster in between."""
        whole = self._levels.get(OVERRIDE, 100.0) / 100.0
        single = {mask: self._levels[name] / 100.0 for name, mask in self._single().items() if name in names}
        if not single:
            return [Command(Code.OVERRIDE, velocity=whole)]
        rest = self._every & ~sum(single)
        orders = {mask: whole * share for mask, share in single.items()} | ({rest: whole} if rest else {})
        return [Command(Code.AXES_OVERRIDE, mask, velocity) for mask, velocity in orders.items()]

    def _single(self) -> Mapping[str, int]:
        return {f"robot.{name}.override": mask for name, mask in self.robots.items()}
