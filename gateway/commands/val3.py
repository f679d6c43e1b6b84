"""VAL 3 applications: check files and programs, run them in virtual time, make a cell from a flash card."""

import argparse
import dataclasses
import json
import pathlib
import sys
from collections.abc import Callable

from gateway.cell_file.load import load_cell
from gateway.commands import val3_import
from gateway.files.find import ConfigNotFound
from gateway.files.robots import load_robot
from gateway.files.val3_disk import DiskUnreadable, place_of, read_disk
from gateway.files.val3_texts import val3_language, val3_texts
from gateway.pure.cell.faults import CellFaults
from gateway.pure.languages.val3.loader import Loader, family_of_arm
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.moves import Moves
from gateway.pure.languages.val3.sealed import SHORTEST_SECRET, public_of
from gateway.pure.languages.val3.virtual import Run, declare_links, summary
from gateway.pure.languages.val3.virtual_events import EventFault, event_of
from gateway.runtime.exit_codes import Exit
from gateway.tools.usage_language import complain, val3_fault_text, val3_text
from motion.errors import MotionError
from motion.robot import Robot

EXAMPLES = """examples:
  axisgate val3 check usrapp/cycle                         every fault of an application: file, line, text
  axisgate val3 check usrapp/cycle/cycle.pjx --json        the same as a JSON list
  axisgate val3 run usrapp/cycle --virtual --json          run it in virtual time; data, tasks, log and moves at the end
  axisgate val3 run usrapp/cycle --virtual --robot tx60-like --at 2 dio.start=1 --at 9 app=stop --until 20
  axisgate val3 password -                                 the VAL 3 password of a ZIP library, for libLoad
  axisgate val3 import /mnt/card --out cell4.toml          a cell from usr/configs and usr/usrapp of a flash card
WHAT of --at: dio.NAME, aio.NAME, mode, power, speed, estop, hold, app=stop, or a global: nCount, sPart[2], mSlow.vel.
exit code: 0 done, 1 faults found or a task ended in an error, 2 command line or files invalid"""
ROBOT = "tx60-like"
LONGEST_S = 86_400.0


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate val3", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    check = commands.add_parser("check", help="check an application: file and line of each fault")
    run = commands.add_parser(
        "run", help="run an application in virtual time", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EXAMPLES
    )
    for each in (check, run):
        each.add_argument("app", metavar="APP", help="folder of the application, or its .pjx file")
        each.add_argument("--disk", help="folder that is Disk:// (default: the folder above the application)")
        which = each.add_mutually_exclusive_group()
        which.add_argument("--robot", help=f"arm: a file of configs/robots or a path (default {ROBOT})")
        which.add_argument("--cell", help="cell whose robot is the arm")
        each.add_argument("--strict-priorities", action="store_true", help="apply the priority of each operator, as in the manual's tables")
        each.add_argument("--json", action="store_true", help="JSON on standard output")
    run.add_argument("--virtual", action="store_true", required=True, help="in virtual time, without processes")
    run.add_argument("--line-us", type=float, default=1.0, metavar="US", help="virtual time of a program line (default 1)")
    run.add_argument("--until", type=float, default=60.0, metavar="S", help="end of the run at the latest (default 60)")
    run.add_argument("--start", metavar="J1,J2,..", help="joints at the start in deg and mm (default: 0, inside the travel)")
    run.add_argument(
        "--at", nargs=2, action="append", default=[], metavar=("S", "WHAT=VALUE"), help="an event from outside; may be repeated"
    )
    val3_import.arguments(commands.add_parser("import", help="make a cell from a flash card: channels, inputs, outputs, application"))
    coded = commands.add_parser("password", help="print the VAL 3 password for libLoad, made from the password of a ZIP library")
    coded.add_argument("secret", metavar="SECRET", help="the password; - reads it from standard input")
    coded.add_argument("--json", action="store_true", help="JSON on standard output")
    options = parser.parse_args(argv)
    commands_by_name: dict[str, Callable[[argparse.Namespace], int]] = {
        "check": _check, "run": _run, "import": val3_import.run, "password": _password,
    }  # fmt: skip
    commanded = commands_by_name[options.command]
    try:
        return commanded(options)
    except (DiskUnreadable, EventFault, ConfigNotFound, CellFaults, MotionError, OSError) as error:
        complain("val3", error)
        return Exit.INVALID


def _password(options: argparse.Namespace) -> int:
    secret = sys.stdin.readline().rstrip("\n") if options.secret == "-" else options.secret
    if len(secret) < SHORTEST_SECRET:
        raise EventFault(f"the password of a ZIP library has {SHORTEST_SECRET} characters at least (VAL 3 reference 6.5)")
    public = public_of(secret)
    print(json.dumps({"password": public}) if options.json else public)
    return Exit.OK


def _robot(options: argparse.Namespace) -> Robot:
    if options.cell is None:
        return load_robot(options.robot or ROBOT)
    named = [robot.model for robot in load_cell(options.cell).robot if robot.model]
    if len(named) != 1:
        raise EventFault(
            f"--cell {options.cell}: a cell with one robot that names its model is expected, it has {len(named)}; give --robot"
        )
    return load_robot(named[0])


def _check(options: argparse.Namespace) -> int:
    root, folder, name = place_of(pathlib.Path(options.app), pathlib.Path(options.disk) if options.disk else None)
    axes = len(_robot(options).axes)
    loaded = Loader(read_disk(root), axes, family=family_of_arm(axes), strict=options.strict_priorities).load(folder, name)
    assert loaded is not None  # the project file exists
    if options.json:
        print(json.dumps(loaded.faults.rows(), indent=1, ensure_ascii=False))
    else:
        for fault in loaded.faults:
            level = "" if fault.severity.value == "error" else f" {val3_text(fault.severity.value)}:"
            logged = loaded.logged(dataclasses.replace(fault, text=val3_fault_text(fault.text)))
            print(logged.replace(")", f"){level}", 1))
        count = loaded.faults.errors
        programs = len(loaded.app.programs)
        counted = f"{programs} {'program' if programs == 1 else 'programs'}, {len(loaded.app.data)} data"
        print(val3_text(f"{name}: {counted}, {count} {'error' if count == 1 else 'errors'}"))
    return Exit.FINDING if loaded.faults.errors else Exit.OK


def _run(options: argparse.Namespace) -> int:
    if not 0.001 <= options.line_us <= 1e6:
        raise EventFault(f"--line-us {options.line_us:g}: 0.001 to 1000000 is expected")
    if not 0 < options.until <= LONGEST_S:
        raise EventFault(f"--until {options.until:g}: seconds above 0, {LONGEST_S:g} at most, are expected")
    events = [event_of(seconds, what) for seconds, what in options.at]
    root, folder, name = place_of(pathlib.Path(options.app), pathlib.Path(options.disk) if options.disk else None)
    robot = _robot(options)
    moves = Moves(robot, start := _start(options.start, robot))
    if start and not moves.in_range(start):
        raise EventFault(f"--start {options.start}: outside the travel of the arm")
    machine = Machine(read_disk(root), moves, round(options.line_us * 1000), strict=options.strict_priorities)
    own = machine.instance(folder, name, "")
    missing = [each for each in ("start", "stop") if own is not None and each not in own.programs]
    if own is None or missing:
        for line in machine.log:
            print(line.partition("VAL3:")[2] or line, file=sys.stderr)
        why = (
            f"{' and '.join(missing)} missing: it serves as a library only" if missing else "it has faults; axisgate val3 check names them"
        )
        complain("val3", f"{name} is not started: {why}")
        return Exit.FINDING
    machine.texts = val3_texts()
    if options.cell is not None:
        machine.robot.language = val3_language(load_cell(options.cell).cell.language)
    declare_links(machine, own.data.values())
    run = Run(machine, own, round(options.until * 1e9), events)
    run.go()
    result = run.result()
    print(json.dumps(result, indent=1, ensure_ascii=False, sort_keys=False) if options.json else "\n".join(map(val3_text, summary(result))))
    return Exit.FINDING if any(task.status > 1 for task in machine.tasks) else Exit.OK


def _start(text: str | None, robot: Robot) -> tuple[float, ...]:
    """Joints at the start: the given ones, else 0 or the nearest position inside the travel."""
    if text is None:
        return ()
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) != len(robot.axes):
        raise EventFault(f"--start {text}: {len(robot.axes)} numbers with commas are expected")
    return values
