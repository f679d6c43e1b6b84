"""`axisgate dap` beside an editor: a client written by others sets breakpoints, steps, looks at variables, in virtual time."""

import importlib
import json
import os
import pathlib
import re
import select
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import pytest

from hil_tests.unit.languages.val3.apps import App, datum

PICK = """PROGRAM PICK
INPUT : 1 = ready
OUTPUT : 1 = grip
INTEGER : parts
BEGIN
  parts = 0
  again:
  count(parts)
  grip = 1
  IF parts < 3 THEN JUMP again
PROGRAM_END
SUBROUTINE count (INTEGER : number)
INTEGER : before
BEGIN
  before = number
  number = before + 1
SUB_END
"""
PATIENCE_S = 30.0
BARE = ("launch", "configurationDone", "next", "stepIn", "stepOut", "disconnect")  # without a body: this client looks for one
HEAD = re.compile(rb"Content-Length: (\d+)\r\n\r\n")


class Editor:
    """The client's messages over the pipes of the adapter."""

    def __init__(self, folder: pathlib.Path) -> None:
        (folder / "PICK.QLL").write_text(PICK)
        self.program = str(folder / "PICK.QLL")
        self.process = subprocess.Popen([sys.executable, "-m", "gateway", "dap"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.client: Any = importlib.import_module("dap").Client("axisgate")  # it has no types
        self.seen: list[dict[str, Any]] = []
        self.data = b""

    def flush(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(self.client.send())
        self.process.stdin.flush()

    def until(self, what: str) -> dict[str, Any]:
        """The next event or response of that name, taken out of what has come; the client's models have judged it."""
        self.flush()
        assert self.process.stdout is not None
        end = time.monotonic() + PATIENCE_S
        while True:
            for each in self.seen:
                if each.get("event", each.get("command")) == what:
                    self.seen.remove(each)
                    return each
            ready, _, _ = select.select([self.process.stdout], [], [], max(end - time.monotonic(), 0.0))
            assert ready, f"no {what}; there were {self.seen}"
            data = os.read(self.process.stdout.fileno(), 65536)
            assert data, f"the adapter ended before {what}"
            self.data += data
            while (found := HEAD.match(self.data)) and len(self.data) >= (size := found.end() + int(found[1])):
                message, self.data = self.data[:size], self.data[size:]
                self.seen.append(json.loads(message[found.end() :]))
                if self.seen[-1].get("command") not in BARE:
                    assert len(list(self.client.receive(message))) == 1, "the client understands it"

    def launched(self, lines: list[int], **more: object) -> list[int]:
        """Breakpoints as they were set."""
        self.until("initialize")
        self.client.send_request("launch", {"program": self.program, **more})
        assert self.until("launch")["success"]
        self.until("initialized")
        self.client.send_request("setBreakpoints", {"source": {"path": self.program}, "breakpoints": [{"line": each} for each in lines]})
        found = [each["line"] for each in self.until("setBreakpoints")["body"]["breakpoints"]]
        self.client.configuration_done()
        self.until("configurationDone")
        return found

    def stopped(self) -> tuple[int, list[tuple[str, int]]]:
        """Thread, and its calls by name and line."""
        thread = int(self.until("stopped")["body"]["threadId"])
        return thread, self.calls(thread)

    def calls(self, thread: int) -> list[tuple[str, int]]:
        self.client.stack_trace(thread)
        self.frames = self.until("stackTrace")["body"]["stackFrames"]
        return [(each["name"], each["line"]) for each in self.frames]

    def variables(self, frame: int = 0) -> dict[str, dict[str, str]]:
        self.client.scopes(self.frames[frame]["id"])
        found = {}
        for scope in self.until("scopes")["body"]["scopes"]:
            self.client.variables(scope["variablesReference"])
            found[scope["name"]] = {each["name"]: each["value"] for each in self.until("variables")["body"]["variables"]}
        return found


@pytest.fixture
def editor(tmp_path: pathlib.Path) -> Iterator[Editor]:
    made = Editor(tmp_path)
    yield made
    made.process.kill()
    made.process.communicate()


def test_a_breakpoint_holds_the_program_and_shows_its_variables(editor: Editor) -> None:
    assert editor.launched([7, 16]) == [8, 16], "a label is not a statement: the next one is taken"
    thread, calls = editor.stopped()
    assert calls == [("PICK", 8)]
    assert editor.variables()["Program"]["PARTS"] == "0" and editor.variables()["Channels"] == {"READY": "0", "GRIP": "0"}
    editor.client.continue_(thread)
    thread, calls = editor.stopped()
    assert calls == [("COUNT", 16), ("PICK", 8)]
    assert editor.variables()["Routine"] == {"BEFORE": "0", "NUMBER": "0"}
    editor.client.continue_(thread)
    thread, calls = editor.stopped()
    assert calls == [("PICK", 8)] and editor.variables()["Program"]["PARTS"] == "1"
    editor.client.evaluate("grip", editor.frames[0]["id"])
    assert editor.until("evaluate")["body"]["result"] == "1", "the output of the round before acts"
    editor.client.disconnect()
    editor.until("disconnect")
    assert editor.process.wait(10) == 0


def test_an_array_is_shown_by_elements_and_lines_count_as_the_editor_counts(editor: Editor) -> None:
    text = "PROGRAM LIST\nARRAY[2..3] INTEGER : F\nBEGIN\nF[2] = 7\nF[3] = F[2]\nPROGRAM_END\n"
    pathlib.Path(editor.program).with_name("LIST.QLL").write_text(text)
    editor.program = editor.program.replace("PICK", "LIST")
    editor.flush()
    editor.until("initialize")
    editor.client.send_request("initialize", {"adapterID": "axisgate", "linesStartAt1": False})
    assert editor.launched([4]) == [4], "the fifth line"
    stopped = editor.until("stopped")["body"]
    assert (stopped["reason"], editor.calls(stopped["threadId"])) == ("breakpoint", [("LIST", 4)])
    assert editor.variables()["Program"] == {"F[2]": "7", "F[3]": "0"}


def test_steps_go_over_into_and_out_of_a_subroutine(editor: Editor) -> None:
    editor.launched([], stopOnEntry=True)
    thread, calls = editor.stopped()
    assert calls == [("PICK", 6)]
    way = []
    for order in (editor.client.next, editor.client.step_in, editor.client.step_in, editor.client.step_out, editor.client.next):
        order(thread)
        way.append(editor.stopped()[1][0])
    assert way == [("PICK", 8), ("COUNT", 15), ("COUNT", 16), ("PICK", 9), ("PICK", 10)]


def test_the_run_prints_its_events_and_ends(editor: Editor) -> None:
    editor.launched([])
    editor.until("terminated")
    printed = "".join(each["body"]["output"] for each in editor.seen if each.get("event") == "output")
    assert printed.count("out channel=1 value=1") == 3 and "PICK:10 end how=ended" in printed


def test_a_robotstar_program_is_held_stepped_and_looked_at(editor: Editor) -> None:
    folder = pathlib.Path(editor.program).parent
    (folder / "SORT.MPR").write_text('1 MPR "SORT"\n2 VAR I1\n3 COPY 4, I1\n4 CALL "UP"\n5 STOP\n6 END\n')
    (folder / "UP.SPR").write_text("SPR UP\nADD 1, I1\nEND\n")
    editor.program = str(folder / "SORT.MPR")
    assert editor.launched([4]) == [4]
    thread, calls = editor.stopped()
    assert calls == [("SORT", 4)] and editor.variables()["Global"]["I1"] == "4"
    editor.client.step_in(thread)
    assert editor.stopped()[1] == [("UP", 2), ("SORT", 4)]
    editor.client.next(thread)
    editor.stopped()
    editor.client.evaluate("i1", editor.frames[0]["id"])
    assert editor.until("evaluate")["body"]["result"] == "5"
    editor.client.continue_(thread)
    editor.until("terminated")


def test_what_cannot_be_done_is_refused_in_a_sentence(editor: Editor) -> None:
    editor.until("initialize")
    for command, given, wanted in (
        (
            "launch",
            {"program": "/nowhere/A.QLL"},
            "/nowhere/A.QLL: there is no such file; program is the path of a .MAC, .MPR, .PGX, .PJX, .QLL, .SPR file",
        ),
        ("launch", {}, "program is missing"),
        ("next", {"threadId": 1}, "launch a program first"),
        ("gotoTargets", {}, "gotoTargets is not supported"),
    ):
        editor.client.send_request(command, given)
        answer = editor.until(command)
        assert (answer["success"], answer["message"]) == (False, wanted)
    pathlib.Path(editor.program).write_text(PICK.replace("JUMP again", "JUMP agian"))
    editor.client.send_request("launch", {"program": editor.program})
    answer = editor.until("launch")
    assert not answer["success"] and "AGIAN" in answer["message"]


def test_bytes_that_are_no_message_end_it(editor: Editor) -> None:
    assert editor.process.stdin is not None
    editor.process.stdin.write(b"GET / HTTP/1.1\r\nHost: a\r\n\r\n")
    editor.process.stdin.flush()
    assert editor.process.wait(PATIENCE_S) == 0


def test_a_val3_application_is_held_at_its_lines(editor: Editor, tmp_path: pathlib.Path) -> None:
    for path, data in (
        App("demo", datum("nCount", "num"), {"start": "nCount=4\ncall add()\nnCount=9", "add": "nCount=nCount+1"}).files().items()
    ):
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_bytes(data)
    editor.program = str(tmp_path / "demo" / "start.pgx")
    rows = pathlib.Path(editor.program).read_text().splitlines()
    call = rows.index("call add()") + 1
    assert editor.launched([call]) == [call]
    thread, calls = editor.stopped()
    assert calls == [("start", call)] and editor.variables()["Global"] == {"nCount": "4"}
    editor.client.step_in(thread)
    thread, calls = editor.stopped()
    assert [name for name, _ in calls] == ["add", "start"]
    editor.client.step_out(thread)
    thread, calls = editor.stopped()
    assert calls == [("start", call + 1)] and editor.variables()["Global"] == {"nCount": "5"}
    editor.client.continue_(thread)
    editor.until("terminated")
