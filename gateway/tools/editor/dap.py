"""The debug adapter of `axisgate dap`: programs of old controllers in virtual time, for an editor.  Source: Debug Adapter Protocol 1.68.

Messages are JSON after a header `Content-Length: n`; the program runs between them.
"""

import itertools
import json
import os
import re
import select
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import BinaryIO

from gateway.pure.languages.baps2.feed import FeedFault
from gateway.pure.languages.base.debug import Step
from gateway.pure.languages.base.requests import RuntimeFault
from gateway.tools.editor.debugged import AdapterFault, Call, Debugged, Row

ROUNDS = 50  # of the program between two looks for messages
MOST_OCTETS, MOST_HEAD = 8 << 20, 4096  # of one message
LENGTH = re.compile(rb"^content-length: *(\d{1,9})\s*$", re.IGNORECASE | re.MULTILINE)
ABILITIES = {"supportsConfigurationDoneRequest": True, "supportsEvaluateForHovers": True, "supportsTerminateRequest": True}


def _baps2(path: Path, arguments: Row) -> Debugged:
    from gateway.tools.editor.debug_baps2 import Baps2Debugged

    return Baps2Debugged(path, arguments)


def _robotstar(path: Path, arguments: Row) -> Debugged:
    from gateway.tools.editor.debug_robotstar import RobotstarDebugged

    return RobotstarDebugged(path, arguments)


def _val3(path: Path, arguments: Row) -> Debugged:
    from gateway.tools.editor.debug_val3 import Val3Debugged

    return Val3Debugged(path, arguments)


LANGUAGES: Mapping[str, Callable[[Path, Row], Debugged]] = {
    ".qll": _baps2,
    **dict.fromkeys((".mpr", ".spr", ".mac"), _robotstar),
    **dict.fromkeys((".pgx", ".pjx"), _val3),
}


def language_of(path: Path) -> Callable[[Path, Row], Debugged] | None:
    """The language that runs a file."""
    return LANGUAGES.get(path.suffix.lower())


class Adapter:
    """One session."""

    def __init__(self, reading: int, writing: BinaryIO) -> None:
        """`reading`: file number of a pipe or socket."""
        self._inbox, self._writing = Inbox(reading), writing
        self._numbers = itertools.count(1)
        self._ids = itertools.count(1)  # of breakpoints
        self._run: Debugged | None = None
        self._moves = self._entry = self._over = False
        self._why, self._first = "entry", 1  # number of the first line
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
            "initialize": self._initialize,
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
    def _initialize(self, arguments: Row) -> Row:
        self._first = 0 if arguments.get("linesStartAt1") is False else 1
        return ABILITIES

    def _launch(self, arguments: Row) -> Row:
        """`program`: a file, its suffix is the language; `stopOnEntry`; the rest is the language's."""
        path = Path(str(arguments["program"])).resolve()
        make = language_of(path)
        if make is None or not path.is_file():
            raise AdapterFault(f"{path}: there is no such file; program is the path of a {', '.join(sorted(LANGUAGES)).upper()} file")
        self._entry = bool(arguments.get("stopOnEntry"))
        self._why = "entry" if self._entry else "breakpoint"
        self._run = make(path, arguments)
        return {}

    def _needed(self) -> Debugged:
        if self._run is None:
            raise AdapterFault("launch a program first")
        return self._run

    def _begin(self, arguments: Row) -> Row:
        self._needed().begin(entry=self._entry)
        self._moves = True
        return {}

    def _go_on(self) -> None:
        """Run some rounds; return the outcome."""
        run = self._needed()
        for _ in range(ROUNDS):
            going = run.go_on()
            if run.held() is not None or not going:
                break
        for line in run.output():
            self._event("output", category="stdout", output=f"{line}\n")
        if (thread := run.held()) is not None:
            self._moves = False
            self._places.clear()
            self._event("stopped", reason=self._why, threadId=thread, allThreadsStopped=True)
            self._why = "breakpoint"
        elif not going:
            self._ended()

    def _ended(self) -> None:
        if not self._over:
            self._moves, self._over = False, True
            self._event("exited", exitCode=0)
            self._event("terminated")

    def _resume(self, arguments: Row, how: Step) -> Row:
        run, number = self._needed(), int(arguments["threadId"])
        if run.held() is None:
            raise AdapterFault("nothing is held")
        self._why = "breakpoint" if how is Step.RUN else "step"
        run.resume(number, how)
        self._moves = True
        return {}

    def _pause(self, arguments: Row) -> Row:
        run = self._needed()
        if run.held() is None:  # else it is held already
            self._why = "pause"
            run.pause()
        return {}

    def _terminate(self, arguments: Row) -> Row:
        self._ended()
        return {}

    def _breakpoints(self, arguments: Row) -> Row:
        """A line without a statement is moved to the next one that has one."""
        run, source = self._needed(), arguments["source"]
        wanted = [int(each["line"]) + 1 - self._first for each in arguments.get("breakpoints") or ()]
        found, why = run.breakpoints(Path(str(source.get("path") or source.get("name"))), wanted)
        rows = ({"verified": True, "line": each - 1 + self._first} if each else {"verified": False, "message": why} for each in found)
        return {"breakpoints": [{"id": next(self._ids), **row} for row in rows]}

    # ---- looking ----------------------------------------------------------------------------------------------------------
    def _threads(self, arguments: Row) -> Row:
        threads = self._run.threads() if self._run is not None else []
        return {"threads": [{"id": number, "name": name} for number, name in threads]}

    def _stack(self, arguments: Row) -> Row:
        rows = [
            {
                "id": call.number,
                "name": call.name,
                "line": call.line - 1 + self._first,
                "column": 1,
                "source": {"name": call.source.name, "path": str(call.source)},
            }
            for call in self._needed().calls()
            if call.thread == int(arguments["threadId"])
        ]
        return {"stackFrames": rows, "totalFrames": len(rows)}

    def _call(self, number: object) -> Call | None:
        return next((call for call in self._needed().calls() if call.number == number), None)

    def _scopes(self, arguments: Row) -> Row:
        call = self._call(int(arguments["frameId"]))
        if call is None:
            raise AdapterFault("this frame no longer exists")
        rows = (
            {"name": name, "variablesReference": self._kept(values), "expensive": False} for name, values in call.scopes.items() if values
        )
        return {"scopes": list(rows)}

    def _kept(self, values: dict[str, object]) -> int:
        self._places.append(values)
        return len(self._places)

    def _variables(self, arguments: Row) -> Row:
        number = int(arguments["variablesReference"])
        if not 0 < number <= len(self._places):
            raise AdapterFault("these variables no longer exist")
        rows = [{"name": name, "value": shown(value), "variablesReference": 0} for name, value in self._places[number - 1].items()]
        return {"variables": rows}

    def _evaluate(self, arguments: Row) -> Row:
        """A name, in any case of letters."""
        name = str(arguments["expression"]).strip().upper()
        call = self._call(arguments.get("frameId"))
        found = {key: value for values in reversed([*call.scopes.values()]) for key, value in values.items()} if call is not None else {}
        found = {key.upper(): value for key, value in found.items()}
        if name not in found:
            raise AdapterFault(f"{name} has no value here")
        return {"result": shown(found[name]), "variablesReference": 0}


class Inbox:
    """Requests that come in.  `open` ends with the stream, or with bytes that are none of the protocol."""

    def __init__(self, number: int) -> None:
        self._number, self._data = number, b""
        self.open = True

    def take(self, *, wait: bool) -> Iterator[Row]:
        """Complete messages; `wait`: wait at least until something arrives."""
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
    """Text to show for it."""
    match fault:
        case KeyError():
            return f"{fault.args[0]} is missing"
        case OSError():
            return f"{fault.filename}: {fault.strerror}"
    return str(fault)
