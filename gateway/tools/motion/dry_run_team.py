"""Dry run of a program of several kinematics: finds blocks that cannot be executed, computes each kinematic."""

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gateway.pure.planning.parts import acting, later_fault
from gateway.pure.planning.trial import Files
from gateway.tools.motion.dry_run import NO_FILES, DryRun, Section, played, sections_of
from motion.files.playing import FilePath
from motion.kinematics.base import Joints
from motion.planner.duration_check import too_long
from motion.planner.path_checks import Slowed
from motion.planner.stretch import Stretch
from motion.planner.team import Team, TeamStretch, own_parts, worst
from motion.planner.team_route import TeamRoute
from motion.planner.trace import PERIOD_S, Trace, joined, numbered, sampled, seen
from motion.program.blocks import Block, MachinePoint, Program
from motion.program.errors import BlockError
from motion.program.systems import located
from motion.program.team import Shared, TeamProgram
from motion.sync.facts import BeltFacts

SAME = 1e-9  # m or rad


@dataclass(frozen=True)
class CellFacts:
    """Facts of the cell in which a program is checked.  numbers: of its kinematics in the cell; altered: numbers of those that have a
    correction, None: no cell was named; speeds, p5_ms: as in gateway.tools.motion.dry_run.DryRun."""

    belts: Sequence[BeltFacts] = ()
    numbers: Sequence[int] = ()
    altered: Container[int] | None = None
    speeds: Sequence[float] = ()
    p5_ms: int = 1

    def number(self, member: int) -> int:
        """Number of a kinematic of the program, from 0, in its cell."""
        return self.numbers[member] if self.numbers else member + 1

    def option(self, member: int) -> bool:
        """Whether it may be corrected, as far as that is known."""
        return self.altered is None or self.number(member) in self.altered


NO_CELL = CellFacts()


@dataclass
class TeamSection:
    """Blocks in a row without a change of numbers, one MOVE_FILE, or parts of one kinematic.  first: number of the first; before: blocks of
    the program, less those of the route, before it; `start`: (all axes,) where they begin; placed: kinematics whose axes got other places
    before it (SF 3).
    """

    first: int
    before: int
    start: Joints
    placed: frozenset[int] = frozenset()
    blocks: list[Shared] = field(default_factory=list)
    stretches: list[Stretch] = field(default_factory=list)
    filed: tuple[int, FilePath] | None = None  # whose way is a file's
    alone: int | None = None  # who is on belts or corrected, from 0
    parts: list[Section] = field(default_factory=list)  # of that one
    belts: Sequence[BeltFacts] = ()  # as statements before it have set them


@dataclass(frozen=True)
class TeamFindings:
    """sections: none where there are faults; faults: of every block, each looked at from where the last good one ended."""

    sections: tuple[TeamSection, ...]
    faults: tuple[BlockError, ...]


class _Looked:
    """Sections checked so far."""

    def __init__(self, team: Team, start: Sequence[float], files: Files, cell_facts: CellFacts) -> None:
        self.team, self.faults, self.files, self.cell_facts = team, list[BlockError](), files, cell_facts
        self.belts = cell_facts.belts
        self.section = TeamSection(1, 0, tuple(start))
        self.sections = [self.section]
        self.route = TeamRoute(team, start)
        self.own: list[Block] = []  # of the section of one kinematic

    def finish(self) -> None:
        """The section ends at rest."""
        if self.section.alone is not None:
            self._finish_alone(self.section, self.section.alone)
            return
        try:
            self.route.finish()
        except BlockError as error:
            self.faults.append(numbered(error, error.block + self.section.before))
        self.section.stretches += self.route.take()

    def _finish_alone(self, section: TeamSection, member: int) -> None:
        """Its blocks, as a program of this robot."""
        program = Program("", "", self.team.split(section.start)[member], tuple(self.own))
        machine, cell_facts = self.team.machines[member], self.cell_facts
        found = sections_of(
            program, machine, section.belts, option=cell_facts.option(member), kinematic=cell_facts.number(member), files=self.files
        )
        section.parts, faults = found
        self.faults += [numbered(self.team.with_kinematic(fault, member), fault.block + section.first - 1) for fault in faults]
        ends = section.parts[-1].ends if section.parts else program.start
        self.route.reset(self.team.placed(section.start, member, ends))
        self.own = []

    def begin(self, number: int, start: Joints, placed: frozenset[int]) -> None:
        """Begin another section after a finished one."""
        self.section = TeamSection(number, number - 1 - self.route.added, start, placed, belts=self.belts)
        self.sections.append(self.section)
        self.route.reset(start)

    def look(self, shared: Shared, number: int) -> None:
        """One block; BlockError."""
        before = self.belts
        parts, self.belts = acting(shared.acts, number, before, "", self.team)
        placed = [part for part in parts if part.point]
        alone = shared.alone[0] if shared.alone is not None else None
        another = self.section.alone != alone or self.section.filed is not None or shared.filed is not None
        if placed or another:
            self.finish()
            start = self.route.position
            for part in placed:
                start = self.team.placed(start, part.member, part.point)
            self.begin(number, start, frozenset(part.member for part in placed))
            self.section.alone, self.section.belts = alone, before
        if shared.filed is not None:
            self._file(number, *shared.filed)
        elif alone is not None:
            own = shared.moves[alone]
            assert own is not None
            acts = (act for act in shared.acts if not isinstance(act, MachinePoint))
            self.own.append(replace(own, acts=(*acts, *own.acts)))
        else:
            located_too = shared.changed(lambda n, block: located(block, self.team.machines[n].corrects))
            self.route.add(replace(located_too, acts=()))
            self.section.blocks.append(located_too)

    def _file(self, number: int, member: int, block: Block) -> None:
        """The section is a MOVE_FILE of one kinematic; BlockError."""
        start = self.route.position
        path = self.files.path(block, 0, start, self.team, number, member)[1]
        self.section.filed = member, path
        self.route.reset(self.team.placed(start, member, path.end))


def team_findings(program: TeamProgram, team: Team, files: Files = NO_FILES, cell_facts: CellFacts = NO_CELL) -> TeamFindings:
    """All blocks; nothing moved."""
    looked = _Looked(team, program.start, files, cell_facts)
    for number, shared in enumerate(program.blocks, 1):
        try:
            looked.look(shared, number)
        except BlockError as error:
            looked.faults.append(numbered(error, number))
    looked.finish()
    try:
        acting(program.acts, len(program.blocks), looked.belts, "", team)
    except BlockError as error:
        looked.faults.append(error)
    if not looked.faults:
        long = ((section, fault) for section in looked.sections for fault in too_long(section.stretches, team))
        looked.faults += [numbered(fault, fault.block + section.before) for section, fault in long]
    faults = sorted(looked.faults, key=lambda fault: fault.block)
    return TeamFindings(() if faults else tuple(looked.sections), tuple(faults))


def team_slowed(findings: TeamFindings) -> dict[int, Slowed]:
    """Blocks in which an axis cannot keep the programmed speed."""
    return worst((stretch.block + each.before, stretch) for each in findings.sections for stretch in each.stretches)


def team_traces(findings: TeamFindings, team: Team, cell_facts: CellFacts = NO_CELL, period: float = PERIOD_S) -> list[Trace]:
    """One for each kinematic, all over the same time; each section begins where the one before really ended.  MotionError where a path
    cannot be run at all, BlockError where a part on a belt cannot go on."""
    start, rows = findings.sections[0].start, []
    for section in findings.sections:
        for member in section.placed:
            start = team.placed(start, member, team.split(section.start)[member])
        own = list(_traced(section, team, start, cell_facts, period))
        rows.append(own)
        start = tuple(float(value) for made in own for value in made.q[-1])
    return [joined(each) for each in zip(*rows, strict=True)]


def _traced(section: TeamSection, team: Team, start: Joints, cell_facts: CellFacts, period: float) -> Iterator[Trace]:
    """Traces of each kinematic in a section."""
    if section.alone is not None:
        yield from _alone(section, section.alone, team, start, cell_facts, period)
        return
    stretches = section.stretches
    if section.blocks and not np.allclose(start, section.start, rtol=0.0, atol=SAME):
        stretches = _again(section, team, start)
    rows, q, blocks, ends = sampled(stretches, team, period=period, start=start)
    if section.filed is not None:
        member, path = section.filed
        q = _filed(team.split(start), member, path, period)
        blocks, ends = [section.first - section.before] * len(q), [(section.first - section.before, path.duration)]
    elif not stretches:  # blocks without way
        blocks = [section.first - section.before]
    for n, (first, behind) in enumerate(zip(team.firsts, team.firsts[1:], strict=False)):
        own = [[part for stretch in row for at, part in own_parts(stretch) if at == n] for row in rows]
        every = [part for row in own for part in row]
        made = seen(own, every, team.machines[n], q[:, first:behind], blocks, ends, period).later(section.before)
        yield replace(made, cuts=(0,)) if n in section.placed else made


def _again(section: TeamSection, team: Team, start: Joints) -> list[Stretch]:
    """Its path from where a part on a belt really ended, its blocks under the numbers that they had."""
    route = TeamRoute(team, start)
    try:
        for shared in section.blocks:
            route.add(replace(shared, acts=()))
        route.finish()
    except BlockError as error:
        raise later_fault(error, section.first - 1) from error
    found = list(route.take())
    first = section.first - section.before - 1
    return [_numbered(stretch, first) for stretch in found]


def _numbered(stretch: Stretch, blocks: int) -> Stretch:
    """Shifted by so many blocks."""
    if isinstance(stretch, TeamStretch):
        parts = tuple((n, _numbered(own, blocks)) for n, own in stretch.parts)
        return replace(stretch, block=stretch.block + blocks, parts=parts)
    return replace(stretch, block=stretch.block + blocks)


def _alone(section: TeamSection, member: int, team: Team, start: Joints, cell_facts: CellFacts, period: float) -> Iterator[Trace]:
    """One on its belt, or corrected; the others are at rest."""
    begun = replace(section.parts[0], start=team.split(start)[member])
    try:
        run = DryRun(team.machines[member], section.belts, cell_facts.speeds, cell_facts.p5_ms, period)
        made = run.run([begun, *section.parts[1:]]).later(section.first - 1)
    except BlockError as error:
        raise team.with_kinematic(later_fault(error, section.first - 1), member) from error
    for n, places in enumerate(team.split(start)):
        if n == member:
            yield replace(made, cuts=(*made.cuts, 0)) if n in section.placed else made
        else:
            q = np.tile(places, (len(made.t), 1))
            resting = seen((), (), team.machines[n], q, made.block.tolist(), (), period)
            yield replace(resting, cuts=(0,)) if n in section.placed else resting


def _filed(start: Sequence[Joints], member: int, path: FilePath, period: float) -> NDArray[np.float64]:
    """(n, all axes) while one runs its file and the others are at standstill."""
    way = played(path, start[member], period)[1]
    return np.concatenate([way if n == member else np.tile(own, (len(way), 1)) for n, own in enumerate(start)], axis=1)
