"""The command line of `axisgate line`: options and examples of its tools."""

import argparse
import pathlib
from collections.abc import Callable, Mapping

from gateway.pure.lines.texts import LANGUAGES
from protocols.p3964r.profiles import PROFILES

Run = Callable[[argparse.Namespace], int]
MOST_SECONDS = 31_536_000
PORTS = "/dev/ttyUSB0, COM5, tcp://host:port, rfc2217://host:port, pty:/path, line:RUN-LINE (simulated run), sim:NAME[,PROFILE[,high|low]]"
EXAMPLES = """examples:
  axisgate line probe sim:bad-partner                          shows a report that contains FAILs
  axisgate line fetch /dev/ttyUSB0 DB11.DW0 --count 8 --type KF
  axisgate line monitor --tap /dev/ttyUSB0,/dev/ttyUSB1        listens to both wires, never sends
  axisgate line export line.rec -o line.pcapng                 for Wireshark (axisgate line export -h)
words: QVZ/ADT acknowledgement delay, ZVZ/CDT character delay, BWZ block wait time; see also axisgate line TOOL -h"""
PROBE_EXAMPLES = """examples:
  axisgate line probe sim:bad-partner
  axisgate line probe COM5 --profile siemens-cp341 --report cw4     writes cw4.json and cw4.html
  axisgate line probe /dev/ttyUSB0 --only receive --only send.silent
Blocks of the probe begin with 55h and change nothing in an RK512 station; SEND is tried with --write only.
Do not use it at a machine that moves.
exit code: 0 no FAIL, 1 at least one, 2 command line, 3 port"""
DIAGNOSE_EXAMPLES = """examples:
  axisgate line diagnose /dev/ttyUSB0 --priority low
  axisgate line diagnose --anzw 0208 --pafe 81                      what an S5 shows
  axisgate line diagnose --cp341 8 6                                event class and number of a CP 340, 341, 440
exit code: 0 nothing wrong, 1 a fault was found, 2 command line, 3 port"""
SEND_EXAMPLES = """examples:
  axisgate line send sim:good DB10.DW2 --type KF 1200 -350
  axisgate line send COM5 DB12.DD0 --type KG 1200.5 --bytes         KG: S5 float; REAL: IEEE
  axisgate line send COM5 DB10.DW0 --type KH,KF 0101 1200
exit code: 0 done, 1 refused or not sent, 2 command line, 3 port"""
FETCH_EXAMPLES = """examples:
  axisgate line fetch sim:good DB11.DW0 --count 8 --type KF,KH,KG
  axisgate line fetch /dev/ttyUSB0 DB11.DW0 --count 8 --type KF --bytes
  axisgate line fetch COM5 DB11.DW0 --json
exit code: 0 done, 1 refused or no answer, 2 command line, 3 port"""
MONITOR_EXAMPLES = """examples:
  axisgate line monitor /dev/ttyUSB0                                one wire: what its sender transmits
  axisgate line monitor --tap /dev/ttyUSB0,/dev/ttyUSB1 --json      both wires, two receive-only adapters
  axisgate line monitor --tap COM5,COM6 --save line.rec             and saves the recording for learn and export
  axisgate line monitor --record line.rec                           a recording instead of a line"""
LEARN_EXAMPLES = """examples:
  axisgate line learn line.rec                                      the draft on standard output
  axisgate learn line line.rec -o cell.toml                         the same command by its other name
  axisgate learn line --tap /dev/ttyUSB0,/dev/ttyUSB1 --seconds 3600 --save line.rec -o cell.toml
  axisgate learn line --tap COM5,COM6                               live, until Ctrl-C; listens only
A is the tap in the wire the PLC sends on, B the one in the other; learn never sends.
exit code: 0 done, 2 command line or nothing to learn from, 3 port"""


# ---- command line
def parser(what: str | None, tools_run: Mapping[str, Run]) -> argparse.ArgumentParser:
    """All six tools; `what`: purpose of the command, `tools_run`: function of each."""
    top = argparse.ArgumentParser("axisgate line", description=what, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter)
    tools = top.add_subparsers(dest="tool", required=True, metavar="TOOL")
    _probe_arguments(_tool(tools, "probe", "run all tests against a station", PROBE_EXAMPLES, tools_run["probe"]))
    _diagnose_arguments(_tool(tools, "diagnose", "find the fault of a line and its remedy", DIAGNOSE_EXAMPLES, tools_run["diagnose"]))
    _send_arguments(_tool(tools, "send", "write data words of a passive RK512 station", SEND_EXAMPLES, tools_run["send"]))
    _fetch_arguments(_tool(tools, "fetch", "read data words of a passive RK512 station", FETCH_EXAMPLES, tools_run["fetch"]))
    _monitor_arguments(_tool(tools, "monitor", "show a line decoded; never sends", MONITOR_EXAMPLES, tools_run["monitor"]))
    _learn_arguments(_tool(tools, "learn", "draft a cell from a recorded or live line", LEARN_EXAMPLES, tools_run["learn"]))
    return top


def _tool(
    tools: "argparse._SubParsersAction[argparse.ArgumentParser]",
    name: str,
    what: str,
    examples: str,
    run: Run,
) -> argparse.ArgumentParser:
    found = tools.add_parser(name, help=what, description=what, epilog=examples, formatter_class=argparse.RawDescriptionHelpFormatter)
    found.set_defaults(run=run)
    return found


def _seconds(text: str) -> float:
    """Above 0, at most a year."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value <= MOST_SECONDS:
        raise argparse.ArgumentTypeError(f"{text!r}: seconds above 0 expected, at most {MOST_SECONDS}")
    return value


def _block(text: str) -> int:
    """Number of a data block."""
    if not text.isdecimal() or not 0 <= int(text) <= 255:
        raise argparse.ArgumentTypeError(f"{text!r}: number of a data block expected, 0..255")
    return int(text)


def _line_arguments(tool: argparse.ArgumentParser, port_optional: bool = False) -> None:
    tool.add_argument("port", metavar="PORT", nargs="?" if port_optional else None, help=PORTS)
    tool.add_argument("--format", default="9600 8E1", metavar='"9600 8E1"', help="speed, data bits, parity, stop bits (default 9600 8E1)")
    tool.add_argument(
        "--profile", default="rho3", choices=sorted(PROFILES), metavar="NAME", help=f"times and attempts: {', '.join(PROFILES)}"
    )


def _priority_argument(tool: argparse.ArgumentParser, default: str) -> None:
    tool.add_argument(
        "--priority",
        default=default,
        choices=("high", "low"),
        help=f"priority of this side; the partner has the other one (default {default})",
    )


def _language_argument(tool: argparse.ArgumentParser) -> None:
    tool.add_argument("--language", choices=LANGUAGES, help="language of verdicts, findings and report (default: the system's)")


def _probe_arguments(tool: argparse.ArgumentParser) -> None:
    _line_arguments(tool, port_optional=True)
    tool.add_argument(
        "--station-priority", choices=("high", "low"), help="priority of the station under test (default high, as old CPs are set)"
    )
    tool.add_argument("--layer", choices=("rk512", "raw"), help="layer above 3964R (default rk512)")
    tool.add_argument(
        "--stimulus", default="auto", choices=("auto", "operator", "fetch", "none"), help="how the station is made to send (auto: FETCH)"
    )
    tool.add_argument(
        "--active", action="store_true", help="when stimulated, the station sends RK512 commands; test it with wrong reactions"
    )
    tool.add_argument("--db", type=_block, default=10, help="a data block that exists (default 10)")
    tool.add_argument("--words", type=int, default=64, help="number of its words (default 64)")
    tool.add_argument("--missing-db", type=_block, default=99, help="a data block that does not exist (default 99)")
    tool.add_argument("--write", action="store_true", help="allow SEND into --db; the words read before are written back")
    tool.add_argument("--only", action="append", default=[], metavar="NAME", help="a test or a group; may be repeated")
    tool.add_argument("--list", action="store_true", help="list the tests and end")
    tool.add_argument("--report", metavar="NAME", default="", help="write NAME.json and NAME.html (default probe-TIME)")
    tool.add_argument("--no-report", action="store_true", help="write no files")
    tool.add_argument("--device", type=pathlib.Path, metavar="FILE", help="device file (TOML) with [device], [link], [stimulus]")
    _language_argument(tool)
    tool.add_argument("--json", action="store_true", help="print the report as JSON")


def _diagnose_arguments(tool: argparse.ArgumentParser) -> None:
    _line_arguments(tool, port_optional=True)
    _priority_argument(tool, "low")
    tool.add_argument("--no-scan", action="store_true", help="do not try other speeds and parities")
    _language_argument(tool)
    tool.add_argument("--anzw", metavar="HEX", help="status word an S5 shows")
    tool.add_argument("--pafe", metavar="HEX", help="parameter error byte an S5 shows")
    tool.add_argument("--cp341", nargs=2, metavar=("CLASS", "NUMBER"), help="event class (decimal) and number (hex) of a CP 340, 341, 440")
    tool.add_argument("--json", action="store_true", help="one JSON object")


def _job_arguments(tool: argparse.ArgumentParser) -> None:
    _priority_argument(tool, "low")
    tool.add_argument("--wait", type=_seconds, default=5.0, metavar="S", help="longest wait for the reaction (default 5)")
    tool.add_argument("--bytes", action="store_true", help="print the telegrams")
    _language_argument(tool)
    tool.add_argument("--json", action="store_true", help="one JSON object")


def _send_arguments(tool: argparse.ArgumentParser) -> None:
    _line_arguments(tool)
    tool.add_argument("address", metavar="DB10.DW2", help="first data word, such as DB10.DW2")
    tool.add_argument("values", nargs="+", metavar="VALUE", help="1200, 0A1F (KH), 12,34 (KY), AB (KC), 1200.5 (KG, REAL)")
    tool.add_argument(
        "--type", required=True, metavar="KF,KH,...", help="number types; the last one is used for the rest; there is no default"
    )
    _job_arguments(tool)


def _fetch_arguments(tool: argparse.ArgumentParser) -> None:
    _line_arguments(tool)
    tool.add_argument("address", metavar="DB11.DW0", help="first data word, such as DB10.DW2")
    tool.add_argument("--count", type=int, default=1, help="values, not words: a KG or REAL takes two words (default 1)")
    tool.add_argument("--type", default="KH", metavar="KF,KH,...", help="number types; the last one is used for the rest (default KH)")
    _job_arguments(tool)


def _monitor_arguments(tool: argparse.ArgumentParser) -> None:
    _line_arguments(tool, port_optional=True)
    tool.add_argument("--tap", metavar="A,B", help="two receive-only ports, one in each wire")
    tool.add_argument("--record", type=pathlib.Path, metavar="FILE", help="decode a recording instead")
    _listening_arguments(tool)
    tool.add_argument("--json", action="store_true", help="one JSON object per line")


def _listening_arguments(tool: argparse.ArgumentParser) -> None:
    tool.add_argument("--seconds", type=_seconds, help="end after this time (default: until Ctrl-C)")
    tool.add_argument("--plain", action="store_true", help="procedure 3964: blocks without check")
    tool.add_argument(
        "--save", type=pathlib.Path, metavar="FILE", help="save what is received as a record for learn, export and monitor --record"
    )


def _learn_arguments(tool: argparse.ArgumentParser) -> None:
    tool.add_argument("trace", type=pathlib.Path, nargs="?", metavar="TRACE", help="record of a line, or journal")
    tool.add_argument(
        "--tap", metavar="A,B", help="instead of a file: two receive-only ports, A in the wire the PLC sends on, B in the other"
    )
    tool.add_argument("--format", default="9600 8E1", metavar='"9600 8E1"', help="format of the taps (default 9600 8E1)")
    _listening_arguments(tool)
    tool.add_argument("-o", "--output", type=pathlib.Path, metavar="FILE", help="write the draft there")
