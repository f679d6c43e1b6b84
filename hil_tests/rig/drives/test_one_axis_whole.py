"""Switch on, reference, move with an override change, stop, resume, lose the drive: our side of one axis against the emulated booster.

No process and no clock: bus time is counted in SYNCs.  The verdicts come from the emulator's own shaft, not from what we sent.
"""

import pathlib
from collections.abc import Callable
from math import pi

import pytest

import configs
from drivers.drives.limits import LagMonitor, LagState
from drivers.drives.reference_settings import ReferenceMove
from drivers.drives.referencing import Referencing, RunState
from drivers.drives.scaling import Scaling
from drivers.drives.servodyn import Demand, Drive, Event, Power
from drivers.emulator.servo.settings import BusSettings, ServoSettings
from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.files.dbc import load_servodyn
from motion.execution.ptp import plan_ptp
from motion.execution.stepper import State, Stepper
from motion.geometry.limits import AxisLimits
from protocols.base.machine import Frame
from protocols.servodyn.codec import SYNC, ActualValue, SetValue

P5_NS = 4_000_000
P5 = P5_NS / 1e9
SCALING = Scaling(16384, gear=5.0, feed_per_turn=0.010)
LIMITS = [AxisLimits("A1", -0.05, 0.40, 0.05, 0.5, 5.0, "mm")]
SWITCH = (-100.0, -9.3)  # rad at the motor


class OneAxis:
    """The cycle as the gateway runs it, for one axis."""

    def __init__(self, gravity_nm: float = 0.0) -> None:
        layout = pathlib.Path(configs.__path__[0]) / "drives" / "servodyn_gc.dbc"
        self.codec = load_servodyn(layout)
        servo = ServoSettings(gravity_nm=gravity_nm, reference_switch_from_rad=SWITCH[0], reference_switch_to_rad=SWITCH[1])
        self.slave = ServodynSlave(BusSettings(4.0, 1, {1: servo}), self.codec)
        self.drive, self.scaling = Drive(), SCALING
        self.now = 0
        self.set = SetValue()
        self.events: list[Event] = []

    def power(self) -> Power:
        return self.drive.power

    def cycle(self, demand: Callable[[ActualValue | None], Demand], *, deaf: bool = False) -> None:
        """SYNC, actual values, set values for the next SYNC."""
        self.now += P5_NS
        self.slave.receive([SYNC._replace(stamp_ns=self.now)], self.now)
        answers = [self.codec.decode_actual(frame)[1] for frame in self.slave.take_output()]
        actual = None if deaf or not answers else answers[-1]
        self.set = self.drive.step(actual, demand(actual))
        self.events += self.drive.events
        frame = self.codec.encode_set(1, self.set)
        self.slave.receive([Frame(frame.identifier, frame.data, self.now + P5_NS // 4)], self.now + P5_NS // 4)

    def cycles(self, count: int, demand: Demand, *, deaf: bool = False) -> None:
        for _ in range(count):
            self.cycle(lambda _: demand, deaf=deaf)

    def shaft_inc(self) -> float:
        return self.slave.axis(1).servo.position_rad * 16384 / (2 * pi)

    def switch_on(self) -> None:
        self.cycles(30, Demand())
        for _ in range(100):
            self.cycles(1, Demand(on=True, position_inc=self.drive.set_inc))
            if self.power() is Power.ENABLED:
                return
        raise AssertionError(f"not enabled: {self.drive.phase}, {self.events}")

    def reference(self) -> Referencing:
        move = ReferenceMove(direction=-1, speed=0.02, slow_speed=0.004, accel=0.5, jerk=5.0, position=0.1, offset=0.005, way=0.2)
        run = Referencing(move.at_motor(SCALING), self.drive.set_inc)
        state = RunState.RUNNING

        def demand(actual: ActualValue | None) -> Demand:
            nonlocal state
            step = run.step(self.drive.position_inc, actual is not None and actual.reference_switch, P5)
            state = step.state
            return Demand(True, False, step.set_inc, step.speed_inc_s / 16384 * 60)

        for _ in range(2000):
            self.cycle(demand)
            if state is not RunState.RUNNING:
                break
        assert state is RunState.DONE
        assert run.zero_inc is not None
        self.scaling = SCALING.with_zero(run.zero_inc)
        return run

    def follow(self, stepper: Stepper, lag: LagMonitor | None = None, count: int = 5000) -> None:
        """Samples to the drive until the path is idle or stopped; the lag is that of the set value active at each SYNC."""
        for _ in range(count):
            sample, active = stepper.step(), self.set.position_inc
            self.cycles(1, Demand(True, False, self.scaling.to_inc(sample.q[0]), self.scaling.to_rpm(sample.qd[0])))
            if lag is not None:
                assert lag.check(active - self.drive.position_inc) is not LagState.TRIPPED
            if sample.state in (State.IDLE, State.STOPPED):
                return
        raise AssertionError("never there")


@pytest.mark.parametrize("gravity_nm", [0.0, 3.0], ids=["horizontal", "vertical"])
def test_on_reference_move_with_override_and_stop_reaches_the_target_within_2_increments(gravity_nm: float) -> None:
    axis = OneAxis(gravity_nm)
    axis.switch_on()
    run = axis.reference()
    assert run.zero_inc == -2 * 16384 - 0.1 * SCALING.inc_per_unit  # zero behind 9.3 rad = 1.48 turns
    stepper = Stepper(1, P5, [axis.scaling.to_si(axis.set.position_inc)])
    piece = plan_ptp([axis.scaling.to_si(axis.set.position_inc)], [0.25], LIMITS, piece_id=5)
    stepper.load(piece)
    lag = LagMonitor(1.2 * 0.05 * SCALING.inc_per_unit / 80, 1.5 * 0.05 * SCALING.inc_per_unit / 80 + 200)
    stepper.set_override(0.3)
    for count in range(200):
        if count == 100:
            stepper.set_override(0.8)
        sample = stepper.step()
        axis.cycles(1, Demand(True, False, axis.scaling.to_inc(sample.q[0]), axis.scaling.to_rpm(sample.qd[0])))
    stepper.set_override(1.0)
    axis.follow(stepper, lag)
    axis.cycles(150, Demand(True, False, axis.scaling.to_inc(0.25), 0.0))
    assert abs(axis.shaft_inc() - axis.scaling.to_inc(0.25)) <= 2.0
    assert axis.events == [Event.ENABLED]
    axis.cycles(100, Demand())
    assert axis.power() is Power.OFF


def test_stop_and_resume_on_the_path_then_the_target() -> None:
    axis = OneAxis()
    axis.switch_on()
    axis.reference()
    here = axis.scaling.to_si(axis.set.position_inc)
    stepper = Stepper(1, P5, [here])
    stepper.load(plan_ptp([here], [0.2], LIMITS))
    for _ in range(200):
        sample = stepper.step()
        axis.cycles(1, Demand(True, False, axis.scaling.to_inc(sample.q[0]), axis.scaling.to_rpm(sample.qd[0])))
    stepper.stop()
    axis.follow(stepper)
    held = axis.set.position_inc
    axis.cycles(150, Demand(True, False, held, 0.0))
    assert abs(axis.shaft_inc() - held) <= 2.0
    stepper.resume()
    axis.follow(stepper)
    axis.cycles(150, Demand(True, False, axis.scaling.to_inc(0.2), 0.0))
    assert abs(axis.shaft_inc() - axis.scaling.to_inc(0.2)) <= 2.0


def test_a_drive_that_is_not_heard_is_let_down_and_comes_back_only_with_a_fresh_edge() -> None:
    axis = OneAxis()
    axis.switch_on()
    on = Demand(on=True, position_inc=axis.set.position_inc)
    axis.cycles(50, on, deaf=True)
    assert axis.power() is Power.LOST
    axis.cycles(100, on)
    assert axis.power() is Power.OFF
    standing = axis.shaft_inc()
    axis.cycles(50, on)
    assert axis.shaft_inc() == standing
    axis.cycles(1, Demand())
    axis.cycles(50, on)
    assert axis.power() is Power.ENABLED


def test_a_fault_of_the_booster_is_reset_by_an_edge() -> None:
    axis = OneAxis()
    axis.switch_on()
    on = Demand(on=True, position_inc=axis.set.position_inc)
    axis.slave.force_fault(1)
    axis.cycles(50, on)
    assert (axis.power(), axis.drive.fault_code) == (Power.FAULT, 99)
    axis.cycles(1, on._replace(reset=True))
    axis.cycles(30, on)
    assert axis.power() is Power.OFF
    axis.cycles(1, Demand())
    axis.cycles(50, on)
    assert axis.power() is Power.ENABLED
