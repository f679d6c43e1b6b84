"""Pieces and their record: round trip, and everything malformed is refused."""

import math
import struct

import pytest

from motion.errors import PieceError
from motion.execution.pieces import MAX_SEGMENTS, MAX_TABLE, RECORD_SIZE, Piece, Segment, axes_of, decode, encode, record_size

LINE = Segment(2.0, ((1.0, 0.5), (0.0, -1.0)))
PIECE = Piece(7, 0b101, 2.0, (LINE,), (4.0, 1.0, 4.0), 3.0, 9.0)


def full(mask: int) -> Piece:
    """Everything but the axes at its largest."""
    row = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    segments = [Segment(1.0, (row,) * mask.bit_count())]
    for n in range(1, MAX_SEGMENTS):
        before = segments[-1]
        rows = tuple((q, dq, 0.25) for q, dq in zip(before.position(1.0), before.slope(1.0), strict=True))
        segments.append(Segment(n + 1.0, rows))
    table = tuple(1.0 + n for n in range(MAX_TABLE))
    return Piece(2**32 - 1, mask, float(MAX_SEGMENTS), tuple(segments), table, 1e-3, 1e9, ends_at_rest=False)


@pytest.mark.parametrize("piece", [PIECE, full(2**12 - 1), full(0xFFF << 20)], ids=["line", "twelve", "the last twelve of 32"])
def test_round_trip(piece: Piece) -> None:
    record = encode(piece)
    assert len(record) == RECORD_SIZE
    assert decode(record) == piece


@pytest.mark.parametrize("axes", [13, 16, 17, 31, 32])
def test_a_record_of_more_axes_is_as_long_as_they_need(axes: int) -> None:
    piece = full(2**axes - 1)
    record = encode(piece)
    assert len(record) == record_size(axes) == RECORD_SIZE + (axes - 12) * 8 * 6 * MAX_SEGMENTS
    assert decode(record) == piece
    for cut in (record[:RECORD_SIZE], record + bytes(8)):
        with pytest.raises(PieceError, match=f"{len(record)} bytes expected"):
            decode(cut)


def test_no_piece_has_an_axis_behind_the_32nd() -> None:
    with pytest.raises(PieceError, match="mask 0x100000000 is outside"):
        full(1 << 32)


def test_position_and_slope_follow_the_polynomials() -> None:
    assert PIECE.axes == (0, 2)
    assert PIECE.start() == (1.0, 0.0)
    assert PIECE.end() == (2.0, -2.0)
    assert PIECE.slope(0.3) == (0.5, -1.0)
    piece = full(2**12 - 1)
    for s in (0.5, 1.0, 1.5, 3.0, 3.999):
        ahead, behind = piece.position(s + 1e-6), piece.position(s - 1e-6)
        assert piece.slope(s) == pytest.approx([(a - b) / 2e-6 for a, b in zip(ahead, behind, strict=True)], rel=1e-4)


def test_masks() -> None:
    assert axes_of(0b1000_0000_0001) == (0, 11)


def broken(at: int, value: bytes) -> bytes:
    record = bytearray(encode(PIECE))
    record[at : at + len(value)] = value
    return bytes(record)


@pytest.mark.parametrize(
    ("record", "why"),
    [
        (encode(PIECE)[:-1], "expected"),
        (encode(PIECE) + b"\0", "expected"),
        (b"", "expected"),
        (bytes(RECORD_SIZE), "starts with"),
        (broken(0, b"AXPD"), "starts with"),
        (broken(4, b"\x02\x00"), "version"),
        (broken(8, b"\x08"), "check sum"),
        (broken(200, b"\x01"), "check sum"),
        (broken(RECORD_SIZE - 1, b"\x01"), "check sum"),
    ],
)
def test_malformed_records_are_refused(record: bytes, why: str) -> None:
    with pytest.raises(PieceError, match=why):
        decode(record)


def resummed(at: int, value: bytes) -> bytes:
    """A record with a right check sum and a wrong content: a writer of another version, not a broken one."""
    import zlib

    record = broken(at, value)
    return record[:20] + struct.pack("<I", zlib.crc32(record[24:], zlib.crc32(record[:20]))) + record[24:]


@pytest.mark.parametrize(
    ("at", "value"),
    [
        (6, b"\x02\x00"),  # unknown flag
        (8, bytes(4)),  # id 0
        (12, b"\x00\x00"),  # no axis
        (12, b"\xff\x1f"),  # thirteen axes in a record of twelve
        (16, b"\x00"),  # no segment
        (16, b"\x09"),
        (17, b"\x01"),  # one table point
        (17, b"\xff"),
        (18, b"\x01"),  # spare
        (24, struct.pack("<d", math.nan)),  # length
        (32, struct.pack("<d", 0.0)),  # sddot limit
        (40, struct.pack("<d", -1.0)),  # s jerk limit
        (48, struct.pack("<d", 1.5)),  # the segment ends before the piece
        (56, struct.pack("<d", math.inf)),  # a coefficient
    ],
)
def test_illegal_contents_are_refused(at: int, value: bytes) -> None:
    with pytest.raises(PieceError):
        decode(resummed(at, value))


def test_a_jump_or_a_corner_between_segments_is_refused() -> None:
    first = Segment(1.0, ((0.0, 1.0),))
    for second, why in ((Segment(2.0, ((1.1, 1.0),)), "jumps"), (Segment(2.0, ((1.0, 0.9),)), "corner")):
        with pytest.raises(PieceError, match=why):
            Piece(1, 1, 2.0, (first, second), (1.0, 1.0), 1.0, 1.0)


def test_segments_must_rise_and_fit_the_mask() -> None:
    one = Segment(1.0, ((0.0, 1.0),))
    with pytest.raises(PieceError, match="not after"):
        Piece(1, 1, 1.0, (one, one), (1.0, 1.0), 1.0, 1.0)
    with pytest.raises(PieceError, match="1 polynomials for 2 axes"):
        Piece(1, 3, 1.0, (one,), (1.0, 1.0), 1.0, 1.0)
    with pytest.raises(PieceError, match="table"):
        Piece(1, 1, 1.0, (one,), (1.0, 0.0), 1.0, 1.0)
