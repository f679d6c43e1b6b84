"""Programs of a Reis ROBOTstar V: check a memory, run a program in virtual time, import printed listings.

It also lists a memory, and protects, deletes, renames and copies its programs.
"""

import argparse
import dataclasses
import json
import sys
from pathlib import Path

from gateway.files.robots import RobotFaults, load_robot
from gateway.files.robotstar import FolderFault, sources, text_of, with_system_used, words, write
from gateway.files.robotstar_directory import copy, delete, entries, protect, rename
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.listing import PointFault, import_listing, points_of
from gateway.pure.languages.robotstar.memory import Memory
from gateway.pure.languages.robotstar.plc_link import PlcLink, check_plc
from gateway.pure.languages.robotstar.protection import Protected
from gateway.pure.languages.robotstar.reach import reach_of
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.script import NS, OrderFault, orders
from gateway.pure.languages.robotstar.virtual import VirtualCell
from gateway.runtime.exit_codes import Exit
from gateway.tools.usage_language import complain, fault_text, report_text

DIRECTORY = {"list": (), "protect": ("program", "letters"), "delete": ("program",), "rename": ("program", "to"), "copy": ("program", "to")}
WORDS = {
    "program": "name of the program, with .MPR, .SPR .. if several have it",
    "letters": "letters to lock: L delete, A execute, E edit, S structure, U rename; - for none",
    "to": "the new name",
}
EXAMPLES = """examples:
  axisgate robotstar check memory                                  all faults of a folder of programs, with file and line
  axisgate robotstar run memory --program PALTEST --virtual        AUTO in virtual time, START at 0
  axisgate robotstar run memory --program P --virtual --mode test1 --at "1 START" --at "2 F2" --until 10 --json
  axisgate robotstar import listing.txt --points points.csv        a printed listing as programs of a memory
  axisgate robotstar list memory                                   type, length, date, protection L/A/E/S/U and Var of each program
  axisgate robotstar protect memory PALTEST LS                     locks deletion and structure; "-" releases all letters
  axisgate robotstar copy memory PALTEST PALOLD                    also rename; delete memory PALOLD
exit code: 0 done, 1 faults or an error of the program, 2 nothing to read or a wrong option"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate robotstar", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parts = parser.add_subparsers(dest="part", required=True, metavar="check|run|import|list|protect|delete|rename|copy")
    for name, add in (("check", _check_options), ("run", _run_options), ("import", _import_options)):
        add(parts.add_parser(name, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter))
    for name, more in DIRECTORY.items():
        _directory_options(parts.add_parser(name, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter), more)
    options = parser.parse_args(argv)
    try:
        return {"check": _check, "run": _run, "import": _import, "list": _list}.get(options.part, _directory)(options)
    except Protected as fault:
        complain("robotstar", fault)
        return Exit.FINDING
    except PointFault as fault:
        complain("robotstar", report_text(str(fault)))
        return Exit.INVALID
    except (FolderFault, OrderFault, RobotFaults, FileNotFoundError) as fault:
        complain("robotstar", fault)
        return Exit.INVALID


def _check_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder", metavar="FOLDER", help="folder of the memory: NAME.MPR, NAME.SPR, NAME.MAC, NAME.PAL, NAME.PLC, directories"
    )
    parser.add_argument("--json", action="store_true")


def _run_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="FOLDER", help="folder of the memory")
    parser.add_argument("--program", required=True, metavar="P", help="program that START runs")
    parser.add_argument("--virtual", action="store_true", required=True, help="in virtual time, without processes and hardware")
    parser.add_argument("--mode", choices=sorted(MODES), default="auto")
    parser.add_argument("--plc", metavar="P", help="start program of the integrated PLC; without it no PLC runs")
    parser.add_argument("--robot", metavar="R", help="robot file: positions outside the limits of its axes are refused")
    parser.add_argument("--until", type=_seconds, metavar="S", help="end of the virtual time (default 600)")
    parser.add_argument("--at", action="append", default=[], metavar='"S WHAT"', help='event at a time: "1.5 E0.6=1", "2 START", "3 F2"')
    parser.add_argument("--json", action="store_true")


def _import_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("listing", type=Path, metavar="LISTING", help="text file of a printed listing")
    parser.add_argument("--points", type=Path, metavar="CSV", help="name,X,Y,Z,A,B,C[,Frame,A7..] of the positions")
    parser.add_argument("--to", type=Path, metavar="FOLDER", help="write the programs there (default: print them)")
    parser.add_argument("--json", action="store_true")


def _directory_options(parser: argparse.ArgumentParser, more: tuple[str, ...]) -> None:
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="folder of the memory")
    for name in more:
        parser.add_argument(name, metavar=name.upper(), help=WORDS[name])
    parser.add_argument("--json", action="store_true")


def _list(options: argparse.Namespace) -> int:
    """The directory as the control shows it."""
    found = entries(options.folder)
    if options.json:
        print(json.dumps([dataclasses.asdict(each) for each in found], indent=1, ensure_ascii=False))
    for each in found if not options.json else ():
        print(f"{each.name:24} {each.kind:5} {each.length:>8} {each.changed} {each.protection} {'Var' if each.variables else ''}".rstrip())
    return Exit.OK


def _directory(options: argparse.Namespace) -> int:
    """protect, delete, rename, copy."""
    folder, name = options.folder, options.program
    match options.part:
        case "protect":
            done = protect(folder, name, options.letters)
        case "delete":
            delete(folder, name)
            done = "deleted"
        case "rename":
            done = rename(folder, name, options.to)
        case _:
            done = copy(folder, name, options.to)
    print(json.dumps({"done": done}) if options.json else f"{name}: {report_text(done)}")
    return Exit.OK


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 1e6:
        raise argparse.ArgumentTypeError(f"{text}: 0 .. 1000000 seconds")
    return value


def _memory(folder: str, program: str = "") -> tuple[Memory, Faults]:
    faults = Faults()
    return Memory.read(with_system_used(sources(folder), program), words(), faults), faults


def _check(options: argparse.Namespace) -> int:
    memory, faults = _memory(options.folder)
    check(memory, faults, VirtualCell(memory, MODES["auto"]).system.names())
    check_plc(memory.plc, memory.plc_files, faults)
    rows = faults.rows()
    if options.json:
        print(json.dumps({"faults": rows}, indent=1, ensure_ascii=False))
    else:
        print("\n".join(fault_text(fault) for fault in faults) or report_text("no fault"))
    return Exit.FINDING if rows else Exit.OK


def _run(options: argparse.Namespace) -> int:
    memory, faults = _memory(options.folder, options.program)
    cell = VirtualCell(memory, MODES[options.mode], PlcLink(memory.plc, options.plc) if options.plc else None)
    if options.robot:
        cell.reaches = reach_of(load_robot(options.robot))
    check(memory, faults, cell.system.names())
    script = orders(options.at)
    cell.run(script, None if options.until is None else round(options.until * NS), options.program)
    end = cell.end(options.program)
    if options.json:
        print(json.dumps({"events": cell.events, "end": end}, indent=1, ensure_ascii=False))
    else:
        for event in cell.events:
            value = report_text(str(event["value"])) if event["what"] == "message" else event["value"]
            print(f"{event['at']:>10} {event['what']} {value}")
        print(report_text(f"{end['state']}: program {end['program']}, step {end['step']}"))
    return Exit.FINDING if end["state"] == "error" else Exit.OK


def _import(options: argparse.Namespace) -> int:
    points = points_of(text_of(options.points)) if options.points else {}
    found = import_listing(text_of(options.listing), words(), points, options.listing.stem.upper())
    if options.to:
        write(options.to, found.files)
    notes = [{"line": note.line, "text": note.text} for note in found.notes]
    if options.json:
        print(json.dumps({"files": found.files, "notes": notes}, indent=1, ensure_ascii=False))
    else:
        for name, text in found.files.items():
            print(report_text(f"{name}: written to {options.to}") if options.to else f"{name}\n{text}")
        for note in found.notes:
            print(f"{options.listing}:{note.line}: {report_text(note.text)}", file=sys.stderr)
    return Exit.FINDING if any("not printed" in str(note["text"]) for note in notes) or not found.files else Exit.OK
