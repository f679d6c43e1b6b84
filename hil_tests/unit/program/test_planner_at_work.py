"""A law takes about as long to make as to run: meanwhile the planner shows life."""

from hil_tests.lab import arms
from motion.planner.planner import Planner
from motion.program.blocks import Block, Interpolation


def test_it_shows_life_at_every_step_of_a_law() -> None:
    beats: list[int] = []
    planner = Planner(arms.portal(), (0.0, 0.0, 0.0), pulse=lambda: beats.append(1))
    planner.add(Block(Interpolation.PTP, arms.at(300.0)))
    planner.finish()
    assert planner.plan(0.0, hurry=True) and not beats, "a straight line needs no search"
    planner.add(Block(Interpolation.CIRCULAR, arms.at(300.0, 200.0), via=arms.at(400.0, 100.0)))
    planner.finish()
    assert planner.plan(0.0, hurry=True) and len(beats) > 5
