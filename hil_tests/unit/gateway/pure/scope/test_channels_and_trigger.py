"""Channels read what the cycle packed; a trigger fires at its passing, with what was before it."""

from dataclasses import replace
from typing import Any

import pytest

from gateway.pure.image.records.cell import MOST_AXES, RC_BYTES, AxisFlag, AxisState, CellState, Motion, pack_cell_state, set_bit
from gateway.pure.image.signals import from_tables
from gateway.pure.scope.channels import AxisFact, ChannelError, all_names, channel, stamp_ns
from gateway.pure.scope.records import pack_scope, scope_bytes
from gateway.pure.scope.trigger import Capture, Rows, TriggerError, parse_trigger

AXES = [AxisFact("X", "mm"), AxisFact("W", "deg")]
SIGNALS = from_tables([
    {"name": "CTRL_ALLOW_RCI", "bit": 25, "direction": "input", "source": "rho3", "de": "", "en": "", "lines": ""},
    {"name": "USER_OUT_RCO", "bit": 384, "direction": "output", "source": "rho3", "de": "", "en": "", "lines": ""},
])  # fmt: skip


def record(x: float = 0.0, *, sync_ns: int = 0, bits: tuple[int, ...] = (), outputs: tuple[int, ...] = (), **cell: Any) -> bytes:
    state = CellState(sync_ns=sync_ns, override=0.5, compute_ns=120_000, motion=Motion.RUNNING)
    for name, value in cell.items():
        setattr(state, name, value)
    state.axes[0] = AxisState(
        actual=x / 1000, set=0.002, speed=-0.3, lag=0.0005, torque=0.25, flags=AxisFlag.ENABLED, fault_code=0x8611, power=3
    )
    state.axes[1] = replace(AxisState(), actual=3.141592653589793)
    images = bytearray(RC_BYTES), bytearray(RC_BYTES)
    for image, numbers in zip(images, (outputs, bits), strict=True):
        for number in numbers:
            set_bit(image, number, True)
    return pack_scope(pack_cell_state(state), *images)


@pytest.mark.parametrize(
    "name, value, unit",
    [
        ("axis.X.actual", 12.5, "mm"),
        ("axis.X.set", 2.0, "mm"),
        ("axis.X.speed", -300.0, "mm/s"),
        ("axis.X.lag", 0.5, "mm"),
        ("axis.X.torque", 25.0, "%"),
        ("axis.X.enabled", 1.0, ""),
        ("axis.X.referenced", 0.0, ""),
        ("axis.X.fault_code", 0x8611, ""),
        ("axis.X.power", 3.0, ""),
        ("axis.W.actual", 180.0, "deg"),
        ("cell.override", 50.0, "%"),
        ("cell.compute_us", 120.0, "us"),
        ("cell.motion", 1.0, ""),
        ("rc_in.25", 1.0, ""),
        ("rc_in.24", 0.0, ""),
        ("CTRL_ALLOW_RCI", 1.0, ""),
        ("rc_out.384", 1.0, ""),
        ("USER_OUT_RCO", 1.0, ""),
    ],
)
def test_a_channel_reads_its_value_in_the_outside_unit(name: str, value: float, unit: str) -> None:
    taken = record(12.5, bits=(25,), outputs=(384,))
    found = channel(name, AXES, SIGNALS)
    assert len(taken) == scope_bytes(MOST_AXES)
    assert found.read(taken) == pytest.approx(value)
    assert found.unit == unit


def test_every_name_that_is_listed_can_be_read() -> None:
    values = [channel(name, AXES, SIGNALS).read(record()) for name in all_names(AXES)]
    assert len(values) == len(set(all_names(AXES))) > 40


@pytest.mark.parametrize(
    "name, words",
    [("axis.Q.lag", "X, W"), ("axis.X.height", "actual"), ("cell.x", "override"), ("rc_in.1024", "0 to 1023"), ("lag", "axis.NAME.VALUE")],
)
def test_an_unknown_name_is_reported_with_those_there_are(name: str, words: str) -> None:
    with pytest.raises(ChannelError, match=words):
        channel(name, AXES, SIGNALS)


def kept(trigger: str, records: list[bytes], *, pre: int = 0, post: int = 3) -> Capture:
    capture = Capture([channel("axis.X.actual", AXES, SIGNALS)], post, pre, parse_trigger(trigger, AXES, SIGNALS) if trigger else None)
    for sequence, one in enumerate(records, start=1):
        capture.take(sequence, one)
    return capture


def values(capture: Capture) -> list[float]:
    return [round(row[0], 9) for row in capture.rows]


RAMP = [record(float(x), sync_ns=1000 * x) for x in range(10)]


def test_without_a_trigger_the_first_records_are_kept() -> None:
    capture = kept("", RAMP)
    assert (values(capture), capture.triggered_at, capture.full) == ([0, 1, 2], 0, True)


def test_a_level_fires_where_it_is_passed_and_keeps_what_was_before() -> None:
    capture = kept("axis.X.actual > 4.5", RAMP, pre=2)
    assert (values(capture), capture.triggered_at) == ([3, 4, 5, 6, 7], 2)
    assert list(capture.stamps) == [3000, 4000, 5000, 6000, 7000] == [stamp_ns(one) for one in RAMP[3:8]]


def test_less_before_the_trigger_than_was_asked_for_is_all_there_is() -> None:
    assert values(kept("axis.X.actual > 0.5", RAMP, pre=5)) == [0, 1, 2, 3]


def test_a_level_that_stays_fires_only_at_its_next_passing() -> None:
    down_and_up = [record(x) for x in (9, 9, 2, 9, 9, 9)]
    assert kept("axis.X.actual > 5", down_and_up).triggered_at is not None
    assert values(kept("axis.X.actual > 5", down_and_up, pre=1)) == [2, 9, 9, 9]
    assert kept("axis.X.actual < 5", RAMP).triggered_at is None


@pytest.mark.parametrize("words, first", [("CTRL_ALLOW_RCI rises", 2), ("CTRL_ALLOW_RCI falls", 4), ("CTRL_ALLOW_RCI changes", 2)])
def test_edges(words: str, first: int) -> None:
    stream = [record(x, bits=(25,) if x in (2, 3) else ()) for x in range(8)]
    assert values(kept(words, stream))[0] == first


@pytest.mark.parametrize("name, value", [("emergency", True), ("stop_cause", 7)])
def test_error_fires_at_an_emergency_and_at_a_stop_by_itself(name: str, value: Any) -> None:
    stream = [record(0), record(1), record(2, **{name: value}), record(3, **{name: value}), record(4)]
    assert values(kept("error", stream)) == [2, 3, 4]


def test_records_that_never_came_are_counted() -> None:
    capture = Capture([channel("axis.X.actual", AXES, SIGNALS)], 3)
    for sequence in (1, 2, 6):
        capture.take(sequence, RAMP[sequence])
    assert (capture.lost, len(capture.rows)) == (3, 3)


@pytest.mark.parametrize(
    "words", ["", "axis.X.actual", "axis.X.actual >> 3", "axis.X.actual > x", "axis.Q.lag > 3", "CTRL_ALLOW_RCI jumps"]
)
def test_a_trigger_that_cannot_be_read_is_refused(words: str) -> None:
    with pytest.raises(TriggerError):
        parse_trigger(words, AXES, SIGNALS)


def test_ten_minutes_of_sixteen_channels_fit_in_forty_megabytes() -> None:
    rows = Rows(16)
    for n in range(1000):
        rows.append(float(16 * n + column) for column in range(16))
    assert len(rows) == 1000 and rows[3] == [float(16 * 3 + column) for column in range(16)] and rows.value(999, 15) == 15_999.0
    assert len(rows.flat) * rows.flat.itemsize * 300 <= 40e6, "300,000 records: ten minutes at 2 ms"
    with pytest.raises(IndexError):
        rows[1000]
