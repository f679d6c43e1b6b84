"""The rows of the bench a user can repeat: program text is as quick as paths put together by hand."""

import pytest

from hil_tests.bench.path_figures import by_text, contour_text, u_arm_text, u_portal_text
from hil_tests.lab.cells import arms
from motion.errors import MotionError
from motion.planner.route import Route
from motion.program.text.reader import read


def test_the_wide_u_of_a_portal() -> None:
    assert by_text(arms.portal(), u_portal_text(24.89)) <= 0.356, "0.391 s where a corner takes at most half of a leg"


def test_the_u_of_an_arm_takes_its_short_legs_whole() -> None:
    machine = arms.robot("tx60-like")
    assert by_text(machine, u_arm_text(24.97)) <= 0.303 < 0.8 * by_text(machine, u_arm_text(0.0))


def test_the_contour() -> None:
    assert by_text(arms.portal("xyz", 500.0, 5000.0, 2e5), contour_text()) <= 1.898


def taken(text: str) -> list[tuple[float, float]]:
    """Per stretch, shares of its block."""
    program = read(text)
    route = Route(arms.portal(), program.start)
    for block in program.blocks:
        route.add(block)
    route.finish()
    return [stretch.share for stretch in route.take()]


def test_a_leg_with_a_corner_at_each_end_gives_half_of_itself_whatever_the_share() -> None:
    head = "robot portal\naxes mm mm mm\nstart 0 0 0\nset radius=24 share=90\n"
    lines = "linear pose 0 0 30 0 0 0\nlinear pose 30 0 30 0 0 0\nlinear pose 30 0 0 0 0 0"
    found = taken(f"{head}{lines} blend=off\n")
    assert found[0] == pytest.approx((0.0, 0.2)), "the first leg may give 80 %"
    assert found[1][1] == pytest.approx(0.5), "the second one half, at both ends"
    assert found[-1][0] == pytest.approx(0.5), "one sphere: both sides shrink"
    with pytest.raises(MotionError):
        read(f"{head}{lines} share=100\n")
