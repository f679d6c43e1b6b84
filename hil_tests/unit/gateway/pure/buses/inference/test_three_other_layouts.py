"""`axisgate bus infer`: recordings of the emulated boosters in layouts it was never told (AX-271)."""

import functools
import itertools
import struct

import cantools
import pytest

from gateway.files.find import find_config, read_text
from gateway.pure.buses.inference.dbc import as_dbc
from gateway.pure.buses.inference.proposal import NothingFound, propose
from gateway.pure.buses.inference.roles import Inferred
from gateway.pure.buses.inference.series import Piece, Series
from gateway.pure.buses.inference.signals import Numbers, counter, position
from hil_tests.lab.virtual.bus_recording import Recording, layout, record
from protocols.base.dbc import compile_dbc
from protocols.base.layout import Layout, Packer
from protocols.base.machine import Frame

FLAGS_BEHIND = layout(
    "position_inc 0|32-,speed_rpm 32|16-,life 48|8+,enable 60|1+,drive_on 57|1+,limit_switch 56|1+,fault_reset 62|1+,brake_open 63|1+",
    "torque_permille 0|16-,ready 16|1+,fault 17|1+,enabled 18|1+,power_on 19|1+,brake_open 20|1+,reference_switch 21|1+,warning 22|1+,"
    "limit_active 23|1+,position_inc 24|32-,fault_code 56|8+",
)
NARROW = layout(
    "life 0|4+,drive_on 4|1+,enable 5|1+,brake_open 6|1+,limit_switch 7|1+,fault_reset 8|1+,position_inc 12|24-,speed_rpm 40|16-",
    "position_inc 4|24-,power_on 0|1+,ready 1|1+,brake_open 2|1+,enabled 3|1+,torque_permille 32|12-,fault_code 48|8+,"
    "reference_switch 44|1+,fault 45|1+,warning 46|1+,limit_active 47|1+",
)
SPEED_FIRST = layout(
    "speed_rpm 0|16-,position_inc 16|28-,drive_on 46|1+,limit_switch 47|1+,enable 48|1+,fault_reset 49|1+,brake_open 50|1+,life 56|8+",
    "fault_code 0|8+,torque_permille 8|16-,reference_switch 24|1+,limit_active 25|1+,warning 26|1+,ready 27|1+,fault 28|1+,"
    "power_on 29|1+,brake_open 30|1+,enabled 31|1+,position_inc 32|32-",
)
SHIPPED = read_text(find_config("servodyn_gc.dbc", "drives"))
LAYOUTS = {"flags behind": FLAGS_BEHIND, "narrow": NARROW, "speed first": SPEED_FIRST, "AX-001": SHIPPED}
OTHERS = ("flags behind", "narrow", "speed first")
IN_SET = ("position_inc", "speed_rpm", "life", "drive_on", "enable")
IN_ACTUAL = ("position_inc", "torque_permille", "power_on", "enabled", "brake_open", "reference_switch")


@functools.cache
def recorded(name: str) -> Recording:
    return record(LAYOUTS[name])


@functools.cache
def proposed(name: str) -> Inferred:
    return propose(recorded(name).frames)


def read_back(dbc: str, frames: list[Frame]) -> list[int]:
    """Positions as cantools decodes them with the proposal."""
    foreign, out = cantools.database.load_string(dbc, "dbc"), []
    assert isinstance(foreign, cantools.database.can.Database)
    for frame in frames:
        values = foreign.decode_message(frame.identifier, frame.data)
        assert isinstance(values, dict)
        out.append(int(str(values["position_inc"])))
    return out


def truth(name: str, message: str) -> dict[str, tuple[int, int]]:
    (found,) = [each for each in compile_dbc(LAYOUTS[name]).values() if each.name == message]
    return {signal.name: (signal.start, signal.bits) for signal in found.signals}


@pytest.mark.parametrize("name", [*OTHERS, "AX-001"])
def test_every_axis_is_found_with_set_value_and_actual_value(name: str) -> None:
    found = proposed(name)
    assert [(axis.set_id, axis.actual_id) for axis in found.axes] == [(210, 610), (220, 620), (230, 630)]
    assert (found.cycles.sync, found.cycles.period_ns, found.reverse) == (100, 4_000_000, False)
    assert all(axis.confidence > 0.9 for axis in found.axes)


@pytest.mark.parametrize("name", [*OTHERS, "AX-001"])
def test_numbers_and_bits_are_where_they_belong(name: str) -> None:
    found = proposed(name)
    for n, axis in enumerate(found.axes, 1):
        for identifier, message, wanted in ((axis.set_id, f"SET_{n}", IN_SET), (axis.actual_id, f"ACT_{n}", IN_ACTUAL)):
            real = truth(name, message)
            told = {each.name: (each.start, each.bits) for each in found.of(identifier)}
            assert {each: told.get(each) for each in wanted} == {each: real[each] for each in wanted}, message


@pytest.mark.parametrize("name", OTHERS)
def test_confidence_is_high_for_what_the_numbers_prove_and_low_for_what_only_the_order_shows(name: str) -> None:
    found = proposed(name)
    sure = {each.name for each in found.signals if each.confidence >= 0.9}
    doubtful = {each.name for each in found.signals if each.confidence <= 0.7}
    assert {"position_inc", "speed_rpm", "life"} <= sure
    assert {"drive_on", "enable", "power_on", "enabled", "brake_open", "reference_switch"} <= doubtful
    assert all(each.why for each in found.signals)


@pytest.mark.parametrize("name", OTHERS)
def test_the_dbc_reads_back_positions_as_they_were(name: str) -> None:
    """Judged by cantools, and by our own compiler."""
    text = as_dbc(proposed(name), "living.log")
    own, whole = compile_dbc(text), recorded(name)
    seen = [frame for frame in whole.frames if frame.identifier == 620]
    positions = read_back(text, seen)
    assert positions == [actual[1].position_inc for actual in whole.actual]
    packer = Packer(own["ACT_2"], ("position_inc",))
    assert [packer.unpack(frame.data)[0] for frame in seen] == positions
    assert "CM_ SG_ 620 position_inc" in text and "confidence 0.9" in text


def backwards(frames: list[Frame]) -> list[Frame]:
    """The same numbers with their high byte first."""
    return [frame._replace(data=frame.data[::-1]) for frame in frames]


def test_numbers_with_the_high_byte_first_are_recognised_as_such() -> None:
    whole = recorded("flags behind")
    found = propose(backwards(whole.frames))
    assert found.reverse and len(found.axes) == 3
    seen = [frame for frame in backwards(whole.frames) if frame.identifier == 610]
    assert read_back(as_dbc(found, "living.log"), seen) == [each[0].position_inc for each in whole.actual]


def test_other_identifiers_foreign_traffic_and_lost_frames_change_little() -> None:
    whole = recorded("narrow")
    moved = {100: 128, 210: 1001, 220: 777, 230: 333, 610: 500, 620: 12, 630: 1900}
    frames: list[Frame] = []
    for n, frame in enumerate(whole.frames):
        if n % 397:  # one frame in 397 was not recorded
            frames.append(frame._replace(identifier=moved[frame.identifier]))
        if n % 50 == 0:
            frames.append(Frame(1234, struct.pack("<I", n), frame.stamp_ns))
    found = propose(frames)
    assert sorted((axis.set_id, axis.actual_id) for axis in found.axes) == [(333, 1900), (777, 12), (1001, 500)]
    assert {each.start for each in found.signals if each.name == "position_inc"} == {4, 12}


def test_an_axis_that_never_moved_is_not_guessed() -> None:
    still = record(FLAGS_BEHIND, axes=1, seconds=0.8)
    found = propose(still.frames)
    assert found.axes == () and all(each.name in ("life", *(f"number_{n}" for n in range(64))) for each in found.signals)


def test_what_has_no_cycle_reports_nothing() -> None:
    for frames in ([], [Frame(1, b"\0", n) for n in range(50)], [Frame(n % 2000, b"\0", n) for n in range(4000)]):
        with pytest.raises(NothingFound):
            propose(frames)


def test_layouts_of_this_test_are_not_the_shipped_one() -> None:
    shipped: dict[str, Layout] = compile_dbc(LAYOUTS["AX-001"])
    for name in OTHERS:
        assert truth(name, "SET_1")["position_inc"] != (shipped["SET_1"].signals[6].start, 32)


def one_number(values: list[int], bits: int, start: int = 8) -> Numbers:
    """A message of 8 bytes in which one number stands, as `numbers` would hand it on."""
    words = tuple((value & (1 << bits) - 1) << start for value in values)
    flips = tuple(tuple(n for n in range(1, len(words)) if (words[n] ^ words[n - 1]) >> bit & 1) for bit in range(64))
    series = Series(201, 8, words, 0.0, flips)
    signed = min(values) < 0
    return Numbers(series, Piece(start, bits, start + bits, len(flips[start])), series.values(start, bits, signed), signed)


@pytest.mark.parametrize(("bits", "step", "wraps"), [(8, 1, 7), (4, 1, 124), (8, -1, 8), (16, 1, 0), (8, 3, 23)])
def test_the_wraps_of_a_counter_are_counted(bits: int, step: int, wraps: int) -> None:
    values = [step * n % (1 << bits) for n in range(2000)]
    found = counter(one_number(values, bits))
    assert found is not None and found.wraps == wraps == sum((b - a) * step < 0 for a, b in itertools.pairwise(values))
    assert found.why.startswith(f"{step:+} in 100.0 %") and (f", {wraps} wraps" in found.why) == bool(wraps)


def test_a_counter_that_began_anew_did_not_wrap_there() -> None:
    values = [n % 256 for n in (*range(1000), *range(100))]
    found = counter(one_number(values, 8))
    assert found is not None and found.wraps == 3, "1000 counts: 3 wraps; the power cycle at 231 is none"


def test_a_position_goes_on_over_the_end_of_its_counter() -> None:
    """A ram that goes 200,000 counts up in a 16-bit number, and slows down at the end."""
    way = [round(40 * n - max(0, n - 4500) ** 2 * 0.04) for n in range(5000)]
    folded = [(value + 32768) % 65536 - 32768 for value in way]
    found = position(one_number(folded, 16))
    assert found is not None and found.wraps == 3 and "3 wraps" in found.why
    assert f"way {max(way) - min(way)}," in found.why and found.confidence > 0.9
