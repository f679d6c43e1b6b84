"""VAL 3 reference, L4609-4656: setLatch and getLatch."""

import pytest

from hil_tests.unit.motion.measure.benches import P5_NS, Rig, bench, undisturbed
from motion.execution.stepper import State
from motion.measure.latch import ARMING_NS, PULSE_NS, UPDATE_NS, Change, Latch
from motion.val3.errors import RuntimeFault

Position = tuple[float, ...] | None


class Arm:
    """An arm on its way, and its latch; a VAL 3 task looks at it once a cycle."""

    def __init__(self) -> None:
        self.rig = Rig(bench())
        self.rig.stepper.load(self.rig.piece)
        self.latch = Latch(self.rig.bench.history, (0, 1))

    def cycle(self, changes: list[Change]) -> None:
        rig = self.rig
        sample = rig.stepper.step()
        rig.now_ns += P5_NS
        rig.bench.history.add(rig.now_ns, sample.q, sample.qd)
        self.latch.step(rig.now_ns, [c for c in changes if rig.now_ns - P5_NS < c.stamp_ns <= rig.now_ns])

    def watch(self, changes: list[Change], seconds: float) -> Position:
        """watch(getLatch(j) == true, seconds)."""
        until = self.rig.now_ns + round(seconds * 1e9)
        while self.latch.get_latch() is None and self.rig.now_ns < until:
            self.cycle(changes)
        return self.latch.get_latch()


def refused(latch: Latch, name: str) -> int:
    try:
        latch.set_latch(name, 0)
    except RuntimeFault as fault:
        return fault.code
    return 0


EDGE_NS = 401_234_567
PULSE = [Change("fIn0", EDGE_NS, True), Change("fIn0", EDGE_NS + 10_000_000, False)]


@pytest.mark.requirement("VAL-LATCH-01", by="motion.measure.latch:Latch.step")
@pytest.mark.requirement("VAL-LATCH-01", by="motion.measure.latch:Latch.get_latch")
@pytest.mark.requirement("VAL-LATCH-01", by="motion.measure.latch:Latch.set_latch")
def test_set_latch_delay_0_watch_get_latch_is_true_after_an_edge_and_other_inputs_are_error_70() -> None:
    arm = Arm()
    assert [refused(arm.latch, name) for name in ("fIn0", "fIn1", "dIn0", "fOut0", "")] == [0, 0, 70, 70, 70]
    arm.latch.set_latch("fIn0", arm.rig.now_ns)
    arm.cycle(PULSE)  # delay(0)
    assert arm.latch.armed_ns is not None and arm.rig.now_ns >= arm.latch.armed_ns
    assert arm.latch.get_latch() is None, "pending"
    position = arm.watch(PULSE, 5.0)
    assert position is not None and arm.rig.now_ns - EDGE_NS <= 2 * P5_NS
    early, late = undisturbed(arm.rig.piece, EDGE_NS), undisturbed(arm.rig.piece, EDGE_NS + UPDATE_NS)
    for axis in (0, 1):
        assert early[axis] - 2e-6 <= position[axis] <= late[axis] + 2e-6, "0 .. 62.5 us after the edge"
    while arm.rig.stepper.state is State.RUNNING:
        arm.cycle([*PULSE, Change("fIn0", EDGE_NS + 300_000_000, True)])
    assert arm.latch.get_latch() == position, "the same until it is armed anew"
    arm.latch.set_latch("fIn0", arm.rig.now_ns)
    assert arm.latch.get_latch() is None


def test_never_armed_or_no_edge_is_false() -> None:
    arm = Arm()
    assert arm.watch(PULSE, 0.5) is None, "never armed"
    arm = Arm()
    arm.latch.set_latch("fIn1", 0)
    assert arm.watch(PULSE, 0.5) is None, "the other input"
    arm = Arm()
    arm.latch.set_latch("fIn0", 0)
    assert arm.watch([Change("fIn0", EDGE_NS, False)], 0.5) is None, "a falling edge"


def test_an_edge_before_the_arming_time_is_not_caught() -> None:
    for late_ns, caught in ((ARMING_NS - 1, False), (ARMING_NS, True)):
        arm = Arm()
        arm.latch.set_latch("fIn0", 0)
        assert (arm.watch([Change("fIn0", late_ns, True)], 0.1) is not None) is caught


@pytest.mark.parametrize(
    ("low_ns", "high_ns", "caught"), [(PULSE_NS, PULSE_NS, True), (PULSE_NS - 1, PULSE_NS, False), (PULSE_NS, PULSE_NS - 1, False)]
)
def test_the_edge_needs_31_25_us_of_low_and_of_high(low_ns: int, high_ns: int, caught: bool) -> None:
    arm = Arm()
    arm.latch.set_latch("fIn0", 0)
    rise = 100_000_000 + low_ns
    signal = [Change("fIn0", 100_000_000, False), Change("fIn0", rise, True), Change("fIn0", rise + high_ns, False)]
    assert (arm.watch(signal, 0.3) is not None) is caught


def test_a_spike_does_not_end_the_waiting() -> None:
    arm = Arm()
    arm.latch.set_latch("fIn0", 0)
    spike = [Change("fIn0", 100_000_000, True), Change("fIn0", 100_000_900, False)]
    position = arm.watch([*spike, *PULSE], 1.0)
    assert position == pytest.approx(undisturbed(arm.rig.piece, EDGE_NS)[:2], abs=2e-6)


def test_an_edge_reported_too_late_latches_nothing_and_one_of_the_future_is_now() -> None:
    arm = Arm()
    arm.latch.set_latch("fIn0", 0)
    for _ in range(100):
        arm.cycle([])
    arm.latch.step(arm.rig.now_ns, [Change("fIn0", 4_000_001, True)])
    assert arm.watch([], 0.1) is None
    arm.latch.set_latch("fIn0", arm.rig.now_ns)
    arm.cycle([])
    now_ns = arm.rig.now_ns
    arm.latch.step(now_ns, [Change("fIn0", now_ns + 10**15, True)])
    assert arm.watch([], 0.1) == arm.rig.bench.history.at(now_ns)[:2]
