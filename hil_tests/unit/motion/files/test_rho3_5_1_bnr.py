"""rho 3 Releases part 2 (TO05), section 5.1 (L6956-7076): the bytes of a BNR file."""

import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motion.files import bnr
from motion.files.bnr import BnrError, Header

# Picture 2 of the manual, byte by byte, low byte first: 80, base 2, 400 us, 1 axis, version 500, check on, 14 reserves.
PICTURE = bytes.fromhex("50000000 02000000 90010000 01000000 f4010000 00000000") + bytes(56)
VALUES = (0.0288, 0.0864, 0.1728, 0.2880, 0.4320, 0.6048, 359.712, 359.827, 359.914, 359.971, 360.0)
DATA = b"".join(struct.pack("<f", value) for value in VALUES)


@pytest.mark.requirement("RHO-MOT-39", by="motion.files.bnr:encode")
@pytest.mark.requirement("RHO-MOT-39", by="motion.files.bnr:decode_header")
@pytest.mark.requirement("RHO-MOT-39", by="motion.files.bnr:points")
def test_the_file_of_picture_2_byte_for_byte_in_both_directions() -> None:
    header = Header(base=2, time_base_us=400, axes=1, version=500)
    file = bnr.encode(header, [(value,) for value in VALUES])
    assert file[:80] == PICTURE and file[80:] == DATA
    assert bnr.decode_header(PICTURE + DATA) == header
    found = bnr.points(PICTURE + DATA, 1, 80)
    assert [point[0] for point in found] == [struct.unpack("<f", struct.pack("<f", value))[0] for value in VALUES]
    assert found[-1] == (360.0,)
    for axes, offset in ((1, len(PICTURE + DATA) + 4), (1, -4)):
        with pytest.raises(bnr.BnrError, match="not a whole number of points"):
            bnr.points(PICTURE + DATA, axes, offset)


def test_axes_of_a_point_stand_side_by_side_cycle_by_cycle() -> None:
    file = bnr.encode(Header(axes=3), [(1.0, 2.0, 3.0), (4.0, 5.0, 6.0)])
    assert struct.unpack("<6f", file[80:]) == (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert bnr.points(file, 3, 80) == ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))
    assert bnr.points(file, 3, 92) == ((4.0, 5.0, 6.0),)


def test_longer_headers_and_users_data_in_the_reserve() -> None:
    header = Header(length=96, reserve=tuple(range(-7, 7)))
    file = bnr.encode(header, [(1.5,)])
    assert len(file) == 100 and file[80:96] == bytes(16)
    assert bnr.decode_header(file) == header


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.tuples(*[st.floats(width=32, allow_nan=False)] * 2), max_size=20),
    st.lists(st.integers(-(2**31), 2**31 - 1), min_size=14, max_size=14),
)
def test_every_file_comes_back_as_it_was_written(rows: list[tuple[float, float]], reserve: list[int]) -> None:
    header = Header(base=1, time_base_us=4000, axes=2, reserve=tuple(reserve))
    file = bnr.encode(header, rows)
    assert bnr.decode_header(file) == header and list(bnr.points(file, 2, 80)) == rows
    assert bnr.encode(bnr.decode_header(file), bnr.points(file, 2, 80)) == file


@pytest.mark.parametrize(
    ("header", "rows"),
    [
        (Header(length=76), []),
        (Header(reserve=(0,)), []),
        (Header(axes=2), [(1.0,)]),
        (Header(), [(1e300,)]),
        (Header(time_base_us=2**31), []),
    ],
)
def test_what_does_not_fit_is_refused(header: Header, rows: list[tuple[float, ...]]) -> None:
    with pytest.raises(BnrError):
        bnr.encode(header, rows)


def test_bytes_that_are_no_file_are_refused() -> None:
    with pytest.raises(BnrError, match="79 bytes"):
        bnr.decode_header(bytes(79))
    for offset, axes in ((81, 1), (85, 1), (-4, 1), (80, 0)):
        with pytest.raises(BnrError, match="not a whole number of points"):
            bnr.points(bytes(84), axes, offset)
