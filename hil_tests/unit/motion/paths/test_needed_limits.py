"""Of many limits those that count are kept, and a law made of them is the law of all (motion.timing.needed)."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.motion_paths import portal_limits, u_portal
from motion.paths.joints import JointPath
from motion.timing import interior, jerk, topp
from motion.timing.choice import assembled
from motion.timing.limits import LawLimits, law_limits
from motion.timing.needed import CLOSE, needed
from motion.timing.slices import Work

CHANCE = np.random.default_rng(7)
PLACES, LIMITS = 60, 40
SIZES = CHANCE.lognormal(0.0, 1.0, (PLACES, LIMITS, 1))
CLOUD = CHANCE.normal(size=(PLACES, LIMITS, 3)) * SIZES * (90.0, 3.0, 1.0)
PLANE = CHANCE.normal(size=(PLACES, LIMITS, 2)) @ CHANCE.normal(size=(PLACES, 2, 3))
LINE = SIZES * CHANCE.normal(size=(PLACES, 1, 3))


def all_count(points: Array, least: float = 1.0) -> NDArray[np.bool_]:
    """In place of `needed`."""
    return np.ones(points.shape[:2], dtype=bool)


@pytest.mark.parametrize(
    "points", [CLOUD, CLOUD[:, :, :2], PLANE, LINE, np.zeros((2, 3, 3))], ids=["cloud", "flat", "plane", "line", "rest"]
)
def test_limits_that_count_say_as_much_as_all(points: Array) -> None:
    count = needed(points)
    largest = np.maximum(np.max(np.abs(points), axis=1, keepdims=True), 1.0)
    for direction in CHANCE.normal(size=(400, points.shape[2])):
        asked = np.abs(np.sum(points * (direction / largest), axis=2))
        told = np.max(np.where(count, asked, 0.0), axis=1)
        assert np.all(told >= np.max(asked, axis=1) - CLOSE * np.sum(np.abs(direction)))


def test_few_limits_count() -> None:
    assert float(np.mean(np.sum(needed(CLOUD[:, :, :2]), axis=1))) < 0.5 * LIMITS
    assert np.sum(needed(LINE), axis=1).tolist() == [1] * PLACES, "the axis that is nearest to its limit"
    assert not np.any(needed(np.zeros((2, 3, 3))))


def many_axes() -> tuple[JointPath, LawLimits]:
    """The U of a portal, run by 32 axes each of which does something else of it."""
    path, limits = assembled(*u_portal(0.0124999)), law_limits(portal_limits())
    mixed = CHANCE.normal(size=(3, 32))
    axes = np.concatenate([path.coefficients[:, :, :3] @ mixed, path.coefficients[:, :, 3:]], axis=2)
    speed, accel, jerks = (
        np.concatenate([CHANCE.uniform(0.5, 2.0, 32) * row[0], row[-2:]]) for row in (limits.speed, limits.accel, limits.jerk)
    )
    return replace(path, coefficients=axes), LawLimits(speed, accel, jerks)


def test_the_law_of_32_axes_is_that_of_all_their_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    path, limits = many_axes()
    rows: list[int] = []

    def counted(of: interior.Rows, share: Array, begin: Array, held: int = 0) -> Work[Array]:
        rows.append(of.right.size // len(begin))
        return interior.fastest(of, share, begin, held)

    monkeypatch.setattr(jerk, "fastest", counted)
    law = jerk.jerk_limited(path, limits)
    few = max(rows)
    monkeypatch.setattr(jerk, "needed", all_count)
    monkeypatch.setattr(topp, "needed", all_count)
    whole = jerk.jerk_limited(path, limits)
    assert few < 0.35 * max(rows)
    assert law.duration == pytest.approx(whole.duration, rel=jerk.SETTLED)
    t = np.linspace(0.0, law.duration, 500)
    assert law.at(t) == pytest.approx(whole.at(t), abs=jerk.SETTLED * path.length)
    assert max(jerk.shares(path, limits, law)) <= 1.05


def test_the_quickest_pass_of_32_axes_is_that_of_all_their_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    path, limits = many_axes()
    s = np.linspace(0.0, path.length, 600)
    first, second = path.at(s, 1), path.at(s, 2)

    def solved() -> topp.Topp:
        return topp.solve(first, second, float(s[1]), limits.accel, topp.speed_limit(first, limits.speed))

    found = solved()
    monkeypatch.setattr(topp, "needed", all_count)
    assert found.b == pytest.approx(solved().b, rel=1e-4)
