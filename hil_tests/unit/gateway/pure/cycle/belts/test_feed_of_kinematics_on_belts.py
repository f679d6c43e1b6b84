"""Feed inputs and override of single kinematics in a cell with belts and a correction, where one program moves at a time (AX-1787)."""

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion, Permit, Quality, pack_cell_state, unpack_cell_state
from hil_tests.lab.cells.arm_and_scara import OWN, cell_text
from hil_tests.lab.cells.carried_cell import ARM
from hil_tests.lab.cells.two_on_belts import MASKS, OnBelts, with_belts

ALLOW, RUN = 145, 161  # of kinematic 2, the SCARA
WIRED = 'wired = ["KIN_2_FEED_ALLOW_RCI", "KIN_2_FEED_HOLD_N_RCI"]'
HERE = {"arm": ("ptp joints 10 30 90 0 60 0", "ptp joints 0 30 90 0 60 0"), "scara": ("ptp joints 20 90 -200 0", "ptp joints 0 90 -200 0")}
ON_BELT = (
    "ptp pose 350 -100 100 180 0 0",
    "synchron B5 at=100mm",
    "linear pose 350 -50 100 180 0 0 belt=100mm",
    "linear pose 350 -50 60 180 0 0 belt=100mm path=20",
    "synchron_end",
    "ptp joints 0 90 -200 0",
)


@pytest.fixture(scope="module")
def both() -> OnBelts:
    text = with_belts(cell_text())
    return OnBelts(load_cell(str(ARM), text.replace("[rc_inputs]\n", f"[rc_inputs]\n{WIRED}\n", 1)))


@pytest.fixture
def home(both: OnBelts) -> OnBelts:
    both.bench.permit(ALLOW, RUN)
    both.bench.settle(both.bench.give(Code.OVERRIDE))
    return both.home()


def moved(home: OnBelts, robot: str, seconds: float = 0.2) -> bool:
    """Whether its set values change within this time."""
    own = OWN[list(MASKS).index(robot)]
    before = home.bench.set()[own]
    home.bench.run(seconds)
    return bool(home.bench.set()[own] != before)


def test_an_input_of_the_scara_holds_what_moves_it_and_nothing_that_moves_the_arm(home: OnBelts) -> None:
    home.bench.permit(RUN, value=False)
    job = home.finished(home.begin("arm", *HERE["arm"]))
    assert job.state is CommandState.DONE
    job = home.begin("scara", *HERE["scara"])
    home.bench.run(0.4)
    assert job.open and not moved(home, "scara")
    seen = unpack_cell_state(pack_cell_state(home.state))
    assert (seen.withheld(MASKS["arm"]), seen.withheld(MASKS["scara"])) == (0, Permit.RUN), "as readers see it"
    home.bench.permit(RUN)
    assert home.finished(job).state is CommandState.DONE, "it goes on by itself"


def test_it_is_held_on_its_belt_too(home: OnBelts) -> None:
    home.started(5, 0.02)
    job = home.begin("scara", *ON_BELT)
    home.until(lambda state: state.engaged != 0.0 and state.belt > 0.1)
    home.bench.run(0.8)
    home.bench.permit(RUN, value=False)
    home.bench.run(0.3)
    held = home.bench.set()[8]
    home.bench.run(0.3)
    assert home.bench.set()[8] == pytest.approx(held, abs=1e-3), "its way down rests"
    assert moved(home, "scara"), "and it rides on"
    home.bench.permit(RUN)
    assert home.finished(job).state is CommandState.DONE


def test_without_its_feed_allow_the_scara_takes_no_move(home: OnBelts) -> None:
    home.bench.permit(ALLOW, value=False)
    home.bench.run(0.1)
    refused = home.begin("scara", *HERE["scara"])
    assert (refused.state, refused.reason, refused.detail) == (CommandState.REFUSED, Reason.FEED_NOT_ALLOWED, "S1, S2, S3, S4")
    home.bench.run(0.1)
    assert home.finished(home.begin("arm", *HERE["arm"])).state is CommandState.DONE


def test_an_input_that_is_lost_stops_the_scara_alone(home: OnBelts) -> None:
    job = home.begin("arm", *HERE["arm"])
    home.bench.run(0.1)
    home.bench.inputs.quality[RUN >> 3] = Quality.BAD
    assert home.finished(job).state is CommandState.DONE
    home.bench.permit(RUN)
    job = home.begin("scara", *HERE["scara"])
    home.bench.run(0.2)
    home.bench.inputs.quality[RUN >> 3] = Quality.BAD
    home.bench.run(0.6)
    assert (home.state.motion, home.state.stop_cause) == (Motion.STOPPED, Reason.INPUT_LOST)
    home.bench.permit(RUN)
    assert not moved(home, "scara"), "nothing moves without a fresh command"
    home.bench.settle(home.bench.give(Code.RESUME))
    assert home.finished(job).state is CommandState.DONE


def test_the_override_of_one_slows_what_moves_it_and_is_kept_beside_the_other_s(home: OnBelts) -> None:
    def seconds(robot: str) -> float:
        job, before = home.begin(robot, *HERE[robot]), home.bench.now
        assert home.bench.settle(job).state is CommandState.DONE
        return (home.bench.now - before) / 1e9

    whole = {robot: seconds(robot) for robot in MASKS}
    assert home.bench.settle(home.bench.give(Code.AXES_OVERRIDE, 1 << 9, velocity=0.2)).state is CommandState.DONE
    assert [home.state.override_of(mask) for mask in MASKS.values()] == [1.0, 0.2]
    assert seconds("arm") == pytest.approx(whole["arm"], rel=0.05)
    assert seconds("scara") > 1.8 * whole["scara"]
    assert home.bench.settle(home.bench.give(Code.AXES_OVERRIDE, 1 << 9, velocity=0.0)).state is CommandState.DONE
    refused = home.begin("scara", *HERE["scara"])
    assert (refused.state, refused.reason) == (CommandState.REFUSED, Reason.OVERRIDE_ZERO)
    home.bench.run(0.1)
    assert seconds("arm") == pytest.approx(whole["arm"], rel=0.05)
    assert home.bench.settle(home.bench.give(Code.OVERRIDE)).state is CommandState.DONE
    assert [home.state.override_of(mask) for mask in MASKS.values()] == [1.0, 1.0], "that of all is of all"
