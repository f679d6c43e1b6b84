"""IO logic and PPO in the cycle (rho3 4.14): a workpiece coordinate of the set values leads the outputs of the image."""

from collections.abc import Callable

import pytest

from gateway.pure.cycle.path_outputs import CoreOutputs, OutputPlace
from gateway.pure.image.records.cell import ALL_PERMITS, RC_BYTES, CellState, Motion, Permit, get_bit
from hil_tests.lab.cells.arms import portal
from motion.measure.errors import ProgramFault
from motion.outputs.function import Function
from motion.outputs.rho3 import Kind

PERIOD, SPEED = 0.004, 0.5  # s, m/s along x
IOL, INTEGER, ANALOG = 400, 416, 432
PLACES = {
    (Kind.IOL, 2): OutputPlace(IOL),
    (Kind.PPO, 3): OutputPlace(INTEGER, 16),
    (Kind.PPO, 204): OutputPlace(ANALOG, 16, rated=1000.0, volts=10.0),
}


class Way:
    """A portal that goes along x."""

    def __init__(self) -> None:
        self.state, self.image = CellState(permits=ALL_PERMITS, motion=Motion.RUNNING), bytearray(RC_BYTES)
        self.outputs = CoreOutputs(PLACES, {1: portal().kinematics}, PERIOD)
        self.x = 0.0

    def call(self, ppo: bool, *numbers: float) -> None:
        no, kin, coordinate, position, value, time = numbers
        asked = Function(ppo, int(no), int(kin), int(coordinate), position, value, int(time))
        self.outputs.call(asked, self.state, self.image)

    def on(self, to: float) -> list[tuple[float, int]]:
        """(x mm, IO) of each cycle up to x = to (mm)."""
        seen = []
        while self.x < to * 1e-3:
            self.cycle(self.x + SPEED * PERIOD)
            seen.append((self.x * 1e3, int(get_bit(self.image, IOL))))
        return seen

    def cycle(self, x: float) -> None:
        self.x = x
        self.outputs.step((x, 0.0, 0.0), self.state, self.image)

    def word(self, bit: int) -> int:
        return int.from_bytes(self.image[bit // 8 : bit // 8 + 2], "big", signed=True)


@pytest.fixture
def way() -> Way:
    return Way()


def test_an_io_switches_in_the_cycle_in_which_the_coordinate_reaches_its_position(way: Way) -> None:
    way.call(False, 2, 1, 1, 100.0, 1, 0)
    seen = way.on(150.0)
    assert all(value == (x >= 100.0 - 1e-9) for x, value in seen) and {value for _, value in seen} == {0, 1}


def test_a_time_offset_shifts_it_by_the_way_of_that_time(way: Way) -> None:
    way.call(False, 2, 1, 1, 100.0, 1, -40)
    seen = way.on(150.0)
    assert all(value == (x >= 80.0 - 1e-6) for x, value in seen), "40 ms at 500 mm/s earlier"


@pytest.mark.requirement(
    "RHO-MOT-35", by=("gateway.pure.cycle.path_outputs:CoreOutputs.call", "gateway.pure.cycle.path_outputs:CoreOutputs.step")
)
def test_values_are_in_the_image_as_numbers_and_a_reset_acts_at_once(way: Way) -> None:
    way.call(True, -3, 1, 1, 1, 50, 0)
    assert way.word(INTEGER) == 50
    way.call(True, 3, 1, 1, 200.0, -50.0, 0)
    way.on(100.0)
    assert abs(way.word(INTEGER)) <= 1, "half of the way from 50 to -50"
    way.on(220.0)
    assert way.word(INTEGER) == -50
    way.call(True, -204, 3 - 2, 1, 1, 500.0, 0)
    assert way.word(ANALOG) == round(0.5 * 32767), "5 V of 10"
    way.call(True, -3, 1, 1, 1, 1e6, 0)
    assert way.word(INTEGER) == 32767, "held at the end of the word"


@pytest.mark.parametrize(
    "change",
    [
        lambda state: setattr(state, "permits", ALL_PERMITS & ~Permit.RUN),
        lambda state: setattr(state, "permits", ALL_PERMITS & ~Permit.FEED),
        lambda state: setattr(state, "permits", ALL_PERMITS & ~Permit.TRAVEL),
        lambda state: setattr(state, "emergency", True),
        lambda state: setattr(state, "motion", Motion.STOPPING),
        lambda state: setattr(state, "failed_job", 7),
    ],
)
@pytest.mark.requirement("RHO-MOT-36", by="gateway.pure.cycle.path_outputs:CoreOutputs.step")
def test_what_stops_the_path_clears_an_io_and_freezes_a_ppo(way: Way, change: Callable[[CellState], None]) -> None:
    way.call(False, -2, 1, 1, 1, 1, 0)  # stands at 1
    way.call(False, 2, 1, 1, 100.0, 1, 0)
    way.call(True, 3, 1, 1, 200.0, 100.0, 0)
    way.on(50.0)
    change(way.state)
    way.cycle(way.x + 1e-3)
    frozen = way.word(INTEGER)
    assert not get_bit(way.image, IOL) and 20 <= frozen <= 30 and way.state.path_stop in (2, 1003)
    way.state.permits, way.state.emergency, way.state.motion = ALL_PERMITS, False, Motion.RUNNING
    way.on(220.0)
    assert way.word(INTEGER) == frozen and not get_bit(way.image, IOL), "it does not go on by itself"
    way.call(False, 2, 1, 1, 300.0, 1, 0)
    with pytest.raises(ProgramFault, match=r"PPO:Fkt\. still in use"):
        way.call(True, 3, 1, 1, 300.0, 1, 0)
    way.call(True, -3, 1, 1, 1, 5, 0)
    way.call(True, 3, 1, 1, 300.0, 1, 0)


def test_a_coordinate_that_stops_before_its_place_is_a_stop_too(way: Way) -> None:
    way.call(False, -2, 1, 1, 1, 1, 0)
    way.call(False, 2, 1, 1, 100.0, 1, 0)
    way.on(50.0)
    way.cycle(way.x)
    assert not get_bit(way.image, IOL) and way.state.path_stop == 2
