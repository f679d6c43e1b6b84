"""What programs of one robot and of several kinematics have in common for the planner process.  Pure."""

from collections.abc import Callable, Iterator, Sequence

from gateway.pure.image.records.planner import PieceRecord
from gateway.pure.planning.parts import Coming, Measuring, later_fault, measured_at
from motion.errors import MotionError
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.program.blocks import Block
from motion.program.errors import BlockError
from motion.program.team import Kinematic, Shared
from motion.program.text.reader import Reader
from motion.program.text.team import TeamReader, several
from motion.rho3.wc import WcFrame


def no_programs(number: int) -> str:
    """Of a cell without programs."""
    raise MotionError(f"program {number}: this cell has none")


def no_team(kinematics: Sequence[Kinematic], number: int) -> Team:
    """Of a cell with one robot and programs without kinematics."""
    raise MotionError(f"kinematic {kinematics[0].name}: this cell has only one robot")


def reader_for(text: str, reader: Reader | TeamReader) -> Reader | TeamReader:
    """The reader of this line: `kinematic` at the beginning marks a program of several kinematics."""
    if isinstance(reader, Reader) and several(text) and reader.untold:
        return TeamReader(reader.name)
    return reader


def own_axes(robots: Machine | Team) -> Iterator[tuple[Machine, int]]:
    """Each robot, and the first of its axes among those of all."""
    if isinstance(robots, Team):
        yield from zip(robots.machines, robots.firsts, strict=False)
    else:
        yield robots, 0


def machines_in(robots: Machine | Team) -> tuple[Machine, ...]:
    """One, or all of a team in their order."""
    return robots.machines if isinstance(robots, Team) else (robots,)


def systems_of(reader: Reader | TeamReader) -> list[WcFrame | None]:
    """Return WC_SYSTEM of each kinematic at the present place in the text; None: not set."""
    readers = reader.readers.values() if isinstance(reader, TeamReader) else (reader,)
    return [each.systems.active for each in readers]


def own_blocks(robots: Machine | Team, block: Block | Shared) -> Iterator[tuple[Machine, Block]]:
    """Each robot that a block moves, and its own part of it."""
    machines = machines_in(robots)
    moves = block.moves if isinstance(block, Shared) else (block,)
    for machine, own in zip(machines, moves, strict=True):
        if own is not None:
            yield machine, own


def not_measured(part: Coming, robots: Machine | Team, measured: Sequence[float | None], mask_of: Callable[[Machine | Team], int]) -> bool:
    """Return whether the target of a kinematic of the part is unknown and it has a label at which to continue."""
    own = own_blocks(robots, part.shared[0]) if part.shared else [(machines_in(robots)[part.member], part.blocks[0])]
    return any(block.otherwise != "" and None in measured_at(measured, mask_of(machine)) for machine, block in own)


def begun_part(
    part: Coming,
    rows: Sequence[Block | Shared],
    planner: Planner,
    measuring: Measuring,
    measured: Sequence[float | None],
    mask_of: Callable[[Machine | Team], int],
    job: int,
    generation: int,
) -> list[PieceRecord]:
    """The blocks of a part go to the planner, what it waits for and ends with to the cycle; BlockError."""
    machines = machines_in(planner.machine)
    places = [measured_at(measured, mask_of(machine)) for machine in machines]

    def known(number: int) -> Callable[[int, Block], Block]:
        """With @MPOS as it was measured."""
        return lambda n, own: Measuring.resolved(part.marked(own), places[n], machines[n], number)

    try:
        for number, row in enumerate(rows, 1):
            planner.add(row.changed(known(number)) if isinstance(row, Shared) else known(number)(0, row))
        if not part.open:
            planner.finish()
    except BlockError as error:
        raise later_fault(error, part.number - 1) from error
    first = [each for row in rows[:1] for each in own_blocks(planner.machine, row)]  # between two SYNC on a belt there may be none
    return [record for machine, block in first for record in measuring.inputs(block, mask_of(machine), job, generation)]
