"""A corner that is passed takes no longer than a stop in it, however small it is and however many there are."""

import pytest

from hil_tests.lab.cells.arms import robot
from motion.planner.planner import Planner
from motion.planner.route import Route
from motion.planner.trace import trace
from motion.program.text.reader import read

HEADS = {
    "tx60-like": "robot tx60-like\nangles val3\naxes deg deg deg deg deg deg\nstart 0 30 90 0 60 0\n",
    "portal": "robot portal\naxes mm mm mm deg\nstart 0 0 0 0\n",
}
MS = 1e-3


def drawn(name: str, text: str) -> float:
    """s, as `motion plot` has it."""
    program, machine = read(HEADS[name] + text), robot(name)
    route = Route(machine, program.start)
    for block in program.blocks:
        route.add(block)
    route.finish()
    return float(trace(route.take(), machine).t[-1])


def planned(name: str, text: str) -> float:
    """s, as a cell has it."""
    program = read(HEADS[name] + text)
    planner = Planner(robot(name), program.start)
    for block in program.blocks:
        planner.add(block)
    planner.finish()
    while planner.plan(planner.end, hurry=True):
        pass
    return planner.end


def steps(count: int, mm: float) -> str:
    """A staircase."""
    return "".join(f"linear rel pose {mm} 0 0 0 0 0\n" if n % 2 else f"linear rel pose 0 {mm} 0 0 0 0\n" for n in range(count))


@pytest.mark.parametrize("radius", [0.1, 0.29, 1.0, 5.0])
@pytest.mark.parametrize("name", list(HEADS))
def test_one_corner(name: str, radius: float) -> None:
    text = "linear rel pose 0 50 0 0 0 0\nlinear rel pose 30 0 0 0 0 0\n"
    rounded = text.replace("\n", f" radius={radius}\n", 1)
    stops = drawn(name, text)
    assert drawn(name, rounded) <= stops + MS and planned(name, rounded) <= stops + MS


@pytest.mark.parametrize("radius", [0.05, 0.3])
@pytest.mark.parametrize("count", [12, 40])
def test_rows_of_tiny_moves(count: int, radius: float) -> None:
    text = steps(count, 1.0)
    stops = drawn("portal", text)
    rounded = f"set radius={radius}\n{text}"
    assert drawn("portal", rounded) <= stops + MS and planned("portal", rounded) <= stops + count * MS


def test_where_passing_is_quicker_it_stays() -> None:
    text = steps(40, 0.1)
    assert drawn("portal", f"set radius=0.03\n{text}") < 0.7 * drawn("portal", text)
