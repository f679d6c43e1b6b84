"""Dry run of a program, belt-synchronous sections included: finds blocks that cannot be executed, computes the axes.

Synchronous parts are checked like an order in the planner (gateway.pure.planning.parts), and run by the code of the cycle
(gateway.pure.cycle.belts), on the grid of the page.
"""

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gateway.pure.cycle.belts import BeltFault, CoreBelts
from gateway.pure.image.belt_texts import OURS, belt_words
from gateway.pure.image.records.cell import InputImage, Quality, set_bit
from gateway.pure.planning.belt_statements import act_order
from gateway.pure.planning.parts import Coming, acting, begun, inside, later_fault, outside
from gateway.pure.planning.trial import Files
from motion.execution.stepper import State, Stepper
from motion.files.playing import FilePath
from motion.geometry.units import from_si
from motion.planner.duration_check import too_long
from motion.planner.path_checks import Slowed
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.planner.stretch import Stretch
from motion.planner.team import worst
from motion.planner.trace import PERIOD_S, BeltWay, Trace, joined, numbered, tool_at, trace
from motion.program.blocks import BeltAct, Block, Program
from motion.program.errors import BlockError
from motion.program.systems import located
from motion.sync.alterable import check_alterable
from motion.sync.belts import SIMULATION, Type
from motion.sync.facts import BeltFacts

NO_FILES = Files()
LEAD_S = 0.5  # lead of a belt's start before the value at which its part begins: its filter has settled by then
MOST_S = 600.0  # of one part


@dataclass
class Section:
    """Blocks of one kind in a row.  first: number of the first; part: of those on a belt; `start`: (axes,) where they begin."""

    first: int
    start: Sequence[float]
    blocks: list[Block] = field(default_factory=list)
    part: Coming | None = None
    path: FilePath | None = None  # of its one block, MOVE_FILE
    placed: bool = False  # the axes got other places before it (SF 3)
    ends: Sequence[float] = ()  # (axes,) the positions after it, the belt at its programmed position


def sections_of(
    program: Program,
    machine: Machine,
    belts: Sequence[BeltFacts],
    *,
    option: bool = True,
    kinematic: int = 1,
    files: Files = NO_FILES,
    said: Callable[[int], None] = lambda block: None,
    slowed: dict[int, Slowed] | None = None,
) -> tuple[list[Section], list[BlockError]]:
    """Look at every block from where the last good one ended; a belt-synchronous part as if the belt were in its intended position, an
    alterable part without its correction.  option: the robot has one; kinematic: its number in the cell; `said` gets the number of each
    block that was looked at, `slowed` those whose programmed speed an axis cannot keep.
    """
    route, found, faults = _Looked(machine, program.start), [Section(1, program.start)], []
    blocks = [located(block, machine.corrects) for block in program.blocks]
    for number, block in enumerate(blocks, 1):
        try:
            section, before = found[-1], blocks[number - 2] if number > 1 else None
            check_alterable(block, before, number, option=option)
            if before is not None and before.alteration != block.alteration and block.synchron is None:
                route.finish()  # the axes rest where an alterable part begins and ends (AX-449)
                section = Section(number, route.position)
                found.append(section)
            parts, belts = acting(outside(block), number, belts, "", machine)
            apart = section.part is not None and not section.part.holds(block)
            filed = block.file is not None or section.path is not None
            if (section.part is None) != (block.synchron is None) or apart or block.acts or filed:
                route.finish()
                placed = [part.point for part in parts if part.point]
                if placed:
                    route.reset(placed[-1])
                coming = begun(block, number, belts, machine, route.position, kinematic, section.part) if block.synchron is not None else []
                part = next((each for each in coming if not each.engages), None)
                if part is None or part.inside is None:  # SYNC inside its part: it continues
                    section = Section(number, route.position, part.blocks if part is not None else [], part, placed=bool(placed))
                    found.append(section)
            plan = section.part.tried if section.part is not None else None
            if block.file is not None:
                section.path = files.path(block, 0, tuple(route.position), machine, number)[1]
                route.reset(section.path.end)
            else:
                route.add(block if plan is None else plan.add(block), number)
            section.blocks.append(block)
            section.ends = tuple(route.position)
        except BlockError as error:
            faults.append(numbered(error, number))
        said(number)
    try:
        acting(program.acts, len(blocks), belts, "", machine)
        route.finish()
    except BlockError as error:
        faults.append(error)
    if slowed is not None:
        slowed |= worst(route.found)
    free = [stretch for number, stretch in route.found if blocks[number - 1].synchron is None]
    faults = sorted((*route.rows, *faults, *(route.renumbered(fault) for fault in too_long(free, machine))), key=lambda fault: fault.block)
    return [section for section in found if section.blocks], faults


class _Looked:
    """A route of the blocks that can be run.  rows: faults of rows of SPLINE blocks, known only after them, with the program's number of
    the block; found: (block of the program, stretch) up to the last rest.
    """

    def __init__(self, machine: Machine, start: Sequence[float]) -> None:
        self._route = Route(machine, start)
        self._numbers: list[int] = []  # of the program, for each block of the route
        self.rows: list[BlockError] = []
        self.found: list[tuple[int, Stretch]] = []

    @property
    def position(self) -> Sequence[float]:
        return self._route.position

    def add(self, block: Block, number: int) -> None:
        """BlockError: this block cannot be run."""
        self._after_rows(lambda: self._route.add(block))
        self._numbers.append(number)

    def reset(self, places: Sequence[float]) -> None:
        """Restart after blocks that no route covers."""
        self._route.reset(places)

    def finish(self) -> None:
        try:
            self._after_rows(self._route.finish)
        finally:
            self.found += ((self._numbers[stretch.block - 1], stretch) for stretch in self._route.take())

    def renumbered(self, error: BlockError) -> BlockError:
        """A fault of a block of the route."""
        return numbered(error, self._numbers[error.block - 1])

    def _after_rows(self, action: Callable[[], object]) -> None:
        try:
            action()
        except BlockError as error:
            if not 0 < error.block <= len(self._numbers):
                raise
            self.rows.append(self.renumbered(error))
            action()  # the row is forgotten


@dataclass
class DryRun:
    """Result of a dry run.  speeds: of the belts in the order of `belts`, m or rad per s; tolerance_cycles: periods of the page in an
    interpolation cycle of the cell."""

    machine: Machine
    belts: Sequence[BeltFacts]
    speeds: Sequence[float]
    tolerance_cycles: int = 1
    period: float = PERIOD_S

    def run(self, sections: Sequence[Section], said: Callable[[int], None] = lambda block: None) -> Trace:
        """Run all sections, each from the real end of the one before; BlockError if a part cannot continue.  `said` gets the number of
        blocks run.
        """
        start = tuple(sections[0].start)
        parts: list[Trace] = []
        for section in sections:
            start = tuple(section.start) if section.placed else start
            if section.path is not None:
                made = self._filed(section, section.path, start)
            else:
                made = self._plain(section, start) if section.part is None else self._on_belt(section, section.part, start)
            parts.append(replace(made, cuts=(0,)) if section.placed else made)
            start = tuple(float(v) for v in made.q[-1])
            said(section.first + len(section.blocks) - 1)
        return joined(parts)

    def _plain(self, section: Section, start: Sequence[float]) -> Trace:
        route = Route(self.machine, start)
        for block in section.blocks:
            route.add(block)
        route.finish()
        return trace(route.take(), self.machine, period=self.period, start=start).later(section.first - 1)

    def _filed(self, section: Section, path: FilePath, start: Sequence[float]) -> Trace:
        """MOVE_FILE."""
        t, q = played(path, start, self.period)
        places = np.array([tool_at(self.machine, row, section.blocks[0].tool.pose) for row in q])
        numbers = np.full(len(t), section.first)
        return Trace(t, q, places, numbers, self.period, (), ((section.first, path.duration),))

    def _on_belt(self, section: Section, part: Coming, start: Sequence[float]) -> Trace:
        """From the moment its belt comes near until the robot is at rest again."""
        run = _PartRun(self, section, part, start)
        rows = list(run.rows())
        q, numbers = np.array([row for row, _, _ in rows]), np.array([number for _, number, _ in rows])
        tools = [section.blocks[int(number) - section.first].tool.pose for number in numbers]
        places = np.array([tool_at(self.machine, row, tool) for row, tool in zip(q, tools, strict=True)])
        t = np.arange(len(q), dtype=np.float64) * self.period
        assert part.tried is not None
        way = BeltWay(part.tried.facts.name, part.tried.facts.data.unit, t, np.array([value for _, _, value in rows]))
        return Trace(t, q, places, numbers, self.period, (), ((int(numbers[-1]), float(t[-1])),), (way,))


def played(path: FilePath, start: Sequence[float], period: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """MOVE_FILE on the grid of the page, from the present axis positions: (n,) s and (n, axes)."""
    t = np.arange(math.ceil(path.duration / period) + 1, dtype=np.float64) * period
    return t, path.begun_at(start).at(np.minimum(t, path.duration))


class _PartRun:
    """One part: its belt, its stepper, and the planner's path of its blocks."""

    def __init__(self, dry_run: DryRun, section: Section, part: Coming, start: Sequence[float]) -> None:
        assert part.tried is not None
        self._dry_run, self._section, self._part, self._start = dry_run, section, part, tuple(start)
        self._plan = part.again(dry_run.machine, self._start)
        own, place = part.tried.facts, part.tried.belt
        now = (own if n == place else each for n, each in enumerate(dry_run.belts))  # as statements of belts have set it
        facts = [self._even(each, speed) for each, speed in zip(now, dry_run.speeds, strict=True)]
        self._belts = CoreBelts(facts, {self._plan.kinematic: dry_run.machine.kinematics}, dry_run.machine.limits, dry_run.period)
        self._stepper = Stepper(len(self._start), dry_run.period, self._start)
        self._inputs = InputImage()
        set_bit(self._inputs.values, SIMULATION, True)
        self._inputs.quality[SIMULATION >> 3] = int(Quality.GOOD)
        self._begins: dict[int, float] = {}
        self._planner: Planner | None = None
        self._machine = dry_run.machine
        self._steps: deque[BeltAct | list[Block]] = deque()  # SYNC, and paths, to come
        self._last = section.first - 1  # last block with a planned path

    def _even(self, facts: BeltFacts, speed: float) -> BeltFacts:
        """Simulated at this speed."""
        return replace(facts, data=replace(facts.data, simulated=from_si(speed, facts.data.unit)))

    def rows(self) -> Iterator[tuple[tuple[float, ...], int, float]]:
        """Set values, block and belt value of each period."""
        belts, plan = self._belts, self._plan
        for block in self._section.blocks:
            plan.add(block)  # also finds where a part of type 1 without at= is meant to begin
        speed = self._dry_run.speeds[plan.belt]
        at = plan.synchron.at if plan.synchron.at is not None else plan.reference
        belts.all.all[plan.belt].set_counter((0.0 if math.isnan(at) else at) - LEAD_S * speed)
        belts.set_override(1.0)
        if plan.synchron.at is None:
            for _ in range(round(LEAD_S / self._dry_run.period)):
                belts.step(self._stepper, self._inputs)  # the order comes when the belt is there
        belts.synchron(replace(plan.order, tolerance=plan.order.tolerance * self._dry_run.tolerance_cycles), self._start)
        for made in plan.blocks:
            belts.add(made)
        for _ in range(round(MOST_S / self._dry_run.period)):
            sample = belts.step(self._stepper, self._inputs)
            if belts.fault is not None:
                raise self._belt_fault(belts.fault)
            if belts.engaged_now:
                self._load(belts.value)
            elif self._planner is not None and self._stepper.state is State.IDLE:
                self._go_on(self._planner.position)
            yield sample.q, self._number(sample.piece_id), belts.shown.counter
            if self._over():
                return
        raise BlockError(f"belt {plan.facts.name} does not bring the part to its end within {MOST_S:g} s", block=self._section.first)

    def _load(self, engaged: float) -> None:
        """The path of a type 1, seen from the belt it has got onto."""
        self._machine, start, blocks = self._part.carried(self._part.again(self._dry_run.machine, self._start), engaged)
        path: list[Block] = []
        self._steps.append(path)
        for block in blocks:
            for act in inside(block):
                self._steps += (act, path := [])
            path.append(block)
        self._go_on(start)

    def _go_on(self, position: Sequence[float]) -> None:
        """At rest: continue with the next SYNC, or with the path after one that was met."""
        belts, part = self._belts, self._plan
        if not self._steps or (belts.awaits and not belts.met(self._inputs)):
            return
        step = self._steps.popleft()
        if isinstance(step, list):
            self._run(position, step)
        elif (order := act_order(step, belts.facts, self._last + 1, part.synchron)) is not None:
            belts.act(order)

    def _run(self, start: Sequence[float], blocks: Sequence[Block]) -> None:
        first = self._planner.next_id if self._planner is not None else 1
        planner = self._planner = Planner(self._machine, start, capacity=len(blocks) + 1, next_id=first, ahead_s=math.inf)
        before, self._last = self._last, self._last + len(blocks)
        self._begins.clear()
        at = 0.0
        try:
            for block in blocks:
                planner.add(block)
            planner.finish()
            while pieces := planner.plan(0.0, hurry=True):
                for piece in pieces:
                    at = self._begins[piece.id] if piece.new_tail else at
                    self._begins[piece.id] = at
                    at += piece.duration
                    self._belts.load(piece)
        except BlockError as error:
            raise later_fault(error, before) from error

    def _number(self, piece: int) -> int:
        """Block of the program that is under way."""
        if self._plan.facts.kind is not Type.PARALLEL:
            return min(max(self._belts.block, self._section.first), self._section.first + len(self._section.blocks) - 1)
        if self._planner is None or piece not in self._begins:
            return max(self._last, self._section.first)
        return self._last - self._planner.added + max(self._planner.place(self._begins[piece])[0], 1)

    def _over(self) -> bool:
        """Types 2 and 3: at the last point; type 1: its path is run, and the robot is at rest next to the belt."""
        if self._plan.facts.kind is not Type.PARALLEL:
            return self._belts.done
        waits = self._planner is None or bool(self._steps) or self._belts.awaits
        return not waits and self._stepper.state is State.IDLE and self._belts.release()

    def _belt_fault(self, fault: BeltFault) -> BlockError:
        axis = self._dry_run.machine.limits[fault.axis - 1].name if fault.axis else ""
        number = self._belts.block or self._section.first
        source = "axisgate" if fault.code in OURS else "rho 3"
        return BlockError(belt_words(fault.code, 0, "").partition(" (")[0], code=fault.code, block=number, axis=axis, source=source)
