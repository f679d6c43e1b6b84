"""ROBOTstar V, section 6: RELATIVE, CALC_REL and the vector commands."""

import pytest

from motion.errors import MotionError
from motion.geometry.displacement import VNULL, Displacement, Position, Vector, added, subtracted

HERE = Position(0, 0, 0)


@pytest.mark.requirement(
    "RSV-MOT-22", by=("motion.geometry.displacement:Displacement.relative", "motion.geometry.displacement:Displacement.position")
)
def test_relative_adds_the_vector_to_each_position_until_vnull() -> None:
    shift = Displacement()
    target = Position(100, 20, 30, 1, 2, 3)
    assert shift.position(target, HERE) == (target, None)
    shift.relative(Vector(10, 0, 0))
    assert shift.position(target, HERE) == (Position(110, 20, 30, 1, 2, 3), None)
    assert shift.position(target, HERE) == (Position(110, 20, 30, 1, 2, 3), None), "each position anew, not summed up"
    shift.relative(Vector(0, 5, 0, 0, 0, 90))
    assert shift.position(target, HERE) == (Position(100, 25, 30, 1, 2, 93), None), "replaces the one before; angles are added"
    shift.relative(VNULL)
    assert shift.position(target, HERE) == (target, None)


@pytest.mark.requirement(
    "RSV-MOT-23", by=("motion.geometry.displacement:Displacement.calc_rel", "motion.geometry.displacement:Displacement.position")
)
def test_calc_rel_gives_actual_minus_programmed_and_the_robot_stays() -> None:
    shift = Displacement()
    a, b, c = Position(10, 20, 30), Position(1, 2, 3), Position(100, 100, 100)
    shift.calc_rel()
    assert shift.position(b, a) == (None, Vector(9, 18, 27)), "B is not approached"
    assert shift.position(c, a) == (c, None), "not yet shifted"
    shift.relative(Vector(9, 18, 27))
    assert shift.position(c, c) == (Position(109, 118, 127), None)


def test_axes_are_shifted_with_the_position() -> None:
    shift = Displacement()
    shift.relative(Vector(axes=(1.0, -2.0)))
    assert shift.position(Position(0, 0, 0, axes=(10.0, 20.0, 30.0)), HERE) == (Position(0, 0, 0, axes=(11.0, 18.0, 30.0)), None)


def test_a_vector_without_values_or_from_another_frame_is_refused() -> None:
    shift = Displacement()
    with pytest.raises(MotionError, match="no valid values"):
        shift.relative(Vector(valid=False))
    shift.calc_rel()
    with pytest.raises(MotionError, match="frame"):
        shift.position(Position(1, 2, 3, frame=2), HERE)


def test_vector_commands() -> None:
    one, two = Vector(150, -30, 10), Vector(200, 100, 30)
    assert added(one, two) == Vector(350, 70, 40)
    assert subtracted(one, two) == Vector(50, 130, 20)
    assert Vector(80, 60, 0).value() == 100.0
