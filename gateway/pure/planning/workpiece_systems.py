"""WC_SYSTEM of the robots of a cell: it stays over programs and their aborts until another one is chosen; a start-up brings WC_UR back
(rho 3 Releases part 1, L8884, L9015-9023, L9070; AX-586).  Pure."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from gateway.pure.planning.team import machines_in
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.program.blocks import Block
from motion.program.systems import located
from motion.program.team import Shared
from motion.rho3.wc import WC_UR, WcFrame

Values = tuple[float, float, float, float, float, float]
Shown = tuple[tuple[int, Values], ...]


@dataclass
class CellSystems:
    """active: kinematic, from 1 -> its system where it is not WC_UR."""

    active: dict[int, WcFrame] = field(default_factory=dict)
    _coming: list[tuple[int, int, WcFrame]] = field(default_factory=list)  # block from which on, kinematic, system
    _read: dict[int, WcFrame] = field(default_factory=dict)  # as the program under way has chosen so far

    def begin(self) -> None:
        """Begin a program, or forget the remainder of one: systems not yet reached count as never chosen."""
        self._coming.clear()
        self._read = dict(self.active)

    def started_up(self) -> None:
        """The cycle began anew."""
        self.active.clear()
        self.begin()

    def placed(self, block: Block | Shared, number: int, robots: Machine | Team, kinematic_of: Callable[[Machine], int]) -> Block | Shared:
        """The block, each robot's own part of it, in the system it names, or in the one in force."""
        machines = machines_in(robots)

        def own(n: int, part: Block) -> Block:
            kinematic = kinematic_of(machines[n])
            self.chosen(part.system, number, kinematic)
            system = self._read.get(kinematic)
            return located(part if part.system is system else replace(part, system=system), machines[n].corrects)

        return block.changed(own) if isinstance(block, Shared) else own(0, block)

    def chosen(self, system: WcFrame | None, number: int, kinematic: int) -> None:
        """By block `number`, or what follows the last one."""
        if system is not None and system != self._read.get(kinematic, WC_UR):
            self._coming.append((number, kinematic, system))
            self._read[kinematic] = system

    def behind(
        self, systems: Sequence[WcFrame | None], number: int, robots: Machine | Team, kinematic_of: Callable[[Machine], int]
    ) -> None:
        """Add the last choice of each kinematic's text, after its last block."""
        for machine, system in zip(machines_in(robots), systems, strict=True):
            self.chosen(system, number, kinematic_of(machine))

    def reached(self, block: int) -> None:
        """So many blocks have begun."""
        while self._coming and self._coming[0][0] <= block:
            _, kinematic, system = self._coming.pop(0)
            if system.values == WC_UR.values:
                self.active.pop(kinematic, None)
            else:
                self.active[kinematic] = system

    @property
    def shown(self) -> Shown:
        """For the successor."""
        return tuple(sorted((kinematic, system.values) for kinematic, system in self.active.items())) if self.active else ()

    def follows(self, before: Shown) -> None:
        """Adopt the last report of the previous planner."""
        self.active = {kinematic: WcFrame(*values) for kinematic, values in before}
