"""The test system of a cell in virtual time: breakpoints, single step, variables, points (rho 3 releases L734-747, 2575-2590)."""

import pytest

from gateway.pure.languages.base.faults import Faults
from gateway.services.rho3_programs import Rho3Programs
from gateway.services.rho3_test_orders import TestOrders
from hil_tests.lab.virtual.baps2_bench import AUTOMATIC, HEAD, ProgramCell

TEST = 22
SOURCE = f"""{HEAD}PROGRAM P
INTEGER : COUNT
REAL : SHARE
TEXT : NOTE
ARRAY [1..3] INTEGER : ROW
OUTPUT : 1 = LAMP
BEGIN
COUNT = 1
TWICE(COUNT)
MOVE PTP TO START1
COUNT = COUNT + 1
LAMP = COUNT > 1
MOVE PTP TO @HOME
PROGRAM_END
SUBROUTINE TWICE (VALUE INTEGER : WHAT)
INTEGER : DOUBLE
BEGIN
DOUBLE = 2 * WHAT
SUB_END
"""
FIRST, CALL, MOVE, COUNT, LAMP, INSIDE = 12, 13, 14, 15, 16, 22


class Debugging:
    """A cell in manual with the test selected, and what a page asks."""

    def __init__(self, source: str = SOURCE) -> None:
        points = "START1 = (200, 60, 40, 12)\n@HOME = @(60, 60, 40, 12)\n"
        self.cell = ProgramCell({"P.QLL": source, "P.PKT": points})
        self.orders = Rho3Programs(self.cell.control, "en")
        self.orders.hosted = self.cell.control.hosted = self.cell.hosted
        self.cell.bench.permit(AUTOMATIC, value=False)
        self.cell.bench.permit(TEST)
        self.cell.bench.run(0.1)

    def ask(self, do: str, **facts: object) -> dict[str, object]:
        answer = self.orders.answer({"do": do, **facts}, 1)
        if "ticket" not in answer:
            return answer
        self.cell.until(lambda: answer["ticket"] in self.cell.hosted.answers, 2.0)
        return self.orders.answer({"do": "outcome", "ticket": answer["ticket"]}, 1)

    def begin(self, *, hold: bool = False) -> int:
        answer = self.ask("test", name="P", hold=hold)
        assert isinstance(answer.get("run"), int), answer
        return int(str(answer["run"]))

    def held_at(self, line: int) -> None:
        self.cell.until(lambda: any(row["state"] == "held" and row["line"] == line for row in self.rows()), 20.0)

    def rows(self) -> list[dict[str, object]]:
        return self.cell.hosted.rows

    def variables(self, run: int) -> dict[str, str]:
        self.ask("look", run=run)
        self.cell.bench.run(0.1)
        found = self.cell.hosted.shown["variables"]
        assert isinstance(found, list)
        return {f"{where}.{name}": value for where, name, _, value, _ in found}


@pytest.fixture
def tester() -> Debugging:
    return Debugging()


def test_a_breakpoint_holds_a_process_of_the_test_behind_what_moves(tester: Debugging) -> None:
    assert tester.ask("breakpoints", name="P", lines=[COUNT]) == {"over": True}
    run = tester.begin()
    tester.held_at(COUNT)
    tester.cell.until(lambda: tester.cell.at()[0] == 200.0)
    assert tester.variables(run)["P.COUNT"] == "1"
    assert tester.ask("step", run=run, how="run") == {"over": True}
    assert tester.cell.ends(run)[:2] == ("ended", 0)
    assert tester.cell.at()[0] == 60.0


def test_a_breakpoint_does_not_stop_the_production(tester: Debugging) -> None:
    tester.ask("breakpoints", name="P", lines=[COUNT])
    tester.cell.bench.permit(AUTOMATIC)
    tester.cell.bench.run(0.1)
    assert tester.cell.run("P")[:2] == ("ended", 0)


@pytest.mark.parametrize(("how", "line"), [("into", INSIDE), ("over", MOVE)])
def test_steps_go_into_a_subroutine_or_over_it(tester: Debugging, how: str, line: int) -> None:
    run = tester.begin(hold=True)
    tester.held_at(FIRST)
    tester.ask("step", run=run, how="into")
    tester.held_at(CALL)
    tester.ask("step", run=run, how=how)
    tester.held_at(line)
    if how == "into":
        assert tester.variables(run)["TWICE.WHAT"] == "1"
        tester.ask("step", run=run, how="out")
        tester.held_at(MOVE)


def test_variables_are_set_while_the_process_is_held(tester: Debugging) -> None:
    tester.ask("breakpoints", name="P", lines=[COUNT])
    run = tester.begin()
    tester.held_at(COUNT)
    for name, value in (("COUNT", "-7"), ("SHARE", "0.25"), ("NOTE", "'left side'"), ("ROW[2]", "12"), ("START1", "100, 60, 40, 12")):
        assert tester.ask("variable", run=run, program="P", name=name, value=value) == {"over": True}
    found = tester.variables(run)
    assert [found[f"P.{name}"] for name in ("COUNT", "SHARE", "NOTE", "ROW[1]", "ROW[2]", "START1")] == [
        "-7", "0.25", "left side", "0", "12", "100, 60, 40, 12",
    ]  # fmt: skip
    tester.ask("step", run=run, how="over")
    tester.held_at(LAMP)
    tester.ask("step", run=run, how="run")
    assert tester.cell.ends(run)[:2] == ("ended", 0)
    assert (1, True) not in [(channel, value) for _, channel, value in tester.cell.outputs], "-6 is not greater than 1"


WRONG = (
    ("COUNT", "1.5", "a whole number"),
    ("COUNT", "99999999999", "a whole number"),
    ("SHARE", "much", "a number"),
    ("ROW", "1", "ROW[1] to ROW[3]"),
    ("ROW[4]", "1", "ROW[1] to ROW[3]"),
    ("COUNT[1]", "1", "not an array"),
    ("START1", "1, 2", "4 numbers"),
    ("NOTE", "x" * 81, "up to 80"),
    ("NOTHING", "1", "no variable of this name"),
)


def test_a_value_that_does_not_fit_is_refused_and_nothing_changes(tester: Debugging) -> None:
    run = tester.begin(hold=True)
    tester.held_at(FIRST)
    before = tester.variables(run)
    for name, value, words in WRONG:
        assert words in str(tester.ask("variable", run=run, program="P", name=name, value=value)["error"])
    assert tester.variables(run) == before


def test_what_is_not_of_the_test_is_neither_stepped_nor_set(tester: Debugging) -> None:
    tester.cell.bench.permit(AUTOMATIC)
    tester.cell.bench.run(0.1)
    run = tester.cell.start("P")
    tester.cell.until(lambda: bool(tester.rows()))
    assert "not in test" in str(tester.ask("step", run=run, how="hold")["error"])
    assert "started in test" in str(tester.ask("variable", run=run, program="P", name="COUNT", value="1")["error"])
    assert "P.START1" in tester.variables(run), "a running process shows what it uses"


def test_the_test_wants_its_signal_and_kinematics_in_manual(tester: Debugging) -> None:
    tester.cell.bench.permit(TEST, value=False)
    tester.cell.bench.run(0.1)
    assert "TEST bit not select." in str(tester.ask("test", name="P")["error"])
    tester.cell.bench.permit(TEST, AUTOMATIC)
    tester.cell.bench.run(0.1)
    how, code, words, _ = tester.cell.ends(tester.begin())
    assert (how, code) == ("aborted", 252) and "not in manual" in words


def test_without_movement_a_program_runs_and_the_axes_rest(tester: Debugging) -> None:
    before = tester.cell.at()
    assert tester.ask("movement", on=False) == {"over": True}
    run = tester.begin()
    assert tester.cell.ends(run)[:2] == ("ended", 0)
    assert tester.cell.at() == before and (1, True) in [(channel, value) for _, channel, value in tester.cell.outputs]
    tester.ask("movement", on=True)
    tester.cell.ends(tester.begin())
    assert tester.cell.at() != before


def test_a_point_is_taught_where_the_axes_are(tester: Debugging) -> None:
    here = tester.cell.at()
    assert tester.ask("teach", name="P", point="start1") == {"over": True}
    assert tester.cell.memory.points("P", Faults())["START1"] == pytest.approx(here, abs=0.01)
    assert tester.ask("define", name="P", point="@HOME", value="(1, 2.5, 3, -4)") == {"over": True}
    assert "@HOME = @(1, 2.5, 3, -4)" in (tester.cell.memory.text("P.PKT") or "")
    for order in ({"do": "teach", "point": "NOWHERE"}, {"do": "define", "point": "@HOME", "value": "1, 2"}):
        answer = tester.ask(order["do"], **{key: value for key, value in order.items() if key != "do"}, name="P")
        assert "no such point; it has" in str(answer.get("error")) or "4 numbers" in str(answer.get("error"))
    assert "kinematic 9" in str(tester.ask("teach", name="P", point="START1", kinematic=9)["error"])


def test_teach_in_wants_manual_and_is_disabled_by_the_plc(tester: Debugging) -> None:
    tester.cell.bench.permit(AUTOMATIC)
    tester.cell.bench.run(0.1)
    before = tester.cell.memory.text("P.PKT")
    assert "automatic" in str(tester.ask("teach", name="P", point="START1")["error"])
    assert tester.cell.memory.text("P.PKT") == before


def test_lines_of_breakpoints_are_statements(tester: Debugging) -> None:
    tester.ask("breakpoints", name="P", lines=[1, COUNT])
    tester.cell.bench.run(0.1)
    shown = tester.cell.hosted.shown["test"]
    assert isinstance(shown, dict) and shown["breakpoints"] == {"P": [FIRST, COUNT]}
    assert "no statement" in str(tester.ask("breakpoints", name="P", lines=[900])["error"])
    assert "no such program" in str(tester.ask("breakpoints", name="NONE", lines=[1])["error"])
    assert "lines" in str(tester.ask("breakpoints", name="P", lines=["x"])["error"])
    assert "how" in str(TestOrders(tester.cell.control, tester.cell.hosted).answer({"do": "step", "how": "back"}, 1)["error"])
