"""VAL 3 sio: whatever comes, however it is cut, is read once and in order; strings do not depend on the pieces they came in."""

from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from gateway.pure.controllers.val3.sio.text import MAX_STRING, TextScan, encode_text
from hil_tests.lab.virtual.val3_sio import WAITS, SioBench

SERIAL = Channel("Serial\\1", Kind.SERIAL, device="/dev/ttyS0", timeout_s=-1)
PIECES = st.lists(st.binary(max_size=40), max_size=12)
TEXTS = st.text(max_size=MAX_STRING).filter(lambda text: len(text.encode()) < MAX_STRING and "\r" not in text)
JUNK = st.lists(
    st.sampled_from([b"a", b"\xc3", b"\xa4", b"\xe2", b"\x82", b"\xac", b"\xf0", b"\xff", b"\xed", b"\xa0", "ä€😀".encode()]), max_size=80
)


@given(PIECES, st.lists(st.integers(1, 50), min_size=1, max_size=8))
def test_sio_get_gives_every_byte_once_and_in_order(pieces: list[bytes], sizes: list[int]) -> None:
    bench = SioBench(SERIAL)
    sio, heard = bench.variable(SERIAL.name), bytearray()
    for turn, piece in enumerate([*pieces, *[b""] * 480]):
        bench.hears(1, piece)
        data = [0.0] * sizes[turn % len(sizes)]
        count = bench.outcome(bench.get(sio, data))
        assert isinstance(count, int) and count >= 0
        heard += bytes(int(value) for value in data[:count])
    assert heard == b"".join(pieces)


@given(st.lists(TEXTS, max_size=6), st.integers(1, 7))
def test_strings_that_are_written_are_read_again(texts: list[str], step: int) -> None:
    stream = b"".join(encode_text(text, 13) for text in texts)
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    bench.control(sio, "timeout", 0)
    calls = [bench.read_text(sio) for _ in texts]
    for at in range(0, len(stream), step):
        bench.hears(1, stream[at : at + step])
    assert [bench.outcome(call) for call in calls] == texts
    assert bench.outcome(bench.read_num(sio)) == WAITS


@given(JUNK, st.sampled_from([0, 13, 0x82, 0xA4, 0xE2, 0xFF]), st.integers(1, 5))
def test_a_string_is_the_same_whole_and_in_pieces_and_never_too_long(junk: list[bytes], end: int, step: int) -> None:
    stream = b"".join(junk) + bytes((end,))
    whole, pieces, buffer = TextScan(end), TextScan(end), bytearray()
    assert whole.run(bytearray(stream))
    for at in range(0, len(stream), step):
        buffer += stream[at : at + step]
        pieces.run(buffer)
    assert (pieces.text, pieces.used, pieces.done) == (whole.text, whole.used, True)
    assert len(whole.text) <= MAX_STRING and whole.text.decode().encode() == whole.text
    before_end = stream[: whole.used].removesuffix(bytes((end,))) if end < 128 else b""
    assert end >= 128 or whole.text.decode() == before_end.decode(errors="ignore")[: len(whole.text.decode())]
