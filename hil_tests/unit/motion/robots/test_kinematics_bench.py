"""The bench of the inverse says what it found; times are for a quiet machine."""

from hil_tests.bench.kinematics_bench import run


def test_a_short_run_finds_every_pose() -> None:
    rows = {str(row["figure"]): row for row in run(300)}
    assert rows["motion.ik_found"]["value"] == 300
    assert rows["motion.ik_flags_wrong"]["value"] == 0
    assert all(rows[name]["met"] for name in ("motion.ik_found", "motion.ik_residual", "motion.ik_flags_wrong"))
    assert {"motion.ik_us", "motion.ik_follow_us", "motion.ik_scara_us", "motion.ik_portal_us"} < set(rows)
