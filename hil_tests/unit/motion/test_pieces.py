"""Pieces and their record: round trip, and everything malformed is refused."""

import math
import struct

import pytest

from motion.errors import PieceError
from motion.pieces import MAX_AXES, MAX_SEGMENTS, MAX_TABLE, RECORD_SIZE, Piece, Segment, axes_of, decode, encode

LINE = Segment(2.0, ((1.0, 0.5), (0.0, -1.0)))
PIECE = Piece(7, 0b101, 2.0, (LINE,), (4.0, 1.0, 4.0), 3.0, 9.0)


def full() -> Piece:
    """Everything at its largest."""
    row = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    segments = [Segment(1.0, (row,) * MAX_AXES)]
    for n in range(1, MAX_SEGMENTS):
        before = segments[-1]
        rows = tuple((q, dq, 0.25) for q, dq in zip(before.position(1.0), before.slope(1.0), strict=True))
        segments.append(Segment(n + 1.0, rows))
    table = tuple(1.0 + n for n in range(MAX_TABLE))
    return Piece(2**32 - 1, 2**MAX_AXES - 1, float(MAX_SEGMENTS), tuple(segments), table, 1e-3, 1e9, ends_at_rest=False)


@pytest.mark.parametrize("piece", [PIECE, full()], ids=["line", "full"])
def test_round_trip(piece: Piece) -> None:
    record = encode(piece)
    assert len(record) == RECORD_SIZE
    assert decode(record) == piece


def test_position_and_slope_follow_the_polynomials() -> None:
    assert PIECE.axes == (0, 2)
    assert PIECE.start() == (1.0, 0.0)
    assert PIECE.end() == (2.0, -2.0)
    assert PIECE.slope(0.3) == (0.5, -1.0)
    piece = full()
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
    return record[:16] + struct.pack("<I", zlib.crc32(record[20:], zlib.crc32(record[:16]))) + record[20:]


@pytest.mark.parametrize(
    ("at", "value"),
    [
        (6, b"\x02\x00"),  # unknown flag
        (8, bytes(4)),  # id 0
        (12, b"\x00\x00"),  # no axis
        (12, b"\x05\x10"),  # axis 12
        (14, b"\x00"),  # no segment
        (14, b"\x09"),
        (15, b"\x01"),  # one table point
        (15, b"\xff"),
        (20, struct.pack("<d", math.nan)),  # length
        (28, struct.pack("<d", 0.0)),  # sddot limit
        (36, struct.pack("<d", -1.0)),  # s jerk limit
        (44, struct.pack("<d", 1.5)),  # the segment ends before the piece
        (52, struct.pack("<d", math.inf)),  # a coefficient
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
