"""Blocks of a program that moves several kinematics: who moves, and who moves together."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from motion.program.blocks import Act, Block, Called, Output


@dataclass(frozen=True, slots=True)
class Shared:
    """One step of a team.  moves: for each kinematic, in the team's order, its own block, or None: it stays where it is.

    All that move begin together and end together, each on its own way; one that moves alone leaves the others at rest.
    """

    moves: tuple[Block | None, ...]
    line: int = field(default=0, compare=False)  # of the program text; 0: none
    label: str = ""  # before it
    acts: tuple[Act, ...] = ()  # done at rest before it

    @property
    def own(self) -> tuple[Block, ...]:
        """Blocks of those that move."""
        return tuple(block for block in self.moves if block is not None)

    @property
    def asks(self) -> bool:
        """It waits for an input, ends with one, goes to where axes were measured or recorded, something is done at rest before it, its way
        is a file's, or leads along a belt or a correction: a part of its own."""
        return (
            self.acts != ()
            or self.filed is not None
            or self.alone is not None
            or any(block.until is not None or block.wait is not None or block.unmet for block in self.own)
        )

    @property
    def alone(self) -> tuple[int, Block] | None:
        """Return the kinematic, from 0, that is on a belt or corrected, and its block with all its statements; None: outside
        such a part.
        """
        found = next(((n, own) for n, own in enumerate(self.moves) if own is not None and (own.synchron or own.alteration)), None)
        if found is None:
            return None
        member, own = found
        return member, replace(own, label=self.label, acts=(*self.acts, *own.acts))

    @property
    def filed(self) -> tuple[int, Block] | None:
        """The kinematic, from 0, whose way is that of a file, and its block."""
        return next(((n, block) for n, block in enumerate(self.moves) if block is not None and block.file is not None), None)

    @property
    def ends(self) -> bool:
        """With an input."""
        return any(block.until is not None for block in self.own)

    @property
    def error(self) -> str:
        """Label at which to continue when its input never came."""
        return next((block.until.error for block in self.own if block.until is not None), "")

    @property
    def recorded(self) -> tuple[int, int]:
        """Entry of the reference path that one of them goes to, and which one, from 0; (0, 0): none does."""
        return next(((block.recorded, n) for n, block in enumerate(self.moves) if block is not None and block.recorded), (0, 0))

    @property
    def otherwise(self) -> str:
        """Label at which to continue when the target of one of them was not measured or stored."""
        return next((block.otherwise for block in self.own if block.otherwise), "")

    def carrying(self, what: tuple[Called | Output, ...]) -> "Shared":
        """With what blocks without way before it begin or end with."""
        first = self.moving[:1] if what else ()
        return self.changed(lambda n, block: replace(block, carried=(*what, *block.carried)) if n in first else block)

    def changed(self, how: Callable[[int, Block], Block]) -> "Shared":
        """Every kinematic's own block by what `how` makes of its number, from 0, and it."""
        return replace(self, moves=tuple(None if block is None else how(n, block) for n, block in enumerate(self.moves)))

    @property
    def moving(self) -> tuple[int, ...]:
        """Numbers of the kinematics that move, from 0."""
        return tuple(n for n, block in enumerate(self.moves) if block is not None)


@dataclass(frozen=True, slots=True)
class Kinematic:
    """One of a team, as its program names it.  start: m or rad, where its axes are before the first block."""

    name: str
    robot: str  # name of a robot file
    start: tuple[float, ...]
    units: tuple[str, ...] = ()  # outside units of its axes, "mm" or "deg"; empty: all deg
    angles: str = "val3"


@dataclass(frozen=True, slots=True)
class TeamProgram:
    """Kinematics in their order, and blocks of all of them."""

    name: str
    kinematics: tuple[Kinematic, ...]
    blocks: tuple[Shared, ...]
    acts: tuple[Act, ...] = ()  # after the last block

    @property
    def start(self) -> tuple[float, ...]:
        """Of all axes, kinematic by kinematic."""
        return tuple(value for each in self.kinematics for value in each.start)
