"""A robot file limits where a virtual robot goes."""

import pytest

from gateway.files.robots import load_robot
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.memory import Memory
from gateway.pure.languages.robotstar.path import Target
from gateway.pure.languages.robotstar.reach import reach_of
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.script import NS, orders
from gateway.pure.languages.robotstar.values import Structure
from gateway.pure.languages.robotstar.virtual import VirtualCell
from hil_tests.unit.languages.robotstar.memory import WORDS, Ran, sources

REACHES = reach_of(load_robot("reis-like"))


@pytest.mark.parametrize(
    "target, said",
    [
        (Target((900, 0, 900, 180, 0, 0)), ""),
        (Target((9000, 0, 900, 180, 0, 0)), "reach"),
        (Target((), 0, {"A1": 10, "A2": 0}), ""),
        (Target((), 0, {"A1": 176}), "A1 176 is outside the travel"),
        (Target((), 0, {"A9": 1}), "A9: robot reis-like has 6 axes"),
    ],
)
def test_what_a_robot_reaches(target: Target, said: str) -> None:
    found = REACHES(target, None)
    assert said in found and bool(said) == bool(found)


def test_the_tool_counts() -> None:
    far = Target((1500, 0, 900, 180, 90, 0))
    assert REACHES(far, None) == "" or REACHES(far, Structure("T", {"Z": -3000.0})) != REACHES(far, None)
    assert REACHES(Target((900, 0, 900, 180, 0, 0)), Structure("T", {"Z": 3000.0}))


def test_a_program_stops_in_front_of_what_is_not_reached() -> None:
    faults = Faults()
    places = "\n".join(f"POSITION #N, X:{x}, Y:0, Z:900, A:180, B:0, C:0" for x in (900, 9000, 800))
    memory = Memory.read(sources({"P.MPR": f"TOOL T\nPTP_SPEED 100\n{places}"}), WORDS, faults)
    cell = VirtualCell(memory, MODES["auto"], reaches=REACHES)
    cell.run(orders(["5 ACK", "6 START"]), 9 * NS, "P")
    ran = Ran(cell, [], cell.end("P"))
    assert (ran.state, ran.step, ran.targets(), len(ran.texts())) == ("error", 5, [(900, 0, 900)], 2)
