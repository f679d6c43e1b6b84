"""Blocks of several kinematics -> stretches of their common path: each kinematic on its own way, one s for all.

Blocks that one kinematic runs alone go through its own route and are rounded as ever.  Of a shared block each kinematic's way is laid
over the same s, so that all are at the same share of their ways at any moment.  A point between two shared blocks is rounded when every
kinematic that moves there may round it; else all stop in it (AX-340).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from motion.errors import MotionError
from motion.kinematics.base import Joints
from motion.outputs.function import Function
from motion.paths.joints import JointPath, joined
from motion.paths.together import rescaled, side_by_side
from motion.planner.stretch import EMPTY, Kind, Stretch, shaped
from motion.planner.team import Team, TeamStretch
from motion.planner.team_corner import Member, cut, paced
from motion.program.blocks import Block, Called, Interpolation, Output, Rounding, Shape
from motion.program.errors import BlockError
from motion.program.team import Shared

MOST = 0.5  # of a block, for one that begins or ends in the corner
LEFT = 0.999  # largest share of a block's known part for the corner at its end


@dataclass(frozen=True)
class _Held:
    """A shared block whose end is not known yet.  begins: share up to which it is run already; ways: per moving kinematic the paths known
    from there on and the full length of its block; rests: positions of all kinematics before it.
    """

    number: int
    shared: Shared
    begins: float
    ways: dict[int, tuple[tuple[JointPath, ...], float]]
    rests: tuple[Joints, ...]

    @property
    def scale(self) -> float:
        """Common s of the entire block."""
        return max(length for _, length in self.ways.values())

    def block(self, n: int) -> Block:
        """Of a kinematic that moves."""
        block = self.shared.moves[n]
        assert block is not None
        return block


@dataclass(frozen=True)
class _Corner:
    """Between two shared blocks.  leave, reach: shares of both; half: as common s, the same on both sides; lengths: full lengths after it
    of the kinematics that move there.
    """

    leave: float
    reach: float
    half: float
    lengths: dict[int, float]


@dataclass
class _State:
    routes: list[Member]
    number: int = 0
    alone: int | None = None  # kinematic whose own route is open
    held: _Held | None = None
    carried: tuple[Called | Output, ...] = ()  # of blocks without way since the last way
    out: tuple[Stretch, ...] = field(default=())


class TeamRoute:
    """add() blocks, take() stretches; see motion.planner.route."""

    def __init__(self, team: Team, start: Sequence[float]) -> None:
        self._team = team
        self._now = _State([Member(machine, own) for machine, own in zip(team.machines, team.split(start), strict=True)])

    @property
    def position(self) -> Joints:
        """Where all axes will be after everything that was added."""
        return tuple(value for route in self._now.routes for value in route.position)

    @property
    def added(self) -> int:
        """Number of the last block."""
        return self._now.number

    @property
    def pending(self) -> bool:
        """Something is left that only the next block or finish() fixes."""
        return self._now.held is not None or any(route.pending for route in self._now.routes)

    def add(self, block: Shared) -> int:
        """The next block; its number, counted from 1.  Raises BlockError."""
        number = self._now.number + 1
        self._guarded(number, lambda: self._add(number, block))
        return number

    def assume_measured(self) -> None:
        """As motion.planner.route.Route: of every kinematic."""
        for route in self._now.routes:
            route.assume_measured()

    def finish(self) -> None:
        """The last block is run to its target and all stop there."""
        self._guarded(self._now.number, self._finish)

    def take(self) -> list[Stretch]:
        """What became known since the last call, in order."""
        out, self._now.out = self._now.out, ()
        return list(out)

    def left(self) -> tuple[Called | Output, ...]:
        """Return the calls and outputs of blocks without way after the last one, once."""
        carried, self._now.carried = self._now.carried, ()
        return carried

    def reset(self, position: Sequence[float]) -> None:
        """Forget everything; the axes are here."""
        for route, own in zip(self._now.routes, self._team.split(position), strict=True):
            route.reset(own)
        self._now = _State(self._now.routes, self._now.number)

    def _guarded(self, number: int, action: Callable[[], None]) -> None:
        kept = replace(self._now, routes=[route.twin() for route in self._now.routes])
        try:
            action()
        except BlockError:
            self._now = kept
            raise
        except MotionError as error:
            self._now = kept
            raise BlockError(str(error), block=number) from error

    # ---- blocks --------------------------------------------------------------------------------------------------------
    def _add(self, number: int, shared: Shared) -> None:
        now = self._now
        if len(shared.moves) != len(self._team.machines) or not shared.moving:
            raise BlockError(
                f"{len(shared.moving)} of {len(shared.moves)} kinematics move, the team has {len(self._team.machines)}", block=number
            )
        for n in shared.moving:
            self._check(n, shared.moves[n], number)
        _check_asked(shared, number)
        if shared.asks:
            self._finish()
        now.number = number
        shared = shared.changed(lambda n, block: _owned(shaped(block, self._team.machines[n]), n)).carrying(now.carried)
        alone = len(shared.moving) == 1
        way = self._add_alone(number, shared.moving[0], shared) if alone else self._add_shared(number, shared)
        for route in now.routes:
            route.left()  # actions without way are kept here, for all kinematics
        unmet = any(block.unmet for block in shared.own)  # looked at as if it had no way, and has one
        now.carried = () if way or unmet else tuple(each for own in shared.own for each in (*own.carried, *own.functions, *own.outputs))
        if shared.ends:
            self._finish()

    def _check(self, kinematic: int, block: Block | None, number: int) -> None:
        """What one of them does alone, in a route of its own (gateway.pure.planning.trial, gateway.tools.motion.dry_run_team)."""
        assert block is not None
        if block.synchron or block.on_belt or block.alteration or block.acts:
            what = "a block on a belt, or with a correction, is not a block of a path of several kinematics"
            raise BlockError(f"kinematic {self._team.names[kinematic]}: {what}", block=number)

    def _add_alone(self, number: int, n: int, shared: Shared) -> bool:
        """Whether it has a way."""
        now = self._now
        if now.alone != n or now.held is not None:
            self._finish()
        now.alone = n
        known = self._known_of(n, number, _adding(shared, n))
        self._lift(n, known)
        spline = shared.own[0].kind is Interpolation.SPLINE  # its curve is known when the row is over
        return spline or any(each.block == number or each.following is not None for each in known)

    def _add_shared(self, number: int, shared: Shared) -> bool:
        """Whether one of them has a way."""
        now = self._now
        if any(block is not None and block.kind is Interpolation.SPLINE for block in shared.moves):
            raise BlockError("splines are run by one kinematic only, not in a shared block", block=number)
        if sum(any(output.before for output in block.outputs) for block in shared.moves if block is not None) > 1:
            raise BlockError("outputs before the end of a shared block are measured on the way of one kinematic", block=number)
        shared = _timed(shared, number)
        if not (now.held is not None and self._rounded(now.held, number, shared)):
            self._finish()
            rests = tuple(route.position for route in now.routes)
            ways = {}
            for n in shared.moving:
                got = self._known_of(n, number, _adding(shared, n))
                if got:
                    ways[n] = (tuple(each.path for each in got), got[0].way)
            now.held = _Held(number, shared, 0.0, ways, rests) if ways else None
        way = now.held is not None
        if any(block.blend.rounding is Rounding.OFF for block in shared.own):
            self._finish()
        return way

    def _known_of(self, n: int, number: int, action: Callable[[Member], object]) -> list[Stretch]:
        """Something done by one kinematic's route: what became known; errors name the kinematic."""
        route = self._now.routes[n]
        route.number(number)
        try:
            action(route)
        except BlockError as error:
            raise self._team.with_kinematic(error, n) from error
        return route.take()

    def _finish(self) -> None:
        """All that is open is run to its end, and all rest."""
        now = self._now
        if now.alone is not None:
            now.routes[now.alone].finish()
            self._lift(now.alone, now.routes[now.alone].take())
            now.alone = None
        if now.held is not None:
            held, now.held = now.held, None
            paths = {}
            for n, (known, _) in held.ways.items():
                now.routes[n].finish()
                paths[n] = joined([*known, *(each.path for each in now.routes[n].take())])
            self._put_main(held, 1.0, paths, stop=True)

    # ---- stretches -----------------------------------------------------------------------------------------------------
    def _lift(self, n: int, known: Sequence[Stretch]) -> None:
        """What one kinematic's route made known, with all others at rest."""
        rests = [route.position for route in self._now.routes]
        for own in known:
            path = side_by_side([*rests[:n], own.path, *rests[n + 1 :]], n)
            square = _lifted(own.square, rests, n) if own.square is not None else None
            made = TeamStretch(
                path, own.block, own.kind, own.source, own.share, own.following, own.stop, own.way, square, parts=((n, own),)
            )
            self._now.out = (*self._now.out, made)

    def _put_main(self, held: _Held, until: float, paths: dict[int, JointPath], *, stop: bool = False) -> None:
        """Shares `begins` .. `until` of a shared block."""
        length = (until - held.begins) * held.scale
        shares, parts = (held.begins, until), []
        for n, path in paths.items():
            parts.append(
                (n, Stretch(rescaled(path, length), held.number, Kind.MAIN, held.block(n), shares, stop=stop, way=held.ways[n][1]))
            )
        lead = _lead(held.shared, tuple(held.ways))
        self._put(Stretch(parts[0][1].path, held.number, Kind.MAIN, _source(held.shared, lead), shares, stop=stop), held, parts, lead)

    def _put(self, like: Stretch, held: _Held, parts: Sequence[tuple[int, Stretch]], lead: int) -> None:
        """The ways of those that move, side by side with the others at rest."""
        rows: list[JointPath | Joints] = list(held.rests)
        for n, part in parts:
            rows[n] = part.path
        way = held.ways[lead][1] if lead in held.ways else parts[0][1].way
        made = TeamStretch(
            side_by_side(rows, lead), like.block, like.kind, like.source, like.share, like.following, like.stop, way, parts=tuple(parts)
        )
        self._now.out = (*self._now.out, made)

    # ---- corners -------------------------------------------------------------------------------------------------------
    def _rounded(self, held: _Held, number: int, shared: Shared) -> bool:
        """Rounds the point between two shared blocks where every kinematic may; else nothing is changed."""
        now, kept = self._now, replace(self._now)
        now.routes = [route.twin() for route in kept.routes]
        try:
            corner = self._corner(held, shared)
            if corner is not None and self._put_corner(held, number, shared, corner):
                return True
        except MotionError:
            pass  # it stops in the point; the fault of the block is reported when it is added from there
        now.routes, now.out = kept.routes, kept.out
        return False

    def _corner(self, held: _Held, shared: Shared) -> _Corner | None:
        leaves, reaches, lengths = [LEFT * (1.0 - held.begins), MOST], [MOST], {}
        through = False
        for n, following in enumerate(shared.moves):
            route = self._now.routes[n]
            if n in held.ways and held.block(n).blend.rounding is Rounding.OFF:
                return None
            length = route.way(following) if following is not None else 0.0
            if following is None or length == 0.0:
                continue
            lengths[n] = length
            if n in held.ways:
                found = route.look(following)
                if found is None:
                    return None
                leaves.append(found[0])
                reaches.append(found[1])
                through = True
        if not through:
            return None  # the moving ones come to rest, others begin
        before, behind = held.scale, max(lengths.values())
        half = min(min(leaves) * before, min(reaches) * behind)
        return _Corner(half / before, half / behind, half, lengths)

    def _put_corner(self, held: _Held, number: int, shared: Shared, corner: _Corner) -> bool:
        """False: one of the ways goes back on itself."""
        now = self._now
        mains: dict[int, JointPath] = {}
        rounded: list[tuple[int, Stretch]] = []
        rests: list[Joints] = [route.position for route in now.routes]
        ways: dict[int, tuple[tuple[JointPath, ...], float]] = {}
        for n in sorted({*held.ways, *corner.lengths}):
            known, length = held.ways.get(n, ((), 0.0))
            if n not in corner.lengths:  # comes to rest in the corner
                now.routes[n].finish()
                path = joined([*known, *(each.path for each in now.routes[n].take())])
                mains[n], last = cut(path, path.length - corner.leave * length)
                rests[n] = now.routes[n].position
                piece = Stretch(last, held.number, Kind.MAIN, held.block(n), (1.0 - corner.leave, 1.0), way=length)
            else:
                route = now.routes[n]
                route.forced = (corner.leave, corner.reach) if n in held.ways else None
                got = self._known_of(n, number, _adding(shared, n))
                route.forced = None
                on, whole = [each.path for each in got if each.block == number and each.kind is Kind.MAIN], corner.lengths[n]
                if n not in held.ways:  # begins in the corner
                    first, rest = cut(joined(on), corner.reach * whole)
                    piece = Stretch(first, held.number, Kind.MAIN, _block(shared, n), (0.0, corner.reach), way=whole)
                    on = [rest]
                else:
                    found = [each for each in got if each.kind is Kind.CORNER]
                    if not found:
                        return False
                    piece = found[0]
                    mains[n] = joined([*known, *(each.path for each in got if each.block == held.number and each.kind is Kind.MAIN)])
                ways[n] = (tuple(on), whole)
            rates = (corner.leave * length / corner.half, corner.reach * corner.lengths.get(n, 0.0) / corner.half)
            rounded.append((n, replace(piece, path=paced(piece.path, rates, 2 * corner.half), square=None)))
        if 1.0 - corner.leave - held.begins > EMPTY:
            self._put_main(held, 1.0 - corner.leave, mains)
        lead = _lead(held.shared, tuple(held.ways))
        source, following = _source(held.shared, lead), _source(shared, _lead(shared, tuple(corner.lengths)))
        share = (1.0 - corner.leave, corner.reach)
        self._put(Stretch(rounded[0][1].path, held.number, Kind.CORNER, source, share, following), held, rounded, lead)
        now.held = _Held(number, shared, corner.reach, ways, tuple(rests))
        return True


def _check_asked(shared: Shared, number: int) -> None:
    """What the kinematics of a block wait for, end with and go to: BlockError where it is not the same for all."""
    if sum(block.until is not None for block in shared.own) > 1 or sum(block.wait is not None for block in shared.own) > 1:
        raise BlockError("only one kinematic may define what a shared block waits for, or ends with", block=number)
    if sum(block.recorded != 0 for block in shared.own) > 1:
        raise BlockError(
            "only one kinematic of a shared block can move to an entry: recorded of another one needs its own block", block=number
        )
    if len(labels := sorted({block.otherwise for block in shared.own} - {""})) > 1:
        raise BlockError(f"a shared block continues at one label, not at {' and '.join(labels)}: error= of one of them", block=number)


def _adding(shared: Shared, n: int) -> Callable[[Member], object]:
    return lambda route: route.add(_block(shared, n))


def _owned(block: Block, n: int) -> Block:
    """What it begins with is that of kinematic n."""
    return replace(block, functions=tuple(each if isinstance(each, Function) else replace(each, member=n) for each in block.functions))


def _block(shared: Shared, n: int) -> Block:
    block = shared.moves[n]
    assert block is not None
    return block


def _lifted(
    square: Callable[[], tuple[JointPath, JointPath]], rests: Sequence[Joints], n: int
) -> Callable[[], tuple[JointPath, JointPath]]:
    """The same corner driven out, with all others at rest."""

    def lifted() -> tuple[JointPath, JointPath]:
        first, second = (side_by_side([*rests[:n], path, *rests[n + 1 :]], n) for path in square())
        return first, second

    return lifted


def _timed(shared: Shared, number: int) -> Shared:
    """A time one of them is given holds for all."""
    given = {block.pace.time for block in shared.moves if block is not None} - {None}
    if len(given) > 1:
        raise BlockError("a shared block has one time, and these give different ones", block=number)
    if not given:
        return shared
    (time,) = given
    return replace(shared, moves=tuple(block and replace(block, pace=replace(block.pace, time=time)) for block in shared.moves))


def _lead(shared: Shared, ways: Sequence[int]) -> int:
    """Whose way is the way of all: of one with outputs so far before the end, else of the first whose tool has a way, else the first."""
    measured = [n for n in ways if any(output.before for output in _block(shared, n).outputs)]
    tools = [n for n in ways if _block(shared, n).kind is not Interpolation.PTP]
    return [*measured, *tools, *ways][0]


def _source(shared: Shared, lead: int) -> Block:
    """The leading kinematic's block, with what all begin and end with; sine-square ramps where all that move have them."""
    blocks = shared.own
    outputs = tuple(each for block in blocks for each in block.outputs)
    functions = tuple(each for block in blocks for each in block.functions)
    carried = tuple(each for block in blocks for each in block.carried)
    shape = Shape.SIN2 if all(block.shape is Shape.SIN2 for block in blocks) else Shape.JERK
    return replace(_block(shared, lead), outputs=outputs, functions=functions, carried=carried, shape=shape)
