"""ROBOTstar V, parameters of the path control: machine data, path errors, what is modal."""

import pytest

from gateway.pure.languages.robotstar.faults import StepFault
from hil_tests.lab.cells.reis_path import Path, fault
from motion.geometry.conventions import VAL3
from motion.program.blocks import Interpolation, JointTarget, PoseTarget, Turning
from motion.program.errors import BlockError
from motion.program.reis import MachineData

PATH = "gateway.pure.languages.robotstar.path:PathState."
START = PoseTarget(VAL3.pose((0, 0, 0, 0, 0, 0)))


def at(x: float, y: float = 0.0, rz: float = 0.0) -> PoseTarget:
    return PoseTarget(VAL3.pose((x, y, 0, 0, 0, rz)))


def linear(**values: float) -> Path:
    path = Path(START)
    path.set("BEWEG_ART", "LINEAR")
    for name, value in values.items():
        path.set(name, value)
    return path


@pytest.mark.requirement("RSV-MOT-21", by="motion.program.reis:check_machine_data")
def test_machine_data_outside_their_range_are_error_650() -> None:
    wrong = {
        "RAPPR_FACT_MAX": (0.0, 0.5), "RDELTA_OV_MAX": (0.0, 1.001), "RSYNC_WEIGHT": (-0.1, 1.1), "RSYNC_MIN_PHASE": (-0.1, 0.51),
        "RSPOS_APPROX_QUAL": (0.0, -1.0), "RS_ORI_EPS": (0.0, float("nan")),
    }  # fmt: skip
    for name, values in wrong.items():
        for value in values:
            with pytest.raises(BlockError, match="machine data exceeds value range") as caught:
                MachineData(**{name: value})
            assert caught.value.code == 650 and name in str(caught.value)
    MachineData(RAPPR_FACT_MAX=0.499, RDELTA_OV_MAX=1.0, RSYNC_WEIGHT=0.0, RSYNC_MIN_PHASE=0.5)


@pytest.mark.requirement("RSV-MOT-06", by=PATH + "set_mode")
def test_an_odd_number_of_circle_positions_is_an_error_at_the_change_of_mode() -> None:
    path = Path(START)
    path.set("BEWEG_ART", "ZIRK_MIN_ORI")
    for x, y in ((10, 10), (20, 0), (30, 10)):
        path.position(at(x, y))
    with pytest.raises(StepFault, match="an even number of positions"):
        path.set("BEWEG_ART", "LINEAR")
    path.position(at(40, 0))
    path.set("BEWEG_ART", "LINEAR")
    path.position(at(50, 0))
    first, second, line = path.blocks()
    assert first.kind is second.kind is Interpolation.CIRCULAR and line.kind is Interpolation.LINEAR
    places = [target.pose.position for target in (first.via, first.target, second.via, second.target) if isinstance(target, PoseTarget)]
    assert places == [pytest.approx((x / 1e3, y / 1e3, 0)) for x, y in ((10, 10), (20, 0), (30, 10), (40, 0))]
    assert first.turning is Turning.LEAST


@pytest.mark.requirement("RSV-MOT-13", by=PATH + "_check_weight")
def test_orientation_weight_twice_in_a_row_is_path_error_903() -> None:
    path = linear()
    path.position(at(10))
    path.set("IORI_WEIGHT", 0)
    assert fault(path, at(20), at(30)) == 0
    path.set("IORI_WEIGHT", 50)
    assert fault(path, at(40)) == 0, "not modal: 100 in between"
    path.set("IORI_WEIGHT", 0)
    assert fault(path, at(50)) == 903


def test_a_weighted_auxiliary_point_next_to_a_weighted_point_is_903_too() -> None:
    path = linear()
    path.set("IORI_WEIGHT", 0)
    path.position(at(10))
    path.set("BEWEG_ART", "ZIRK_MIN_ORI")
    path.set("IORI_CIRCHP", 50)
    assert fault(path, at(20, 10)) == 903


@pytest.mark.requirement("RSV-MOT-16", by=PATH + "_check")
def test_an_orientation_only_path_without_bahn_zeit_is_path_error_622() -> None:
    assert fault(linear(), at(10), at(10, 0, 30)) == 622
    timed = linear()
    timed.position(at(10))
    timed.set("BAHN_ZEIT", 2.0)
    assert fault(timed, at(10, 0, 30)) == 0
    assert [block.pace.time for block in timed.blocks()] == [None, 2.0]


@pytest.mark.requirement("RSV-MOT-17", by=PATH + "_check")
def test_approximation_faults_620_102_621_623_624() -> None:
    assert fault(linear(UEBERSCHL=1), at(10), at(10)) == 620
    assert fault(linear(UEBERSCHL=1, BAHN_RADIUS=0, BAHN_DISTANZ=0), at(10)) == 102
    turning = linear(UEBERSCHL=1)
    turning.set("BAHN_ZEIT", 1.0)
    assert fault(turning, at(0, 0, 30)) == 621
    for target, code in ((at(10), 623), (at(10, 0, 30), 624)):
        following = linear(UEBERSCHL=1)
        following.position(at(10))
        following.set("UEBERSCHL", 0)
        following.set("BAHN_ZEIT", 1.0)
        assert fault(following, target) == code


def test_bahn_zeit_wins_over_speed_and_is_not_modal() -> None:
    path = linear(BAHN_GESCHW=50, BAHN_ZEIT=4.0)
    path.position(at(10))
    path.position(at(20))
    first, second = path.blocks()
    assert (first.pace.time, first.pace.path_speed) == (4.0, None)
    assert second.pace.time is None and second.pace.path_speed == pytest.approx(0.05)
    assert second.pace.path_accel == pytest.approx(1.0), "50 % of 2000 mm/s2"


def test_distance_goes_out_beside_the_radius_and_spline_ignores_both() -> None:
    path = linear(UEBERSCHL=1, BAHN_RADIUS=10, BAHN_DISTANZ=3, IV_FLYBY_S=50)
    path.position(at(100))
    path.set("BEWEG_ART", "SPLINE")
    path.position(at(200))
    rounded, curve = path.blocks()
    assert (rounded.blend.leave, rounded.blend.distance, rounded.blend.share, rounded.blend.flyby) == (0.01, 0.003, 0.4, 0.5)
    assert curve.blend.leave == curve.blend.distance == 0.0


def test_ptp_runs_with_the_lead_axis() -> None:
    path = Path(JointTarget((0.0, 0.0)))
    path.set("PTP_GESCHW", 50)
    path.position(JointTarget((1.0, 0.5)))
    (block,) = path.blocks()
    assert block.pace.lead and block.pace.speed == 0.5 and block.pace.accel == 0.5


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("IV_FLYBY_S", 101, "is outside"),
        ("IACC_TIME", 51, "is outside"),
        ("BAHN_RADIUS", -1, "is outside"),
        ("PTP_GESCHW", 0, "must be above 0 and at most 100"),
        ("BAHN_GESCHW", float("nan"), "must be above 0 and at most"),
    ],
)
def test_values_outside_their_range_are_refused(name: str, value: float, reason: str) -> None:
    with pytest.raises(StepFault, match=reason):
        linear(**{name: value})
