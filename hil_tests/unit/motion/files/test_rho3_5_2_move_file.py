"""rho 3 Releases part 2 (TO05), sections 5.2 and 5.3 (L7078-7212): MOVE_FILE, its checks, modulo and playback."""

import math
import struct
from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motion.errors import LimitError, MotionError
from motion.files import bnr
from motion.files.bnr import Header
from motion.files.errors import MoveFileError
from motion.files.move_file import Control, MoveFiles, Playback
from motion.geometry.limits import AxisLimits
from motion.kinematics.endless import AxisType

DEG = math.pi / 180
LIMITS = (
    AxisLimits("A1", -400 * DEG, 400 * DEG, 2000 * DEG, 1.0, 1.0, "deg"),
    AxisLimits("A2", -0.5, 0.5, 5.0, 1.0, 1.0, "mm"),
)
CONTROL = Control(LIMITS, period_us=4000, divider=10, types=(AxisType.ENDLESS_MAIN, AxisType.MAIN), modulo=(360.0, 0.0))
HEADER = Header(base=2, time_base_us=400, axes=2)
ROWS = tuple((0.25 * k, 0.125 * math.sin(k / 10)) for k in range(1, 1441))  # one turn in 0.576 s; 360.0 at the end
FLAG = (0.0, 0.0)
FILE = bnr.encode(HEADER, ROWS)


def opened(data: bytes = FILE, offset: int = 80, control: Control = CONTROL) -> MoveFiles:
    files = MoveFiles(control)
    files.read_begin("CURVE", data, offset)
    return files


def code(data: bytes = FILE, offset: int = 80, base: int = 2, flag: Sequence[float | None] = FLAG, control: Control = CONTROL) -> int:
    """Number of the error; 0: it may run."""
    try:
        opened(data, offset, control).move_file("CURVE", base, flag, (0.0, 0.0))
    except MoveFileError as error:
        return error.code
    return 0


def changed(**fields: int) -> bytes:
    """The file with other numbers in its header: offset of each field by the table of 5.1.1."""
    places = {"length": 0, "base": 4, "time": 8, "axes": 12, "version": 16, "off": 20}
    data = bytearray(FILE)
    for name, value in fields.items():
        struct.pack_into("<i", data, places[name], value)
    return bytes(data)


def played(run: Playback) -> list[tuple[float, ...]]:
    found: list[tuple[float, ...]] = []
    while not run.ended:
        assert len(found) <= len(ROWS), "it never ends"
        found.append(run.step())
    return found


@pytest.mark.requirement("RHO-MOT-39", by="motion.files.move_file:MoveFiles._rows")
def test_data_begin_at_offset_80() -> None:
    run = opened().move_file("CURVE", 2, FLAG, (0.0, 0.0))
    assert run.step() == (struct.unpack_from("<f", FILE, 80)[0] * DEG, struct.unpack_from("<f", FILE, 84)[0] * 1e-3)


@pytest.mark.requirement("RHO-MOT-40", by="motion.files.move_file:MoveFiles._header")
@pytest.mark.requirement("RHO-MOT-40", by="motion.files.move_file:MoveFiles._rows")
@pytest.mark.requirement("RHO-MOT-40", by="motion.files.move_file:MoveFiles.move_file")
def test_the_errors_by_their_numbers() -> None:
    assert code() == 0
    assert code(changed(version=501)) == 95
    assert code(changed(axes=3)) == 96
    assert [code(offset=offset) for offset in (0, 40, 79)] == [97, 97, 97]
    assert code(changed(length=96), offset=88) == 97, "the header the file says it has"
    assert [code(FILE[:-1]), code(FILE + b"\0"), code(offset=84), code(offset=len(FILE))] == [100, 100, 100, 100]
    assert code(FILE + bytes(4), offset=84) == 100, "whole points from the marker on, but between the points of the file"
    assert code(offset=88) == 0, "header + N x 4 x axes"
    files = MoveFiles(CONTROL)
    for close in (False, True):
        if close:
            files.read_begin("CURVE", FILE, 80)
            files.close("CURVE")
        with pytest.raises(MoveFileError, match="READ_BEGIN expected") as caught:
            files.move_file("CURVE", 2, FLAG, (0.0, 0.0))
        assert caught.value.code == 63


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
@pytest.mark.parametrize("point", [0, 700, len(ROWS) - 1])
def test_numbers_that_are_none_are_error_38_wherever_they_are(point: int, value: float) -> None:
    data = bytearray(FILE)
    struct.pack_into("<f", data, 80 + point * 8 + 4, value)
    assert code(bytes(data)) == 38


@pytest.mark.requirement("RHO-MOT-41", by="motion.files.move_file:MoveFiles._header")
@pytest.mark.requirement("RHO-MOT-41", by="motion.files.move_file:Control.cycle_us")
def test_base_check_off_1_takes_a_wrong_time_base_0_is_error_98() -> None:
    assert code(changed(time=500, off=0)) == 98
    assert code(changed(time=500, off=1)) == 0
    assert code(changed(time=500, off=2)) == 98, "only the value 1 switches it off"
    assert code(changed(base=1, time=4000), base=2) == 99
    assert code(changed(base=1, time=4000, off=1), base=2) == 0
    assert code(changed(base=1, time=4000), base=1) == 0
    assert code(changed(base=1, time=400), base=1) == 98, "400 us is the position-controller cycle"
    assert [code(changed(base=3), base=2), code(base=3), code(changed(off=1), base=0)] == [99, 99, 99]


@pytest.mark.requirement("RHO-MOT-42", by="motion.files.move_file:MoveFiles._flags")
@pytest.mark.requirement("RHO-MOT-42", by="motion.files.move_file:Playback.end_position")
def test_modulo_flag_1_reduces_by_the_last_value_2_by_p311_and_the_errors_101_and_102() -> None:
    last = ROWS[-1]
    float32 = struct.unpack("<f", struct.pack("<f", last[1]))[0]
    ends = {}
    for flag in (0.0, 1.0, 2.0, 3.0, -1.0):
        run = opened().move_file("CURVE", 2, (flag, 0.0), (0.0, 0.0))
        played(run)
        ends[flag] = run.end_position()
    assert ends[1.0] == (0.0, float32), "360 deg reduced by the file's last value of this axis"
    assert ends[2.0] == (0.0, float32)
    assert ends[0.0] == ends[3.0] == ends[-1.0] == (360.0, float32), "other values count as 0.0"
    short = bnr.encode(HEADER, ROWS[:1000])  # ends at 250 deg
    by_file = opened(short).move_file("CURVE", 2, (1.0, 0.0), (0.0, 0.0))
    by_p311 = opened(short).move_file("CURVE", 2, (2.0, 0.0), (0.0, 0.0))
    assert (by_file.end_position()[0], by_p311.end_position()[0]) == (0.0, 250.0)
    assert code(flag=(0.0, 1.0)) == 102
    assert code(flag=(0.0, 2.0)) == 0, "P311 on an axis that is not endless: nothing to do"
    assert [code(flag=(None, 0.0)), code(flag=(0.0, None)), code(flag=())] == [101, 101, 101]


@pytest.mark.requirement("RHO-MOT-43", by="motion.files.move_file:Playback.step")
def test_set_points_are_sent_unchanged_one_per_cycle() -> None:
    files = opened()
    for _ in range(2):  # as often as wanted between READ_BEGIN and CLOSE
        run = files.move_file("CURVE", 2, FLAG, (0.0, 0.0))
        sent = played(run)
        assert len(sent) == len(ROWS)
        back = b"".join(struct.pack("<2f", q[0] / DEG, q[1] * 1e3) for q in sent)
        assert back == FILE[80:], "byte for byte what stands in the file"
        assert run.step() == sent[-1] and run.ended, "at the end it stands"
    part = opened(offset=80 + 8 * 1400).move_file("CURVE", 2, FLAG, (ROWS[1399][0] * DEG, 0.0))
    assert played(part) == sent[1400:]


def test_positions_and_speeds_the_axes_cannot_have_are_named_before_anything_moves() -> None:
    for rows, axis in (([(0.5, 0.0), (0.5, 501.0)], "A2"), ([(0.5, 0.0), (2.0, 0.0)], "A1"), ([(50.0, 0.0)], "A1")):
        with pytest.raises(LimitError) as caught:
            opened(bnr.encode(HEADER, rows)).move_file("CURVE", 2, FLAG, (0.0, 0.0))
        assert caught.value.axis == axis
    assert MoveFiles(Control(LIMITS, 4000)).control.endless(0) is False


def test_a_file_without_a_whole_header_is_error_100_and_a_negative_offset_none() -> None:
    assert code(FILE[:60], offset=0) == 100
    with pytest.raises(MotionError, match="READ_BEGIN"):
        MoveFiles(CONTROL).read_begin("CURVE", FILE, -1)


@settings(max_examples=150, deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 24), st.binary(min_size=4, max_size=4)), max_size=4),
    st.integers(0, 200),
    st.integers(-1, 4),
    st.lists(st.one_of(st.none(), st.floats()), max_size=3),
    st.integers(0, 120),
)
def test_damaged_files_and_strange_calls_end_in_an_error_with_a_name_or_in_set_points_inside_the_limits(
    words: list[tuple[int, bytes]], offset: int, base: int, flag: list[float | None], length: int
) -> None:
    data = bytearray(FILE[: 80 + 8 * 10])
    for place, word in words:
        data[4 * place : 4 * place + 4] = word
    try:
        run = opened(bytes(data[: max(len(data) - length, 0)]), offset).move_file("CURVE", base, flag, (0.0, 0.0))
    except (MoveFileError, LimitError):
        return
    assert all(math.isfinite(value) for q in played(run) for value in (*q, *run.end_position()))


def test_a_header_shorter_than_its_fields_is_error_100() -> None:
    assert [code(changed(length=length)) for length in (-8, 0, 23)] == [100, 100, 100]
    assert code(changed(length=24), offset=80) == 0, "a short one without the reserve is as good as the file says"
