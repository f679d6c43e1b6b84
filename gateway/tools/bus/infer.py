"""`axisgate bus infer LOG`: infers the layout from a recording of the living old controller, as a DBC with a confidence per field."""

import argparse
import dataclasses
import json
import pathlib

from drivers.ports.can.wire import MAX_ID
from gateway.pure.buses.candump import frames_of
from gateway.pure.buses.inference.dbc import SURE, as_dbc, names
from gateway.pure.buses.inference.missing import missing
from gateway.pure.buses.inference.proposal import NothingFound, propose
from gateway.pure.buses.inference.roles import Inferred
from gateway.runtime.exit_codes import Exit
from gateway.tools.bus.logs import BadLog, read_log
from gateway.tools.command_support import of_file
from gateway.tools.usage_language import complain
from protocols.base.machine import Frame

EXAMPLES = """examples:
  axisgate bus infer living.log                    what was found, on standard output
  axisgate bus infer living.blf -o proposal.dbc    the proposal as a DBC; every signal has its confidence as a comment
  axisgate bus infer living.log --json             the same for a program
Record a switching on, moves of every axis in both directions over its reference switch, and a switching off.
A proposal is a proposal: confirm it on the living control before anything is enabled with it.
exit code: 0 axes were found, 1 none was, 2 the file cannot be read"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate bus infer", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("log", type=pathlib.Path, metavar="LOG", help="recording: candump .log, .asc, .blf, .trc")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FILE", help="write the proposal there as a DBC")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args(argv)
    try:
        found = propose(frames(options.log))
    except (BadLog, OSError) as error:
        complain("bus infer", of_file(error))
        return Exit.INVALID
    except NothingFound as error:
        complain("bus infer", error)
        return Exit.FINDING
    if options.output:
        options.output.write_text(as_dbc(found, options.log.name))
    print(json.dumps(as_json(found), indent=1) if options.json else "\n".join(finding_lines(found, options.output)))
    return Exit.OK if found.axes else Exit.FINDING


def frames(path: pathlib.Path) -> list[Frame]:
    """Candump text is read here, because our own broker writes more into it than python-can reads; other formats by python-can."""
    if path.suffix == ".log":
        with path.open(encoding="utf-8", errors="replace") as file:
            return list(frames_of(file))
    return [frame for frame in read_log(path) if frame.identifier <= MAX_ID]  # data frames of drives


def finding_lines(found: Inferred, output: pathlib.Path | None) -> list[str]:
    """The lines for a person."""
    order = "high byte first" if found.reverse else "low byte first"
    called = names(found)
    sync = f"SYNC {found.cycles.sync}" if found.cycles.sync is not None else "no SYNC without data"
    lines = [f"{len(found.axes)} axes, cycle {found.cycles.period_ns / 1e6:g} ms, {order}, {sync}"]
    for axis in found.axes:
        for identifier in (axis.set_id, axis.actual_id):
            lines.append(f"{called[identifier]} (identifier {identifier})")
            for each in found.of(identifier):
                place = f"bit {each.start}" if each.bits == 1 else f"bits {each.start}..{each.start + each.bits - 1}"
                lines.append(f"  {each.name:<18} {place:<12} {each.confidence:4.2f}  {each.why}")
    sure = sum(each.confidence >= SURE for each in found.signals)
    lines.append(f"{sure} of {len(found.signals)} signals at {SURE} or above; the others are to be confirmed on the living control")
    lines += [f"missing: {each}" for each in missing(found)]
    return [*lines, f"next: axisgate bus monitor PORT --dbc {output}" if output else "next: axisgate bus infer LOG -o proposal.dbc"]


def as_json(found: Inferred) -> dict[str, object]:
    """For a program."""
    return {
        "sync": found.cycles.sync,
        "period_ms": found.cycles.period_ns / 1e6,
        "byte_order": "big" if found.reverse else "little",
        "axes": [dataclasses.asdict(axis) for axis in found.axes],
        "messages": names(found),
        "missing": missing(found),
        "signals": [dataclasses.asdict(each) for each in found.signals],
    }
