"""PLC programs of a ROBOTstar V: check them, run them in virtual time, import statement lists of STEP 5 and STEP 7."""

import argparse
import json
import pathlib
import time
import zlib
from collections.abc import Collection, Iterable, Iterator

from gateway.assembly.program_memory import plc_folder
from gateway.assembly.run import slug_of
from gateway.files.plc_programs import ProgramFileFault, read_listing, read_programs, write_programs
from gateway.pure.cell.cell import Cell
from gateway.pure.languages.plc.awl.report import Imported, imported
from gateway.pure.languages.plc.check import check_programs
from gateway.pure.languages.plc.commands import Code, Command
from gateway.pure.languages.plc.orders import OrderFault, orders_of
from gateway.pure.languages.plc.plc import Settings
from gateway.pure.languages.plc.reader import Line, lines_of
from gateway.pure.languages.plc.steps import step_of
from gateway.pure.languages.plc.translation import start_in_folder
from gateway.pure.languages.plc.virtual import Event, VirtualRun
from gateway.runtime.exit_codes import Exit
from gateway.tools.cell_argument import load
from gateway.tools.client import Row, ToolClient, ToolError, running
from gateway.tools.command_support import ENVIRONMENT
from gateway.tools.usage_language import complain, fault_text, report_text

SUFFIX = ".PLC"
ACTS_S = 0.3  # an order is carried out between two scans; translating a long program takes some time
SHOWN_STEPS = 500  # of it in one answer
SHOWN_S = 3.0  # until the test display of a program that runs is on
IN_CELLS = {
    "status": "state and message of the PLC of a running cell",
    "start": "translate and start, as Start PLC does",
    "stop": "end the cyclic processing; all outputs are 0",
    "ack": "acknowledge the message that is shown",
    "show": "a program with its test display: state, VKE, ACCU1 and ACCU2 after each step",
    "set": "write a marker between two scans",
}
EXAMPLES = """examples:
  axisgate plc check cell/PLC                                        all faults of all programs
  axisgate plc run cell/PLC --start MAIN --virtual --scans 200       what 200 scans do, without any process
  axisgate plc run cell/PLC --start MAIN --virtual --at "3 E0.6=1" --at "9 E0.6=0" --json
  axisgate plc status reis-plc                                       the PLC of a running cell; also start [PROGRAM], stop, ack
  axisgate plc show reis-plc MAIN                                    its listing with state, VKE and accumulators after each step
  axisgate plc set reis-plc M10.0 1                                  a marker by hand: M10.0, M10, MD10
  axisgate plc import LIST.TXT --to cell/PLC                         a statement list of STEP 5 or STEP 7 becomes NAME.PLC files
exit code: 0 done, 1 a finding (faults, a refused start, PLC error, lines not translated, missing blocks), 2 wrong arguments or files"""


def main(argv: list[str]) -> int:
    options = parser().parse_args(argv)
    try:
        return {"check": check, "run": run, "import": import_list}.get(options.action, in_cell)(options)
    except (ProgramFileFault, OrderFault) as error:
        complain("plc", error)
    except OSError as error:
        complain("plc", f"{error.filename}: {error.strerror}")
    return Exit.INVALID


def parser() -> argparse.ArgumentParser:
    """All options."""
    whole = argparse.ArgumentParser(
        "axisgate plc", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    actions = whole.add_subparsers(dest="action", required=True)
    one = actions.add_parser("check", help="faults of all programs of a folder")
    one.add_argument("folder", type=pathlib.Path, metavar="FOLDER")
    two = actions.add_parser("run", help="run a program in virtual time")
    two.add_argument("folder", type=pathlib.Path, metavar="FOLDER", help="the folder S:/PLC with NAME.PLC files")
    two.add_argument("--start", required=True, metavar="PROGRAM", help="start program (_SSTARTPLC), with FOLDER/ in front if it is in one")
    two.add_argument("--virtual", action="store_true", required=True, help="in virtual time, without processes")
    two.add_argument("--period", type=_period, default=10.0, metavar="MS", help="interpolation period (default 10)")
    two.add_argument("--load", type=_count, metavar="N", help="commands a period (IPLC_LOAD; default: a whole scan each period, 0: off)")
    two.add_argument("--watchdog", type=_count, default=30, metavar="N", help="longest scan in 1/100 s (_ITIME_PLC, default 30)")
    two.add_argument("--scans", type=_count, default=100, metavar="N", help="scans 0 to N-1 (default 100)")
    two.add_argument(
        "--at", action="append", default=[], metavar='"N WHAT"', help="before scan N: E0.6=1, M20=5, EA2=4.5, START, STOP, ACK .."
    )
    three = actions.add_parser("import", help="translate a statement list")
    three.add_argument("file", type=pathlib.Path, metavar="FILE", help="text file: listing of STEP 5 or source of STEP 7")
    three.add_argument("--to", type=pathlib.Path, required=True, metavar="FOLDER", help="where the NAME.PLC files are written")
    three.add_argument("--words", type=pathlib.Path, metavar="TABLE", help="data words and markers: one `DB10.DW5 = M200` a line")
    others = [actions.add_parser(word, help=text) for word, text in IN_CELLS.items()]
    for each in others:
        each.add_argument("cell", metavar="CELL", help="cell file of the run, or its name")
        each.add_argument("--name", help="name of the run, if it differs from the file")
    others[1].add_argument("program", nargs="?", default="", metavar="PROGRAM", help="start program (default: that of the cell)")
    others[4].add_argument("program", metavar="PROGRAM", help="a program that runs")
    others[5].add_argument("operand", metavar="MARKER", help="M10.0 (bit), M10 (byte), MD10 (double word)")
    others[5].add_argument("value", metavar="VALUE", help="decimal, or hexadecimal with H (12H)")
    for each in (one, two, three, *others):
        each.add_argument("--json", action="store_true", help="one JSON object on standard output")
    return whole


def in_cell(options: argparse.Namespace) -> int:
    """The PLC of a running cell."""
    cell = load(options.cell)
    if isinstance(cell, int):
        return cell
    if cell.controller is None or cell.controller.plc is None:
        complain("plc", f"{options.cell} has no PLC: [controller.plc] with start = PROGRAM adds one")
        return Exit.INVALID
    try:
        with running(options.name or slug_of(cell)) as client:
            if options.action == "show":
                return show(cell, options, client)
            if options.action == "set":
                client.ask("plc", do="write", operand=options.operand, value=options.value)
            elif options.action != "status":
                client.ask("plc", do=options.action, name=getattr(options, "program", ""))
                time.sleep(ACTS_S)
            answer = client.ask("plc", do="status")
    except ToolError as error:
        complain("plc", report_text(str(error)))
        return ENVIRONMENT
    print(json.dumps(answer, indent=1) if options.json else sentence(answer))
    return Exit.FINDING if options.action == "start" and _refused(answer["message"]) else Exit.OK


def _refused(message: object) -> bool:
    """Whether the message that is shown is that of a refused start: red, without a number."""
    return isinstance(message, dict) and not message["number"] and bool(message["reaction"])


def sentence(answer: Row) -> str:
    """The state of a PLC in words."""
    message = answer["message"]
    shown = f"; message: {message['text']}" if isinstance(message, dict) else ""
    return report_text(f"PLC {answer['state']}, {answer['scans']} scans{shown}")


def show(cell: Cell, options: argparse.Namespace, client: ToolClient) -> int:
    """A listing with its test display.  ToolError."""
    folder, name = plc_folder(cell), options.program.upper()
    text = read_programs(folder).get(name) if folder is not None else None
    if text is None:
        raise ProgramFileFault(f"{options.program}: there is no such program in {folder}")
    answer = client.ask("plc", do="show", name=name, first=1)
    end = time.monotonic() + SHOWN_S
    while not answer["on"] and time.monotonic() < end:
        time.sleep(0.1)
        answer = client.ask("plc", do="show", name=name, first=1)
    steps: list[list[object]] = []
    while isinstance(found := answer["rows"], list) and found:
        steps += found
        if len(found) < SHOWN_STEPS:
            break
        answer = client.ask("plc", do="show", name=name, first=found[-1][0] + 1)
    rows = {row[0]: row for row in steps}
    same = answer["on"] and answer["text"] == zlib.crc32(text.encode())
    why = "" if same else "the file differs from the program that runs" if answer["on"] else answer["why"] or "the program does not run"
    if options.json:
        print(json.dumps({"on": same, "why": why, "rows": steps if same else []}, indent=1))
        return Exit.OK if same else Exit.FINDING
    width = len(report_text("step"))
    print(f"{report_text('step'):>5} {'':{45 - max(width, 5)}} {report_text('state'):>5} VKE      ACCU1      ACCU2")
    for line in lines_of(text):
        row = rows.get(line.step) if same else None
        shown = f"{row[1]:>5} {row[2]:>3} {row[3]:>10} {row[4]:>10}" if row else "  NOP" if same and _acts(line) else ""
        print(f"{line.step:>5} {line.text[:40]:40} {shown}".rstrip())
    if why:
        print(report_text(f"the test display is off: {why}"))
    return Exit.OK if same else Exit.FINDING


def _acts(line: Line) -> bool:
    """Whether a step is a command: head, END, labels, comments and invalid steps do nothing in any scan."""
    step = step_of(line.text, line.step) if line.valid else None
    return isinstance(step, Command) and step.code is not Code.LABEL


def _count(text: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) > 10_000_000:
        raise argparse.ArgumentTypeError(f"{text}: a whole number from 0 to 10000000")
    return int(text)


def _period(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.1 <= value <= 1000:
        raise argparse.ArgumentTypeError(f"{text}: 0.1 to 1000 ms")
    return value


def check(options: argparse.Namespace) -> int:
    """Prints the faults of all programs."""
    faults = check_programs(read_programs(options.folder))
    if options.json:
        print(json.dumps({"faults": faults.rows()}, indent=1))
    else:
        print("\n".join(fault_text(fault) for fault in faults) or report_text("no faults"))
    return Exit.FINDING if len(faults) else Exit.OK


def run(options: argparse.Namespace) -> int:
    """Prints events and end."""
    orders = [order for text in options.at for order in orders_of(text)]
    settings = Settings(load=options.load, watchdog=options.watchdog)
    programs = read_programs(options.folder)
    start = _start_of(options.start)
    virtual = VirtualRun(programs, start, orders, round(options.period * 1e6), settings)
    end = virtual.run(options.scans)
    if options.json:
        print(json.dumps({"events": virtual.events, "end": end}, indent=1))
    else:
        for event in virtual.events:
            print(line_of(event))
        if end["state"] == "error" and not any(event["what"] == "state" for event in virtual.events):
            print(report_text(refused_start(start, options.folder, programs)))
        print(report_text(f"end: {end['state']}, {end['program']} step {end['step']}, {end['scans']} scans in {end['time_s']} s"))
    return Exit.FINDING if end["state"] == "error" else Exit.OK


def _start_of(name: str) -> str:
    """The start program as the folder has it, from its name, file or path; unchanged if it is elsewhere and START refuses it."""
    plain = name[: -len(SUFFIX)] if name.upper().endswith(SUFFIX) else name
    try:
        return start_in_folder(plain) if "/" in plain or "\\" in plain else plain
    except ValueError:
        return plain


def refused_start(start: str, folder: pathlib.Path, programs: Collection[str]) -> str:
    """Remedy if the PLC did not start."""
    if start.upper() not in programs:
        return f"START is refused: {folder} has no program {start}; it has {', '.join(sorted(programs)) or 'none'}"
    return f"START is refused: correct {start}; all faults with their lines: axisgate plc check {folder}"


def line_of(event: Event) -> str:
    """One event as a line."""
    if event["what"] != "message":
        return f"{event['at']:>6}  {event['what']} = {event['value']}"
    place = f" ({event['program']} step {event['step']})" if event["program"] else ""
    kind, text = report_text(str(event["class"])), report_text(f"{event['text']}{place}")
    return f"{event['at']:>6}  {kind}: {text}"


def import_list(options: argparse.Namespace) -> int:
    """Writes the programs and reports each line that was not translated."""
    table = read_listing(options.words) if options.words else ""
    present = read_programs(options.to) if options.to.is_dir() else {}
    result = imported(read_listing(options.file), table, present)
    if not result.programs:
        raise ProgramFileFault(
            f"{options.file}: no line of a statement list was found; print the blocks as statement list (AWL) to a text file"
        )
    paths = write_programs(options.to, result.programs)
    if options.json:
        print(json.dumps({"programs": [str(path) for path in paths], **result.as_dict()}, indent=1))
    else:
        print("\n".join(lines_of_import(paths, result)))
    return Exit.FINDING if result.refused or result.missing else Exit.OK


def lines_of_import(paths: Iterable[pathlib.Path], result: Imported) -> Iterator[str]:
    """The report for a reader, in the user's language; lines of the list as they are."""
    yield from (report_text(f"written: {path}") for path in paths)
    yield report_text(f"{result.statements} statements, {len(result.refused)} not translated")
    for each in result.refused:
        block = f" ({each.block})" if each.block else ""
        yield f"{report_text(f'line {each.line}')}{block}: {each.text}: {report_text(each.reason)}"
    yield from (report_text(note) for note in result.notes)
