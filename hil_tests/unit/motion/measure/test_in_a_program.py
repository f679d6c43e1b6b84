"""MOVE UNTIL inside a planned program: a chain of timed pieces is interrupted, and what follows is planned from where the axes are."""

import pytest

from hil_tests.unit.motion.execution.measure import worst
from hil_tests.unit.motion.measure.benches import P5_NS, bench
from motion.execution.stepper import State, Stepper
from motion.geometry.limits import AxisLimits
from motion.kinematics.identity import Identity
from motion.measure.inputs import Edge, input_of
from motion.measure.until import MoveUntil, Outcome
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.program.blocks import Blend, Block, Interpolation, JointTarget, Rounding

LIMITS = tuple(AxisLimits(f"A{n + 1}", -50.0, 50.0, 1.0, 10.0, 200.0, "mm") for n in range(3))
STANDING: tuple[float, ...] = (0.0, 0.0, 0.0)
EXACT, ROUND = Blend(), Blend(Rounding.JOINT, leave=0.05, reach=0.05)


def to(*q: float, blend: Blend = EXACT) -> Block:
    return Block(Interpolation.PTP, JointTarget(q), blend=blend)


def test_a_chain_of_blocks_is_left_on_its_path_and_the_program_goes_on_from_there() -> None:
    on = bench((0, 1))
    planner, stepper = Planner(Machine(Identity(LIMITS), LIMITS), STANDING), Stepper(3, P5_NS * 1e-9)
    on.history.add(0, STANDING, STANDING)
    for block in (to(0.3, 0.0, 0.0, blend=ROUND), to(0.3, 0.6, 0.1)):
        planner.add(block)
    planner.finish()
    move = MoveUntil(on, stepper, input_of(610))
    assert move.begin(False, 0)
    for piece in planner.plan(0.0, hurry=True):
        stepper.load(piece)
    samples, edge, now_ns = [STANDING], Edge(610, 700_000_500, True), 0
    while move.outcome is Outcome.RUNNING:
        sample = move.step(now_ns, [edge] if now_ns - P5_NS < edge.stamp_ns <= now_ns else [])
        now_ns += P5_NS
        on.history.add(now_ns, sample.q, sample.qd)
        samples.append(sample.q)
        assert len(samples) < 2000
    assert move.outcome is Outcome.MET and stepper.state is State.IDLE
    stopped = samples[-1]
    assert stopped[0] == pytest.approx(0.3, abs=1e-9) and 0.1 < stopped[1] < 0.55 and stopped[2] == pytest.approx(stopped[1] / 6, abs=1e-9)
    at = on.mpos.read()
    assert at == on.history.at(edge.stamp_ns)[:2] and at[1] < stopped[1]

    planner.reset(stopped)
    planner.add(to(0.0, at[1], 0.0))
    planner.finish()
    for piece in planner.plan(0.0, hurry=True):
        stepper.load(piece)
    while stepper.state is not State.IDLE:
        samples.append(stepper.step().q)
    assert samples[-1] == pytest.approx((0.0, at[1], 0.0), abs=1e-9)
    shares = worst(samples, LIMITS, P5_NS * 1e-9)
    assert shares.speed <= 1.0001 and shares.accel <= 1.02 and shares.jerk <= 1.10
