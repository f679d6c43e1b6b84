"""VAL 3 under the debugger: breakpoints, steps over lines, into and out of calls, variables, tasks, in virtual time."""

import pathlib

import pytest

from gateway.pure.languages.base.debug import Step
from gateway.tools.editor.debug_val3 import Val3Debugged
from gateway.tools.editor.debugged import AdapterFault, Call
from hil_tests.unit.languages.val3.apps import App, datum, value

DATA = datum("nCount", "num") + datum("aList", "num", "3", value("1", value=4)) + datum("jA", "joint", values=value(j1=2.5))
START = """nCount=1
// a comment
call add(nCount,aList[1])
taskCreate "other",10,other()
delay(0.5)
nCount=nCount*10
for nCount=1 to 3
aList[0]=nCount
endFor"""
ADD = "l_n=x_n\nx_n=l_n+x_m\nl_n=0"


@pytest.fixture
def folder(tmp_path: pathlib.Path) -> pathlib.Path:
    programs: dict[str, str | tuple[list[str], str]] = {
        "start": START,
        "add(num& x_n,num x_m)": (["num l_n"], ADD),
        "other": "delay(0.1)\naList[2]=7\ndelay(0.1)",
    }
    for path, data in App("demo", DATA, programs).files().items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_bytes(data)
    return tmp_path / "demo"


class Session:
    """A run, and where it is."""

    def __init__(self, path: pathlib.Path, **arguments: object) -> None:
        self.path, self.run = path, Val3Debugged(path, dict(arguments))

    def line(self, text: str, file: str = "start.pgx") -> int:
        """Line of a file with this text."""
        rows = (self.path.parent / file).read_text().splitlines()
        return next(number for number, row in enumerate(rows, 1) if row.strip() == text)

    def stop_at(self, *texts: str, file: str = "start.pgx") -> list[int | None]:
        return self.run.breakpoints(self.path.parent / file, [self.line(text, file) for text in texts])[0]

    def held(self) -> tuple[str, str]:
        """Runs until a task is held: task and its line."""
        while self.run.held() is None:
            assert self.run.go_on(), "it ended"
        call = self.calls()[0]
        return dict(self.run.threads())[call.thread], call.source.read_text().splitlines()[call.line - 1].strip()

    def calls(self) -> list[Call]:
        return [call for call in self.run.calls() if call.thread == self.run.held()]

    def step(self, how: Step) -> str:
        self.run.resume(self.run.held() or 0, how)
        return self.held()[1]


def test_steps_go_over_into_and_out_of_calls(folder: pathlib.Path) -> None:
    session = Session(folder / "start.pgx")
    session.run.begin(entry=True)
    assert session.held() == ("demo~", "nCount=1")
    assert session.step(Step.OVER) == "call add(nCount,aList[1])", "a comment is not a line to stop at"
    assert session.step(Step.INTO) == "l_n=x_n"
    assert session.step(Step.OVER) == "x_n=l_n+x_m"
    inner, outer = session.calls()
    assert (inner.name, outer.name, outer.line) == ("add", "start", session.line("call add(nCount,aList[1])"))
    assert inner.scopes["Local"] == {"x_n": 1, "x_m": 4, "l_n": 1}
    assert outer.scopes["Global"]["aList"] == [0, 4, 0] and outer.scopes["Global"]["jA.j1"] == 2.5
    assert session.step(Step.OUT) == 'taskCreate "other",10,other()'
    assert session.calls()[0].scopes["Global"]["nCount"] == 5


def test_breakpoints_hold_their_task_and_time_with_it(folder: pathlib.Path) -> None:
    session = Session(folder / "demo.pjx")
    found = session.stop_at("// a comment", "nCount=nCount*10", "aList[0]=nCount")
    assert found == [session.line(text) for text in ("call add(nCount,aList[1])", "nCount=nCount*10", "aList[0]=nCount")]
    assert session.stop_at("aList[2]=7", file="other.pgx") == [session.line("aList[2]=7", "other.pgx")]
    session.run.begin(entry=False)
    assert session.held() == ("demo~", "call add(nCount,aList[1])")
    clock = session.run._machine.clock
    assert session.run.go_on() and session.run._machine.clock == clock, "no time passes"
    session.run.resume(1, Step.RUN)
    assert session.held() == ("other", "aList[2]=7") and 1e8 <= session.run._machine.clock < 1.1e8
    assert [name for _, name in session.run.threads()] == ["demo~", "other"]
    assert session.step(Step.RUN) == "nCount=nCount*10" and session.calls()[0].scopes["Global"]["aList[2]"] == 7
    assert [session.step(Step.RUN) for _ in range(3)] == ["aList[0]=nCount"] * 3
    session.stop_at()
    session.run.resume(1, Step.RUN)
    while session.run.go_on():
        assert session.run.held() is None
    assert session.run.threads() == []


def test_events_from_outside_and_what_is_refused(folder: pathlib.Path) -> None:
    session = Session(folder / "start.pgx", at=["0.2 nCount=7"], until=10)
    session.stop_at("nCount=nCount*10")
    session.run.begin(entry=False)
    assert session.held()[1] == "nCount=nCount*10" and session.calls()[0].scopes["Global"]["nCount"] == 7
    assert session.run.breakpoints(folder / "none.pgx", [1]) == ([None], "none.pgx is not a program of this application")
    for arguments, words in (({"at": ["x"]}, "a number of seconds is expected"), ({"robot": "nothing"}, "nothing")):
        with pytest.raises(AdapterFault, match=words):
            Session(folder / "start.pgx", **arguments)
    (folder / "start.pgx").write_text((folder / "start.pgx").read_text().replace("nCount=1\n", "nCount=\n"))
    with pytest.raises(AdapterFault, match="line 2"):
        Session(folder / "start.pgx")
