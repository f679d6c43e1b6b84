"""Points in workpiece coordinates: positions wholly, orientations as far as there are components for them (rho 3 L8797-8937)."""

import pytest

from gateway.pure.languages.baps2.frames import to_workpiece, to_world
from motion.geometry.conventions import RHO3
from motion.rho3.wc import Assignment

FRAMES = [(10.0, 20.0, 30.0, 0.0, 0.0, 90.0), (10.0, 20.0, 30.0, 20.0, 0.0, 0.0), (0.0, 5.0, 0.0, 10.0, -35.0, 120.0)]
POINTS = [(1.0, 2.0, 3.0), (1.0, 2.0, 3.0, 40.0), (1.0, 2.0, 3.0, 15.0, -25.0, 40.0)]
P313 = {3: (1, 2, 3, 0, 0, 0), 4: (1, 2, 3, 0, 0, 4), 6: (1, 2, 3, 4, 5, 6)}


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("point", POINTS)
def test_a_point_is_where_the_assignment_of_its_components_puts_it(frame: tuple[float, ...], point: tuple[float, ...]) -> None:
    expected = Assignment(P313[len(point)]).moved(point, RHO3.pose(frame))
    assert to_world(frame, point) == pytest.approx(expected)


def test_the_fourth_component_of_four_turns_about_z() -> None:
    assert to_world((0.0, 0.0, 0.0, 0.0, 0.0, 90.0), (100.0, 0.0, 50.0, 10.0)) == (0.0, 100.0, 50.0, 100.0)
    assert to_workpiece((0.0, 0.0, 0.0, 0.0, 0.0, 90.0), (0.0, 100.0, 50.0, 100.0)) == (100.0, 0.0, 50.0, 10.0)


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("point", [(1.0, 2.0, 3.0), (1.0, 2.0, 3.0, 15.0, -25.0, 40.0, 7.0)])
def test_the_way_back_gives_the_point(frame: tuple[float, ...], point: tuple[float, ...]) -> None:
    assert to_workpiece(frame, to_world(frame, point)) == pytest.approx(point)
