"""ROBOTstar programs under the debugger: breakpoints, single step into and over calls, variables, time that stands."""

import pathlib

import pytest

from gateway.pure.languages.base.debug import Step
from gateway.tools.editor.debug_robotstar import RobotstarDebugged
from gateway.tools.editor.debugged import AdapterFault, Row

MAIN = """1 MPR "PICK"
2 VAR I_PARTS
3 COPY 0, I_PARTS
4 LABEL "NEXT"
5 CALL "GRIP"
6 WAIT 1.5
7 ADD 1, I_PARTS
8 TEST #VARIABLE, I_PARTS, #<, 3, "NEXT"
9 STOP
10 END
"""
GRIP = """SPR GRIP
LOC_VAR I_OWN
COPY 7, I_OWN
WRITE_BIT #AUSGANG, 1, 1, 6
END
"""


class Session:
    """One run of PICK."""

    def __init__(self, folder: pathlib.Path, arguments: Row | None = None, *, entry: bool = False) -> None:
        (folder / "PICK.MPR").write_text(MAIN)
        (folder / "GRIP.SPR").write_text(GRIP)
        self.folder, self.run = folder, RobotstarDebugged(folder / "PICK.MPR", arguments or {})
        self.entry, self.begun = entry, False

    def goes(self) -> list[tuple[str, int]]:
        """Until it is held, or over; name and line of each call."""
        if not self.begun:
            self.begun = True
            self.run.begin(entry=self.entry)
        for _ in range(10_000):
            going = self.run.go_on()
            if self.run.held() is not None:
                return [(call.name, call.line) for call in self.run.calls()]
            if not going:
                return []
        raise AssertionError("it never ends")

    def step(self, how: Step) -> list[tuple[str, int]]:
        self.run.resume(1, how)
        return self.goes()

    def value(self, name: str) -> object:
        call = next(iter(self.run.calls()))
        return {key: value for values in call.scopes.values() for key, value in values.items()}[name]


def test_a_breakpoint_holds_the_program_in_front_of_its_step(tmp_path: pathlib.Path) -> None:
    session = Session(tmp_path)
    assert session.run.breakpoints(tmp_path / "PICK.MPR", [4, 7])[0] == [5, 7], "a label does nothing: the next step is taken"
    assert session.goes() == [("PICK", 5)] and session.value("I_PARTS") == 0
    assert session.step(Step.RUN) == [("PICK", 7)]
    assert session.value("A1") == 64, "the output that GRIP has set"
    assert session.step(Step.RUN) == [("PICK", 5)] and session.value("I_PARTS") == 1
    session.run.breakpoints(tmp_path / "PICK.MPR", [])
    assert session.step(Step.RUN) == []


def test_single_steps_go_into_a_sub_program_over_it_and_out_of_it(tmp_path: pathlib.Path) -> None:
    session = Session(tmp_path, entry=True)
    assert session.goes() == [("PICK", 3)], "the first step that does something"
    assert session.step(Step.OVER) == [("PICK", 5)]
    assert session.step(Step.INTO) == [("GRIP", 3), ("PICK", 5)], "the caller is at its call"
    assert session.step(Step.INTO) == [("GRIP", 4), ("PICK", 5)] and session.value("I_OWN") == 7
    assert session.step(Step.OUT) == [("PICK", 6)]
    assert session.step(Step.OVER) == [("PICK", 7)]
    assert session.step(Step.OVER) == [("PICK", 8)]
    assert session.step(Step.OVER) == [("PICK", 5)]
    assert session.step(Step.OVER) == [("PICK", 6)], "over the call"


def test_held_time_does_not_pass_and_events_are_as_without_a_debugger(tmp_path: pathlib.Path) -> None:
    held, free = Session(tmp_path), Session(tmp_path)
    held.run.breakpoints(tmp_path / "PICK.MPR", [6, 8])
    held.run.breakpoints(tmp_path / "GRIP.SPR", [4])
    stops = 0
    place = held.goes()
    while place:
        stops += 1
        place = held.step(Step.RUN)
    assert free.goes() == [] and stops == 9
    assert held.run.output() == free.run.output()


def test_inputs_come_from_the_script_and_pause_holds(tmp_path: pathlib.Path) -> None:
    session = Session(tmp_path, {"at": ["0.2 E0.3=1"], "mode": "test2"})
    session.run.breakpoints(tmp_path / "PICK.MPR", [7])
    assert session.goes() == [("PICK", 7)] and session.value("E0") == 8
    session.run.breakpoints(tmp_path / "PICK.MPR", [])
    session.run.pause()
    assert session.step(Step.INTO) == [("PICK", 8)]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [({"mode": "test1"}, "test2, test4, auto"), ({"at": ["1 JUMP"]}, "are known"), ({"memory": "/nowhere"}, "is not in /nowhere")],
)
def test_what_cannot_be_launched_is_one_sentence(arguments: Row, said: str, tmp_path: pathlib.Path) -> None:
    with pytest.raises(AdapterFault, match=said):
        Session(tmp_path, arguments)
