"""`axisgate conformance run`: from files and options to a device, a run and its reports."""

import argparse
import contextlib
import datetime
import difflib
import functools
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import FrameType

from drivers.ports.base import PortError
from gateway.conformance.framework.base import Tester
from gateway.conformance.framework.bench_file import BadFile, Bench, Waiver, load_bench, load_pics, load_waivers
from gateway.conformance.framework.result import Result
from gateway.conformance.framework.run import Runner, Session, ordered
from gateway.conformance.framework.witness import Witness
from gateway.conformance.reporting.document import Circumstances, cases_of, code_of, counts, document
from gateway.conformance.reporting.folder import load, suite_of, write_folder
from gateway.conformance.reporting.german import verdict_text
from gateway.conformance.suites.opening import Opened, OpenPort, factory_of
from gateway.conformance.suites.registry import SUITES, Suite
from gateway.conformance.suites.scores import SCORES
from gateway.links.serial.tool_wire import ToolPort
from gateway.pure.conformance.purpose import Purpose, selected, unknown
from gateway.pure.conformance.verdict import Verdict
from gateway.pure.lines.texts import language_of
from gateway.tools.usage_language import complain

NOT_PASSED = ("FAIL", "ERROR", "INCONC")
DEFAULT_SEED = 1
ENVIRONMENT, DONE = 3, 0
END_LIMIT_S = 3.0
OWN_GROUP = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)  # Windows: Ctrl-C does not reach the device


class Stop(Exception):
    """A fault of the command line, in one sentence."""


def suite_named(name: str) -> Suite:
    if name not in SUITES:
        near = difflib.get_close_matches(name, SUITES, n=1, cutoff=0.4)
        raise Stop(f"suite {name}: there are {', '.join(SUITES)}" + (f"; did you mean {near[0]}?" if near else ""))
    return SUITES[name]


def language(arguments: argparse.Namespace, bench: Bench | None = None) -> str:
    stated = bench.report.get("language") if bench is not None else None
    return language_of(arguments.language or (str(stated) if stated in ("en", "de") else None), dict(os.environ))


def bench_of(arguments: argparse.Namespace, items: Mapping[str, str] | None = None) -> Bench:
    if (arguments.bench is None) == (arguments.port is None):
        raise Stop("one of --bench FILE and --port URL expected")
    return load_bench(arguments.bench, items) if arguments.bench is not None else Bench(None, arguments.port)


def files_of(suite: Suite, arguments: argparse.Namespace) -> tuple[Bench, dict[str, object], dict[str, Waiver]]:
    """Bench, PICS (stated by the bench, then by the file) and waivers; BadFile lists the faults of all three."""
    faults: list[str] = []
    bench, stated, waivers = Bench(None, ""), dict[str, object](), dict[str, Waiver]()
    ids = frozenset(purpose.id for purpose in suite.purposes())
    try:
        bench = bench_of(arguments, suite.pics_keys)
    except BadFile as bad:
        faults += bad.faults
    try:
        stated = dict(bench.pics) | (load_pics(arguments.pics, suite.pics_keys) if arguments.pics is not None else {})
    except BadFile as bad:
        faults += bad.faults
    try:
        waivers = load_waivers(arguments.waivers, ids, datetime.date.today()) if arguments.waivers is not None else {}
    except BadFile as bad:
        faults += bad.faults
    if faults:
        raise BadFile(faults)
    return bench, stated, waivers


def chosen(suite: Suite, arguments: argparse.Namespace) -> list[Purpose[Tester]]:
    """Cases selected by --only and --failed-from."""
    purposes = suite.purposes()
    if strange := unknown(purposes, arguments.only):
        near = difflib.get_close_matches(strange[0], [purpose.id for purpose in purposes], n=1, cutoff=0.5)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise Stop(f"--only {', '.join(strange)}: no such case{hint} (axisgate conformance list {suite.name})")
    found = selected(purposes, arguments.only)
    if arguments.failed_from is not None:
        earlier = load(arguments.failed_from)
        if (other := suite_of(earlier)) != suite.name:
            raise Stop(f"--failed-from {arguments.failed_from}: is a report of the suite {other}, not of {suite.name}")
        failed = {str(case["id"]) for case in cases_of(earlier) if case["verdict"] in NOT_PASSED}
        if gone := failed - {purpose.id for purpose in purposes}:
            words = f"--failed-from {arguments.failed_from}: the suite {suite.name} {suite.version} no longer has {', '.join(sorted(gone))}"
            complain("conformance", words)
        found = [purpose for purpose in found if purpose.id in failed]
    if not found:
        raise Stop("nothing is selected: --only and --failed-from leave no case")
    return found


def run_suite(arguments: argparse.Namespace) -> int:
    suite = suite_named(arguments.suite)
    bench, stated, waivers = files_of(suite, arguments)
    purposes = chosen(suite, arguments)
    make = factory_of(bench, suite.frames, suite.sim)
    if arguments.dry_run:
        return _dry(suite, bench, stated, purposes, arguments)
    if make is not None:
        make()  # a factory that raises is a fault of the bench file
    with ending_like_ctrl_c(), started(bench), witnessed(make is not None) as witness:
        seed = DEFAULT_SEED if arguments.seed is None else arguments.seed
        opened = Opened(bench, stated, port_opener(bench), make, witness, seed, say=functools.partial(_say, language(arguments, bench)))
        return _played(suite, bench, stated, purposes, waivers, opened, arguments)


def _played(
    suite: Suite,
    bench: Bench,
    stated: Mapping[str, object],
    purposes: Sequence[Purpose[Tester]],
    waivers: Mapping[str, Waiver],
    opened: Opened,
    arguments: argparse.Namespace,
) -> int:
    session = suite.session(opened)
    try:
        done = [0]

        def progress(result: Result) -> None:
            done[0] += 1
            _progress(result, done[0], len(purposes), arguments)

        runner = Runner(session, purposes, arguments.seed, waivers, progress)
        checked: Mapping[str, object] = {}
        try:
            checked = _checked(session)
        except KeyboardInterrupt:
            runner.interrupted = True
        results = runner.run()
    finally:
        with contextlib.suppress(PortError):
            session.close()
    with _undisturbed():
        return _reported(suite, bench, stated, runner, session, checked, results, arguments)


def _reported(
    suite: Suite,
    bench: Bench,
    stated: Mapping[str, object],
    runner: Runner,
    session: Session,
    checked: Mapping[str, object],
    results: Sequence[Result],
    arguments: argparse.Namespace,
) -> int:
    assumed = [*session.assumed, *(f"{key}: has no effect in the suite {suite.name}" for key in bench.named() if key not in suite.keys)]
    assumed += [f"waiver of {one.purpose.id}: not needed, the case passed" for one in results if one.waived and one.verdict is Verdict.PASS]
    ran = Circumstances(assumed, checked, arguments.seed, runner.interrupted)
    found = document(suite, bench, stated, results, ran, SCORES[suite.name])
    code = code_of(results)
    if arguments.report is not None:
        try:
            write_folder(arguments.report, found, results, language(arguments, bench))
            print(f"report: {arguments.report / 'report.html'}", file=sys.stderr if arguments.json else sys.stdout)
        except OSError as error:
            complain("conformance", f"the report cannot be written to {arguments.report}: {error.strerror or error}")
            code = code or ENVIRONMENT
    if arguments.json:
        _print_json(found)
    else:
        print(", ".join(f"{count} {name}" for name, count in counts(results).items() if count))
    return code


def _print_json(found: Mapping[str, object]) -> None:
    """Last of all: a full disk at standard output costs no report."""
    try:
        print(json.dumps(found, ensure_ascii=False), flush=True)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(error.errno, f"the JSON cannot be written to standard output: {error.strerror or error}") from error


def _checked(session: Session) -> Mapping[str, object]:
    try:
        return session.self_check()
    except PortError as error:
        return {"failed": str(error.args[-1] if error.args else error)}


def _progress(result: Result, done: int, of: int, arguments: argparse.Namespace) -> None:
    stream = sys.stderr if arguments.json else sys.stdout
    german = language(arguments) == "de"
    waived = f" ({'Ausnahme bis' if german else 'waived until'} {result.waived.until})" if result.waived else ""
    summary = result.purpose.summary_de if german else result.purpose.summary
    said = verdict_text(result.reason, language(arguments)) or summary
    print(f"[{done}/{of}] {result.verdict.value:7}{waived} {result.purpose.id}  {said}", file=stream, flush=True)


def _dry(
    suite: Suite, bench: Bench, stated: Mapping[str, object], purposes: Sequence[Purpose[Tester]], arguments: argparse.Namespace
) -> int:
    """Opens nothing: the PICS decides, the rest is discovered at the device."""
    rows = []
    for purpose in ordered(purposes, arguments.seed):
        missing = [key for key in purpose.condition if stated.get(key) is False]
        rows.append({"id": purpose.id, "run": not missing, "reason": f"the PICS has no {', '.join(missing)}" if missing else ""})
    if arguments.json:
        print(json.dumps({"kind": "axisgate conformance dry run", "format": 1, "suite": suite.name, "port": bench.url, "cases": rows}))
        return DONE
    for row in rows:
        print(f"{'run' if row['run'] else 'N/A':4} {row['id']}  {row['reason']}".rstrip())
    print(f"{sum(bool(row['run']) for row in rows)} of {len(rows)} cases would be run at {bench.url}; nothing was opened")
    return DONE


def _say(spoken: str, text: str) -> None:
    """Instruction to the operator, in that language."""
    print(f">>> {verdict_text(text, spoken)}", file=sys.stderr, flush=True)


def port_opener(bench: Bench) -> OpenPort:
    """With the marks of a pty as the bench states them."""
    return lambda url, line_format: open_port(url, line_format, bench.marks)


def open_port(url: str, line_format: str, marks: bool | None = None) -> ToolPort:
    from gateway.tools.line.ports import open_port as opener

    try:
        return opener(url, line_format, marks)
    except ImportError as error:
        raise PortError(0, f"this port needs {error.name}, which this system does not have; use COM..., rfc2217:// or tcp://") from error


@contextlib.contextmanager
def witnessed(simulated: bool) -> Iterator[Witness | None]:
    """In virtual time no host is late."""
    if simulated:
        yield None
        return
    witness = Witness()
    try:
        yield witness
    finally:
        witness.close()


@contextlib.contextmanager
def started(bench: Bench) -> Iterator[None]:
    """The device's own program, ended with the run, and all that it started.  Ctrl-C is for the run alone: the device lives until the
    case is over."""
    if not bench.start:
        yield
        return
    try:
        child = subprocess.Popen(
            bench.start,
            cwd=bench.folder,
            stdout=subprocess.DEVNULL,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            creationflags=OWN_GROUP,
        )
    except OSError as error:
        raise BadFile([f"{bench.path}: device.start {bench.start[0]}: cannot be started ({error.strerror or error})"]) from error
    try:
        time.sleep(0.2)
        yield
    finally:
        _end(child)


@contextlib.contextmanager
def ending_like_ctrl_c() -> Iterator[None]:
    """A kill or a closed terminal would leave the device running: report what was done and end the device."""
    with _handled(signal.default_int_handler, "SIGTERM", "SIGHUP"):
        yield


@contextlib.contextmanager
def _undisturbed() -> Iterator[None]:
    """A second Ctrl-C still yields the complete report."""
    with _handled(signal.SIG_IGN, "SIGINT", "SIGTERM", "SIGHUP"):
        yield


@contextlib.contextmanager
def _handled(handler: Callable[[int, FrameType | None], None] | signal.Handlers, *names: str) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    found = [getattr(signal, name) for name in names if hasattr(signal, name)]
    before = [(number, signal.signal(number, handler)) for number in found]
    try:
        yield
    finally:
        for number, earlier in before:
            signal.signal(number, earlier)


def _end(child: subprocess.Popen[bytes]) -> None:
    _signal(child, "SIGTERM")
    try:
        child.wait(END_LIMIT_S)
    except subprocess.TimeoutExpired:
        _signal(child, "SIGKILL")
        child.wait()


def _signal(child: subprocess.Popen[bytes], name: str) -> None:
    """To the complete group of the program, on systems with groups."""
    if hasattr(os, "killpg"):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, getattr(signal, name))
    else:
        child.kill() if name == "SIGKILL" else child.terminate()
