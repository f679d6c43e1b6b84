"""Trial of a program before any of it moves: its parts from the first one on that is not a plain continuation.  Pure."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from gateway.pure.planning.parts import Coming, acting, begun, later_fault, outside
from gateway.pure.planning.team import machines_in
from motion.errors import MotionError
from motion.files.playing import FilePath
from motion.kinematics.base import Joints
from motion.planner.file_plan import FilePlan, file_path
from motion.planner.marks import check_outputs
from motion.planner.planner import NO_WAY, Planner
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.planner.team import Team
from motion.planner.team_route import TeamRoute
from motion.program.blocks import MEASURED, Act, Block, Called, Flying, Output
from motion.program.errors import BlockError
from motion.program.team import Shared
from motion.sync.facts import BeltFacts
from motion.timing.slices import Work

LEAST = 1e-3  # velocity factor of an order


def no_files(name: str, number: int) -> bytes:
    """Of a robot that has none."""
    raise MotionError(f"{name}: no such file")


@dataclass(frozen=True, slots=True)
class Files:
    """BNR files.  read: name, number of the program -> bytes, raises MotionError; period_us: P5 of the cell."""

    read: Callable[[str, int], bytes] = no_files
    period_us: int = 0  # 0: no cell

    def path(
        self, block: Block, program: int, position: Joints, robots: Machine | Team, number: int, member: int = 0
    ) -> tuple[bytes, FilePath]:
        """The file of a MOVE_FILE block, and its way from where the axes are; BlockError.  member: whose, of several kinematics."""
        assert block.file is not None
        try:
            data = self.read(block.file.name, program)
        except MotionError as error:
            raise BlockError(f"move_file {error}", block=number) from error
        return data, self._way(block, data, position, robots, number, member)

    def played(self, part: Coming, planner: Planner, velocity: float, mask: int) -> FilePlan:
        """The points of its file from where the axes really are; more slowly where the order asks for it.  mask: of its robot."""
        (block,), robots = part.blocks, planner.machine
        path = self._way(block, part.data, planner.position, robots, part.number, part.member)
        slower = replace(path, period=path.period / max(velocity, LEAST))
        return FilePlan(machines_in(robots)[part.member], block, slower, mask, planner.next_id)

    def _way(self, block: Block, data: bytes, position: Joints, robots: Machine | Team, number: int, member: int) -> FilePath:
        if not isinstance(robots, Team):
            return file_path(block, data, position, robots, self.period_us, number)
        try:
            return file_path(block, data, robots.split(position)[member], robots.machines[member], self.period_us, number)
        except BlockError as error:
            raise robots.with_kinematic(error, member) from error


@dataclass(frozen=True, slots=True)
class Behind:
    """Where a trial begins: after all blocks of a planner, which may be that of one of several robots."""

    planner: Planner
    robots: Machine | Team
    team_position: Sequence[float] = ()  # (all axes,) where the part began that one of several is in
    member: int = 0  # which one, from 0

    @property
    def position(self) -> Joints:
        """Positions of all robots after the planner's last block."""
        own = self.planner.position
        if not isinstance(self.robots, Team) or isinstance(self.planner.machine, Team):
            return own
        return self.robots.placed(self.team_position, self.member, own)


@dataclass
class Trial:
    """later: the parts to come; belts: as they will be after everything tried so far; program: its number."""

    belts: Sequence[BeltFacts]
    files: Files
    program: int = 0
    later: deque[Coming] = field(default_factory=deque)
    under_way: Coming | None = None  # the part taken last
    skipping: str = ""  # label after all known blocks
    streams: bool = False  # blocks move on arrival: actions of the last ones without way are done at the end of their part
    _route: Route | TeamRoute | None = None  # of the blocks after the first one that ends with an input
    # whose route that is, where one of several is on a belt or corrected; start positions of all
    _alone: tuple[int, Team, Joints] | None = None
    _armed: dict[int, int] = field(default_factory=dict)  # channels that wait for their edge -> whose axes, of several, they store
    _moves: bool = False  # the part looked at has a way
    _left: tuple[Called | Output, ...] = ()  # of blocks without way before it, in parts that have none
    _tried: int = 0  # blocks before those, and those that no route knows

    @property
    def begun(self) -> bool:
        """Return whether parts are tried separately from here on."""
        return self._route is not None

    def ending(self, planner: Planner, block: Block | None = None, member: int = 0) -> Work[None]:
        """Do in slices the slow work of the following add() or behind() (motion.planner.route.Route.ending)."""
        if self._route is None:
            yield from planner.ending()
        elif isinstance(self._route, Route):
            goes_on = self._alone is None or self._alone[0] == member
            try:
                yield from self._route.ending(block if goes_on else None)
            except BlockError as error:
                raise later_fault(error, self._tried) from error

    def add(self, behind: Behind, block: Block, number: int, kinematic: int, member: int = 0) -> None:
        """The block is tried as if the part before had reached its target, the belt where it was programmed; BlockError.  kinematic:
        number of the robot in its cell; member: its place among several kinematics."""
        try:
            self._add(behind, block, number, kinematic, member)
        except BlockError as error:
            if isinstance(behind.robots, Team):
                raise behind.robots.with_kinematic(error, member) from error
            raise

    def _add(self, behind: Behind, block: Block, number: int, kinematic: int, member: int) -> None:
        route = self._divided(behind, number - 1)
        if not self.later or self.later[-1].member != member or not self.later[-1].holds(block):
            self._finished(route)
            self._begun(block, number, behind.robots, kinematic, member)
        route = self._route_of(behind.robots, member, number - 1)
        part = self.later[-1]
        if block.file is not None or block.synchron is not None:
            self._check_left(number)
        block, self._left = replace(block, carried=self._left), ()
        if block.file is not None:
            self._file(part, block, behind.robots)
            return
        looked_at = part.tried.add(block) if part.tried is not None else block
        try:
            route.add(looked_at)
            if block.until is not None:
                route.finish()
            self._look(route)
        except BlockError as error:
            raise later_fault(error, self._tried) from error
        part.blocks.append(replace(block, target=MEASURED) if block.recorded else block)

    def _route_of(self, robots: Machine | Team, member: int, blocks: int) -> Route:
        """Return the route of a single robot, also of one of several while the others rest: it begins after the tried blocks, which are
        finished.
        """
        if isinstance(robots, Team) and (self._alone is None or self._alone[0] != member):
            team_position = self.position
            assert team_position is not None
            self._alone = member, robots, team_position
            self._route, self._tried = Route(robots.machines[member], robots.split(team_position)[member]), blocks
            self._route.assume_measured()
        assert isinstance(self._route, Route)
        return self._route

    def together(self, behind: Behind, shared: Shared, number: int, kinematic_of: Callable[[Machine], int]) -> None:
        """A block of several kinematics, tried as if the part before had reached its target; BlockError.  kinematic_of: number of
        each in the cell."""
        route, team = self._divided(behind, number - 1), behind.robots
        assert isinstance(team, Team)
        if not self.later or not self.later[-1].takes(shared):
            self._finished(route)
            if self._alone is not None:  # after the part of one of them all share a route again
                team_position = self.position
                assert team_position is not None
                self._route, self._alone, self._tried = TeamRoute(team, team_position), None, number - 1
                self._route.assume_measured()
            self._acting(shared.acts, number, team, shared.label)
            label = "" if shared.acts else shared.label
            entry, whose = shared.recorded
            if entry:
                self.later.append(Coming(number, recall=entry, label=label, kinematic=kinematic_of(team.machines[whose])))
                label = ""
            self.later.append(Coming(number, error=shared.error, otherwise=shared.otherwise, label=label))
        together = self._route
        assert isinstance(together, TeamRoute)
        if shared.filed is not None:
            self._check_left(number)
            self.later[-1].member, block = shared.filed
            self._file(self.later[-1], block, team)
            return
        shared, self._left = shared.carrying(self._left), ()
        try:
            together.add(shared)
            self._look(together)
        except BlockError as error:
            raise later_fault(error, self._tried) from error
        met = shared.changed(lambda _, block: replace(block, target=MEASURED) if block.recorded else block)
        self.later[-1].shared.append(met)

    def _look(self, route: Route | TeamRoute) -> None:
        """What has become known; BlockError."""
        for stretch in route.take():
            check_outputs(stretch)
            self._moves = True

    def _finished(self, route: Route | TeamRoute) -> None:
        try:
            route.finish()
        except BlockError as error:
            raise later_fault(error, self._tried) from error
        left, moves = route.left(), self._moves or bool(route.take())
        self._left, self._moves = () if moves else (*self._left, *left), False

    def _begun(self, block: Block, number: int, robots: Machine | Team, kinematic: int, member: int) -> None:
        """Add the parts before it, and its own."""
        before = self.later[-1] if self.later else None
        self._acting(outside(block), number, robots, block.label)
        if block.recorded:
            label = "" if outside(block) else block.label
            self.later.append(Coming(number, recall=block.recorded, label=label, kinematic=kinematic))
            block = replace(block, label="")
        machine, position = machines_in(robots)[member], self.position
        assert position is not None
        own = robots.split(position)[member] if isinstance(robots, Team) else position
        parts = begun(block, number, self.belts, machine, own, kinematic, before or self.under_way)
        self.later += (replace(part, member=member) for part in parts)

    def _file(self, part: Coming, block: Block, robots: Machine | Team) -> None:
        """MOVE_FILE: no route leads along it."""
        assert self._route is not None
        part.data, path = self.files.path(block, self.program, self._route.position, robots, part.number, part.member)
        self._set_position(robots, part.member, path.end)
        part.blocks.append(block)
        self._tried += 1

    def _check_left(self, number: int) -> None:
        """BlockError where what blocks without way before it begin or end with has no place in block `number`."""
        if self._left:
            raise BlockError(NO_WAY, block=number - 1)

    def coming(self, unmeasured: Callable[[Coming], bool]) -> Coming | None:
        """The next part; one to @MPOS where nothing was measured leads on at its label."""
        while self.later:
            part = self.later.popleft()
            if not part.otherwise or not unmeasured(part):
                return part
            if not self.skip(part.otherwise):
                self.skipping = part.otherwise
        return None

    def skip(self, label: str) -> bool:
        """The ERROR part of MOVE UNTIL: everything before the label is left out (rho3 L1134); False: it is still to come."""
        while self.later and self.later[0].label != label:
            self.later.popleft()
        return bool(self.later)

    def anew(self) -> "Trial":
        """Return a new trial: all tried blocks are running or completed."""
        return Trial(self.belts, self.files, self.program, streams=self.streams, _armed=self._armed)

    def begins_at(self, robots: Machine | Team, position: Sequence[float], blocks: int) -> None:
        """Try the following blocks as a separate part from here; blocks: number of blocks before it."""
        self._route = TeamRoute(robots, position) if isinstance(robots, Team) else Route(robots, position)
        self._alone, self._tried = None, blocks
        self._route.assume_measured()

    def passes_over(self, blocks: int) -> None:
        """So many were dropped: what comes keeps its numbers."""
        self._tried += blocks

    @property
    def position(self) -> Joints | None:
        """Return where the tried blocks end; None: none are tried separately."""
        if self._route is None or self._alone is None:
            return None if self._route is None else self._route.position
        member, team, team_position = self._alone
        return team.placed(team_position, member, self._route.position)

    def joined(self, part: Coming, block: Block) -> None:
        """One more block of the part on a belt that has begun; BlockError."""
        assert part.tried is not None and isinstance(self._route, Route)
        looked_at = part.tried.add(block)
        try:
            self._route.add(looked_at)
            self._look(self._route)
        except BlockError as error:
            raise later_fault(error, self._tried) from error

    def behind(self, behind: Behind, acts: Sequence[Act], blocks: int, label: str) -> None:
        """Add the statements after the last block; label: before them."""
        self._finished(self._divided(behind, blocks))
        self.check_done(blocks)
        self._acting(acts, blocks + 1, behind.robots, label)

    def check_done(self, blocks: int, left: Sequence[Called | Output] = ()) -> None:
        """Behind the last block: BlockError where no way is left for what blocks without way have begun or ended with; left: of those
        before the first part."""
        still = self._route is not None and self._route.left() and not (self._moves or self._route.take())
        if left or self._left or still:
            raise BlockError(NO_WAY, block=blocks)

    def _divided(self, behind: Behind, blocks: int) -> Route | TeamRoute:
        """Return the route tried from the first part on that is not a plain continuation; blocks: number of blocks before it."""
        if self._route is None:
            behind.planner.finish()
            self._left = () if self.streams else behind.planner.left()
            self.begins_at(behind.robots, behind.position, blocks)  # whether a position is measured by then is checked separately (OfCell)
        assert self._route is not None
        return self._route

    def _acting(self, acts: Sequence[Act], number: int, robots: Machine | Team, label: str) -> None:
        parts, self.belts = acting(acts, number, self.belts, label, robots)
        for part in parts:
            waiting = [channel for channel, member in self._armed.items() if member == part.member]
            if part.point and waiting:
                what = f"mach_pos: ch{min(waiting)} waits for its edge, and where the axes were would not be known: measure_off before"
                raise BlockError(what, block=number)
            if part.point:
                self._set_position(robots, part.member, part.point)
        self.later += parts

    def _set_position(self, robots: Machine | Team, member: int, places: Sequence[float]) -> None:
        """What comes is tried from there on."""
        position = self.position
        assert self._route is not None and position is not None
        if not isinstance(robots, Team):
            self._route.reset(places)
            return
        team_position = robots.placed(position, member, places)
        if self._alone is None:
            self._route.reset(team_position)
        else:
            self._alone = self._alone[0], robots, team_position
            self._route.reset(robots.split(team_position)[self._alone[0]])

    def armed_by(self, block: Block | Shared) -> None:
        """Behind it: probes that store where the axes were."""
        moves = block.moves if isinstance(block, Shared) else (block,)
        calls = [(member, call) for member, own in enumerate(moves) if own is not None for call in own.functions]
        for member, call in calls:
            if isinstance(call, Flying):
                self._armed.pop(call.channel, None)
                self._armed |= {call.channel: member} if call.edge is not None else {}
