"""Goal 9 of motion.md: the median over override changes on the U, and the worst of all, each with its own limit."""

from hil_tests.bench.online_figures import override


def test_the_median_is_that_of_the_u_and_its_goal_is_50_ms() -> None:
    rows = {str(row["figure"]): row for row in override(starts=5, chains=1)}
    median, worst = rows["motion.override_median_ms"], rows["motion.override_ms"]
    assert (median["goal"], worst["goal"]) == (50.0, 120.0)
    assert median["unit"] == "ms, 5 starts on the U" and "random chains" in str(worst["unit"])
    assert worst["met"], worst
