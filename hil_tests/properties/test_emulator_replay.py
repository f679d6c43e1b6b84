"""The same stamped frames and seed give the same answers bit for bit, however they are cut into calls and whenever `wake` comes."""

from dataclasses import replace
from functools import cache
from math import sin

from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from drivers.emulator.servo.settings import BusSettings, ServoSettings
from drivers.emulator.servodyn.slave import Event, FaultRaised, ServodynSlave
from hil_tests.lab.virtual.servodyn_bus import CODEC, DriveBus
from protocols.base.machine import Frame

ROUGH = ServoSettings(gravity_nm=1.5, torque_noise_nm=0.3, following_error_rad=8.0)
EXAMPLES = 25
Outcome = tuple[list[Frame], list[Event], bytes, dict[str, object]]


@cache
def recorded() -> tuple[BusSettings, tuple[Frame, ...]]:
    """Some 3 s of four axes: motion, jitter, a fault by jump, a dead axis, SYNC lost and back, reset, motion again."""
    bus = DriveBus(ROUGH, replace(ROUGH, brake=False, gravity_nm=0.0), replace(ROUGH, soft_limit_max_inc=60_000), ROUGH, seed=11)
    bus.enable()
    for number in bus.want:
        bus.move(lambda t: 6_000.0 * sin(16.0 * t), number)
    for k in range(60):
        bus.now += 37_000 if k % 3 else -61_000
        bus.cycle()
    bus.want[3].limit_switch = True
    bus.move(lambda t: 200_000.0 * t, 3)
    bus.run(0.6)
    bus.move(lambda t: 90_000.0, 1)
    bus.cycle(5)
    bus.want[2].silent = True
    bus.cycle(10)
    bus.now += 400_000_000
    bus.want[2].silent = False
    bus.cycle(5)
    for want in bus.want.values():
        want.on, want.enable, want.reset, want.path = False, False, True, None
    bus.cycle(4)
    bus.enable()
    bus.cycle(5)
    assert {event.code for event in bus.events if isinstance(event, FaultRaised)} == {1, 2, 4, 5}
    return bus.settings, tuple(bus.trace)


def finish(slave: ServodynSlave, events: list[Event], said: list[Frame]) -> Outcome:
    end = recorded()[1][-1].stamp_ns + 300_000_000
    events += slave.wake(end)
    return said + slave.take_output(), events, slave.take_record(), slave.state()


@cache
def whole() -> Outcome:
    chosen, trace = recorded()
    slave = ServodynSlave(chosen, CODEC)
    return finish(slave, slave.receive(trace, trace[-1].stamp_ns), [])


@settings(max_examples=EXAMPLES, deadline=None, phases=[Phase.explicit, Phase.reuse, Phase.generate])  # a smaller trace tells no more
@given(
    cuts=st.lists(st.integers(1, 40), min_size=1, max_size=60),
    wakes=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20),
    ahead=st.booleans(),
)
def test_a_recorded_trace_replays_bit_for_bit(cuts: list[int], wakes: list[float], ahead: bool) -> None:
    chosen, trace = recorded()
    slave = ServodynSlave(chosen, CODEC)
    said: list[Frame] = []
    events: list[Event] = []
    at = turn = 0
    while at < len(trace):
        batch = trace[at : at + cuts[turn % len(cuts)]]
        begin = trace[at - 1].stamp_ns if at else batch[0].stamp_ns - 1_000_000
        events += slave.wake(begin + int((batch[0].stamp_ns - begin) * wakes[turn % len(wakes)]))
        said += slave.take_output()
        events += slave.receive(batch, batch[-1].stamp_ns + 1000 * turn)
        said += slave.take_output()
        if ahead:
            slave.prepare()
        at, turn = at + len(batch), turn + 1
    outcome, expected = finish(slave, events, said), whole()
    assert outcome[0] == expected[0]
    assert outcome[1] == expected[1]
    assert outcome[2] == expected[2]
    assert outcome[3]["axes"] == expected[3]["axes"]


def test_another_seed_gives_other_answers() -> None:
    chosen, trace = recorded()
    slave = ServodynSlave(replace(chosen, seed=12), CODEC)
    assert finish(slave, slave.receive(trace, trace[-1].stamp_ns), [])[2] != whole()[2]


@settings(max_examples=40, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from([100, 210, 220, 230, 240, 250, 260, 610, 5]), st.binary(max_size=8), st.integers(-3_000_000, 9_000_000)),
        max_size=60,
    )
)
def test_garbage_on_the_bus_never_raises_and_always_comes_to_rest(frames: list[tuple[int, bytes, int]]) -> None:
    slave = ServodynSlave(BusSettings(seed=3), CODEC)
    now = 10**9
    for identifier, data, step in frames:
        now += step
        slave.receive([Frame(identifier, data, now)], now)
    slave.wake(now + 10**9)
    for frame in slave.take_output():
        CODEC.decode_actual(frame)
    assert all(slave.axis(number).servo.speed_rad_s == 0.0 for number in range(1, 7))
