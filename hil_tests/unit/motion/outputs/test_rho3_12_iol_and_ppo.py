"""rho 3 Releases part 1, section 12 (L4211-4264): IO logic (SF 1) and PPO (SF 2), reset and stop."""

import pytest

from motion.errors import MotionError
from motion.execution.ptp import plan_ptp
from motion.execution.stepper import State, Stepper
from motion.geometry.limits import AxisLimits
from motion.measure.errors import ProgramFault
from motion.outputs.rho3 import IOL_IN_USE, PPO_IN_USE, Analog, Call, Kind, PathOutputs, Stop

P5 = 0.004
LIMITS = tuple(AxisLimits(f"A{n + 1}", -1.0, 1.0, 0.25, 2.0, 40.0, "mm") for n in range(2))


class Way:
    """A kinematic on its way of 200 mm along coordinate 1, and the functions that follow it."""

    def __init__(self, outputs: PathOutputs) -> None:
        self.outputs, self.stepper = outputs, Stepper(2, P5)
        self.stepper.load(plan_ptp((0.0, 0.0), (0.2, 0.0), LIMITS))
        self.at: list[float] = []
        self.said: list[str] = []

    def run(self, kind: Kind, number: int, kinematic: int = 1, until: float = 1e9, stops: tuple[Stop, ...] = ()) -> list[float]:
        """Value of the output in each cycle, to this position (mm)."""
        values = []
        while self.stepper.state is not State.IDLE and (not self.at or self.at[-1] < until):
            values += self.cycle(kind, number, kinematic, stops)
        return values

    def cycle(self, kind: Kind, number: int, kinematic: int = 1, stops: tuple[Stop, ...] = ()) -> list[float]:
        self.at.append(self.stepper.step().q[0] * 1e3)
        self.said.append(self.outputs.step(kinematic, (self.at[-1], 0.0), P5, stops))
        return [self.outputs.outputs.get((kind, kinematic, number), 0.0)]


def refusal(outputs: PathOutputs, kind: Kind, asked: Call) -> str:
    try:
        outputs.call(kind, asked)
    except ProgramFault as fault:
        return fault.text
    return ""


@pytest.mark.requirement("RHO-MOT-35", by="motion.outputs.rho3:PathOutputs.call")
@pytest.mark.requirement("RHO-MOT-35", by="motion.outputs.rho3:PathOutputs.in_use")
def test_ppo_minus_3_sets_integer_output_3_to_50_at_once_and_the_function_is_free() -> None:
    outputs = PathOutputs()
    outputs.call(Kind.PPO, Call(3, 1, 1, 150.0, 80.0))
    assert outputs.in_use(Kind.PPO, 1, 3)
    assert refusal(outputs, Kind.PPO, Call(3, 1, 1, 150.0, 80.0)) == PPO_IN_USE
    outputs.call(Kind.PPO, Call(-3, 1, 1, 1.0, 50.0, 0))
    assert outputs.outputs[Kind.PPO, 1, 3] == 50.0
    assert not outputs.in_use(Kind.PPO, 1, 3)
    assert refusal(outputs, Kind.PPO, Call(3, 1, 1, 150.0, 80.0)) == ""


@pytest.mark.requirement("RHO-MOT-35", by="motion.outputs.rho3:PathOutputs.call")
def test_io_logic_minus_2_clears_the_binary_output_of_kinematic_2_and_analog_outputs_are_scaled() -> None:
    outputs = PathOutputs({204: Analog(rated=250.0, volts=13.3)})
    outputs.call(Kind.IOL, Call(2, 2, 1, 10.0, 1.0))
    assert refusal(outputs, Kind.IOL, Call(2, 2, 1, 10.0, 1.0)) == IOL_IN_USE
    assert refusal(outputs, Kind.IOL, Call(2, 1, 1, 10.0, 1.0)) == "", "another kinematic's function 2"
    outputs.call(Kind.IOL, Call(-2, 2, 1, 1.0, 0.0))
    assert outputs.outputs[Kind.IOL, 2, 2] == 0.0 and not outputs.in_use(Kind.IOL, 2, 2)
    outputs.call(Kind.PPO, Call(-204, 3, 1, 1.0, 100.0))
    assert outputs.outputs[Kind.PPO, 3, 204] == pytest.approx(100 / 250 * 13.3)
    outputs.call(Kind.PPO, Call(-204, 3, 1, 1.0, 999.0))
    assert outputs.outputs[Kind.PPO, 3, 204] == 13.3, "no more than the board gives"


@pytest.mark.parametrize("stop", [s for s in Stop if s is not Stop.COORDINATE])
@pytest.mark.requirement("RHO-MOT-36", by="motion.outputs.rho3:PathOutputs.step")
def test_a_stop_in_the_block_clears_the_io_and_freezes_the_ppo(stop: Stop) -> None:
    outputs = PathOutputs()
    outputs.call(Kind.IOL, Call(-1, 1, 1, 0.0, 1.0))  # stands at 1
    outputs.call(Kind.IOL, Call(1, 1, 1, 180.0, 1.0))
    outputs.call(Kind.PPO, Call(3, 1, 1, 160.0, 80.0))
    way = Way(outputs)
    way.run(Kind.PPO, 3, until=100.0)
    frozen = outputs.outputs[Kind.PPO, 1, 3]
    assert 49.0 < frozen < 52.0 and outputs.outputs[Kind.IOL, 1, 1] == 1.0 and set(way.said) == {""}
    way.cycle(Kind.PPO, 3, stops=(stop,))
    assert way.said[-1].startswith("PPO/IOL : IPO - STOP") and stop.value in way.said[-1]
    assert outputs.outputs[Kind.IOL, 1, 1] == 0.0 and outputs.outputs[Kind.PPO, 1, 3] == frozen
    way.run(Kind.PPO, 3)
    assert outputs.outputs[Kind.IOL, 1, 1] == 0.0 and outputs.outputs[Kind.PPO, 1, 3] == frozen, "nothing changes on the rest of the way"
    assert refusal(outputs, Kind.PPO, Call(3, 1, 1, 160.0, 80.0)) == PPO_IN_USE, "until it is reset"


@pytest.mark.requirement("RHO-MOT-36", by="motion.outputs.rho3:PathOutputs._reason")
@pytest.mark.requirement("RHO-MOT-36", by="motion.outputs.rho3:PathOutputs._stop")
def test_a_coordinate_that_stops_before_the_position_ends_the_functions_even_when_the_program_wants_it() -> None:
    outputs = PathOutputs()
    outputs.call(Kind.PPO, Call(3, 1, 1, 300.0, 80.0))
    outputs.call(Kind.IOL, Call(-7, 1, 1, 0.0, 1.0))
    outputs.call(Kind.IOL, Call(7, 1, 1, 300.0, 1.0))
    way = Way(outputs)
    way.run(Kind.PPO, 3)
    way.cycle(Kind.PPO, 3)
    assert (
        way.said[-1].startswith("PPO/IOL : IPO - STOP")
        and Stop.COORDINATE.value in way.said[-1]
        and way.said[:-2] == [""] * (len(way.said) - 2)
    )
    assert outputs.outputs[Kind.PPO, 1, 3] == pytest.approx(80 * 200 / 300, abs=0.2)
    assert outputs.outputs[Kind.IOL, 1, 7] == 0.0 and not outputs.in_use(Kind.IOL, 1, 7)


def test_on_the_way_io_switches_at_its_position_and_ppo_follows_the_coordinate() -> None:
    outputs = PathOutputs()
    outputs.call(Kind.PPO, Call(-3, 1, 1, 0.0, 20.0))
    outputs.call(Kind.PPO, Call(3, 1, 1, 160.0, 100.0))
    outputs.call(Kind.IOL, Call(1, 1, 1, 120.0, 1.0))
    way = Way(outputs)
    io, ppo = [], []
    while way.stepper.state is not State.IDLE:
        ppo += way.cycle(Kind.PPO, 3)
        io.append(outputs.outputs.get((Kind.IOL, 1, 1), 0.0))
    assert io == [float(at >= 120.0) for at in way.at]
    begin = way.at[0]
    assert ppo == pytest.approx([20 + 80 * min((at - begin) / (160 - begin), 1.0) for at in way.at], abs=1e-9)
    assert way.said == [""] * len(way.said) and not outputs.in_use(Kind.PPO, 1, 3), "both have ended"
    assert outputs.outputs[Kind.PPO, 1, 3] == 100.0, "the last value stays"


def test_time_offset_moves_the_place_by_what_the_coordinate_travels_in_it() -> None:
    switched = {}
    for time_ms in (-40, 0, 40):
        outputs = PathOutputs()
        outputs.call(Kind.IOL, Call(1, 1, 1, 100.0, 1.0, time_ms))
        way = Way(outputs)
        switched[time_ms] = way.run(Kind.IOL, 1).index(1.0)
    assert switched[0] - switched[-40] == 10 == switched[40] - switched[0], "40 ms are ten cycles"


def test_before_the_movement_begins_nothing_is_stopped() -> None:
    outputs = PathOutputs()
    outputs.call(Kind.IOL, Call(1, 1, 2, 100.0, 1.0))
    for _ in range(5):
        assert outputs.step(1, (0.0, 0.0), P5, (Stop.FEED_HOLD,)) == ""
    assert outputs.in_use(Kind.IOL, 1, 1)


@pytest.mark.parametrize(
    "asked",
    [
        Call(0, 1, 1, 0.0, 0.0),
        Call(1, 0, 1, 0.0, 0.0),
        Call(1, 1, 0, 0.0, 0.0),
        Call(1, 1, 1, float("nan"), 0.0),
        Call(201, 1, 1, 0.0, 1.0),
    ],
)
def test_calls_that_make_no_sense_are_refused(asked: Call) -> None:
    with pytest.raises(MotionError):
        PathOutputs().call(Kind.PPO, asked)


def test_analog_outputs_need_a_rated_value_and_one_of_two_boards() -> None:
    for rated, volts in ((0.0, 10.0), (100.0, 12.0)):
        with pytest.raises(MotionError, match="P405"):
            Analog(rated, volts)
