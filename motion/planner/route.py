"""Blocks -> stretches of path: geometry alone, block by block, as far as it is known.

With only block k the path is known up to the point where its corner may begin (VAL 3 L5591-5608: "A leave"); block k + 1 fixes that
corner and the path up to its own.  So a route that is fed block by block and one that has the entire program yield the same path.
What cannot be run is refused when its block is added, with the manual's number, the block and the axis; the route is then
as it was before.  The curve of a row of SPLINE blocks is known when the row is over: its fault is reported with the block after it (or
finish()), names the block of the row, and the row is forgotten; the block after it may be added again.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np

from motion.errors import MotionError
from motion.geometry.limits import TOUCH
from motion.geometry.units import from_si
from motion.kinematics.base import Joints
from motion.paths.base import PathError
from motion.paths.corner import clipped, corner, directions, radius_for
from motion.paths.joints import JointPath, joint_blend, joint_part
from motion.paths.polynomial import part
from motion.planner.adaptive_path import followed
from motion.planner.additional_axes import joining, shifted, states
from motion.planner.block_paths import JOINT_LIMIT, Leg, block_fault, check_end, check_numbers, make_leg, run_out, turns_more
from motion.planner.block_slope_sum import own_ramp, sum_keeps
from motion.planner.given_times import check_time
from motion.planner.path_checks import check_range, check_speed
from motion.planner.ranges import axis_range, first_at
from motion.planner.relative import shown, unwound
from motion.planner.robot import Machine
from motion.planner.round_corner import span
from motion.planner.spline_rows import curve_of, goes_on, legs_of, place_of
from motion.planner.stretch import EMPTY, SMALLEST, Kind, Stretch, evenly, shaped
from motion.planner.tool_speed import limited
from motion.program.blocks import MEASURED, Block, Called, Interpolation, JointTarget, Output, Rounding, Shape, Slope
from motion.program.errors import BlockError
from motion.program.passing import passed
from motion.program.slopes import Ramped, earliest, frozen, overlap
from motion.timing.slices import Work, whole

HALF = 0.5  # of a block, which has a corner at each end
LOOKS = 8  # at a stretch against the travel limits


@dataclass
class _State:
    position: Joints  # end of everything added
    number: int = 0
    last: Leg | None = None  # not yet run out to its end
    known: float = 0.0  # s on the last leg that is out
    begun: float = 0.0  # the part of it used by the corner at its start
    tail: JointPath | None = None  # the last stretch, while no stop follows it
    splines: tuple[tuple[int, Block], ...] = ()
    spline_start: Joints = ()
    measured: Joints | None = None  # @MPOS as looked at beforehand: the end of the last block an input may end
    carried: tuple[Called | Output, ...] = ()  # of blocks without way since the last leg
    out: tuple[Stretch, ...] = ()


RouteState = _State


def _copied(state: _State) -> _State:
    """Return the same as replace() without a change; each block needs two."""
    made = object.__new__(_State)
    vars(made).update(vars(state))
    return made


class Route:
    """add() blocks, take() stretches."""

    evens: ClassVar[bool] = True  # whether take() returns even stretches, see evenly

    def __init__(self, machine: Machine, start: Sequence[float]) -> None:
        if len(start) != machine.axes:
            raise MotionError(f"{len(start)} positions for {machine.axes} axes")
        self._machine = machine
        self._low = np.array([axis.lower - TOUCH for axis in machine.limits])
        self._high = np.array([axis.upper + TOUCH for axis in machine.limits])
        self._now = _State(tuple(start))

    @property
    def position(self) -> Joints:
        """Where the axes will be after everything that was added."""
        return self._now.position

    @property
    def added(self) -> int:
        """Number of the last block."""
        return self._now.number

    @property
    def pending(self) -> bool:
        """Return whether a part is left that only the next block or finish() fixes, or that take() has not returned."""
        return self._now.last is not None or bool(self._now.splines) or bool(self._now.out)

    def add(self, block: Block) -> int:
        """The next block; its number, counted from 1.  Raises BlockError."""
        number = self._now.number + 1
        self._guarded(number, lambda: self._add(number, self._resolved(block)))
        if block.unmet:
            self._now.carried = ()  # looked at as if it had no way, and has one
        if block.measures:
            self.assume_measured()
        return number

    def assume_measured(self) -> None:
        """@MPOS, until it is measured: where the axes will be after everything that was added."""
        self._now.measured = self._now.position

    def _resolved(self, block: Block) -> Block:
        block = shaped(block, self._machine)
        if block.recorded:  # unknown beforehand: assume the present position
            return replace(block, target=JointTarget(shown(self._now.position, self._machine.limits)))
        if block.target != MEASURED:
            return block
        if self._now.measured is None:
            raise BlockError("point not defined: @MPOS before anything was measured", source="rho 3")
        return replace(block, target=JointTarget(shown(self._now.measured, self._machine.limits)))

    def finish(self) -> None:
        """The blending of the last block is cancelled: the axes run to its target and stop there."""
        self._guarded(self._now.number, self._finish)

    def take(self) -> list[Stretch]:
        """What became known since the last call, in order."""
        out, self._now.out = self._now.out, ()
        return [evenly(each) for each in out] if self.evens else list(out)

    def kept(self) -> "RouteState":
        """The state after the last block, to return to."""
        return _copied(self._now)

    def back_to(self, state: "RouteState") -> None:
        """As if nothing had been added since."""
        self._now = _copied(state)

    def left(self) -> tuple[Called | Output, ...]:
        """Return the calls and outputs of blocks without way after the last one; the caller executes them."""
        carried, self._now.carried = self._now.carried, ()
        return carried

    def reset(self, position: Sequence[float]) -> None:
        """Forget everything but that @MPOS was measured; the axes are here."""
        measured = self._now.measured is not None
        self._now = _State(tuple(position), self._now.number, measured=tuple(position) if measured else None)

    def ending(self, block: Block | None = None) -> Work[None]:
        """End in slices the row of splines that `block` does not continue (None: the last one): a long one needs seconds.  add() and
        finish() do the same at once.  Raise BlockError.
        """
        row = self._now.splines
        if row and not (block is not None and block.kind is Interpolation.SPLINE and goes_on(row, block)):
            kept = _copied(self._now)
            try:
                yield from self._end_splines()
            except MotionError as error:
                raise self._undone(kept, kept.number, error) from error

    def _guarded(self, number: int, action: Callable[[], None]) -> None:
        kept = _copied(self._now)
        try:
            action()
        except MotionError as error:
            raise self._undone(kept, number, error) from error

    def _undone(self, kept: _State, number: int, error: MotionError) -> BlockError:
        """As before the block; without its row of splines, where one of them is the fault."""
        fault = block_fault(error, number, self._machine)
        row = kept.splines if any(fault.block == each for each, _ in kept.splines) else ()
        self._now = replace(kept, splines=(), position=kept.spline_start) if row else kept
        return fault

    def _finish(self) -> None:
        whole(self._end_splines())
        if self._now.last is not None:
            self._run_out(self._now.last)

    # ---- blocks ------------------------------------------------------------------------------------------------------
    def _add(self, number: int, block: Block) -> None:
        now = self._now
        now.number = number
        if block.file is not None:
            raise BlockError(f"move_file {block.file.name} runs in a cell or in a dry run: it has no planned path")
        if block.kind is Interpolation.SPLINE:
            self._add_spline(number, block)
            return
        whole(self._end_splines())
        leg = make_leg(number, self._carrying(block), now.position, self._machine)
        if leg is None:
            now.carried = (*now.carried, *block.carried, *block.functions, *block.outputs)
            if block.blend.rounding is Rounding.OFF and now.last is not None:
                self._run_out(now.last)
            return
        now.carried = ()
        check_range(leg, self._machine)
        reach = self._join(now.last, leg) if now.last is not None else 0.0
        now.position, now.last, now.known, now.begun = leg.end, leg, reach, reach
        leave = self._leave(leg)
        self._main(leg, leg.length - leave, stop=leave == 0.0)
        if leave == 0.0:
            now.last = None

    def _add_spline(self, number: int, block: Block) -> None:
        now = self._now
        if not goes_on(now.splines, block):
            whole(self._end_splines())
        if now.last is not None:
            self._run_out(now.last)
        check_numbers(block)
        block, now.carried = self._carrying(unwound(block, now.position, self._machine)), ()
        if not now.splines:
            now.spline_start = now.position
        now.position = place_of(block, now.position, self._machine)
        now.splines = (*now.splines, (number, block))

    def _carrying(self, block: Block) -> Block:
        return replace(block, carried=self._now.carried) if self._now.carried else block

    def _end_splines(self) -> Work[None]:
        """One curve through the row of SPLINE blocks, one stretch for each of them: a slice each."""
        now, machine = self._now, self._machine
        if not now.splines:
            return
        row, q, now.splines = now.splines, now.spline_start, ()
        curve = curve_of(row, q, machine)
        for leg in legs_of(row, curve, q, machine):
            now.known = 0.0
            try:
                check_range(leg, machine)
                self._main(replace(leg, start=(*q[: machine.arm], *leg.start[machine.arm :])), leg.length, stop=leg.number == row[-1][0])
                before, q = q, now.out[-1].path.q(leg.length)
                check_end(leg.block, before, q, machine)
            except MotionError as error:
                raise block_fault(error, leg.number, machine) from error
            yield
        now.position = q

    # ---- stretches ---------------------------------------------------------------------------------------------------
    def _main(self, leg: Leg, end: float, *, stop: bool = False) -> None:
        """Add the stretch of a leg from its known part to `end`."""
        now, start = self._now, self._now.known
        if end - start <= EMPTY * leg.length:
            if stop and now.out:
                now.out = (*now.out[:-1], replace(now.out[-1], stop=True))
                now.tail = None
            return
        self._put(
            Stretch(
                self._axes_of(leg, start, end),
                leg.number,
                Kind.MAIN,
                leg.block,
                (start / leg.length, end / leg.length),
                stop=stop,
                way=leg.length,
                clock=self._ramped(leg).clock(start, end) if leg.block.slope is Slope.BLOCK and leg.block.shape is Shape.SIN2 else None,
            )
        )
        now.known = end

    def _put(self, stretch: Stretch) -> None:
        if stretch.source.pace.time is not None and stretch.share == (0.0, 1.0):
            check_time(stretch.path, stretch.source, stretch.block, self._machine)
        self._check_travel(stretch)
        if stretch.kind is Kind.MAIN:
            stretch = replace(stretch, slowed=check_speed(stretch.path, stretch.source, self._machine))
        self._now.out = (*self._now.out, stretch)
        self._now.tail = None if stretch.stop else stretch.path

    def _axes_of(self, leg: Leg, start: float, end: float, near: Joints | None = None) -> JointPath:
        """Path of the axes along a leg from s = start to s = end."""
        if leg.path is not None:
            return joint_part(leg.path, start, end)
        if leg.axes is not None:
            return joint_part(leg.axes, start, end)
        assert leg.curve is not None
        tail = self._now.tail
        if near is None:
            near = leg.start if start == 0.0 or tail is None else tail.q(tail.length)
        return followed(part(leg.curve, start, end), near, leg.block.tool.pose, shifted(leg.course, start), self._machine)

    def _run_out(self, leg: Leg) -> None:
        self._main(leg, leg.length, stop=True)
        self._now.last = None

    def _check_travel(self, stretch: Stretch) -> None:
        """Every axis within its travel all along; looked at densely enough for quintics of a few degrees."""
        path = stretch.path
        lowest, highest = path.reach
        if (lowest >= self._low).all() and (highest <= self._high).all():
            return
        s = path.looks(LOOKS * len(path.coefficients))
        q = path.at(s)[:, : self._machine.axes]
        outside = np.argwhere((q < self._low) | (q > self._high))
        if len(outside):
            where, axis = int(outside[0][0]), int(outside[0][1])
            limits, value = self._machine.limits[axis], float(q[where][axis])
            if where and stretch.source.kind is not Interpolation.PTP and turns_more(limits):
                raise run_out(limits, f"{100 * s[where] / path.length:.0f} %")
            word = "the path begins at" if where == 0 else "the path goes through"
            low_end, high_end, here = (from_si(each, limits.unit) for each in (limits.lower, limits.upper, value))
            what = f"{word} {here:.6g} {limits.unit}, outside {low_end:.6g} .. {high_end:.6g} {limits.unit}"
            raise BlockError(what, code=JOINT_LIMIT, axis=limits.name, source="VAL 3")

    # ---- corners -----------------------------------------------------------------------------------------------------
    def _join(self, last: Leg, leg: Leg) -> float:
        """Add the corner between the last leg and this one; return how much of this one it uses."""
        block_slope = last.block.slope is Slope.BLOCK
        if (
            last.resting
            or leg.resting
            or not (last.block.blend.past_circles or passed(last.block.kind, leg.block.kind, block_slope=block_slope))
        ):
            self._run_out(last)
            return 0.0
        leave, reach = self._ranges(last, leg)
        if block_slope:
            return self._join_slopes(last, leg, leave)
        tail_known = self._now.known
        if min(leave, reach) <= SMALLEST or last.length - leave < tail_known - EMPTY * last.length:
            self._run_out(last)
            return 0.0
        self._main(last, last.length - leave)
        assert self._now.tail is not None
        here = self._now.tail.q(self._now.tail.length)
        rounded = self._corner(last, leg, leave, reach, here)
        if rounded is None:
            self._run_out(last)
            return 0.0
        shares = (1.0 - leave / last.length, reach / leg.length)
        if last.block.blend.flyby == 0.0 and Interpolation.PTP not in (last.block.kind, leg.block.kind):
            self._resting_in(rounded, last, leg, shares)
            return reach

        def square() -> tuple[JointPath, JointPath]:
            return self._axes_of(last, last.length - leave, last.length, here), self._axes_of(leg, 0.0, reach, leg.start)

        self._put(Stretch(rounded, last.number, Kind.CORNER, last.block, shares, leg.block, way=last.length, square=square))
        return reach

    def _resting_in(self, rounded: JointPath, last: Leg, leg: Leg, shares: tuple[float, float]) -> None:
        """_IV_FLYBY_S = 0 (Reis L1792-1811, L2155): the path stays rounded, and the axes rest in the middle of it (AX-415)."""
        middle = 0.5 * rounded.length
        before, after = joint_part(rounded, 0.0, middle), joint_part(rounded, middle, rounded.length)
        self._put(Stretch(before, last.number, Kind.MAIN, last.block, (shares[0], 1.0), stop=True, way=last.length))
        self._put(Stretch(after, leg.number, Kind.MAIN, leg.block, (0.0, shares[1]), way=leg.length))

    def _join_slopes(self, last: Leg, leg: Leg, leave: float) -> float:
        """Block slope: the next block starts while this one still brakes, and both are added (motion.program.slopes)."""
        limits = self._machine.limits
        before, after = (self._ramped(one) for one in (last, leg))
        sine = last.block.shape is leg.block.shape is Shape.SIN2
        keeps = partial(sum_keeps, before, after, blocks=(last.block, leg.block), machine=self._machine) if sine else None
        found = overlap(before, after, earliest(before, leave), limits, keeps) if leave > SMALLEST else None
        made = frozen(before, after, found) if found is not None else None
        if found is None or made is None or last.length - found.leave < self._now.known - EMPTY * last.length:
            self._run_out(last)
            return 0.0
        self._main(last, last.length - found.leave)
        shares = (1.0 - found.leave / last.length, found.reach / leg.length)
        curve = limited(made[0], self._machine, last.block, leg.block, anyhow=sine)
        self._put(Stretch(curve, last.number, Kind.CORNER, last.block, shares, leg.block, way=last.length, clock=made[1]))
        return found.reach

    def _ramped(self, leg: Leg) -> Ramped:
        return own_ramp(leg.block, leg.path or self._axes_of(leg, 0.0, leg.length, leg.start), self._machine)

    def _leave(self, leg: Leg) -> float:
        """Return the most that its corner can use of a leg, known without the next block; 0: it runs to its end and stops."""
        blend = leg.block.blend
        if leg.resting or blend.rounding is Rounding.OFF or (leg.block.kind is Interpolation.CIRCULAR and not blend.past_circles):
            return 0.0
        if blend.axes and leg.path is not None:
            wanted = axis_range(leg, blend.axes)
        elif blend.distance > 0.0:
            wanted = leg.length  # the angle is not known yet
        else:
            wanted = self._along(leg, blend.leave, from_end=True)
        return clipped(wanted, leg.length, self._share_to(leg))

    def _share_to(self, leg: Leg) -> float:
        """Return the most of the last leg that the corner at its end may use: more than half only without a corner at its start."""
        alone = self._now.begun == 0.0 and leg.block.slope is not Slope.BLOCK
        return leg.block.blend.share if alone else min(leg.block.blend.share, HALF)

    def _share_on(self, last: Leg, leg: Leg) -> float:
        """And of the next leg the corner at its start: more than half only where it ends at rest by its own words."""
        alone = leg.block.blend.rounding is Rounding.OFF and last.block.slope is not Slope.BLOCK
        return last.block.blend.share if alone else min(last.block.blend.share, HALF)

    def _ranges(self, last: Leg, leg: Leg) -> tuple[float, float]:
        """leave on the last leg and reach on this one, in s of each."""
        blend, before, onward = last.block.blend, self._share_to(last), self._share_on(last, leg)
        if blend.axes and last.path is not None and leg.path is not None:
            both = min(self._leave(last), clipped(axis_range(leg, blend.axes), leg.length, onward))
            return both, both
        if blend.distance > 0.0 and last.curve is not None and leg.curve is not None:
            radius = radius_for(blend.distance, *directions(last.curve, leg.curve))
            both = min(clipped(radius, last.length, before), clipped(radius, leg.length, onward))
            return both, both
        leave = clipped(self._along(last, blend.leave, from_end=True), last.length, before)
        reach = clipped(self._along(leg, blend.reach, from_end=False), leg.length, onward)
        if blend.leave == blend.reach and last.curve is not None and leg.curve is not None:
            leave = reach = min(leave, reach)  # one sphere: where a neighbour is short, both sides shrink (rho 3 L1801-1811)
        return leave, reach

    def _along(self, leg: Leg, distance: float, *, from_end: bool) -> float:
        """s from one end of a leg at which the TCP is `distance` (m) from that end."""
        if leg.curve is not None or distance <= 0.0:
            return min(max(distance, 0.0), leg.length)
        path, tool = leg.path, leg.block.tool.pose
        assert path is not None

        def place(s: float) -> tuple[float, float, float]:
            q = path.q(path.length - s if from_end else s)
            return (self._machine.forward(q) @ tool).position

        here = place(0.0)
        return first_at(lambda s: math.dist(place(s), here), distance, path.length)

    def _corner(self, last: Leg, leg: Leg, leave: float, reach: float, here: Joints) -> JointPath | None:
        """Return the rounded corner from `here`, or None where nothing can round it."""
        blend, tail = last.block.blend, self._now.tail
        assert tail is not None
        try:
            if last.path is not None and leg.path is not None:
                length = span(last.path, leg.path, reach, self._machine.limits) if leave == reach else leave + reach
                return limited(joint_blend(tail, tail.length, leg.path, reach, length), self._machine, last.block, leg.block)
            if (
                last.curve is not None
                and leg.curve is not None
                and blend.rounding is Rounding.CARTESIAN
                and last.block.tool == leg.block.tool
            ):
                curve = corner(last.curve, leg.curve, leave, reach)
                course = joining(curve.length, states(last.course, last.length - leave), states(leg.course, reach))
                return followed(curve, here, last.block.tool.pose, course, self._machine)
            onward = self._axes_of(leg, 0.0, reach, leg.start)
            made = joint_blend(tail, tail.length, onward, onward.length, leave + reach)
            return limited(made, self._machine, last.block, leg.block)
        except PathError as error:
            if error.number:
                raise
            return None  # the path goes back on itself: it stops there
