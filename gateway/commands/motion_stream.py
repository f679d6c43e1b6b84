"""Run a stream of statements on a cell: each moves the axes as soon as it is known, answers come block by block."""

import argparse
import contextlib
import json
import pathlib
import select
import sys
import time
from collections.abc import Iterator
from typing import TextIO

from gateway.assembly.programs import machines_of_cell, mask_of
from gateway.commands.motion_run import stopped
from gateway.pure.cell.cell import Cell
from gateway.tools.cell_argument import load
from gateway.tools.client import Row, ToolClient, ToolError
from gateway.tools.client import mask_of as named_axes
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.motion.ready import client_of, reference
from gateway.tools.usage_language import complain
from motion.errors import MotionError

EXAMPLES = """examples:
  axisgate motion stream scara moves.txt --sim      statements of a file, all emulated
  axisgate motion stream cell.toml                  statements as they are typed; an empty line: run to the last target
  axisgate motion stream cell.toml - --robot 2      of the second robot of the cell
a line that begins with ! is an order: !hold, !go, !retrace (back along the path until !hold), !flush (rest on the path, drop what waits),
!cut N (drop what follows block N), !single (each block waits for !step; !run ends it), !end (done where the axes are)
Ctrl-C, or the end of this command, stops on the path and drops the rest.
exit code: 0 done, 1 refused or ended early, 2 unknown cell or file, 3 no such run"""
POLL_S = 0.02
WAITING = 256  # blocks of a file that are sent ahead
ORDERS: dict[str, Row] = {"run": {"do": "single", "on": False}, "end": {"do": "end_here"}}  # where the word is not the request's


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate motion stream", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", metavar="CELL", help="cell file, or the name of a shipped one")
    parser.add_argument("file", metavar="FILE", nargs="?", default="-", help="statements (default: standard input)")
    parser.add_argument("--sim", action="store_true", help="run the cell under simulation for this")
    parser.add_argument("--ready", action="store_true", help="drives on and reference run first (a simulation does it anyway)")
    parser.add_argument("--robot", type=int, default=1, metavar="N", help="which robot of the cell, from 1 (default 1)")
    parser.add_argument("--name", help="name of the run, if it differs from the file")
    parser.add_argument("--json", action="store_true", help="each answer as a line of JSON")
    options = parser.parse_args(argv)
    cell = load(options.cell)
    if isinstance(cell, int):
        return cell
    try:
        machines = machines_of_cell(cell)
        mask = mask_of(cell, machines[options.robot - 1]) if 1 <= options.robot <= len(machines) else 0
    except MotionError as error:
        return _said(error, USAGE)
    if not mask:
        return _said(f"--robot {options.robot}: the cell has {len(machines)} robots", USAGE)
    try:
        with _lines(options.file) as source, client_of(options, cell) as client:
            try:
                return _play(client, cell, mask, source, options)
            except ToolError as error:
                return _said(error, FINDING)
    except OSError as error:
        return _said(error, USAGE)
    except ToolError as error:
        return _said(error, ENVIRONMENT)


def _said(error: object, code: int) -> int:
    complain("motion stream", error)
    return code


@contextlib.contextmanager
def _lines(path: str) -> Iterator[TextIO]:
    if path == "-":
        yield sys.stdin
    else:
        with pathlib.Path(path).open(encoding="utf-8") as file:
            yield file


def _play(client: ToolClient, cell: Cell, mask: int, source: TextIO, options: argparse.Namespace) -> int:
    every = named_axes(cell, [axis.name for axis in cell.axis])
    client.command("request_control")
    try:
        if options.sim or options.ready:
            client.take_over()
            client.command("enable", every)
            reference(client, cell)
        answer = client.ask("stream", do="begin", robot=options.robot, mask=mask)
        try:
            answer = _result(client, answer, source, options)
        except KeyboardInterrupt:
            answer = stopped(client, answer)
        except ToolError:
            with contextlib.suppress(ToolError):
                stopped(client, answer)
            raise
    finally:
        with contextlib.suppress(ToolError):
            if options.sim:
                client.command("disable", every)
            client.command("release_control")
    words = "" if answer["state"] == "DONE" else f": {answer['words']} {answer['detail']}"
    print(f"{str(answer['state']).lower()}{words}".rstrip(), flush=True)
    return DONE if answer["state"] == "DONE" else FINDING


def _result(client: ToolClient, answer: Row, source: TextIO, options: argparse.Namespace) -> Row:
    """Feed the stream until it has an outcome; print the progress of its blocks."""
    job, shown, over, words = answer.get("job"), (0, 0), False, answer.get("order_fault")
    typed = source is sys.stdin
    while answer["open"]:
        room = int(str(answer["said"])) - int(str(answer["passed"])) < WAITING
        if not over and (room or typed) and (not typed or select.select([source], (), (), POLL_S)[0]):
            text = source.readline()
            over = text == ""
            answer = _said_or_ordered(client, answer, text, typed=typed)
        else:
            time.sleep(POLL_S)
            answer = client.ask("stream", do="look", job=job)
        shown = _show(answer, shown, as_json=options.json)
        if answer["order_fault"] not in ("", words):
            print(answer["order_fault"], file=sys.stderr)
        words = answer["order_fault"]
    return answer


def _said_or_ordered(client: ToolClient, answer: Row, text: str, *, typed: bool) -> Row:
    """Pass on a line of the source: a statement, or an order to the stream.  A refusal of a typed line is printed, and the stream
    continues.
    """
    line, job = text.strip(), answer["job"]
    try:
        if line.startswith("!"):
            return _ordered(client, job, line[1:].split())
        then = "end" if text == "" else "" if line else "finish"
        return client.ask("stream", do="say", job=job, lines=[line] if line else [], then=then)
    except ToolError as error:
        if not typed or text == "":
            raise
        print(error, file=sys.stderr)
        return client.ask("stream", do="look", job=job)


def _ordered(client: ToolClient, job: object, words: list[str]) -> Row:
    what, *rest = words or [""]
    if len(rest) > (what == "cut") or (what == "cut" and not (rest and rest[0].isdecimal())):
        raise ToolError(f"!{' '.join(words)}: {'!cut and the number of a block' if what == 'cut' else 'nothing follows the order'}")
    request = {"do": what, **ORDERS.get(what, {}), **({"block": int(rest[0])} if rest else {})}
    return client.ask("stream", job=job, **request)


def _show(answer: Row, shown: tuple[int, int], *, as_json: bool) -> tuple[int, int]:
    passed, answers = int(str(answer["passed"])), answer["answers"]
    assert isinstance(answers, list)
    fresh = [each for each in answers if each["block"] > shown[1]]
    if passed > shown[0] or fresh:
        if as_json:
            print(json.dumps({"passed": passed, "block": answer["block"], "position": answer["position"], "answers": fresh}), flush=True)
        else:
            for each in fresh:
                print(f"block {each['block']}: {'met' if each['met'] else 'not met'} {_places(each['places'])}".rstrip())
            print(f"block {passed} passed", flush=True)
    return max(passed, shown[0]), max([shown[1], *(each["block"] for each in fresh)])


def _places(places: list[float | None]) -> str:
    return ", ".join("-" if place is None else f"{place:.3f}" for place in places)
