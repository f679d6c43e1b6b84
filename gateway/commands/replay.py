"""Replay a recording on the core in virtual time and compare the outputs with the recorded ones."""

import argparse
import json
import pathlib
from typing import Any

from gateway.pure.cell.cell import Cell
from gateway.pure.image.records.cell import AxisFlag
from gateway.pure.recording.messages import ServiceEvent, Source
from gateway.recording.file import Found, RecordError, read
from gateway.recording.replay import Verdict, recorded_cell, replay
from gateway.tools.cell_argument import load
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.progress import Progress
from gateway.tools.usage_language import complain, result_text

EXAMPLES = """examples:
  axisgate replay monday.axrec                              contents of the file
  axisgate replay monday.axrec --diff                       the cell as it was recorded: the first difference, or none
  axisgate replay monday.axrec --diff --cell changed.toml   the same inputs with another cell: where do they differ?
exit code: 0 no difference, 1 a difference, 2 command line, cell or file, 3 the file cannot be read"""
SOURCES = {Source.HEARD: "heard", Source.SAID: "said", Source.WRITTEN: "inputs", Source.COMMAND: "command", Source.TOOL: "tool"}


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate replay", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", metavar="FILE", type=pathlib.Path)
    parser.add_argument("--diff", action="store_true", help="replay it and show the first difference")
    parser.add_argument("--cell", metavar="CELL", help="with another cell than the recorded one")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(argv)
    if options.cell and not options.diff:
        parser.error("--cell needs --diff")
    try:
        found = read(options.file)
        return _diff(options, found) if options.diff else _show(options, found)
    except RecordError as error:
        return _said(error, USAGE)
    except OSError as error:
        return _said(f"{error.filename}: {error.strerror}; axisgate record CELL -o {options.file.name} makes one", ENVIRONMENT)


def _said(error: object, code: int) -> int:
    complain("replay", error)
    return code


def _holds(options: argparse.Namespace, found: Found) -> dict[str, Any]:
    head = found.head
    shown = {name: head[name] for name in ("cell", "sha256", "version", "wall", "p5_ms", "simulated")}
    return {
        "file": str(options.file),
        **shown,
        "cycles": found.cycles,
        "segments": len(found.segments),
        "lost": [*found.lost, *({"at_byte": at, "why": "a block of the file is spoiled"} for at in found.spoiled)],
        "cut_bytes": found.cut,
        "ended": found.ended,
    }


def _show(options: argparse.Namespace, found: Found) -> int:
    holds = _holds(options, found)
    if options.json:
        print(json.dumps(holds))
        return DONE
    _sentences(holds)
    print(result_text(f"next: axisgate replay {options.file} --diff"))
    return DONE


def _sentences(holds: dict[str, Any]) -> None:
    seconds = holds["cycles"] * holds["p5_ms"] / 1000.0
    print(
        result_text(f"{holds['file']}: {holds['cell']}, {holds['wall']}, {holds['cycles']} cycles of {holds['p5_ms']} ms ({seconds:.1f} s)")
    )
    print(result_text(f"  cell file sha256 {holds['sha256'][:16]}, axisgate {holds['version']}, {holds['segments']} starts"))
    for entry in holds["lost"]:
        place = f"after cycle {entry['after_cycle']}" if "after_cycle" in entry else f"at byte {entry['at_byte']}"
        print(result_text(f"  lost {place}: {entry['why']}"))
    if holds["cut_bytes"]:
        print(result_text(f"  {holds['cut_bytes']} bytes of a half block at the end are left out"))
    if not holds["ended"]:
        print(result_text("  the recorder did not end it: its last half second may be missing"))


def _diff(options: argparse.Namespace, found: Found) -> int:
    if not found.segments:
        return _said(f"{options.file}: contains no start; a recording begins when nothing moves", USAGE)
    with recorded_cell(found) as pristine:
        cell: Cell = pristine
        if options.cell:
            other = load(options.cell)
            if isinstance(other, int):
                return other
            cell = other
        with Progress("replay", found.cycles) as said:
            verdict = replay(found, pristine, cell, said=said)
    _judged(options, found, verdict)
    return DONE if verdict.first is None else FINDING


def _judged(options: argparse.Namespace, found: Found, verdict: Verdict) -> None:
    first, holds = verdict.first, _holds(options, found)
    if options.json:
        difference = None
        if first is not None:
            difference = {"cycle": first.cycle, "at_s": round(verdict.at_s, 6), "name": first.name}
            difference |= {"expected": _plain(first.expected), "got": _plain(first.got), "more_in_this_cycle": verdict.also}
            difference["events"] = [_event_text(each, first.stamp_ns) for each in verdict.events_before]
        played = {"played": verdict.cycles, "played_s": round(verdict.seconds, 3), "without_outputs": verdict.without_outputs}
        print(json.dumps({**holds, **played, "equal": first is None, "first": difference}))
        return
    _sentences(holds)
    if first is None:
        print(result_text(f"no difference in {verdict.cycles} cycles"))
        return
    print(result_text(f"first difference: cycle {first.cycle}, {verdict.at_s:.3f} s after the beginning: {first.name}"))
    print(result_text(f"  expected {_plain(first.expected)}"))
    print(result_text(f"  got      {_plain(first.got)}"))
    if verdict.also:
        print(result_text(f"  and {verdict.also} more in the same cycle"))
    for each in verdict.events_before:
        print(f"  {_event_text(each, first.stamp_ns)}")


def _plain(value: object) -> object:
    """Enumerations by their numbers, flags by their names."""
    if isinstance(value, AxisFlag):
        return " ".join(flag.name or "" for flag in AxisFlag if flag & value) or "none"
    return int(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _event_text(each: ServiceEvent, stamp_ns: int) -> str:
    words = each.data.decode(errors="replace") if each.source is Source.TOOL else each.data.hex(" ")
    return f"{(each.stamp - stamp_ns) / 1e6:+.1f} ms command source {each.number} {SOURCES[each.source]}: {words}"
