"""The figures of belts that are owed (motion.md E 11), by the functions the bench uses; costs are measured there alone."""

from hil_tests.bench.belt_figures import belt_cam, tracking


def test_300_mm_per_s_with_10_percent_and_a_stop_is_followed_within_0_1_mm_rms_and_0_7_mm() -> None:
    rms, most = tracking(1)
    assert rms <= 0.10 and most <= 0.7
    late, _ = tracking(4)
    assert late <= 0.12


def test_without_prediction_and_filter_the_same_chain_is_far_off() -> None:
    rms, _ = tracking(12, (0.99, 1e-9, 0.0))
    assert rms > 1.0, "the figure really is about prediction"


def test_the_cam_is_exact_to_1e_9() -> None:
    assert belt_cam()["met"]
