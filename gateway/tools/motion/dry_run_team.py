"""Dry run of a program of several kinematics: finds blocks that cannot be executed, computes each kinematic."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gateway.pure.planning.parts import acting
from gateway.pure.planning.trial import Files
from gateway.tools.motion.dry_run import NO_FILES, played
from motion.files.playing import FilePath
from motion.kinematics.base import Joints
from motion.planner.duration_check import too_long
from motion.planner.path_checks import Slowed
from motion.planner.route import Stretch
from motion.planner.team import Team, own_parts, worst
from motion.planner.team_route import TeamRoute
from motion.planner.trace import PERIOD_S, Trace, joined, numbered, sampled, seen
from motion.program.blocks import Block
from motion.program.errors import BlockError
from motion.program.systems import located
from motion.program.team import TeamProgram


@dataclass
class TeamSection:
    """Blocks in a row without a change of numbers, or one MOVE_FILE.  first: number of the first; before: blocks of the program, less
    those of the route, in front of it; `stands`: (all axes,) where they begin; placed: kinematics whose axes got other places before it
    (SF 3)."""

    first: int
    before: int
    stands: Joints
    placed: frozenset[int] = frozenset()
    stretches: list[Stretch] = field(default_factory=list)
    filed: tuple[int, FilePath] | None = None  # whose way is a file's


@dataclass(frozen=True)
class TeamFindings:
    """sections: none where there are faults; faults: of every block, each looked at from where the last good one ended."""

    sections: tuple[TeamSection, ...]
    faults: tuple[BlockError, ...]


class _Looked:
    """What has been looked at so far, section by section."""

    def __init__(self, team: Team, start: Sequence[float]) -> None:
        self.team, self.faults = team, list[BlockError]()
        self.section = TeamSection(1, 0, tuple(start))
        self.sections = [self.section]
        self.route = TeamRoute(team, start)

    def finish(self) -> None:
        """The section ends at rest."""
        try:
            self.route.finish()
        except BlockError as error:
            self.faults.append(numbered(error, error.block + self.section.before))
        self.section.stretches += self.route.take()

    def begin(self, number: int, stands: Joints, placed: frozenset[int]) -> None:
        """Another section, behind a finished one."""
        self.section = TeamSection(number, number - 1 - self.route.added, stands, placed)
        self.sections.append(self.section)
        self.route.reset(stands)

    def file(self, number: int, member: int, block: Block, files: Files) -> None:
        """The section is a MOVE_FILE of one kinematic; BlockError."""
        stands = self.route.standing
        path = files.path(block, 0, stands, self.team, number, member)[1]
        self.section.filed = member, path
        self.route.reset(self.team.placed(stands, member, path.end))


def team_findings(program: TeamProgram, team: Team, files: Files = NO_FILES) -> TeamFindings:
    """All blocks; nothing moved."""
    looked = _Looked(team, program.start)
    for number, shared in enumerate(program.blocks, 1):
        try:
            parts, _ = acting(shared.acts, number, (), "", team)
            if parts or shared.filed is not None or looked.section.filed is not None:
                looked.finish()
                stands = looked.route.standing
                for part in parts:
                    stands = team.placed(stands, part.member, part.point)
                looked.begin(number, stands, frozenset(part.member for part in parts))
            if shared.filed is not None:
                looked.file(number, *shared.filed, files)
                continue
            looked.route.add(shared.changed(lambda n, block: located(block, team.machines[n].corrects)))
        except BlockError as error:
            looked.faults.append(numbered(error, number))
    looked.finish()
    try:
        acting(program.acts, len(program.blocks), (), "", team)
    except BlockError as error:
        looked.faults.append(error)
    if not looked.faults:
        long = ((section, fault) for section in looked.sections for fault in too_long(section.stretches, team))
        looked.faults += [numbered(fault, fault.block + section.before) for section, fault in long]
    return TeamFindings(() if looked.faults else tuple(looked.sections), tuple(looked.faults))


def team_slowed(findings: TeamFindings) -> dict[int, Slowed]:
    """Blocks in which an axis cannot keep the programmed speed."""
    return worst((stretch.block + each.before, stretch) for each in findings.sections for stretch in each.stretches)


def team_traces(findings: TeamFindings, team: Team, period: float = PERIOD_S) -> list[Trace]:
    """One for each kinematic, all over the same time; MotionError where a path cannot be run at all."""
    parts = [list(_traced(section, team, period)) for section in findings.sections]
    return [joined(each) for each in zip(*parts, strict=True)]


def _traced(section: TeamSection, team: Team, period: float) -> Iterator[Trace]:
    """Of each kinematic in a section."""
    rows, q, blocks, ends = sampled(section.stretches, team, period=period, stands=section.stands)
    if section.filed is not None:
        member, path = section.filed
        q = _filed(team.split(section.stands), member, path, period)
        blocks, ends = [section.first - section.before] * len(q), [(section.first - section.before, path.duration)]
    elif not section.stretches:  # blocks without way
        blocks = [section.first - section.before]
    for n, (first, behind) in enumerate(zip(team.firsts, team.firsts[1:], strict=False)):
        own = [[part for stretch in row for at, part in own_parts(stretch) if at == n] for row in rows]
        every = [part for row in own for part in row]
        made = seen(own, every, team.machines[n], q[:, first:behind], blocks, ends, period).later(section.before)
        yield replace(made, cuts=(0,)) if n in section.placed else made


def _filed(stands: Sequence[Joints], member: int, path: FilePath, period: float) -> NDArray[np.float64]:
    """(n, all axes) while one runs its file, and the others stand."""
    way = played(path, stands[member], period)[1]
    return np.concatenate([way if n == member else np.tile(own, (len(way), 1)) for n, own in enumerate(stands)], axis=1)
