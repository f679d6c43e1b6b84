"""Run a motion program of a cell: on the running gateway, or with everything simulated (--sim)."""

import argparse
import contextlib
import json
import time

from gateway.pure.cell.cell import Cell
from gateway.pure.image.records.cell import Motion
from gateway.tools.cell_argument import load
from gateway.tools.client import Row, ToolClient, ToolError, mask_of
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.motion.ready import client_of, reference
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate motion run scara 1 --sim                 a shipped cell: drives on, referenced, program 1, all emulated
  axisgate motion run cell.toml pick --speed 20     the running cell: program "pick" at 20 % of its speeds
  axisgate motion run cell.toml 3 --ready --json    drives on and reference run first; the outcome as JSON
PROGRAM is a number or a name of the cell's [[program]] tables.  Ctrl-C stops on the path and drops the rest.
exit code: 0 done, 1 refused or ended early, 2 unknown cell or program, 3 no such run"""
POLL_S = 0.05


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate motion run", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", metavar="CELL", help="cell file, or the name of a shipped one")
    parser.add_argument("program", metavar="PROGRAM", help="number or name")
    parser.add_argument("--sim", action="store_true", help="run the cell under simulation for this")
    parser.add_argument("--ready", action="store_true", help="drives on and reference run first (a simulation does it anyway)")
    parser.add_argument("--speed", type=float, default=100.0, metavar="PERCENT", help="of the programmed speeds (default 100)")
    parser.add_argument("--accel", type=float, default=100.0, metavar="PERCENT", help="of the programmed accelerations (default 100)")
    parser.add_argument("--name", help="name of the run, if it differs from the file")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(argv)
    cell = load(options.cell)
    if isinstance(cell, int):
        return cell
    number = number_of(cell, options.program)
    if number is None:
        known = ", ".join(f"{each.number} {each.name}" for each in cell.program) or "none; name one in a [[program]] table"
        complain("motion run", f"{options.program}: no such program in {options.cell}; there is {known}")
        return USAGE
    try:
        with client_of(options, cell) as client:
            try:
                found = play(client, cell, number, options)
            except ToolError as error:
                return _said(error, FINDING)
    except ToolError as error:
        return _said(error, ENVIRONMENT)
    print(json.dumps(found, indent=1) if options.json else found["sentence"])
    return DONE if found["state"] == "DONE" else FINDING


def _said(error: ToolError, code: int) -> int:
    complain("motion run", error)
    return code


def number_of(cell: Cell, word: str) -> int | None:
    """Number of a program from its number or its name."""
    return next((each.number for each in cell.program if word in (str(each.number), each.name)), None)


def play(client: ToolClient, cell: Cell, number: int, options: argparse.Namespace) -> Row:
    """Order it and stay until it is over; the axes are left at rest whatever happens."""
    name = next(each.name for each in cell.program if each.number == number)
    every = mask_of(cell, [axis.name for axis in cell.axis])
    client.command("request_control")
    try:
        if options.sim or options.ready:
            client.take_over()
            client.command("enable", every)
            reference(client, cell)
        began = time.monotonic()
        answer = client.ask("tool", code="program", mask=number, velocity=options.speed / 100, acceleration=options.accel / 100)
        try:
            while answer["open"]:
                time.sleep(POLL_S)
                answer = client.ask("job", job=answer["job"])
        except KeyboardInterrupt:
            answer = stopped(client, answer)
        seconds = time.monotonic() - began
    finally:
        with contextlib.suppress(ToolError):
            if options.sim:
                client.command("disable", every)
            client.command("release_control")
    return _result(client, number, name, answer, seconds)


def stopped(client: ToolClient, answer: Row) -> Row:
    """Ctrl-C: on the path, and the rest is dropped; a program that was only being prepared is over with the stop."""
    client.command("stop")
    if int(str(client.ask("axes")["motion"])) == Motion.STOPPED:
        client.command("abandon")
    return client.ask("job", job=answer["job"])


def _result(client: ToolClient, number: int, name: str, answer: Row, seconds: float) -> Row:
    axes = client.axes()
    rows = {str(row["name"]): float(str(row["actual"])) for row in axes}
    measured = {str(row["name"]): float(str(row["measured"])) for row in axes if "measured" in row}
    places = ", ".join(f"{axis} {place:.3f}" for axis, place in rows.items())
    state, detail = str(answer["state"]), str(answer["detail"])
    outcome = f"done in {seconds:.2f} s" if state == "DONE" else f"{state.lower()}: {answer['words']} {detail}".rstrip()
    return {
        "program": number,
        "name": name,
        "state": state,
        "reason": answer["reason"],
        "detail": detail,
        "seconds": round(seconds, 3),
        "axes": rows,
        "measured": measured,
        "sentence": f"program {number} {name}: {outcome}; the axes are at {places}{_caught(measured)}",
    }


def _caught(measured: dict[str, float]) -> str:
    """@MPOS in words."""
    return f"; measured at {', '.join(f'{axis} {place:.3f}' for axis, place in measured.items())}" if measured else ""
