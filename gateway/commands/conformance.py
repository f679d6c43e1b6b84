"""Test the conformance of a device: 3964R, RK512, Modbus, CANopen, CiA 402; verdicts with reasons, times, traces and a report."""

import argparse
import contextlib
import io
import json
import pathlib
import sys
from collections.abc import Callable, Sequence

from gateway.conformance.framework.bench_file import BadFile
from gateway.conformance.reporting.document import FORMAT, KIND
from gateway.conformance.reporting.folder import BadReport
from gateway.tools.conformance import compare_reports, list_suites, new_case, new_pics, play_mutants, run_suite, verify_folder
from gateway.tools.conformance.run import Stop
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate conformance run 3964r --port /dev/ttyUSB0 --report out        tests the station at this port
  axisgate conformance run rk512 --bench station.toml --json > r.json    the complete result as JSON
  axisgate conformance run rk512 --bench station.toml --failed-from r.json
exit code: 0 only PASS, WARN, N/A or waived, 1 a FAIL, 2 command line or files, 3 ERROR, or INCONC without FAIL"""
USAGE, ENVIRONMENT = 2, 3


def main(argv: list[str]) -> int:
    arguments = _parsed(argv)
    run: Callable[[argparse.Namespace], int] = arguments.run
    try:
        return run(arguments)
    except (BadFile, BadReport, Stop, ValueError) as error:
        return _refused(arguments, USAGE, str(error).splitlines())
    except KeyboardInterrupt:
        return _refused(arguments, ENVIRONMENT, ["interrupted before the first case; nothing was tested"])
    except BrokenPipeError:  # `| head` has seen enough: __main__ ends quietly
        raise
    except OSError as error:
        return _refused(arguments, ENVIRONMENT, [str(error.args[-1] if error.args else error)])


def _parsed(argv: list[str]) -> argparse.Namespace:
    """argparse ends the program itself; with --json its complaint is printed as an object as well."""
    if "--json" not in argv:
        return _parser().parse_args(argv)
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            return _parser().parse_args(argv)
    except SystemExit as ended:
        if ended.code == USAGE:
            _print_errors("", USAGE, said.getvalue().strip().splitlines()[-1:])
        raise
    finally:
        sys.stderr.write(said.getvalue())


def _refused(arguments: argparse.Namespace, code: int, faults: Sequence[str]) -> int:
    """Report what stops a command before it has a result; with --json also as one object on standard output."""
    for fault in faults:
        complain("conformance", fault)
    if getattr(arguments, "json", False):
        _print_errors(getattr(arguments, "suite", None) or "", code, faults)
    return code


def _print_errors(suite: str, code: int, faults: Sequence[str]) -> None:
    """A result with `errors` and without cases."""
    found = {"kind": KIND, "format": FORMAT, "suite": {"name": suite}, "exit": code, "errors": list(faults), "counts": {}, "cases": []}
    with contextlib.suppress(OSError):  # standard output may have failed
        print(json.dumps(found, ensure_ascii=False), flush=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="axisgate conformance", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    tools = parser.add_subparsers(dest="tool", required=True)

    def tool(name: str, help_text: str, run: Callable[[argparse.Namespace], int]) -> argparse.ArgumentParser:
        found = tools.add_parser(name, help=help_text, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter)
        found.set_defaults(run=run)
        found.add_argument("--language", choices=("en", "de"), help="language of report and summaries (default: the system's)")
        return found

    listed = tool("list", "list the suites, or the cases of one", list_suites)
    listed.add_argument("suite", nargs="?", metavar="SUITE")
    listed.add_argument("--json", action="store_true", help="all fields of each case")
    _run_options(tool("run", "test a device", run_suite))
    pics = tool("new-pics", "write a PICS from questions to the device and to you", new_pics)
    pics.add_argument("suite", metavar="SUITE")
    _device(pics)
    pics.add_argument("--output", type=pathlib.Path, metavar="FILE", help="file to write (default: standard output)")
    new = tool("new", "print the skeleton of a case", new_case)
    new.add_argument("suite", metavar="SUITE")
    new.add_argument("id", metavar="ID", help="id of the new case, such as 3964R_RCV_BV_21")
    mutants = tool("mutants", "run a suite against faulty devices and count those it detects", play_mutants)
    mutants.add_argument("suite", metavar="SUITE")
    mutants.add_argument("--json", action="store_true")
    compared = tool("compare", "compare the verdicts of two reports", compare_reports)
    compared.add_argument("a", type=pathlib.Path, metavar="A", help="folder or JSON of the older report")
    compared.add_argument("b", type=pathlib.Path, metavar="B", help="folder or JSON of the newer report")
    compared.add_argument("--json", action="store_true")
    checked = tool("verify", "verify that no byte of a report folder has changed", verify_folder)
    checked.add_argument("folder", type=pathlib.Path, metavar="DIR", help="folder of the report")
    checked.add_argument("--json", action="store_true")
    return parser


def _device(tool: argparse.ArgumentParser) -> None:
    tool.add_argument("--bench", type=pathlib.Path, metavar="FILE", help="bench file (TOML): device, port, link, what may be touched")
    tool.add_argument(
        "--port",
        metavar="URL",
        help="instead of a bench file: /dev/ttyUSB0, COM5, pty:/path, tcp://host:port, socketcan:can0, sim, machine:FILE.py:FACTORY",
    )


def _run_options(tool: argparse.ArgumentParser) -> None:
    tool.add_argument("suite", metavar="SUITE", help="suite to run; axisgate conformance list shows all")
    _device(tool)
    tool.add_argument("--pics", type=pathlib.Path, metavar="FILE", help="what the maker states about the device (new-pics writes one)")
    tool.add_argument("--report", type=pathlib.Path, metavar="DIR", help="folder for page, JSON, JUnit and traces")
    tool.add_argument("--json", action="store_true", help="one JSON object on standard output, progress on standard error")
    tool.add_argument("--only", action="append", default=[], metavar="ID|GROUP|GLOB", help="these cases only (may be repeated)")
    tool.add_argument("--failed-from", type=pathlib.Path, metavar="JSON", help="only the cases that did not pass in that report")
    tool.add_argument("--waivers", type=pathlib.Path, metavar="FILE", help="file of waivers: [[waiver]] with id, reason, who, until")
    tool.add_argument("--seed", type=int, metavar="N", help="seed for the order of the cases and for random data")
    tool.add_argument("--dry-run", action="store_true", help="list what would run; open and send nothing")
