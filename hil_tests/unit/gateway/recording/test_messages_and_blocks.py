"""The format of a recording: messages, their way through a ring, blocks with sums, tails that were cut, bytes that were spoiled."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.recording.blocks import HEAD, MAGIC, Kind, Scan, decode, encode, whole_length
from gateway.pure.recording.messages import (
    Assembly,
    Message,
    Source,
    What,
    chunks,
    pack,
    pack_frames,
    pack_service_event,
    pack_shown,
    unpack,
    unpack_frames,
    unpack_service_event,
    unpack_shown,
)
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame

FRAMES = [Frame(0x100, b"", 5), Frame(0x262, b"\x01\x02\x03", 6), Frame(0x7FF, bytes(8), 2**62)]


def test_frames_come_back_with_stamps_and_lengths() -> None:
    assert unpack_frames(pack_frames(2, 1, FRAMES)) == (2, 1, FRAMES)
    with pytest.raises(DecodeError):
        unpack_frames(pack_frames(2, 1, FRAMES)[:-19])


def test_contacts_and_words_come_back() -> None:
    assert unpack_shown(pack_shown(1, [(0, True), (300, False)])) == (1, {0: True, 300: False})
    records = pack_service_event(7, Source.SAID, 3, bytes(range(256)) * 4)
    assert len(records) == 3 and b"".join(unpack_service_event(record).data for record in records) == bytes(range(256)) * 4


def test_a_message_that_is_cut_or_unknown_is_refused() -> None:
    good = pack(What.BEGIN, b"abc")
    assert list(unpack(good)) == [Message(What.BEGIN, b"abc")]
    for bad in (good[:-1], good[:3], b"\x63" + good[1:]):
        with pytest.raises(DecodeError):
            list(unpack(bad))


@given(st.lists(st.binary(max_size=3000), min_size=1, max_size=6), st.integers(0, 40))
def test_cycles_come_whole_out_of_the_ring_and_a_lost_record_costs_its_cycle_alone(cycles: list[bytes], lost: int) -> None:
    records = [(number, record) for number, octets in enumerate(cycles) for record in chunks(number, octets)]
    hit = records.pop(lost % len(records))[0]
    assembly = Assembly()
    found = dict(whole for _, record in records if (whole := assembly.take(record)) is not None)
    assert found == {number: octets for number, octets in enumerate(cycles) if number != hit}


BLOCKS = [(Kind.HEAD, b"{}"), (Kind.CYCLES, b"x" * 300), (Kind.CYCLES, b"AXB1 a mark inside"), (Kind.END, b"")]
FILE = MAGIC + b"".join(encode(*block) for block in BLOCKS)
ENDS = [len(MAGIC)]
for each in BLOCKS:
    ENDS.append(ENDS[-1] + HEAD.size + len(each[1]))


def blocks(octets: bytes) -> tuple[list[tuple[Kind, bytes]], Scan]:
    scan = Scan()
    return [(kind, payload) for _, kind, payload in decode(octets, scan)], scan


def test_a_whole_file() -> None:
    found, scan = blocks(FILE)
    assert found == BLOCKS and not scan.spoiled and not scan.cut and whole_length(FILE) == len(FILE)


def test_a_tail_that_was_cut_anywhere_costs_its_block_alone() -> None:
    for length in range(len(MAGIC), len(FILE)):
        whole = sum(end <= length for end in ENDS) - 1
        found, scan = blocks(FILE[:length])
        assert found == BLOCKS[:whole] and not scan.spoiled, length
        assert (scan.cut, whole_length(FILE[:length])) == (length - ENDS[whole], ENDS[whole])


def test_a_spoiled_byte_anywhere_costs_its_block_alone_and_is_found() -> None:
    for at in range(len(MAGIC), len(FILE)):
        octets = bytearray(FILE)
        octets[at] ^= 0x20
        hit = next(number for number, end in enumerate(ENDS[1:]) if at < end)
        found, scan = blocks(bytes(octets))
        assert found == BLOCKS[:hit] + BLOCKS[hit + 1 :], f"byte {at}"
        assert scan.spoiled == [ENDS[hit]] or scan.cut
