"""A program of several kinematics on paper: what of it cannot be run, and what each kinematic does."""

from motion.planner.team import Team, own_parts, worst
from motion.planner.teamroute import TeamRoute
from motion.planner.trace import PERIOD_S, Findings, Trace, numbered, sampled, seen
from motion.planner.watched import Slowed
from motion.program.errors import BlockError
from motion.program.systems import located
from motion.program.team import TeamProgram


def team_findings(program: TeamProgram, team: Team) -> Findings:
    """All blocks, each looked at from where the last good one ended; nothing moved."""
    route, faults = TeamRoute(team, program.start), []
    for number, shared in enumerate(program.blocks, 1):
        try:
            route.add(shared.changed(lambda n, block: located(block, team.machines[n].corrects)))
        except BlockError as error:
            faults.append(numbered(error, number))
    try:
        route.finish()
    except BlockError as error:
        faults.append(error)
    return Findings(() if faults else tuple(route.take()), tuple(faults))


def team_slowed(findings: Findings) -> dict[int, Slowed]:
    """Blocks in which an axis cannot keep the programmed speed."""
    return worst((stretch.block, stretch) for stretch in findings.stretches)


def team_traces(findings: Findings, team: Team, period: float = PERIOD_S) -> list[Trace]:
    """One for each kinematic, all over the same time; MotionError where a path cannot be run at all."""
    rows, q, blocks, ends = sampled(findings.stretches, team, period=period)
    traces = []
    for n, (first, behind) in enumerate(zip(team.firsts, team.firsts[1:], strict=False)):
        own = [[part for stretch in row for at, part in own_parts(stretch) if at == n] for row in rows]
        every = [part for row in own for part in row]
        traces.append(seen(own, every, team.machines[n], q[:, first:behind], blocks, ends, period))
    return traces
