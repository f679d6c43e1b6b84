"""Motion programs: where one leaves reach or limits (check), what it does (plot), before anything moves; and a run of one (run)."""

import argparse
import json
import pathlib
import sys

import numpy as np

from gateway.commands.motion_run import main as run
from gateway.errors import Exit
from gateway.files import ConfigNotFound, find_config, read_text
from gateway.motionplot import page
from gateway.robotfile import RobotFaults, load_robot
from motion.errors import MotionError
from motion.planner.robot import Machine, machine_of
from motion.planner.trace import Findings, Trace, route_of, trace
from motion.program.blocks import Program
from motion.program.errors import BlockError, TextFaults
from motion.program.text import read

EXAMPLES = """examples:
  axisgate motion check arm-u-cycle                         every block that cannot be run, with number, line and axis
  axisgate motion plot scara-pick-and-place                 writes scara-pick-and-place.html: path, speeds, loads, corners
  axisgate motion check mine.txt --robot tx60-like --json   another robot than the program names; findings as JSON
  axisgate motion run scara 1 --sim                         program 1 of a cell, on its emulated drives (motion run -h)
PROGRAM is a file, or the name of a shipped one (configs/programs); the text form is told in docs/guide/motion-programs.md.
exit code: 0 can be run, 1 a finding, 2 the program, its text or the robot is invalid"""


def main(argv: list[str]) -> int:
    if argv[:1] == ["run"]:
        return run(argv[1:])
    parser = argparse.ArgumentParser(
        "axisgate motion", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=["check", "plot"])
    parser.add_argument("program", metavar="PROGRAM")
    parser.add_argument("--robot", metavar="ROBOT", help="robot file, or the name of a shipped one; default: the one the program names")
    parser.add_argument("--out", metavar="FILE", help="plot: the page to write (default: NAME.html here)")
    parser.add_argument("--json", action="store_true", help="findings and figures as JSON on standard output")
    options = parser.parse_args(argv)
    try:
        program, machine = load(options.program, options.robot)
    except (ConfigNotFound, OSError, UnicodeDecodeError, RobotFaults) as error:
        return refuse(error)
    except TextFaults as faults:
        for fault in faults.faults:
            print(f"{options.program}: {fault}", file=sys.stderr)
        return Exit.INVALID
    except MotionError as error:
        return refuse(error)
    findings = route_of(program, machine)
    if options.what == "check" or findings.faults:
        return check(program, findings, options.json)
    return plot(program, machine, trace(findings.stretches, machine), options)


def refuse(error: Exception) -> int:
    """Said in one line."""
    print(f"axisgate motion: {error}", file=sys.stderr)
    return Exit.INVALID


def load(name: str, robot: str | None) -> tuple[Program, Machine]:
    """The program and the robot it is for."""
    program = read(read_text(find_config(name, "programs")))
    machine = machine_of(load_robot(robot or program.robot))
    if len(program.start) != machine.axes:
        raise MotionError(f"start has {len(program.start)} values, robot {robot or program.robot} has {machine.axes} axes")
    return program, machine


def check(program: Program, findings: Findings, as_json: bool) -> int:
    """Findings, one a line."""
    if as_json:
        print(json.dumps([_record(program, fault) for fault in findings.faults], indent=1))
    else:
        for fault in findings.faults:
            print(f"line {_line(program, fault)}: {fault}")
        count = len(findings.faults)
        print(f"{len(program.blocks)} blocks: " + ("all can be run" if not count else f"{count} cannot be run"))
    return Exit.FINDING if findings.faults else Exit.OK


def _line(program: Program, fault: BlockError) -> int:
    return program.blocks[fault.block - 1].line if 1 <= fault.block <= len(program.blocks) else 0


def _record(program: Program, fault: BlockError) -> dict[str, object]:
    return {
        "block": fault.block,
        "line": _line(program, fault),
        "axis": fault.axis,
        "code": fault.code,
        "source": fault.source,
        "text": fault.what,
    }


def plot(program: Program, machine: Machine, made: Trace, options: argparse.Namespace) -> int:
    """The page, and what it shows in a few numbers."""
    target = pathlib.Path(options.out or f"{pathlib.Path(options.program).stem}.html")
    target.write_text(page(program, machine, made))
    tops = {name: float(np.max(made.loads(machine, order))) for order, name in ((1, "speed"), (2, "acceleration"), (3, "jerk"))}
    if options.json:
        corners = [{"block": c.block, "missed_mm": round(c.missed * 1e3, 4)} for c in made.corners]
        print(json.dumps({"page": str(target), "seconds": round(float(made.t[-1]), 4), "loads": tops, "corners": corners}, indent=1))
    else:
        loads = ", ".join(f"{name} {100 * value:.1f} %" for name, value in tops.items())
        print(f"{target}: {made.t[-1]:.3f} s; largest loads of the axes: {loads}")
    return Exit.OK
