"""Check a motion program (check), plot its path and loads (plot), or run it in a cell (run, stream)."""

import argparse
import json
import pathlib
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gateway.assembly.alter import altered
from gateway.assembly.belts import belt_facts
from gateway.assembly.programs import bnr_files, machine_of_cell, numbers_by_axis, robot_meant, team_meant
from gateway.commands.motion_run import main as run
from gateway.commands.motion_stream import main as stream
from gateway.files.find import ConfigNotFound, find_config, read_text
from gateway.files.robots import RobotFaults, load_robot
from gateway.pure.cell.cell import Cell
from gateway.pure.planning.trial import Files
from gateway.runtime.exit_codes import Exit
from gateway.tools.cell_argument import load as cell_of
from gateway.tools.motion.dry_run import DryRun, sections_of
from gateway.tools.motion.dry_run_team import CellFacts, team_findings, team_slowed, team_traces
from gateway.tools.motion.plot import page, team_page
from gateway.tools.progress import Progress
from gateway.tools.usage_language import complain
from motion.errors import MotionError
from motion.geometry.units import to_si
from motion.planner.path_checks import Slowed
from motion.planner.robot import Machine, machine_of
from motion.planner.team import Team, called, team_of
from motion.planner.trace import Trace
from motion.program.blocks import Block, MachinePoint, Program
from motion.program.errors import BlockError, TextFaults
from motion.program.team import TeamProgram
from motion.program.text.reader import read
from motion.program.text.team import read_team, several
from motion.robot import Installation
from motion.sync.facts import BeltFacts

BELTS_OF_A_CELL = "sync and belt functions need the belts of a cell: name it with --cell CELL"
EXAMPLES = """examples:
  axisgate motion check arm-u-cycle                         every block that cannot be executed, with number, line and axis
  axisgate motion plot scara-pick-and-place                 writes scara-pick-and-place.html: path, speeds, loads, corners
  axisgate motion check mine.txt --robot tx60-like --json   another robot than the program names; findings as JSON
  axisgate motion plot pick.txt --cell portal --belt-speed 150   in a cell: its limits, blocks on its belts at 150 mm/s
  axisgate motion run scara 1 --sim                         program 1 of a cell, on its emulated drives (motion run -h)
  axisgate motion stream scara moves.txt --sim              statements that move as they arrive (motion stream -h)
PROGRAM is a file, or the name of a shipped one (configs/programs); the text form is described in docs/guide/motion-programs.md.
exit code: 0 can be run, 1 a finding, 2 the program, its text or the robot is invalid"""


def main(argv: list[str]) -> int:
    if argv[:1] in (["run"], ["stream"]):
        return (run if argv[0] == "run" else stream)(argv[1:])
    parser = argparse.ArgumentParser(
        "axisgate motion", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=["check", "plot"])
    parser.add_argument("program", metavar="PROGRAM")
    parser.add_argument("--robot", metavar="ROBOT", help="robot file, or the name of a shipped one (default: named in the program)")
    parser.add_argument("--cell", metavar="CELL", help="cell with the robot, the limits of its axes, and its belts")
    parser.add_argument("--belt-speed", metavar="SPEED", type=float, help="plot: mm/s or deg/s of every belt (default: P508 of each)")
    parser.add_argument("--out", metavar="FILE", help="plot: the page to write (default: NAME.html here)")
    parser.add_argument("--json", action="store_true", help="findings and figures as JSON on standard output")
    options = parser.parse_args(argv)
    if options.robot and options.cell:
        parser.error("--robot and --cell: a cell has its own robot")
    cell = cell_of(options.cell) if options.cell else None
    if isinstance(cell, int):
        return cell
    try:
        text = read_text(find_config(options.program, "programs"))
        if several(text):
            return team(text, options, cell)
        program, machine, belts = load(text, options.robot, cell)
    except (ConfigNotFound, OSError, UnicodeDecodeError, RobotFaults) as error:
        return refuse(error)
    except TextFaults as error:
        for fault in error.faults:
            print(f"{options.program}: {fault}", file=sys.stderr)
        return Exit.INVALID
    except MotionError as error:
        return refuse(error)
    files = files_of(options.program, program.blocks, cell)
    slowed: dict[int, Slowed] = {}
    with Progress("blocks", len(program.blocks)) as said:
        number = 1 if cell is None else numbers_by_axis(cell).get(machine.limits[0].name, 1)
        option = cell is None or number in altered(cell)
        found = sections_of(program, machine, belts.facts, option=option, kinematic=number, files=files, said=said, slowed=slowed)
    sections, faults = found
    if options.what == "check" or faults:
        return check(program, faults, slowed, as_json=options.json)
    try:
        with Progress("motion", len(program.blocks)) as said:
            made = DryRun(machine, belts.facts, belts.speeds(options.belt_speed), belts.p5_ms).run(sections, said)
    except BlockError as error:  # the belt runs on while the robot works: not all of it can be known before
        return check(program, [error], slowed, as_json=options.json)
    except MotionError as error:
        return refuse(error)
    return plot(program, machine, made, options)


def files_of(path: str, blocks: Sequence[Block], cell: Cell | None) -> Files:
    """The BNR files that a program names, next to it."""
    found = bnr_files(str(find_config(path, "programs")), blocks)

    def read(name: str, number: int) -> bytes:
        data = found[name]
        if isinstance(data, MotionError):
            raise data
        return data

    return Files(read, 0 if cell is None else 1000 * cell.cycle_ms)


def refuse(error: Exception) -> int:
    """Report in one line."""
    complain("motion", error)
    return Exit.INVALID


@dataclass(frozen=True)
class Belts:
    """Belts of the cell in which the program is checked.  p5_ms: periods of the page in an interpolation cycle."""

    facts: tuple[BeltFacts, ...] = ()
    p5_ms: int = 1

    def speeds(self, given: float | None) -> tuple[float, ...]:
        """m or rad per s: one value for all, or each belt's own P508.  MotionError if a belt has none."""
        for belt in self.facts:
            if given is None and not belt.data.simulated:
                raise MotionError(f"belt {belt.name} has no speed of its own (simulated = ..): give one with --belt-speed")
        return tuple(to_si(belt.data.simulated if given is None else given, belt.data.unit) for belt in self.facts)


def team(text: str, options: argparse.Namespace, cell: Cell | None) -> int:
    """A program of several kinematics."""
    if options.robot:
        raise MotionError("the program names the robot of each kinematic: --robot is for programs of one robot")
    program = read_team(text)
    machines = team_of_program(program, cell)
    blocks = [block for shared in program.blocks for block in shared.own]
    cell_facts = cell_facts_of(program, machines, cell)
    findings = team_findings(program, machines, files_of(options.program, blocks, cell), cell_facts)
    if options.what == "check" or findings.faults:
        return check(program, findings.faults, team_slowed(findings), as_json=options.json)
    try:
        speeds = Belts(tuple(cell_facts.belts)).speeds(options.belt_speed) if any(each.parts for each in findings.sections) else ()
        traces = team_traces(findings, machines, replace(cell_facts, speeds=speeds))
    except BlockError as error:
        return check(program, [error], team_slowed(findings), as_json=options.json)
    target = pathlib.Path(options.out or f"{pathlib.Path(options.program).stem}.html")
    target.write_text(team_page(program, machines, traces))
    rows = [
        (each.name, _tops(machine, made), made) for each, machine, made in zip(program.kinematics, machines.machines, traces, strict=True)
    ]
    seconds = float(traces[0].t[-1])
    if options.json:
        kinematics = {name: {"loads": tops, "corners": _corners(made)} for name, tops, made in rows}
        print(json.dumps({"page": str(target), "seconds": round(seconds, 4), "kinematics": kinematics}, indent=1))
    else:
        print(f"{target}: {seconds:.3f} s")
        for name, tops, _ in rows:
            print(f"  {name}: largest loads of the axes: {_loads(tops)}")
    return Exit.OK


def cell_facts_of(program: TeamProgram, machines: Team, cell: Cell | None) -> CellFacts:
    """Facts of the cell in which the program is checked; MotionError if it names belts and no cell was named."""
    if cell is not None:
        numbers = numbers_by_axis(cell)
        own = [numbers.get(machine.limits[0].name, 1) for machine in machines.machines]
        return CellFacts(belt_facts(cell), own, altered(cell), p5_ms=cell.cycle_ms)
    _need_no_belts(block for shared in program.blocks for block in shared.own)
    acts = (*program.acts, *(act for shared in program.blocks for act in shared.acts))
    if any(not isinstance(act, MachinePoint) for act in acts):
        raise MotionError(BELTS_OF_A_CELL)
    return CellFacts()


def _need_no_belts(blocks: Iterable[Block]) -> None:
    for block in blocks:
        if block.synchron is not None:
            raise MotionError(f"line {block.line}: belt {block.synchron.belt} belongs to a cell: name it with --cell CELL")


def team_of_program(program: TeamProgram, cell: Cell | None) -> Team:
    """The robots its kinematics name, of a cell with the limits of its axes."""
    if cell is not None:
        made = team_meant(cell, program.kinematics)
    else:
        made = team_of(Installation(tuple(called(each.name, load_robot(each.robot)) for each in program.kinematics)))
    for each, machine in zip(program.kinematics, made.machines, strict=True):
        if len(each.start) != machine.axes:
            raise MotionError(f"kinematic {each.name}: start has {len(each.start)} values, its robot has {machine.axes} axes")
    return made


def load(text: str, robot: str | None, cell: Cell | None) -> tuple[Program, Machine, Belts]:
    """The program, the robot it is for, and the belts its blocks may lie on."""
    program, belts = read(text), Belts()
    if cell is None:
        if not (robot or program.robot):
            raise MotionError("the program names no robot: `robot NAME` in it, or --robot NAME, or --cell CELL")
        machine = machine_of(load_robot(robot or program.robot))
        _need_no_belts(program.blocks)
        if program.acts or any(block.acts for block in program.blocks):
            raise MotionError(BELTS_OF_A_CELL)
    else:
        machine, belts = _robot_in(cell, program), Belts(belt_facts(cell), cell.cycle_ms)
    if len(program.start) != machine.axes:
        raise MotionError(f"start has {len(program.start)} values, its robot has {machine.axes} axes")
    return program, machine, belts


def _robot_in(cell: Cell, program: Program) -> Machine:
    """The cell's robot; of several the one the program names."""
    return robot_meant(cell, program.robot) if len(cell.robot) > 1 else machine_of_cell(cell)


def check(program: Program | TeamProgram, faults: Sequence[BlockError], slowed: Mapping[int, Slowed], *, as_json: bool) -> int:
    """Findings, one a line; slowed: blocks that are run, but not as fast as programmed (too_fast = 3)."""
    if as_json:
        warnings = [
            _record(program, BlockError(each.words, block=number, axis=each.axis, source="rho 3")) for number, each in slowed.items()
        ]
        print(json.dumps([_record(program, fault) for fault in faults] + [row | {"warning": True} for row in warnings], indent=1))
    else:
        for fault in faults:
            print(f"line {_line(program, fault.block)}: {fault}")
        for number, each in slowed.items():
            print(f"line {_line(program, number)}: warning: {each.of(number)}")
        count, blocks = len(faults), len(program.blocks)
        print(f"{blocks} block{'s' * (blocks != 1)}: " + ("all can be run" if not count else f"{count} cannot be run"))
    return Exit.FINDING if faults else Exit.OK


def _line(program: Program | TeamProgram, block: int) -> int:
    return program.blocks[block - 1].line if 1 <= block <= len(program.blocks) else 0


def _record(program: Program | TeamProgram, fault: BlockError) -> dict[str, object]:
    return {
        "block": fault.block,
        "line": _line(program, fault.block),
        "warning": False,
        "axis": fault.axis,
        "code": fault.code,
        "source": fault.source,
        "text": fault.what,
    }


def plot(program: Program, machine: Machine, made: Trace, options: argparse.Namespace) -> int:
    """The page, and its content in a few numbers."""
    target = pathlib.Path(options.out or f"{pathlib.Path(options.program).stem}.html")
    target.write_text(page(program, machine, made))
    tops = _tops(machine, made)
    if options.json:
        result = {"page": str(target), "seconds": round(float(made.t[-1]), 4), "loads": tops, "corners": _corners(made)}
        print(json.dumps(result, indent=1))
    else:
        print(f"{target}: {made.t[-1]:.3f} s; largest loads of the axes: {_loads(tops)}")
    return Exit.OK


def _tops(machine: Machine, made: Trace) -> dict[str, float]:
    return {name: float(np.max(made.loads(machine, order))) for order, name in ((1, "speed"), (2, "acceleration"), (3, "jerk"))}


def _loads(tops: dict[str, float]) -> str:
    return ", ".join(f"{name} {100 * value:.1f} %" for name, value in tops.items())


def _corners(made: Trace) -> list[dict[str, float]]:
    return [{"block": corner.block, "missed_mm": round(corner.missed * 1e3, 4)} for corner in made.corners]
