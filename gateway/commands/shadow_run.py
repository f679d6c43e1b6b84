"""`axisgate run CELL --shadow`: plays the shadow until Ctrl-C, then writes its report (AX-493)."""

import argparse
import json
import os
import pathlib
import signal
import sys
import threading

from gateway.processes.supervisor import Supervisor
from gateway.pure.cell.cell import Cell
from gateway.pure.shadow.report import as_html, as_text, report
from gateway.shadow.log_writer import kept
from gateway.shadow.plan import BUSES, LINES, left_out, parse_taps, plan_shadow, why_not_shadow
from gateway.tools.command_support import BANNER, DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.usage_language import complain

OPTIONS = ("tap", "seconds", "report", "tolerance")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Those of a shadow."""
    group = parser.add_argument_group("shadow", "next to a working old controller: listen on taps, send nothing, compare")
    group.add_argument(
        "--shadow", action="store_true", help="compare axisgate's status with that of the old controller; no output is opened"
    )
    group.add_argument(
        "--tap",
        action="append",
        default=[],
        metavar="NAME=FIRST,SECOND",
        help="LINE=FROM_PLC,FROM_CONTROLLER: two receive-only ports on a line; SERVER=CAPTURE,OLD_CONTROLLER: what tcpdump writes of the "
        "PLC's Modbus TCP, and the address of the old controller, 10.0.0.7:502; repeatable",
    )
    group.add_argument(
        "--tolerance",
        type=float,
        metavar="UNITS",
        help="largest difference of equal positions, mm or deg (default: following_error.warn of each axis)",
    )
    group.add_argument("--seconds", type=float, help="end after this time (default: Ctrl-C)")
    group.add_argument("--report", metavar="NAME", help="write NAME.txt, NAME.json, NAME.html (default: shadow-RUN)")


def misplaced(arguments: argparse.Namespace) -> str:
    """Empty, or which option goes with the other kind of run only."""
    if not arguments.shadow:
        given = next((name for name in OPTIONS if getattr(arguments, name)), "")
        return f"--{given} needs --shadow" if given else ""
    others = ("sim", "modbus_port", "web", "record")
    given = next((name for name in others if getattr(arguments, name) not in (None, False)), "")
    return f"--{given.replace('_', '-')}: a shadow run serves nothing and retains nothing" if given else ""


def run_shadow(arguments: argparse.Namespace, cell: Cell) -> int:
    """The exit code: 0 equal, 1 a difference, 2 command line or cell, 3 nothing received or no port."""
    try:
        taps = parse_taps(arguments.tap)
    except ValueError as error:
        return _said(str(error), USAGE)
    if arguments.tolerance is not None and arguments.tolerance < 0.0:
        return _said(f"--tolerance {arguments.tolerance:g}: 0 or more", USAGE)
    refusal = why_not_shadow(cell, taps, arguments.bus)
    if refusal:
        return _said(refusal, USAGE)
    plan = plan_shadow(cell, taps, slug=arguments.name, bus=arguments.bus, p5_ms=arguments.p5, tolerance=arguments.tolerance)
    print(BANNER, file=sys.stderr)
    print("shadow: listens only, sends nothing; start it while the drives are off; Ctrl-C ends it", file=sys.stderr, flush=True)
    if arguments.seconds:
        timer = threading.Timer(arguments.seconds, os.kill, (os.getpid(), signal.SIGINT))
        timer.daemon = True
        timer.start()
    code = Supervisor(plan, echo=not arguments.json).run()
    if code:
        return code
    lines, buses = kept(plan.folder / LINES), kept(plan.folder / BUSES)
    found = report({"cell": cell.cell.name, "file": cell.file}, lines, buses, left_out(cell, taps))
    name = arguments.report or f"shadow-{plan.slug}"
    words = as_text(found)
    for ending, content in (("txt", words), ("json", json.dumps(found, indent=1) + "\n"), ("html", as_html(found))):
        pathlib.Path(f"{name}.{ending}").write_text(content, encoding="utf-8")
    if arguments.json:
        print(json.dumps(found))
    else:
        print(f"{words}report: {name}.html, {name}.txt, {name}.json")
    if not found["compared"]:
        return ENVIRONMENT
    return DONE if found["equal"] else FINDING


def _said(error: str, code: int) -> int:
    complain("run --shadow", error)
    return code
