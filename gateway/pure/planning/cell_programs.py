"""The data of a cell that its planner uses.  Pure."""

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.cycle.path_outputs import Places
from gateway.pure.image.records.planner import MeasuringFacts
from gateway.pure.planning.backlog import Backlog
from gateway.pure.planning.team import no_programs, no_team
from gateway.pure.planning.trial import Files
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.program.team import Kinematic
from motion.sync.facts import BeltFacts


@dataclass
class CellPrograms:
    """What programs of a cell are planned with.

    machine_of: (robot a text names, number of the program, 0: a stream, -n: a stream of robot n) -> machine; text_of: number -> text;
    team_of: kinematics of a text, its number -> team.  Files are read there; all raise MotionError.
    """

    machine_of: Callable[[str, int], Machine]
    mask_of: Callable[[Machine | Team], int]  # axes of the cell
    text_of: Callable[[int], str] = no_programs
    outputs: Container[int] = range(0)  # RC outputs programs may switch
    belts: Sequence[BeltFacts] = ()
    functions: Places = field(default_factory=dict)  # IO logic and PPO the cell has
    kinematic_of: Callable[[Machine], int] = lambda _: 1  # number of a robot in the cell
    altered: Container[int] = ()  # kinematics that have a correction (VAL 3 alter)
    systems: int = 0  # measuring systems: axes and belts
    channels: Mapping[int, MeasuringFacts] = field(default_factory=dict)  # measuring inputs by their numbers
    files: Files = Files()
    windows: Sequence[float] = ()  # of the axes of the cell, in position; m and rad
    team_of: Callable[[Sequence[Kinematic], int], Team] = no_team
    backlog: Backlog = field(default_factory=Backlog)  # of the ring all lanes share
