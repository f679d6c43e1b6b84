"""`axisgate program run|start|stop|status`: programs of the old controller in a cell."""

import argparse
import contextlib
import json
import time
from collections.abc import Iterator

from gateway.assembly.run import slug_of
from gateway.pure.cell.cell import Cell
from gateway.pure.image.records.cell import Motion
from gateway.registry import CONTROLLERS, NO_PROGRAMS, language_in
from gateway.tools.cell_argument import load
from gateway.tools.client import Row, ToolClient, ToolError, heeded, interrupt_later, mask_of, running, simulated
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, INTERRUPTED, USAGE
from gateway.tools.usage_language import complain

IN_CELLS = ("run", "start", "stop", "status")
WAYS = {"ended": "ended after {seconds:.2f} s", "breakpoint": "is halted at the breakpoint {place}"}
POLL_S = 0.05
STOP_AGAIN_S = 5.0
KEPT_S = 10.0  # a full or slow disk
COMES_S = 30.0  # the interpreter reads and checks all programs first


def add_to(tools: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """The tools that need a cell."""
    helps = {
        "run": "run a program in a cell until it ends",
        "start": "start a program in the running cell, as the panel does",
        "stop": "stop a process of the running cell",
        "status": "show programs and processes of the running cell",
    }
    for word, text in helps.items():
        parser = tools.add_parser(word, help=text)
        parser.add_argument("cell", metavar="CELL", help="cell file, or the name of a shipped one")
        if word != "status":
            parser.add_argument("program", metavar="PROGRAM")
        if word == "run":
            parser.add_argument("--sim", action="store_true", help="run the cell under simulation for this")
            parser.add_argument("--ready", action="store_true", help="drives on and reference run first (a simulation does it anyway)")
        parser.add_argument("--name", help="name of the run, if it differs from the file")
        parser.add_argument("--json", action="store_true")


def run_in_cell(options: argparse.Namespace) -> int:
    """One of them."""
    cell = load(options.cell)
    if isinstance(cell, int):
        return cell
    if language_in(cell) is None:
        return _said(f"{options.cell} has no programs: {NO_PROGRAMS}", USAGE)
    try:
        with heeded(), _client(options, cell) as client:
            try:
                return _done(client, cell, options)
            except ToolError as error:
                return _said(str(error), FINDING)
    except ToolError as error:
        return _said(str(error), ENVIRONMENT)
    except KeyboardInterrupt as interrupt:
        return _said(str(interrupt) or "interrupted before its end", INTERRUPTED)


def _said(words: str, code: int) -> int:
    complain("program", words)
    return code


@contextlib.contextmanager
def _client(options: argparse.Namespace, cell: Cell) -> Iterator[ToolClient]:
    if options.tool == "run" and options.sim:
        with simulated(options.cell) as (client, _):
            client.wait_ready()
            yield client
    else:
        with running(options.name or slug_of(cell)) as client:
            yield client


def _done(client: ToolClient, cell: Cell, options: argparse.Namespace) -> int:
    _wait_for_programs(client)
    match options.tool:
        case "status":
            return _status(client, options)
        case "start":
            client.ask("process", do="start", name=options.program)
            print(f"{options.program} is started")
            return DONE
        case "stop":
            client.ask("process", do="stop", name=options.program)
            print(f"{options.program} is stopped")
            return DONE
    found = play(client, cell, options)
    print(json.dumps(found, indent=1) if options.json else found["sentence"])
    lost = [str(each) for each in _list(found["lost"])]
    for each in lost:
        complain("program", each)
    return DONE if found["how"] == "ended" and not lost else FINDING


def _wait_for_programs(client: ToolClient) -> None:
    end = time.monotonic() + COMES_S
    while not client.ask("process", do="list")["id"]:
        if time.monotonic() > end:
            raise ToolError("the interpreter is not running; see the journal for the reason")
        time.sleep(POLL_S)


def _status(client: ToolClient, options: argparse.Namespace) -> int:
    found = client.ask("process", do="list")
    if options.json:
        print(json.dumps({"programs": found["programs"], "processes": found["processes"]}, indent=1))
        return DONE
    for row in _rows(found["programs"]):
        print(f"program {row['name']:<13} {row['kind']:<10} {row['fault'] or 'can run'}")
    for row in _rows(found["processes"]):
        if row["task"]:
            state = f": {row['error']}" if row["error"] else " suspended" if row["state"] == "suspended" else ""
            print(f"task    {row['task']:<13} {row['program']} line {row['line']}{state}")
            continue
        waits = f", waits for {row['waits']}" if row["waits"] else ""
        if row["holder"]:
            waits = f", waits for {row['held']}, held by {row['holder']}"
        waits += ": blocked, they wait for each other" if row["stuck"] else ""
        where = f"{row['line']} of {row['external']}" if row["external"] else row["line"]
        print(f"process {row['program']:<13} {row['kind']:<10} line {where}{waits}")
    return DONE


def _rows(found: object) -> list[Row]:
    return [row for row in _list(found) if isinstance(row, dict)]


def _list(found: object) -> list[object]:
    return found if isinstance(found, list) else []


def play(client: ToolClient, cell: Cell, options: argparse.Namespace) -> Row:
    """Start it and stay until it is over; the axes are left at rest whatever happens."""
    every = mask_of(cell, [axis.name for axis in cell.axis])
    client.command("request_control")
    run: object = None
    try:
        if options.sim or options.ready:
            client.take_over()
            client.command("enable", every)
            searched = mask_of(cell, [axis.name for axis in cell.axis if axis.home.by != "none"])
            if searched:
                client.command("reference", searched, timeout_s=120.0)
        began = time.monotonic()
        try:
            with interrupt_later():  # or a program that has begun would not be stopped
                run = client.ask("process", do="start", name=options.program)["run"]
            answer = _over(client, run, options.program)
        except KeyboardInterrupt:
            if run is None:
                raise
            answer = _stopped(client, run, options.program)
        seconds = time.monotonic() - began
        _rest(client, cell)
        answer["lost"] = _lost(client, run)
    except KeyboardInterrupt as interrupt:
        if run is None:
            raise KeyboardInterrupt(f"{options.program}: interrupted before it began") from interrupt
        raise
    finally:
        with contextlib.suppress(ToolError):
            if options.sim:
                client.command("disable", every)
            client.command("release_control")
    return _result(client, options.program.upper(), answer, seconds)


def _stopped(client: ToolClient, run: object, name: str) -> Row:
    """Orders the stop until the program is over: an order may be refused or lost."""
    again = 0.0
    while not (answer := client.ask("process", do="state", run=run))["over"]:
        if time.monotonic() >= again:
            with contextlib.suppress(ToolError):
                client.ask("process", do="stop", name=name)
            again = time.monotonic() + STOP_AGAIN_S
        time.sleep(POLL_S)
    return answer


def _over(client: ToolClient, run: object, name: str) -> Row:
    failed: Row = {}
    while not (answer := client.ask("process", do="state", run=run))["over"]:
        rows = _rows(answer["rows"])
        if rows and all(row["error"] for row in rows) and not failed:  # no task can continue: their application would never end
            code, _, text = str(rows[0]["error"]).partition(" ")
            place = f"{rows[0]['program']} line {rows[0]['line']}"
            failed = {"how": "aborted", "code": int(code), "text": text, "place": place}
            client.ask("process", do="stop", name=name)
        time.sleep(POLL_S)
    return {**answer, **failed}


def _lost(client: ToolClient, run: object) -> list[object]:
    """Sentences about files that the program has written and that are not on the disk: known once the interpreter has written all."""
    end = time.monotonic() + KEPT_S
    while not (answer := client.ask("process", do="state", run=run)).get("kept", True) and time.monotonic() < end:
        time.sleep(POLL_S)
    return _list(answer.get("lost"))


def _rest(client: ToolClient, cell: Cell) -> None:
    """Discard the rest of a stopped program; a control that resumes keeps it for the next START."""
    kept = cell.controller is not None and CONTROLLERS[cell.controller.kind].resumes
    rest = (Motion.IDLE, Motion.STOPPED) if kept else (Motion.IDLE,)
    end = time.monotonic() + 5.0
    while int(str(client.ask("axes")["motion"])) not in rest and time.monotonic() < end:
        time.sleep(POLL_S)


def _result(client: ToolClient, name: str, answer: Row, seconds: float) -> Row:
    rows = {str(row["name"]): float(str(row["actual"])) for row in client.axes()}
    places = ", ".join(f"{axis} {place:.3f}" for axis, place in rows.items())
    words = WAYS.get(str(answer["how"]), str(answer["how"])).format(seconds=seconds, **answer)
    if answer["code"] or (answer["text"] and answer["how"] != "ended"):  # the controls have messages without a number, too
        what = f"{answer['code']} {answer['text']}" if answer["code"] else str(answer["text"])
        words = f"{answer['how']}: {answer['place']}: {what}".replace(": :", ":")
    facts = {"program": name, **{key: answer[key] for key in ("how", "code", "text", "place")}, "seconds": round(seconds, 3), "axes": rows}
    return {**facts, "lost": answer.get("lost", []), "sentence": f"{name} {words}; the axes are at {places}"}
