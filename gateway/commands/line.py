"""Tools at a 3964R line: probe a station, diagnose a line, send and fetch data words, monitor, learn a cell from a recording."""

import argparse
import contextlib
import json
import os
import pathlib
import sys
import time
import tomllib
from collections.abc import Callable, Iterable

from drivers.ports.base import PortError
from drivers.ports.linewire import parse_format
from gateway.line_tools import cases_rk512
from gateway.line_tools.client import Client
from gateway.line_tools.client import Refused as JobRefused
from gateway.line_tools.diagnose import gather
from gateway.line_tools.learn import NoTrace, characters, learned, of_line
from gateway.line_tools.monitor import Monitor, Printer, Recorder, forget, replay
from gateway.line_tools.partners import Station
from gateway.line_tools.ports import open_port, open_wire
from gateway.line_tools.probe import Result, Settings, all_cases, counted, exit_code, probe, stamp
from gateway.line_tools.report import as_dict, to_html, to_json
from gateway.line_tools.transfer import BadInput, decoded, encoded, kinds, place, words_needed
from gateway.line_tools.wire import ToolPort, VirtualWire, Wire
from gateway.pure.line_decoder import Told
from gateway.pure.line_diagnosis import Finding, anzw, cp341, judge, pafe
from gateway.pure.line_learning import Learned
from gateway.pure.line_texts import LANGUAGES, in_language, language_of, said
from protocols.base.errors import ProtocolError
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.profiles import PROFILES, Priority, Profile

DONE, FINDING, USAGE, ENVIRONMENT = 0, 1, 2, 3
LEVELS = ("fault", "warn", "ok", "note")  # of a finding
PLEASE = "Please make the station send now"
PORTS = "/dev/ttyUSB0, COM5, tcp://host:port, rfc2217://host:port, pty:/path, line:RUN-LINE (simulated run), sim:NAME[,PROFILE[,high|low]]"
EXAMPLES = """examples:
  axisgate line probe sim:bad-partner                          a look at a report that has FAILs
  axisgate line fetch /dev/ttyUSB0 DB11.DW0 --count 8 --type KF
  axisgate line monitor --tap /dev/ttyUSB0,/dev/ttyUSB1        listens to both wires, never sends
  axisgate line export line.rec -o line.pcapng                 for Wireshark (axisgate line export -h)
words: QVZ/ADT acknowledgement delay, ZVZ/CDT character delay, BWZ block wait time; axisgate line TOOL -h tells more"""
PROBE_EXAMPLES = """examples:
  axisgate line probe sim:bad-partner
  axisgate line probe COM5 --profile siemens-cp341 --report cw4     writes cw4.json and cw4.html
  axisgate line probe /dev/ttyUSB0 --only receive --only send.silent
Blocks of the probe begin with 55h and change nothing in an RK512 station; SEND is tried with --write only.  Not at a machine that moves.
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
  axisgate line monitor /dev/ttyUSB0                                one wire: what its sender says
  axisgate line monitor --tap /dev/ttyUSB0,/dev/ttyUSB1 --json      both wires, two receive-only adapters
  axisgate line monitor --tap COM5,COM6 --save line.rec             and keeps what it hears, for learn and export
  axisgate line monitor --record line.rec                           a recording instead of a line"""
LEARN_EXAMPLES = """examples:
  axisgate line learn line.rec                                      the draft on standard output
  axisgate learn line line.rec -o cell.toml                         the same command by its other name
  axisgate learn line --tap /dev/ttyUSB0,/dev/ttyUSB1 --seconds 3600 --save line.rec -o cell.toml
  axisgate learn line --tap COM5,COM6                               live, until Ctrl-C; listens only
A is the tap in the wire the PLC sends on, B the one in the other; learn has nothing to send with.
exit code: 0 done, 2 command line or nothing to learn from, 3 port"""


def main(argv: list[str]) -> int:
    if argv[:1] == ["export"]:
        from gateway.commands.line_export import main as export  # its own options

        return export(argv[1:])
    arguments = parser().parse_args(argv)
    try:
        run: Callable[[argparse.Namespace], int] = arguments.run
        return run(arguments)
    except (BadInput, NoTrace, ValueError) as error:
        return _fault(arguments.tool, str(error), USAGE)
    except JobRefused as error:
        return _fault(arguments.tool, str(error), FINDING)
    except (PortError, OSError) as error:
        return _fault(arguments.tool, str(error.args[-1] if isinstance(error, PortError) else error), ENVIRONMENT)
    except ImportError as error:
        return _fault(
            arguments.tool, f"this port needs {error.name}, which this system has not; use COM..., rfc2217:// or tcp://", ENVIRONMENT
        )
    except KeyboardInterrupt:
        return DONE


def _fault(tool: str, text: str, code: int) -> int:
    print(f"axisgate line {tool}: {text}", file=sys.stderr)
    return code


# ---- command line
def parser() -> argparse.ArgumentParser:
    """All six tools."""
    top = argparse.ArgumentParser(
        "axisgate line", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    tools = top.add_subparsers(dest="tool", required=True, metavar="TOOL")
    _probe_arguments(_tool(tools, "probe", "test a station against the whole list", PROBE_EXAMPLES, run_probe))
    _diagnose_arguments(_tool(tools, "diagnose", "what is wrong with this line, in words", DIAGNOSE_EXAMPLES, run_diagnose))
    _send_arguments(_tool(tools, "send", "write data words of a passive RK512 station", SEND_EXAMPLES, run_send))
    _fetch_arguments(_tool(tools, "fetch", "read data words of a passive RK512 station", FETCH_EXAMPLES, run_fetch))
    _monitor_arguments(_tool(tools, "monitor", "show a line decoded; never sends", MONITOR_EXAMPLES, run_monitor))
    _learn_arguments(_tool(tools, "learn", "draft of a cell out of a recorded or living line", LEARN_EXAMPLES, run_learn))
    return top


def _tool(
    tools: "argparse._SubParsersAction[argparse.ArgumentParser]",
    name: str,
    what: str,
    examples: str,
    run: Callable[[argparse.Namespace], int],
) -> argparse.ArgumentParser:
    found = tools.add_parser(name, help=what, description=what, epilog=examples, formatter_class=argparse.RawDescriptionHelpFormatter)
    found.set_defaults(run=run)
    return found


def _line_arguments(tool: argparse.ArgumentParser, port_optional: bool = False) -> None:
    tool.add_argument("port", metavar="PORT", nargs="?" if port_optional else None, help=PORTS)
    tool.add_argument("--format", default="9600 8E1", metavar='"9600 8E1"', help="speed, data bits, parity, stop bits (default 9600 8E1)")
    tool.add_argument(
        "--profile", default="rho3", choices=sorted(PROFILES), metavar="NAME", help=f"times and attempts: {', '.join(PROFILES)}"
    )


def _priority_argument(tool: argparse.ArgumentParser, default: str) -> None:
    tool.add_argument(
        "--priority", default=default, choices=("high", "low"), help=f"ours; the partner has the other one (default {default})"
    )


def _language_argument(tool: argparse.ArgumentParser) -> None:
    tool.add_argument("--language", choices=LANGUAGES, help="of verdicts, findings and report (default: as the system speaks)")


def _probe_arguments(tool: argparse.ArgumentParser) -> None:
    _line_arguments(tool, port_optional=True)
    tool.add_argument("--station-priority", choices=("high", "low"), help="of the station under test (default high, as old CPs are set)")
    tool.add_argument("--layer", choices=("rk512", "raw"), help="what rides on 3964R (default rk512)")
    tool.add_argument(
        "--stimulus", default="auto", choices=("auto", "operator", "fetch", "none"), help="how the station is made to send (auto: FETCH)"
    )
    tool.add_argument("--active", action="store_true", help="stimulated, the station sends RK512 commands: wrong reactions are tried on it")
    tool.add_argument("--db", type=int, default=10, help="a data block that exists (default 10)")
    tool.add_argument("--words", type=int, default=64, help="words it has (default 64)")
    tool.add_argument("--missing-db", type=int, default=99, help="a data block that does not exist (default 99)")
    tool.add_argument("--write", action="store_true", help="allow SEND into --db; what was read is written back")
    tool.add_argument("--only", action="append", default=[], metavar="NAME", help="a test or a group; may be given several times")
    tool.add_argument("--list", action="store_true", help="only the list of the tests")
    tool.add_argument("--report", metavar="NAME", default="", help="writes NAME.json and NAME.html (default probe-TIME)")
    tool.add_argument("--no-report", action="store_true", help="writes no files")
    tool.add_argument("--device", type=pathlib.Path, metavar="FILE", help="device file (TOML) with [device], [link], [stimulus]")
    _language_argument(tool)
    tool.add_argument("--json", action="store_true", help="the report on standard output")


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
    tool.add_argument("--wait", type=float, default=5.0, metavar="S", help="longest wait for the reaction (default 5)")
    tool.add_argument("--bytes", action="store_true", help="print the telegrams")
    tool.add_argument("--json", action="store_true", help="one JSON object")


def _send_arguments(tool: argparse.ArgumentParser) -> None:
    _line_arguments(tool)
    tool.add_argument("address", metavar="DB10.DW2", help="first data word")
    tool.add_argument("values", nargs="+", metavar="VALUE", help="1200, 0A1F (KH), 12,34 (KY), AB (KC), 1200.5 (KG, REAL)")
    tool.add_argument(
        "--type", required=True, metavar="KF,KH,...", help="number types; the last one holds for the rest; there is no default"
    )
    _job_arguments(tool)


def _fetch_arguments(tool: argparse.ArgumentParser) -> None:
    _line_arguments(tool)
    tool.add_argument("address", metavar="DB11.DW0", help="first data word")
    tool.add_argument("--count", type=int, default=1, help="values, not words: a KG or REAL takes two words (default 1)")
    tool.add_argument("--type", default="KH", metavar="KF,KH,...", help="number types; the last one holds for the rest (default KH)")
    _job_arguments(tool)


def _monitor_arguments(tool: argparse.ArgumentParser) -> None:
    _line_arguments(tool, port_optional=True)
    tool.add_argument("--tap", metavar="A,B", help="two receive-only ports, one in each wire")
    tool.add_argument("--record", type=pathlib.Path, metavar="FILE", help="decode a recording instead")
    _listening_arguments(tool)
    tool.add_argument("--json", action="store_true", help="one JSON object a line")


def _listening_arguments(tool: argparse.ArgumentParser) -> None:
    tool.add_argument("--seconds", type=float, help="end after so long (default: until Ctrl-C)")
    tool.add_argument("--plain", action="store_true", help="procedure 3964: blocks without check")
    tool.add_argument(
        "--save", type=pathlib.Path, metavar="FILE", help="keep what is heard as a record for learn, export and monitor --record"
    )


def _learn_arguments(tool: argparse.ArgumentParser) -> None:
    tool.add_argument("trace", type=pathlib.Path, nargs="?", metavar="TRACE", help="record of a line, or journal")
    tool.add_argument("--tap", metavar="A,B", help="live instead: two receive-only ports, A in the wire the PLC sends on, B in the other")
    tool.add_argument("--format", default="9600 8E1", metavar='"9600 8E1"', help="of the taps (default 9600 8E1)")
    _listening_arguments(tool)
    tool.add_argument("-o", "--output", type=pathlib.Path, metavar="FILE", help="write the draft there")


# ---- the tools
def run_probe(arguments: argparse.Namespace) -> int:
    device = _device(arguments)
    if arguments.list:
        for case in all_cases(_settings(arguments, None)):
            print(f"{case.name:26} {in_language(case.title, _language(arguments))}")
        return DONE
    if not arguments.port:
        raise BadInput(f"PORT is missing: {PORTS}")
    wire = open_wire(arguments.port, arguments.format)
    results: list[Result] = []
    gone: PortError | None = None

    def told(result: Result) -> None:
        results.append(result)
        if not arguments.json:
            _tell(result, _language(arguments))

    try:
        settings = _settings(arguments, wire)
        if not all_cases(settings):
            raise BadInput(f"--only {' '.join(arguments.only)}: no such test; --list shows them")
        probe(wire, settings, lambda: _operator(device, _language(arguments)), told)
    except PortError as error:
        gone = error  # what was seen so far is reported all the same
    finally:
        wire.close()
    facts = {key: str(value) for key, value in device.get("device", {}).items()}
    if gone is not None:
        facts["Broken off"] = said("after {} tests: {}", len(results), str(gone.args[-1]))
    language = _language(arguments)
    report = as_dict(results, settings, arguments.port, arguments.format, stamp(), wire.simulated, facts, language)
    _write_report(report, results, arguments)
    if gone is not None:
        raise gone
    return exit_code(results)


def _write_report(report: dict[str, object], results: list[Result], arguments: argparse.Namespace) -> None:
    """Files and the last lines."""
    name = arguments.report or f"probe-{time.strftime('%Y%m%d-%H%M%S')}"
    if not arguments.no_report:
        pathlib.Path(f"{name}.json").write_text(to_json(report), encoding="utf-8")
        pathlib.Path(f"{name}.html").write_text(to_html(report), encoding="utf-8")
    if arguments.json:
        print(to_json(report), end="")
        return
    language = _language(arguments)
    print(", ".join(f"{count} {in_language(word, language)}" for word, count in counted(results).items() if count))
    if not arguments.no_report:
        print(in_language(said("report: {}.html, {}.json", name, name), language))
    print(report["text"])


def _tell(result: Result, language: str) -> None:
    verdict, text = in_language(result.verdict, language), in_language(result.reason or result.case.title, language)
    print(f"{verdict:12} {result.case.name:26} {text}", flush=True)


def _language(arguments: argparse.Namespace) -> str:
    return language_of(arguments.language, os.environ)


def _operator(device: dict[str, dict[str, object]], language: str) -> None:
    prompt = device.get("stimulus", {}).get("prompt", "")
    text = prompt.get(language, prompt.get("en", "")) if isinstance(prompt, dict) else str(prompt)
    print(f">>> {text or in_language(PLEASE, language)}", file=sys.stderr, flush=True)


def _device(arguments: argparse.Namespace) -> dict[str, dict[str, object]]:
    """The device file; what it says of the link stands in for options that were not given."""
    if arguments.device is None:
        return {}
    try:
        found: dict[str, dict[str, object]] = tomllib.loads(arguments.device.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"{arguments.device}: {error}; TOML wants one key a line, without semicolons") from error
    link = found.get("link", {})
    arguments.port = arguments.port or link.get("port")
    arguments.format = str(link.get("format", arguments.format))
    arguments.station_priority = arguments.station_priority or link.get("priority_of_device")
    profile = str(link.get("profile", arguments.profile))
    if profile not in PROFILES:
        raise BadInput(f"{arguments.device}: link.profile {profile!r} is unknown; there are {', '.join(PROFILES)}")
    arguments.profile = profile
    how = found.get("stimulus", {}).get("how")
    if how in ("operator", "none") and arguments.stimulus == "auto":
        arguments.stimulus = how
    return found


def _settings(arguments: argparse.Namespace, wire: Wire | None) -> Settings:
    station = wire.station if isinstance(wire, VirtualWire) else None
    known = station if isinstance(station, Station) else None
    profile = known.profile if known and arguments.port.count(",") else PROFILES[arguments.profile]
    priority = arguments.station_priority or (known.priority.name.lower() if known else "high")
    layer = arguments.layer or ("raw" if known and known.passive is None else "rk512")
    spot = cases_rk512.Place(arguments.db, 0, arguments.words, arguments.missing_db, arguments.write or known is not None)
    return Settings(profile, Priority[priority.upper()], layer, arguments.stimulus, arguments.active, spot, tuple(arguments.only))


def run_diagnose(arguments: argparse.Namespace) -> int:
    found = list(_shown(arguments))
    if arguments.port:
        seen = gather(
            lambda line_format: open_wire(arguments.port, line_format),
            arguments.format,
            PROFILES[arguments.profile],
            arguments.priority,
            arguments.port,
            not arguments.no_scan,
        )
        found += judge(seen)
    elif not found:
        raise BadInput(f"PORT, --anzw, --pafe or --cp341 expected; ports: {PORTS}")
    language = _language(arguments)
    if arguments.json:
        told = [(one.name, one.level, in_language(one.text, language), in_language(one.todo, language)) for one in found]
        print(json.dumps([dict(zip(("name", "level", "text", "todo"), one, strict=True)) for one in told], indent=1))
    else:
        width = max(6, *(len(in_language(level, language)) for level in LEVELS))
        for one in found:
            level, name, text = (in_language(each, language) for each in (one.level, one.name, one.text))
            print(f"{level:{width}} {name}: {text}")
            if one.todo:
                print(" " * (width + 1) + in_language(said("do: {}", one.todo), language))
    return FINDING if any(one.level == "fault" for one in found) else DONE


def _shown(arguments: argparse.Namespace) -> Iterable[Finding]:
    """What the partner shows, put in words."""
    if arguments.anzw is not None:
        yield from anzw(_hex("--anzw", arguments.anzw, 0xFFFF))
    if arguments.pafe is not None:
        yield pafe(_hex("--pafe", arguments.pafe, 0xFF))
    if arguments.cp341 is not None:
        group, number = arguments.cp341
        if not group.isdecimal():
            raise BadInput(f"--cp341 {group}: a class such as 8, then a number such as 06 expected")
        yield cp341(int(group), _hex("--cp341", number, 0xFF))


def _hex(name: str, text: str, most: int) -> int:
    try:
        value = int(text.rstrip("hH"), 16)
    except ValueError:
        value = -1
    if not 0 <= value <= most:
        raise BadInput(f"{name} {text}: hexadecimal 0..{most:X} expected")
    return value


def _client(arguments: argparse.Namespace) -> Client:
    profile: Profile = PROFILES[arguments.profile]
    wire = open_wire(arguments.port, arguments.format)
    return Client(wire, profile, Priority[arguments.priority.upper()], ms(1000 * arguments.wait))


def run_send(arguments: argparse.Namespace) -> int:
    db, word = place(arguments.address)
    data = encoded(kinds(arguments.type), arguments.values)
    client = _client(arguments)
    try:
        client.send(db, word, data)
    finally:
        client.wire.close()
        _print_bytes(client, arguments)
    words = len(data) // 2
    if arguments.json:
        print(json.dumps({"written": words, "db": db, "word": word, "bytes": data.hex()}))
    else:
        print(f"written: DB{db}.DW{word}{f'..DW{word + words - 1}' if words > 1 else ''}, {words} words: {data.hex(' ').upper()}")
    return DONE


def run_fetch(arguments: argparse.Namespace) -> int:
    db, word = place(arguments.address)
    types = kinds(arguments.type)
    if arguments.count < 1:
        raise BadInput(f"--count {arguments.count}: at least 1 expected")
    client = _client(arguments)
    try:
        data = client.fetch(db, word, words_needed(types, arguments.count))
    finally:
        client.wire.close()
        _print_bytes(client, arguments)
    values = decoded(types, db, word, data)
    if arguments.json:
        print(json.dumps([{"at": one.address, "type": one.kind, "value": one.value, "bytes": one.data.hex()} for one in values], indent=1))
    else:
        for one in values:
            print(f"{one.address:12} {one.kind:5} {one.text:>14}   {one.data.hex(' ').upper()}")
    return DONE


def _print_bytes(client: Client, arguments: argparse.Namespace) -> None:
    if arguments.bytes:
        for telegram in client.traffic:
            print(f"{'>' if telegram.ours else '<'} {telegram.data.hex(' ').upper()}", file=sys.stderr)


def run_monitor(arguments: argparse.Namespace) -> int:
    printer = Printer(lambda text: print(text, flush=True), arguments.json)
    if arguments.record is not None:
        replay(characters(arguments.record.read_text(encoding="utf-8", errors="replace")), printer)
        return DONE
    names = arguments.tap.split(",") if arguments.tap else [arguments.port] if arguments.port else []
    if not names or (arguments.tap and len(names) != 2):
        raise BadInput("PORT, --tap A,B (two ports) or --record FILE expected")
    _listen(arguments, names, printer)
    return DONE


def _listen(arguments: argparse.Namespace, names: list[str], tell: Callable[[Told], None]) -> None:
    """One port or two, read only, for --seconds or until Ctrl-C; kept in --save."""
    with contextlib.ExitStack() as stack:
        ports: list[tuple[str, ToolPort]] = []
        for side, name in zip("AB", names, strict=False):
            port = open_port(name, arguments.format)
            stack.callback(port.close)
            ports.append((side, port))
        keep: Callable[[Ns, str, int | Damage], None] = forget
        if arguments.save is not None:
            out = stack.enter_context(arguments.save.open("w", encoding="ascii", buffering=1))
            keep = Recorder(out, "tap", parse_format(arguments.format), time.monotonic_ns())
        monitor = Monitor(ports, time.monotonic_ns, tell, not arguments.plain, keep)
        monitor.run(None if arguments.seconds is None else ms(1000 * arguments.seconds))


def run_learn(arguments: argparse.Namespace) -> int:
    if bool(arguments.trace) is bool(arguments.tap):
        raise BadInput("TRACE, or live --tap A,B (two ports), expected")
    seen, text = _learned_live(arguments) if arguments.tap else _learned(arguments.trace)
    if arguments.output is None:
        print(text, end="")
    else:
        arguments.output.write_text(text, encoding="utf-8")
        print(f"{arguments.output}: {seen.blocks} blocks, {len(seen.jobs)} kinds of telegrams; next: axisgate check {arguments.output}")
    return DONE


def _learned(trace: pathlib.Path) -> tuple[Learned, str]:
    try:
        return learned(trace)
    except ProtocolError as error:
        raise NoTrace(f"{trace}: {error}") from error


def _learned_live(arguments: argparse.Namespace) -> tuple[Learned, str]:
    """Ctrl-C ends the listening, not the learning."""
    names = arguments.tap.split(",")
    if len(names) != 2:
        raise BadInput("--tap A,B: two ports expected; a cell is learned from both wires")
    tolds: list[Told] = []
    print(f"axisgate learn line: listening at {arguments.tap}, Ctrl-C ends it", file=sys.stderr, flush=True)
    with contextlib.suppress(KeyboardInterrupt):
        _listen(arguments, names, tolds.append)
    return of_line(tolds, arguments.tap, parse_format(arguments.format))
