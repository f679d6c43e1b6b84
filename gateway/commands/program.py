"""Check, list and dry-run programs of the rho 3 (BAPS2) in virtual time; run, start and stop them in a cell."""

import argparse
import json
import pathlib
import sys
from dataclasses import replace

from gateway.commands.program_cell import IN_CELLS, add_to, run_in_cell
from gateway.commands.program_files import OF_FILES, add_files_to, run_on_files
from gateway.commands.program_pic import PicTraceFault, event_line, pic_trace
from gateway.files.pic_program import check_pic
from gateway.files.program_memory import baps2_words, folder_memory, read_feed
from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import Feed, FeedFault
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory, decoded
from gateway.pure.languages.base.faults import Faults, SourceFault
from gateway.runtime.exit_codes import Exit
from gateway.tools.usage_language import baps2_text, complain, fault_text

EXAMPLES = """examples:
  axisgate program check memory/QUICKST.QLL memory/MAIN.QLL      every fault with file, line and column
  axisgate program trace memory QUICKST --feed feed.toml --json  what the program does, event by event, in virtual time
  axisgate program trace memory LOCK.QLS --feed pic.toml         a PIC program, with inputs set at their times
  axisgate program list memory                                   all programs of a memory folder
  axisgate program points memory PICK                            points as the PKT file has them
  axisgate program run palletiser PALLET --sim                   in a simulated cell: drives on, program, drives off
  axisgate program run cell.toml PALLET                          in the running cell, until it ends; Ctrl-C stops it
  axisgate program start cell.toml PALLET                        as the panel does: it moves if the PLC has control
  axisgate program stop cell.toml PALLET
  axisgate program put cell.toml NEW.QLL --force                 into the memory of a cell, also of a running one
  axisgate program get cell.toml PALLET --to saved               copies its source, points and data out of it
  axisgate program compile memory PALLET                         writes PALLET.IRD, or PALLET.ERR with the faults
exit code: 0 done; 1 a program has errors, was refused or ended with one; 2 a file, folder or program is missing, or the feed is invalid;
3 no such run; 130 interrupted before the program began"""


def main(argv: list[str]) -> int:
    """check, trace, list."""
    parser = argparse.ArgumentParser(
        "axisgate program", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    tools = parser.add_subparsers(dest="tool", required=True)
    check = tools.add_parser("check", help="check programs; the folder of a file is its memory")
    check.add_argument("files", nargs="+", metavar="FILE", type=pathlib.Path)
    check.add_argument("--json", action="store_true", help="a JSON list of faults")
    trace = tools.add_parser("trace", help="dry-run a program and print its events")
    trace.add_argument("folder", metavar="FOLDER", type=pathlib.Path, help="the memory folder")
    trace.add_argument("program", metavar="PROGRAM")
    trace.add_argument("--feed", metavar="FILE", type=pathlib.Path, help="inputs, points, device data and files of the run (TOML)")
    trace.add_argument("--json", action="store_true", help="one JSON object per event and line")
    listed = tools.add_parser("list", help="list the programs of a memory folder")
    listed.add_argument("folder", metavar="FOLDER", type=pathlib.Path, nargs="?", default=pathlib.Path())
    listed.add_argument("--json", action="store_true", help="a JSON list of programs")
    points = tools.add_parser("points", help="list the points of a program as its PKT file has them")
    points.add_argument("folder", metavar="FOLDER", type=pathlib.Path, help="the memory folder")
    points.add_argument("program", metavar="PROGRAM")
    points.add_argument("--json", action="store_true", help="a JSON object: name and components")
    add_to(tools)
    add_files_to(tools)
    options = parser.parse_args(argv)
    if options.tool in IN_CELLS:
        return run_in_cell(options)
    if options.tool in OF_FILES:
        return run_on_files(options)
    try:
        return int({"check": _check, "trace": _trace, "list": _list, "points": _points}[options.tool](options))
    except BrokenPipeError:  # `| head` has seen enough: __main__ ends quietly
        raise
    except OSError as error:
        return _invalid(f"{error.filename}: {error.strerror}")


def _invalid(text: str) -> int:
    complain("program", text)
    return Exit.INVALID


def _check(options: argparse.Namespace) -> int:
    words = baps2_words()
    rows, errors = [], 0
    memories: dict[pathlib.Path, Library] = {}
    for path in options.files:
        text = decoded(path.read_bytes())
        folder = path.resolve().parent
        if path.suffix.upper() == ".QLS":
            faults = check_pic(path, text)
        else:
            if folder not in memories:
                memories[folder] = Library(words, folder_memory(folder))
            _, faults = memories[folder].check(str(path), text)
        errors += faults.errors
        found = [_placed(fault, path) for fault in faults]
        rows += [fault.as_row() for fault in found]
        if not options.json:
            for fault in found:
                print(fault_text(fault, baps2_text))
    if options.json:
        print(json.dumps(rows, indent=1))
    return Exit.FINDING if errors else Exit.OK


def _placed(fault: SourceFault, path: pathlib.Path) -> SourceFault:
    """With the path of the included file that it is in, as the folder spells it."""
    name = fault.position.file
    if name == str(path):
        return fault
    spelled = next((each.name for each in path.resolve().parent.iterdir() if each.name.upper() == name.upper()), name)
    return replace(fault, position=fault.position._replace(file=str(path.parent / spelled)))


def _trace_pic(options: argparse.Namespace, name: str) -> int:
    try:
        run = pic_trace(options.folder, name, options.feed)
    except PicTraceFault as fault:
        for each in fault.faults or ():
            print(each, file=sys.stderr)
        complain("program", fault)
        return Exit.FINDING if fault.faults is not None else Exit.INVALID
    for event in run.trace:
        print(event_line(event, options.json))
    return Exit.OK


def _trace(options: argparse.Namespace) -> int:
    stem = options.program.upper().removesuffix(".QLS")
    store = folder_memory(options.folder)
    if store.text(f"{stem}.QLS") is not None and (stem != options.program.upper() or store.text(f"{stem}.QLL") is None):
        return _trace_pic(options, stem)
    try:
        feed = read_feed(options.feed) if options.feed else Feed()
    except FeedFault as fault:
        return _invalid(f"{options.feed}: {fault}")
    memory = folder_memory(options.folder, feed)
    library = Library(baps2_words(), memory)
    name = options.program.upper().removesuffix(".QLL")
    if not library.has(name) and name not in library.names():
        known = ", ".join(library.names())
        return _invalid(f"there is no program {name} in {options.folder}" + (f"; there are {known}" if known else ""))
    unit, faults = library.unit(name)
    if unit is None:
        return _faulty(name, faults)
    run = DryRun(library, memory, feed)
    if (error := run.run(name)) is not None:
        return _invalid(f"{name} does not start: {error.code} {error.text}")
    for event in run.trace:
        print(json.dumps(event) if options.json else _line(event))
    return Exit.OK


def _faulty(name: str, faults: Faults) -> int:
    for fault in faults:
        print(fault, file=sys.stderr)
    complain("program", f"{name} has errors and does not run")
    return Exit.FINDING


def _line(event: dict[str, object]) -> str:
    """An event for people."""
    facts = " ".join(f"{name}={value}" for name, value in event.items() if name not in ("t", "process", "line", "event"))
    return f"{event['t']:>10} {event['process']}:{event['line']} {event['event']} {facts}".rstrip()


def _list(options: argparse.Namespace) -> int:
    library = Library(baps2_words(), memory := folder_memory(options.folder))
    rows = [_row(name, library, memory) for name in library.names()]
    if options.json:
        print(json.dumps(rows, indent=1))
        return Exit.OK
    for row in rows:
        print(f"{row['program']:<13} {row['kind']:<10} {row['lines']:>6} lines {row['errors']:>4} errors {row['warnings']:>4} warnings")
    return Exit.OK


def _points(options: argparse.Namespace) -> int:
    faults, name = Faults(), options.program.upper().removesuffix(".QLL").removesuffix(".PKT")
    memory = folder_memory(options.folder)
    if memory.text(f"{name}.PKT") is None:
        return _invalid(f"there is no {name}.PKT in {options.folder}")
    points = memory.points(name, faults)
    for fault in faults:
        print(fault, file=sys.stderr)
    if options.json:
        print(json.dumps(points, indent=1))
    else:
        for point, values in points.items():
            print(f"{point:<13} {', '.join(f'{value:g}' for value in values)}")
    return Exit.FINDING if faults.errors else Exit.OK


def _row(name: str, library: Library, memory: Memory) -> dict[str, str | int]:
    _, faults = library.unit(name)
    tree = library.tree(name)
    kind = "faulty" if tree is None else "subroutine" if tree.external_subroutine else "permanent" if tree.head.permanent else "program"
    lines = (memory.text(f"{name}.QLL") or "").count("\n")
    return {"program": name, "kind": kind, "lines": lines, "errors": faults.errors, "warnings": len(faults) - faults.errors}
