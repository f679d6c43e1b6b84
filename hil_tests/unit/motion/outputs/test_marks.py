"""Outputs of blocks on the pieces a planner hands on: at their place of the way, whatever is planned anew meanwhile."""

import numpy as np
import pytest

from hil_tests.lab.cells.arms import portal
from motion.execution.timed import TimedPiece
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.program.errors import BlockError
from motion.program.text.reader import Reader

HEAD = "axes mm mm mm"


def planner(*lines: str, machine: Machine | None = None) -> Planner:
    made, reader = Planner(machine or portal(), (0.0, 0.0, 0.0)), Reader()
    for line in (HEAD, *lines):
        reader.statement(line)
        for block in reader.take():
            made.add(block)
    return made


def places(made: Planner, pieces: list[TimedPiece]) -> dict[int, list[float]]:
    """Output -> where the tool is at each of its marks, m."""
    by_id = {piece.id: piece for piece in pieces}
    found: dict[int, list[float]] = {}
    for mark in made.take_marks():
        piece = by_id[mark.piece]
        assert 0.0 <= mark.after <= piece.duration + 1e-9, "on its own piece"
        at = [float(np.interp(mark.after, piece.times, [node[3 * axis] for node in piece.nodes])) for axis in range(3)]
        found.setdefault(mark.number, []).extend(round(value, 6) for value in at)
    return found


def test_an_output_lies_at_the_end_of_its_block_or_so_far_before_it() -> None:
    made = planner("linear pose 100 0 0 0 0 0 out=1:1@30,2:1,3:1@100", "linear pose 100 50 0 0 0 0 out=1:0@50,4:1")
    made.finish()
    found = places(made, made.plan(0.0, hurry=True) + made.plan(0.0, hurry=True))
    assert found[2] == pytest.approx([0.1, 0.0, 0.0], abs=1e-5) and found[3] == pytest.approx([0.0, 0.0, 0.0], abs=1e-5)
    assert found[1] == pytest.approx([0.07, 0.0, 0.0, 0.1, 0.0, 0.0], abs=1e-5)
    assert found[4] == pytest.approx([0.1, 0.05, 0.0], abs=1e-5)


def test_in_a_corner_the_end_of_the_block_is_its_middle() -> None:
    made = planner("linear pose 100 0 0 0 0 0 radius=20 out=1:1,2:1@40", "linear pose 100 100 0 0 0 0")
    made.finish()
    found = places(made, made.plan(0.0, hurry=True))
    x, y, _ = found[1]
    assert x == pytest.approx(0.1 - y, abs=1e-4) and 0.09 < x < 0.1, "on the diagonal of the corner"
    assert found[2][0] == pytest.approx(0.06, abs=3e-3) and found[2][1] == pytest.approx(0.0, abs=1e-5)


def test_a_tail_that_is_planned_anew_has_its_outputs_once() -> None:
    made = planner("linear pose 300 0 0 0 0 0 radius=60 out=1:1@250", "linear pose 300 300 0 0 0 0 radius=60 out=2:1")
    pieces = {piece.id: piece for piece in made.plan(0.0, hurry=True)}
    marks = made.take_marks()
    reader = Reader()
    for line in (HEAD, "linear pose 0 300 0 0 0 0 out=3:1"):
        reader.statement(line)
    made.add(reader.take()[0])
    made.finish()
    tail = made.plan(0.0, hurry=True)
    assert tail and tail[0].new_tail
    marks = [mark for mark in marks if mark.piece < tail[0].id] + made.take_marks()
    pieces |= {piece.id: piece for piece in tail}
    assert [mark.number for mark in marks] == [1, 2, 3]
    assert [mark.piece for mark in marks] == sorted(mark.piece for mark in marks)
    assert all(0.0 <= mark.after <= pieces[mark.piece].duration for mark in marks)


@pytest.mark.parametrize(
    ("line", "words"),
    [("linear pose 100 0 0 0 0 0 out=7:1@100.1", "output 7.*100.1 mm before"), ("ptp joints 100 0 0 out=7:1@5", "output 7.*PTP")],
)
def test_places_a_block_does_not_have_are_refused(line: str, words: str) -> None:
    made, reader = Planner(portal(), (0.0, 0.0, 0.0)), Reader()
    reader.statement(HEAD)
    reader.statement(line)
    with pytest.raises(BlockError, match=words):
        made.add(reader.take()[0])
