"""The debug adapter of `axisgate dap`: BAPS2 programs in virtual time, for an editor.  Source: Debug Adapter Protocol 1.68.

Messages are JSON behind a head `Content-Length: n`; the program runs between them.
"""

import itertools
import json
import os
import re
import select
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from gateway.files.program_memory import baps2_words, folder_memory, read_feed
from gateway.pure.languages.baps2.debugging import DebugRun, Frame
from gateway.pure.languages.baps2.feed import Feed, FeedFault
from gateway.pure.languages.base.debug import Step
from gateway.pure.languages.base.requests import RuntimeFault

ROUNDS = 50  # of the program between two looks for messages
MOST_OCTETS, MOST_HEAD = 8 << 20, 4096  # of one message
LENGTH = re.compile(rb"^content-length: *(\d{1,9})\s*$", re.IGNORECASE | re.MULTILINE)
ABILITIES = {"supportsConfigurationDoneRequest": True, "supportsEvaluateForHovers": True, "supportsTerminateRequest": True}
Row = dict[str, Any]


class AdapterFault(Exception):
    """A request cannot be answered: one sentence."""


class Adapter:
    """One session."""

    def __init__(self, reading: int, writing: BinaryIO) -> None:
        """`reading`: file number of a pipe or socket."""
        self._inbox, self._writing = Inbox(reading), writing
        self._numbers = itertools.count(1)
        self._ids = itertools.count(1)  # of breakpoints
        self._run: DebugRun | None = None
        self._folder = Path()
        self._program = ""
        self._moves = self._entry = self._over = False
        self._why = "entry"
        self._shown = 0  # events of the trace that were sent
        self._places: list[dict[str, object]] = []  # variables by reference - 1, while everything is held

    def serve(self) -> None:
        """Until the editor disconnects."""
        while self._inbox.open:
            if self._moves:
                self._go_on()
            for request in self._inbox.take(wait=not self._moves):
                if not self._answer(request):
                    return

    # ---- messages ---------------------------------------------------------------------------------------------------------
    def _send(self, kind: str, **facts: object) -> None:
        data = json.dumps({"seq": next(self._numbers), "type": kind, **facts}).encode()
        self._writing.write(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))
        self._writing.flush()

    def _event(self, name: str, **body: object) -> None:
        self._send("event", event=name, body=body)

    def _answer(self, request: Row) -> bool:
        """Answers one request; False: it was the last one."""
        command, arguments = str(request.get("command")), request.get("arguments") or {}
        facts: Row = {"request_seq": request.get("seq", 0), "command": command}
        doing = self._doing().get(command)
        try:
            if doing is None:
                raise AdapterFault(f"{command} is not supported")
            body = doing(arguments)
        except (AdapterFault, RuntimeFault, FeedFault, OSError, KeyError, TypeError, ValueError) as fault:
            words = sentence(fault)
            self._send("response", success=False, message=words, body={"error": {"id": 1, "format": words}}, **facts)
            return True
        self._send("response", success=True, body=body, **facts)
        if command == "launch":  # breakpoints need the program
            self._event("initialized")
        return command != "disconnect"

    def _doing(self) -> Mapping[str, Callable[[Row], Row]]:
        return {
            "initialize": lambda _: ABILITIES,
            "launch": self._launch,
            "setBreakpoints": self._breakpoints,
            "setExceptionBreakpoints": lambda _: {},
            "configurationDone": self._begin,
            "threads": self._threads,
            "stackTrace": self._stack,
            "scopes": self._scopes,
            "variables": self._variables,
            "evaluate": self._evaluate,
            "continue": lambda arguments: {"allThreadsContinued": True, **self._resume(arguments, Step.RUN)},
            "next": lambda arguments: self._resume(arguments, Step.OVER),
            "stepIn": lambda arguments: self._resume(arguments, Step.INTO),
            "stepOut": lambda arguments: self._resume(arguments, Step.OUT),
            "pause": self._pause,
            "terminate": self._terminate,
            "disconnect": lambda _: {},
        }

    # ---- the run ----------------------------------------------------------------------------------------------------------
    def _launch(self, arguments: Row) -> Row:
        """`program`: a .QLL file, its folder is the memory; `feed`: a feed file; `stopOnEntry`."""
        path = Path(str(arguments["program"])).resolve()
        if not path.is_file():
            raise AdapterFault(f"{path}: there is no such file; program is the path of a .QLL file")
        feed = read_feed(Path(str(arguments["feed"]))) if arguments.get("feed") else Feed()
        self._folder, self._program = path.parent, path.stem.upper()
        self._entry = bool(arguments.get("stopOnEntry"))
        run = DebugRun(baps2_words(), folder_memory(self._folder, feed), feed)
        unit, faults = run.library.unit(self._program)
        if unit is None:
            raise AdapterFault("; ".join(str(each) for each in faults) or f"{path.name} is no program of its folder")
        self._run = run
        return {}

    def _needed(self) -> DebugRun:
        if self._run is None:
            raise AdapterFault("launch a program first")
        return self._run

    def _begin(self, arguments: Row) -> Row:
        run = self._needed()
        run.run.begin(self._program)
        if self._entry:
            run.pause()
        self._moves = True
        return {}

    def _go_on(self) -> None:
        """Some rounds; what came of it."""
        run = self._needed()
        for _ in range(ROUNDS):
            going = run.run.go_on()
            if run.held() or not going:
                break
        self._trace(run)
        if held := run.held():
            self._moves = False
            self._places.clear()
            thread = held[0].process.number
            self._event("stopped", reason=self._why, threadId=thread, allThreadsStopped=True)
            self._why = "breakpoint"
        elif not going:
            self._ended()

    def _ended(self) -> None:
        if not self._over:
            self._moves, self._over = False, True
            self._event("exited", exitCode=0)
            self._event("terminated")

    def _trace(self, run: DebugRun) -> None:
        """Events of the dry run as output."""
        for event in itertools.islice(run.run.trace, self._shown, None):
            if event["event"] == "files":
                continue
            facts = " ".join(f"{name}={value}" for name, value in event.items() if name not in ("t", "process", "line", "event"))
            text = f"{event['t']:>8} s {event['process']}:{event['line']} {event['event']} {facts}".rstrip()
            self._event("output", category="stdout", output=f"{text}\n")
        self._shown = len(run.run.trace)

    def _resume(self, arguments: Row, how: Step) -> Row:
        run, number = self._needed(), int(arguments["threadId"])
        if not run.held():
            raise AdapterFault("nothing is held")
        self._why = "breakpoint" if how is Step.RUN else "step"
        run.resume(number, how)
        self._moves = True
        return {}

    def _pause(self, arguments: Row) -> Row:
        self._why = "pause"
        self._needed().pause()
        return {}

    def _terminate(self, arguments: Row) -> Row:
        self._ended()
        return {}

    def _breakpoints(self, arguments: Row) -> Row:
        """A line without a statement takes the next one that has one."""
        run, source = self._needed(), arguments["source"]
        name = Path(str(source.get("path") or source.get("name"))).stem.upper()
        lines = run.lines(name)
        wanted = [int(each["line"]) for each in arguments.get("breakpoints") or ()]
        found = [next((line for line in lines if line >= each), None) for each in wanted]
        run.debugger.set_breakpoints(name, [each for each in found if each is not None])
        why = "no statement here or below" if lines else f"{name} is no program of this memory, or has errors"
        rows = ({"verified": True, "line": each} if each else {"verified": False, "message": why} for each in found)
        return {"breakpoints": [{"id": next(self._ids), **row} for row in rows]}

    # ---- looking ----------------------------------------------------------------------------------------------------------
    def _threads(self, arguments: Row) -> Row:
        tasks = self._run.tasks() if self._run is not None else []
        return {"threads": [{"id": task.process.number, "name": f"{task.unit.name} ({task.kind})"} for task in tasks]}

    def _frames(self) -> Iterator[tuple[int, int, Frame]]:
        """Number, thread and frame of each."""
        run = self._needed()
        for task in run.tasks():
            for depth, frame in enumerate(run.frames(task.process.number)):
                yield task.process.number * 1000 + depth, task.process.number, frame

    def _stack(self, arguments: Row) -> Row:
        rows = [
            {"id": number, "name": frame.routine, "line": frame.line, "column": 1, "source": self._source(frame.program)}
            for number, thread, frame in self._frames()
            if thread == int(arguments["threadId"])
        ]
        return {"stackFrames": rows, "totalFrames": len(rows)}

    def _source(self, program: str) -> Row:
        path = next((each for each in self._folder.iterdir() if each.name.upper() == f"{program}.QLL"), self._folder / f"{program}.QLL")
        return {"name": path.name, "path": str(path)}

    def _scopes(self, arguments: Row) -> Row:
        frame = next((frame for number, _, frame in self._frames() if number == int(arguments["frameId"])), None)
        if frame is None:
            raise AdapterFault("this frame is gone")
        parts = (("Routine", frame.own), ("Program", frame.program_wide), ("Channels", self._needed().channels(frame.program)))
        return {
            "scopes": [{"name": name, "variablesReference": self._kept(values), "expensive": False} for name, values in parts if values]
        }

    def _kept(self, values: dict[str, object]) -> int:
        self._places.append(values)
        return len(self._places)

    def _variables(self, arguments: Row) -> Row:
        number = int(arguments["variablesReference"])
        if not 0 < number <= len(self._places):
            raise AdapterFault("these variables are gone")
        rows = [{"name": name, "value": shown(value), "variablesReference": 0} for name, value in self._places[number - 1].items()]
        return {"variables": rows}

    def _evaluate(self, arguments: Row) -> Row:
        """A name, in any case of letters."""
        name = str(arguments["expression"]).strip().upper()
        frame = next((frame for number, _, frame in self._frames() if number == arguments.get("frameId")), None)
        found = {**self._needed().channels(frame.program), **frame.program_wide, **frame.own} if frame is not None else {}
        if name not in found:
            raise AdapterFault(f"{name} has no value here")
        return {"result": shown(found[name]), "variablesReference": 0}


class Inbox:
    """Requests that come in.  `open` ends with the stream, or with bytes that are none of the protocol."""

    def __init__(self, number: int) -> None:
        self._number, self._data = number, b""
        self.open = True

    def take(self, *, wait: bool) -> Iterator[Row]:
        """What is whole; `wait`: at least until something comes."""
        ready, _, _ = select.select([self._number], [], [], None if wait else 0)
        if ready:
            data = os.read(self._number, 1 << 16)
            self._data += data
            self.open = bool(data)
        while (message := self._next()) is not None:
            if message.get("type") == "request":
                yield message

    def _next(self) -> Row | None:
        head, found, rest = self._data.partition(b"\r\n\r\n")
        length = LENGTH.search(head) if found else None
        size = int(length[1]) if length is not None else 0
        if size > MOST_OCTETS or (found and length is None) or (not found and len(head) > MOST_HEAD):
            self.open = False
            return None
        if not found or len(rest) < size:
            return None
        self._data = rest[size:]
        try:
            message = json.loads(rest[:size])
        except ValueError:
            return {}
        return message if isinstance(message, dict) else {}


def shown(value: object) -> str:
    """A value as the language writes it."""
    match value:
        case None:
            return "not defined"
        case str():
            return repr(value)
        case float():
            return f"{value:g}"
        case tuple():
            return f"({', '.join(shown(each) for each in value)})"
    return str(value)


def sentence(fault: Exception) -> str:
    """What to show of it."""
    match fault:
        case KeyError():
            return f"{fault.args[0]} is missing"
        case OSError():
            return f"{fault.filename}: {fault.strerror}"
    return str(fault)
