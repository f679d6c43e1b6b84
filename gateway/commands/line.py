"""Tools for 3964R lines: test a station, diagnose a line, send and fetch data words, monitor, learn a cell from a recording."""

import argparse
import contextlib
import json
import os
import pathlib
import sys
import time
import tomllib
from collections.abc import Callable, Iterable, Iterator
from typing import TextIO

from drivers.ports.base import PortError
from drivers.ports.serial.line_format import parse_format
from gateway.conformance.report import as_dict, to_html, to_json
from gateway.conformance.serial import cases_rk512
from gateway.conformance.serial.partners import Station
from gateway.conformance.serial.run import Result, Settings, all_cases, counted, exit_code, probe, stamp, unknown
from gateway.links.serial.line_monitor import Monitor, Printer, Recorder, forget, replay
from gateway.links.serial.tool_wire import ToolPort, VirtualWire, Wire
from gateway.pure.lines.decoder import LineReport
from gateway.pure.lines.diagnosis import Finding, anzw, cp341, judge, pafe
from gateway.pure.lines.learning import Learned
from gateway.pure.lines.texts import in_language, language_of, said
from gateway.tools.command_support import of_file
from gateway.tools.line.arguments import PORTS, parser
from gateway.tools.line.client import Client
from gateway.tools.line.client import Refused as JobRefused
from gateway.tools.line.diagnose import gather
from gateway.tools.line.learn import NoTrace, characters, learned, of_line, text_of
from gateway.tools.line.ports import open_port, open_wire
from gateway.tools.line.transfer import BadInput, decoded, encoded, kinds, place, reachable, words_needed
from gateway.tools.usage_language import complain
from protocols.base.errors import ProtocolError
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.profiles import PROFILES, Priority, Profile

DONE, FINDING, USAGE, ENVIRONMENT = 0, 1, 2, 3
INTERRUPTED = 130  # by Ctrl-C, as a shell has it
MOST_COUNT = 10_000  # values; more than any block has
LEVELS = ("fault", "warn", "ok", "note")  # of a finding
PLEASE = "Please make the station send now"


def main(argv: list[str]) -> int:
    if argv[:1] == ["export"]:
        from gateway.commands.line_export import main as export  # its own options

        return export(argv[1:])
    arguments = parser(__doc__, TOOLS).parse_args(argv)
    try:
        run: Callable[[argparse.Namespace], int] = arguments.run
        return run(arguments)
    except (BadInput, NoTrace, ValueError) as error:
        return _fault(arguments.tool, str(error), USAGE)
    except JobRefused as error:
        return _fault(arguments.tool, in_language(error.text, _language(arguments)), FINDING)
    except PortError as error:
        return _fault(arguments.tool, _of_port(error), ENVIRONMENT)
    except BrokenPipeError:  # `| head`: who reads has seen enough; nothing is left to be flushed at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return ENVIRONMENT
    except OSError as error:
        return _fault(arguments.tool, of_file(error), ENVIRONMENT)
    except ImportError as error:
        return _fault(
            arguments.tool, f"this port needs {error.name}, which this system does not have; use COM..., rfc2217:// or tcp://", ENVIRONMENT
        )
    except KeyboardInterrupt:
        return DONE if arguments.tool == "monitor" else _fault(arguments.tool, "interrupted before its end", INTERRUPTED)


def _of_port(error: PortError) -> str:
    """A cell opens its port again; a tool has ended."""
    return str(error.args[-1]).partition("; it is opened again")[0]


def _fault(tool: str, text: str, code: int) -> int:
    complain(f"line {tool}", text)
    return code


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
    gone: PortError | KeyboardInterrupt | None = None

    def take(result: Result) -> None:
        results.append(result)
        if not arguments.json:
            _print_result(result, _language(arguments))

    try:
        settings = _settings(arguments, wire)
        if strange := unknown(settings):
            raise BadInput(f"--only {' '.join(strange)}: no such test; --list shows them")
        probe(wire, settings, lambda: _operator(device, _language(arguments)), take)
    except (PortError, KeyboardInterrupt) as error:
        gone = error  # what was found so far is still reported
    finally:
        wire.close()
    facts = {key: str(value) for key, value in device.get("device", {}).items()}
    if gone is not None:
        why = _of_port(gone) if isinstance(gone, PortError) else "Ctrl-C"
        facts["Broken off"] = said("after 1 test: {}", why) if len(results) == 1 else said("after {} tests: {}", len(results), why)
    language = _language(arguments)
    report = as_dict(results, settings, arguments.port, arguments.format, stamp(), wire.simulated, facts, language)
    written = _write_report(report, results, arguments)
    if gone is not None:
        raise gone
    return exit_code(results) if written else ENVIRONMENT


def _write_report(report: dict[str, object], results: list[Result], arguments: argparse.Namespace) -> bool:
    """Files and the last lines; False: the files cannot be written, and the lines are all there is."""
    name = arguments.report or f"probe-{time.strftime('%Y%m%d-%H%M%S')}"
    written = arguments.no_report or all(
        _kept(f"{name}.{end}", text) for end, text in (("json", to_json(report)), ("html", to_html(report)))
    )
    if arguments.json:
        print(to_json(report), end="")
        return written
    language = _language(arguments)
    print(", ".join(f"{count} {in_language(word, language)}" for word, count in counted(results).items() if count))
    print(report["conclusion"])
    if written and not arguments.no_report:
        print(in_language(said("report: {}.html, {}.json", name, name), language))
    print(report["text"])
    return written


def _kept(path: str, text: str) -> bool:
    try:
        pathlib.Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        _fault("probe", f"report {path} cannot be written: {error.strerror}", ENVIRONMENT)
        return False
    return True


def _print_result(result: Result, language: str) -> None:
    verdict, text = in_language(result.verdict, language), in_language(result.reason or result.case.title, language)
    print(f"{verdict:12} {result.case.name:26} {text}", flush=True)


def _language(arguments: argparse.Namespace) -> str:
    return language_of(arguments.language, dict(os.environ))


def _operator(device: dict[str, dict[str, object]], language: str) -> None:
    prompt = device.get("stimulus", {}).get("prompt", "")
    text = prompt.get(language, prompt.get("en", "")) if isinstance(prompt, dict) else str(prompt)
    print(f">>> {text or in_language(PLEASE, language)}", file=sys.stderr, flush=True)


def _device(arguments: argparse.Namespace) -> dict[str, dict[str, object]]:
    """The device file; its link settings replace options that are not set."""
    if arguments.device is None:
        return {}
    try:
        found: dict[str, dict[str, object]] = tomllib.loads(arguments.device.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"{arguments.device}: {error}; TOML needs one key per line, without semicolons") from error
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
    if not 1 <= arguments.words <= 256:
        raise BadInput(f"--words {arguments.words}: 1..256 expected, as many as DB {arguments.db} has")
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
        rows = [(one.name, one.level, in_language(one.text, language), in_language(one.todo, language)) for one in found]
        print(json.dumps([dict(zip(("name", "level", "text", "todo"), one, strict=True)) for one in rows], indent=1))
    else:
        width = max(6, *(len(in_language(level, language)) for level in LEVELS))
        for one in found:
            level, name, text = (in_language(each, language) for each in (one.level, one.name, one.text))
            print(f"{level:{width}} {name}: {text}")
            if one.todo:
                print(" " * (width + 1) + in_language(said("do: {}", one.todo), language))
    return FINDING if any(one.level == "fault" for one in found) else DONE


def _shown(arguments: argparse.Namespace) -> Iterable[Finding]:
    """The partner's behaviour, in words."""
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
    reachable(word, len(data) // 2)
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
        last = f"..DW{word + words - 1}" if words > 1 else ""
        print(f"written: DB{db}.DW{word}{last}, {_count(words, 'word')}: {data.hex(' ').upper()}")
    return DONE


def run_fetch(arguments: argparse.Namespace) -> int:
    db, word = place(arguments.address)
    types = kinds(arguments.type)
    if arguments.count < 1:
        raise BadInput(f"--count {arguments.count}: at least 1 expected")
    words = words_needed(types, min(arguments.count, MOST_COUNT))
    reachable(word, words)
    client = _client(arguments)
    try:
        data = client.fetch(db, word, words)
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
        try:
            replay(characters(text_of(arguments.record)), printer)
        except ProtocolError as error:
            raise NoTrace(f"{arguments.record}: neither a line record nor a journal: {error}") from error
        return DONE
    names = arguments.tap.split(",") if arguments.tap else [arguments.port] if arguments.port else []
    if not names or (arguments.tap and len(names) != 2):
        raise BadInput("PORT, --tap A,B (two ports) or --record FILE expected")
    _two_ports(names)
    _listen(arguments, names, printer)
    return DONE


def _two_ports(names: list[str]) -> None:
    if len(names) != len(set(names)):
        raise BadInput(f"--tap {','.join(names)}: two different ports expected, one in each wire")


def _listen(arguments: argparse.Namespace, names: list[str], report: Callable[[LineReport], None]) -> None:
    """One port or two, read only, for --seconds or until Ctrl-C; kept in --save."""
    with contextlib.ExitStack() as stack:
        ports: list[tuple[str, ToolPort]] = []
        for side, name in zip("AB", names, strict=False):
            port = open_port(name, arguments.format)
            stack.callback(port.close)
            ports.append((side, port))
        keep: Callable[[Ns, str, int | Damage], None] = forget
        if arguments.save is not None:
            out = stack.enter_context(_record(arguments.save))
            keep = Recorder(out, "tap", parse_format(arguments.format), time.monotonic_ns())
        monitor = Monitor(ports, time.monotonic_ns, report, not arguments.plain, keep)
        complain(f"line {arguments.tool}", f"listening at {' and '.join(names)}, Ctrl-C ends it")
        monitor.run(None if arguments.seconds is None else ms(1000 * arguments.seconds), lambda silence: _quiet(arguments.tool, silence))


@contextlib.contextmanager
def _record(path: pathlib.Path) -> Iterator[TextIO]:
    """The file of --save, written line by line.  A full disk fails again when it is closed, and that error has no name, either."""
    out = path.open("w", encoding="ascii", buffering=1)
    try:
        yield out
    finally:
        try:
            out.close()
        except OSError as error:
            raise OSError(error.errno, f"nothing more can be kept: {error.strerror}", str(path)) from error


def _quiet(tool: str, silence: Ns) -> None:
    words = "is the partner on, the tap in the right wire, and the format right?"
    complain(f"line {tool}", f"nothing received for {silence / 1e9:.3g} s: {words}")


def run_learn(arguments: argparse.Namespace) -> int:
    if bool(arguments.trace) is bool(arguments.tap):
        raise BadInput("TRACE, or live --tap A,B (two ports), expected")
    seen, text = _learned_live(arguments) if arguments.tap else _learned(arguments.trace)
    if arguments.output is None:
        print(text, end="")
    else:
        arguments.output.write_text(text, encoding="utf-8")
        what = f"{_count(seen.blocks, 'block')}, {_count(len(seen.jobs), 'kind')} of telegrams"
        print(f"{arguments.output}: {what}; next: axisgate check {arguments.output}")
    return DONE


def _count(amount: int, what: str) -> str:
    return f"{amount} {what}" if amount == 1 else f"{amount} {what}s"


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
    _two_ports(names)
    tolds: list[LineReport] = []
    try:
        _listen(arguments, names, tolds.append)
    except KeyboardInterrupt:
        pass
    except OSError as error:  # days of listening are not lost with an adapter, or with a full disk
        if not tolds:
            raise
        why = _of_port(error) if isinstance(error, PortError) else of_file(error)
        _fault(arguments.tool, f"{why}: learned from what was received until then", ENVIRONMENT)
    return of_line(tolds, arguments.tap, parse_format(arguments.format))


TOOLS = {
    "probe": run_probe,
    "diagnose": run_diagnose,
    "send": run_send,
    "fetch": run_fetch,
    "monitor": run_monitor,
    "learn": run_learn,
}
