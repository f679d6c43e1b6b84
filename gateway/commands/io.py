"""List the contacts of a running cell, or test them one by one with a question for each."""

import argparse
import json
import socket
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

from drivers.ports.base import runtime_dir
from gateway.assembly.run import slug_of
from gateway.commands.var import SUFFIX
from gateway.pure.buses.contacts import WATCHDOG
from gateway.tools.cell_argument import load
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate io list cell.toml            every contact: signal, value, quality
  axisgate io test cell.toml            outputs are switched one by one, inputs are read; one question each
  axisgate io test cell.toml --json --yes --only lamp   for scripts: no questions; the device confirms what was switched
"""
WARNING = (
    "Outputs are switched now, one at a time: brakes, lamps and enable chains may act. Check first that the machine is clear of people.\n"
    "Drives have to be off; the watchdog is never switched by hand. Is the machine clear of people? [type yes] "
)
HOLD_S = 60.0
Ask = Callable[[str], str]
Row = dict[str, Any]


class IoConsole:
    """The services of one run."""

    def __init__(self, name: str) -> None:
        self._path = str(runtime_dir() / f"{name}{SUFFIX}")

    def ask(self, **request: object) -> Mapping[str, Any]:
        """One question; OSError without an answer."""
        with socket.socket(socket.AF_UNIX) as link:
            link.settimeout(3.0)
            link.connect(self._path)
            link.sendall(json.dumps(request).encode() + b"\n")
            found: Mapping[str, Any] = json.loads(link.makefile().readline())
            return found

    def rows(self) -> list[Row]:
        return list(self.ask(op="contacts").get("contacts", []))

    def row(self, name: str) -> Row:
        return next(row for row in self.rows() if row["name"] == name)


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate io", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("list", "test"))
    parser.add_argument("cell")
    parser.add_argument("--name", help="name of the run, if it differs from the cell")
    parser.add_argument("--only", action="append", default=[], metavar="CONTACT", help="can be given several times")
    parser.add_argument("--yes", action="store_true", help="ask no questions; use the confirmation of the device")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args(argv)
    cell = load(arguments.cell)
    if isinstance(cell, int):
        return cell
    unknown = [name for name in arguments.only if name not in [io.name for io in cell.io]]
    if unknown or not cell.io:
        there = ", ".join(io.name for io in cell.io)
        complain("io", f"{', '.join(unknown)}: no such contact; " * bool(unknown) + f"the cell has {there or 'no [[io]]'}")
        return USAGE
    name = arguments.name or slug_of(cell)
    console = IoConsole(name)
    try:
        rows = [row for row in console.rows() if not arguments.only or row["name"] in arguments.only]
        if arguments.what == "list":
            return _list(rows, as_json=arguments.json)
        return _test(console, rows, _nobody if arguments.yes else _person, as_json=arguments.json)
    except OSError as error:
        complain("io", f"run {name!r} does not answer ({error}); start it with: axisgate run {arguments.cell}")
        return ENVIRONMENT


def _person(question: str) -> str:
    print(question, end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower()


def _nobody(question: str) -> str:
    return ""


def _list(rows: list[Row], *, as_json: bool) -> int:
    if as_json:
        print(json.dumps({"contacts": rows}))
    for row in () if as_json else rows:
        forced = ", forced" if row["forced"] else ""
        forced += f": {row['why']}" if row.get("why") else ""
        print(
            f"{row['name']:<20}{row['way']:<8}{row['device']} {row['channel']:<4}{row['signal']:<24}{row['value']} {row['quality']}{forced}"
        )
    return DONE if all(row["quality"] == "GOOD" for row in rows) else FINDING


def _test(console: IoConsole, rows: list[Row], ask: Ask, *, as_json: bool) -> int:
    """Test the outputs in turn; release every output in any case."""
    if ask is not _nobody and ask(WARNING) != "yes":
        complain("io", "nothing was switched")
        return FINDING
    results = [_input(console, row, ask) if row["way"] == "input" else _output(console, row, ask) for row in rows]
    if as_json:
        print(json.dumps({"results": results}))
    for result in () if as_json else results:
        print(f"{'ok  ' if result['ok'] else 'FAIL'}  {result['name']}: {result['result']}")
    return DONE if all(result["ok"] for result in results) else FINDING


def _result(row: Row, found: str, *, ok: bool) -> dict[str, object]:
    return {"name": row["name"], "way": row["way"], "signal": row["signal"], "ok": ok, "result": found}


def _output(console: IoConsole, row: Row, ask: Ask) -> dict[str, object]:
    if row["signal"] == WATCHDOG:
        return _watchdog(console, row)
    seen = []
    try:
        for value in (1, 0):
            answer = console.ask(op="force", name=row["name"], value=value, seconds=HOLD_S)
            if "error" in answer:
                return _result(row, str(answer["error"]), ok=False)
            if ask is _nobody:
                seen.append(_confirmed(console, row["name"], value))
                continue
            state = "closed" if value else "open"
            seen.append(ask(f"{row['name']} ({row['signal']}) is switched to {value}: is the contact {state}? [y/n] ").startswith("y"))
    finally:
        console.ask(op="force", name=row["name"], value=None)
    return _result(row, "switched to 1 and 0" if all(seen) else f"not seen at {'1' if not seen[0] else '0'}", ok=all(seen))


def _confirmed(console: IoConsole, name: str, value: int) -> bool:
    for _ in range(200):
        row = console.row(name)
        if row["value"] == value and row["quality"] == "GOOD":
            return True
        time.sleep(0.01)
    return False


def _watchdog(console: IoConsole, row: Row) -> dict[str, object]:
    """It is looked at, never switched."""
    seen = set()
    for _ in range(200):
        found = console.row(row["name"])
        if found["quality"] == "GOOD":
            seen.add(found["value"])
        if len(seen) == 2:
            return _result(row, "toggles by itself", ok=True)
        time.sleep(0.007)
    return _result(row, "does not toggle: no completed cycles, or its device is silent", ok=False)


def _input(console: IoConsole, row: Row, ask: Ask) -> dict[str, object]:
    if row["quality"] != "GOOD":
        return _result(row, "its device is silent", ok=False)
    if ask is _nobody:
        return _result(row, f"reads {row['value']}", ok=True)
    right = ask(f"{row['name']} ({row['signal']}) reads {row['value']}: is that so? [y/n] ").startswith("y")
    changed = (
        right and ask(f"{row['name']}: change it now, then press Enter ") is not None and console.row(row["name"])["value"] != row["value"]
    )
    return _result(row, "read at both levels" if changed else "wrong" if not right else "did not change", ok=changed)
