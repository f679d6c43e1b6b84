"""Courses of additional axes (7 .. 24) along a path: one polynomial of degree 5 or less in s for each, in step with the path.

Along a block a course is straight; where blocks are rounded into each other, and along a row of SPLINE blocks (motion.planner.spline_rows),
it joins the courses before and after it with equal slope and continuous bend.
"""

from collections.abc import Sequence

import numpy as np

from motion.paths.corner import hermite
from motion.paths.joints import DEGREE, JointPath
from motion.paths.polynomial import Row, values

Course = tuple[Row, ...]  # (additional axes,)
State = tuple[float, float, float]  # value, slope, bend by s


def straight(start: Sequence[float], end: Sequence[float], length: float) -> Course:
    """From start to end over 0 .. length."""
    return tuple((a, (b - a) / length) for a, b in zip(start, end, strict=True))


def states(course: Course, s: float) -> list[State]:
    """At s."""
    return [values(row, s)[:3] for row in course]


def places(course: Course, s: float) -> tuple[float, ...]:
    """(additional axes,) at s."""
    return tuple(values(row, s)[0] for row in course)


def joining(length: float, start: Sequence[State], end: Sequence[State]) -> Course:
    """Quintics over 0 .. length from one state to the other."""
    return tuple(hermite(length, a, b) for a, b in zip(start, end, strict=True))


def shifted(course: Course, by: float) -> Course:
    """The same about another beginning."""
    return tuple(tuple(about(row, by)) for row in course)


def with_course(path: JointPath, course: Course) -> JointPath:
    """Return the path of the arm with the columns of the additional axes appended."""
    if not course:
        return path
    count, arm = len(path.coefficients), path.axes
    table = np.zeros((count, DEGREE + 1, arm + len(course) + 2))
    table[:, :, :arm] = path.coefficients[:, :, :arm]
    table[:, :, -2:] = path.coefficients[:, :, arm:]
    for i, knot in enumerate(path.knots[:-1]):
        for j, row in enumerate(course):
            table[i, :, arm + j] = about(row, float(knot))
    return JointPath(path.knots, table)


def about(row: Sequence[float], u: float) -> list[float]:
    """Six coefficients of the same polynomial about another point."""
    result = [*row, *[0.0] * (DEGREE + 1 - len(row))]
    for i in range(DEGREE):
        for k in range(DEGREE - 1, i - 1, -1):
            result[k] += u * result[k + 1]
    return result
