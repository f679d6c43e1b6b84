"""AX-001: set and actual values byte for byte; cantools is the judge in both directions."""

import cantools
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gateway.files.dbc import load_layouts
from gateway.files.find import find_config
from hil_tests.lab.virtual.bus_recording import layout
from hil_tests.lab.virtual.servodyn_bus import CODEC
from protocols.base.dbc import compile_dbc
from protocols.base.errors import DecodeError, EncodeError
from protocols.base.machine import Frame
from protocols.servodyn.codec import ActualValue, Codec, SetValue

FILE = find_config("servodyn_gc.dbc", "drives")
JUDGE = cantools.database.can.Database()
JUDGE.add_dbc_file(str(FILE))

AXES = st.integers(1, 6)
BYTE, INT16, INT32 = st.integers(0, 255), st.integers(-(2**15), 2**15 - 1), st.integers(-(2**31), 2**31 - 1)
BIT = st.booleans()
SETS = st.builds(SetValue, BIT, BIT, BIT, BIT, BIT, BYTE, INT32, INT16)
ACTUALS = st.builds(ActualValue, BIT, BIT, BIT, BIT, BIT, BIT, BIT, BIT, BYTE, INT32, INT16)


def judged(identifier: int, data: bytes) -> dict[str, object]:
    return dict(JUDGE.get_message_by_frame_id(identifier).decode_simple(data, decode_choices=False))


def set_value(name: str, value: int) -> SetValue:
    return SetValue(**(SetValue()._asdict() | {name: value}))


def actual_value(name: str, value: int) -> ActualValue:
    return ActualValue(**(ActualValue()._asdict() | {name: value}))


def test_a_set_value_byte_for_byte() -> None:
    value = SetValue(True, False, True, False, True, 0x5A, -2, 0x0102)
    assert CODEC.encode_set(2, value) == Frame(220, bytes.fromhex("15 5a fe ff ff ff 02 01"))


def test_an_actual_value_byte_for_byte() -> None:
    value = ActualValue(True, False, True, False, False, True, False, True, 0x63, 0x01020304, -1)
    assert CODEC.encode_actual(6, value) == Frame(660, bytes.fromhex("a5 63 04 03 02 01 ff ff"))


@pytest.mark.parametrize(("name", "bit"), [("enable", 0), ("drive_on", 1), ("limit_switch", 2), ("fault_reset", 3), ("brake_open", 4)])
def test_each_set_bit_is_where_ax_001_says(name: str, bit: int) -> None:
    assert CODEC.encode_set(1, set_value(name, True)).data[0] == 1 << bit


@settings(max_examples=300, deadline=None)
@given(AXES, SETS)
def test_cantools_reads_what_we_send_and_we_read_what_cantools_sends_set_values(axis: int, value: SetValue) -> None:
    frame = CODEC.encode_set(axis, value)
    message = JUDGE.get_message_by_frame_id(frame.identifier)
    assert message.decode_simple(frame.data, decode_choices=False) == value._asdict()
    assert CODEC.decode_set(Frame(message.frame_id, bytes(message.encode(value._asdict())))) == (axis, value)


@settings(max_examples=300, deadline=None)
@given(AXES, ACTUALS)
def test_cantools_reads_what_we_send_and_we_read_what_cantools_sends_actual_values(axis: int, value: ActualValue) -> None:
    frame = CODEC.encode_actual(axis, value)
    message = JUDGE.get_message_by_frame_id(frame.identifier)
    assert message.decode_simple(frame.data, decode_choices=False) == value._asdict()
    assert CODEC.decode_actual(Frame(message.frame_id, bytes(message.encode(value._asdict())))) == (axis, value)


@settings(max_examples=200, deadline=None)
@given(AXES, st.binary(min_size=8, max_size=8))
def test_any_eight_bytes_mean_to_us_what_they_mean_to_cantools(axis: int, data: bytes) -> None:
    for number, read in ((200 + 10 * axis, CODEC.decode_set), (600 + 10 * axis, CODEC.decode_actual)):
        assert read(Frame(number, data))[1]._asdict() == judged(number, data)


@pytest.mark.parametrize(
    ("name", "low", "high"), [("life", 0, 255), ("position_inc", -(2**31), 2**31 - 1), ("speed_rpm", -(2**15), 2**15 - 1)]
)
def test_both_ends_of_every_range_of_set_values_and_one_step_beyond(name: str, low: int, high: int) -> None:
    for value in (low, high):
        frame = CODEC.encode_set(3, set_value(name, value))
        assert judged(230, frame.data)[name] == value == getattr(CODEC.decode_set(frame)[1], name)
    for value in (low - 1, high + 1):
        with pytest.raises(EncodeError, match=rf"SET_3\.{name} = {value} is outside {low}\.\.{high}"):
            CODEC.encode_set(3, set_value(name, value))


@pytest.mark.parametrize(
    ("name", "low", "high"), [("fault_code", 0, 255), ("position_inc", -(2**31), 2**31 - 1), ("torque_permille", -(2**15), 2**15 - 1)]
)
def test_both_ends_of_every_range_of_actual_values_and_one_step_beyond(name: str, low: int, high: int) -> None:
    for value in (low, high):
        frame = CODEC.encode_actual(3, actual_value(name, value))
        assert judged(630, frame.data)[name] == value == getattr(CODEC.decode_actual(frame)[1], name)
    for value in (low - 1, high + 1):
        with pytest.raises(EncodeError, match=rf"ACT_3\.{name} = {value} is outside {low}\.\.{high}"):
            CODEC.encode_actual(3, actual_value(name, value))


@pytest.mark.parametrize("length", [0, 7, 9])
def test_a_byte_too_few_and_a_byte_too_many_are_reported_with_the_bytes(length: int) -> None:
    data = bytes(range(length))
    with pytest.raises(DecodeError, match=f"8 bytes expected, {length} received"):
        CODEC.decode_set(Frame(210, data))
    with pytest.raises(DecodeError, match=f"8 bytes expected, {length} received"):
        CODEC.decode_actual(Frame(610, data))


def test_identifiers_of_the_other_direction_are_refused() -> None:
    with pytest.raises(DecodeError, match="610 is not a set value"):
        CODEC.decode_set(Frame(610, bytes(8)))
    with pytest.raises(DecodeError, match="210 is not an actual value"):
        CODEC.decode_actual(Frame(210, bytes(8)))


def test_a_layout_that_misses_signals_is_refused_with_the_list() -> None:
    layouts = load_layouts(FILE)
    short = layouts["SET_4"]
    layouts["SET_4"] = type(short)(short.name, short.identifier, short.length, short.signals[1:-1])
    del layouts["ACT_2"], layouts["SYNC"]
    with pytest.raises(EncodeError) as caught:
        Codec(layouts)
    assert "SYNC is missing" in str(caught.value)
    assert "SET_4 (240) misses the signals: enable, speed_rpm" in str(caught.value)


def test_an_axis_with_set_values_only_is_refused() -> None:
    layouts = load_layouts(FILE)
    del layouts["ACT_2"]
    with pytest.raises(EncodeError, match="every axis needs both"):
        Codec(layouts)


def test_the_file_says_that_nobody_verified_it_on_hardware() -> None:
    assert "not verified on hardware" in FILE.read_text() and "axisgate's own" in FILE.read_text()


def test_flags_of_a_layout_of_somebodys_own_may_have_more_bits_than_one() -> None:
    """Two bits for ready: only 1 is ready; what was seen before does not hide what comes next."""
    text = "ready 0|2+,power_on 2|1+,enabled 3|1+,fault 4|1+,warning 5|1+,limit_active 6|1+,reference_switch 7|1+,brake_open 8|1+,"
    actual = text + "fault_code 12|4+,position_inc 16|32-,torque_permille 48|16-"
    sets = "enable 0|1+,drive_on 1|1+,limit_switch 2|1+,fault_reset 3|1+,brake_open 4|1+,life 8|8+,position_inc 16|32-,speed_rpm 48|16-"
    codec = Codec(compile_dbc(layout(sets, actual)))
    for low, ready in ((1, True), (0, False), (2, False), (3, False), (1, True)):
        axis, value = codec.decode_actual(Frame(610, bytes((low | 0x0C, 0x51, 7, 0, 0, 0, 0xFE, 0xFF))))
        assert (axis, value.ready, value.enabled, value.brake_open, value.fault_code) == (1, ready, True, True, 5)
        assert (value.position_inc, value.torque_permille) == (7, -2)
        assert value.ready is ready
    values = SetValue(enable=True, drive_on=True, life=9, position_inc=-5)
    assert codec.decode_set(codec.encode_set(2, values)) == (2, values)
    with pytest.raises(EncodeError, match=r"life = 256 is outside 0\.\.255"):
        codec.encode_set(2, values._replace(life=256))
