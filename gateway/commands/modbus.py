"""Test a Modbus TCP server with raw requests, or find a value in its registers."""

import argparse
import dataclasses
import json
import pathlib
import sys

from drivers.ports.base import PortError
from gateway.conformance.modbus.probe import Prober, Result, as_report, probe, search, summary, to_html
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.usage_language import complain
from protocols.modbus.probing import Verdict, cases

EXAMPLES = """examples:
  axisgate modbus probe 10.0.0.7                                reads only; nothing is changed in the device
  axisgate modbus probe 10.0.0.7:1502 --unit 3 --report cw4     writes cw4.json and cw4.html
  axisgate modbus probe 10.0.0.7 --find 21.5 --last 499         which registers hold the 21.5 that its display shows?
exit code: 0 no FAIL (with --find: found), 1 at least one (not found), 2 command line, 3 no connection"""
DEFAULT_PORT = 502


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate modbus", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    tools = parser.add_subparsers(dest="tool", required=True)
    tool = tools.add_parser(
        "probe",
        help="send raw requests, or find a value with --find VALUE",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    tool.add_argument("server", help="host or host:port (port 502 unless given)")
    tool.add_argument("--unit", type=int, default=1, help="unit id of the server (default 1)")
    tool.add_argument("--missing-unit", type=int, default=247, help="a unit id that does not exist (default 247)")
    tool.add_argument("--register", type=int, default=0, help="a register that can be read, base 0 (default 0)")
    tool.add_argument("--coil", type=int, default=0, help="a coil and discrete input that can be read, base 0 (default 0)")
    tool.add_argument(
        "--write", action="store_true", help="also send invalid writes to --register and --coil; a careless server may execute them"
    )
    tool.add_argument("--wait", type=float, default=1.0, metavar="S", help="longest wait for an answer (default 1 s)")
    tool.add_argument("--report", metavar="NAME", help="write NAME.json and NAME.html")
    tool.add_argument("--json", action="store_true", help="print the report as JSON")
    tool.add_argument("--find", type=float, metavar="VALUE", help="search the registers for this value, in every type and byte order")
    tool.add_argument("--first", type=int, default=0, help="with --find: first register, base 0 (default 0)")
    tool.add_argument("--last", type=int, default=999, help="with --find: last register (default 999)")
    arguments = parser.parse_args(argv)
    host, colon, port = arguments.server.rpartition(":") if ":" in arguments.server else (arguments.server, "", "")
    if (colon and not port.isdecimal()) or not 0 <= arguments.unit <= 255 or not 0 <= arguments.first <= arguments.last <= 0xFFFF:
        complain("modbus", "host:port, unit 0..255, registers 0..65535 expected; axisgate modbus probe -h")
        return USAGE
    prober = Prober(host.strip("[]"), int(port) if colon else DEFAULT_PORT, arguments.wait)
    try:
        return _find(prober, arguments) if arguments.find is not None else _probe(prober, arguments)
    except PortError as error:
        complain("modbus", error.args[-1])
        return ENVIRONMENT


def _probe(prober: Prober, arguments: argparse.Namespace) -> int:
    wanted = cases(arguments.unit, arguments.register, arguments.coil, arguments.missing_unit, arguments.write)
    results = probe(prober, wanted, (lambda result: None) if arguments.json else _print)
    report = as_report(prober, arguments.unit, results)
    if arguments.json:
        print(json.dumps(report, indent=1))
    else:
        print(summary(report))
    if arguments.report:
        pathlib.Path(f"{arguments.report}.json").write_text(json.dumps(report, indent=1) + "\n")
        pathlib.Path(f"{arguments.report}.html").write_text(to_html(report))
    return FINDING if any(result.verdict is Verdict.FAIL for result in results) else DONE


def _print(result: Result) -> None:
    why = f": {result.why}" if result.why else ""
    print(f"{result.verdict.value:<12} {result.case.name}{why}", flush=True)


def _find(prober: Prober, arguments: argparse.Namespace) -> int:
    found, read = search(prober, arguments.find, arguments.unit, arguments.first, arguments.last)
    if arguments.json:
        print(
            json.dumps({"read": read, "places": [{**dataclasses.asdict(place), "reference": place.reference} for place in found]}, indent=1)
        )
        return DONE if found else FINDING
    for place in found:
        factor = f", {place.factor} counts to one" if place.factor > 1 else ""
        print(f"{place.table} register {place.address} ({place.reference}): {place.type} {place.order}{factor}: {place.value:.9g}")
    if not found:
        print(
            f"{arguments.find:g} was found in none of the {read} registers that could be read; try --first, --last, --unit", file=sys.stderr
        )
    return DONE if found else FINDING
