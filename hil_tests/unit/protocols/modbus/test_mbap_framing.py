"""TCP guide, section 3.1.3: the MBAP header, and what our decisions AX-071 and AX-072 add."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_tests.unit.protocols.modbus.wire import frame
from protocols.base.machine import Damage, ms
from protocols.modbus.mbap import Closing, Event, Foreign, Framing, Request, Why

READ = "03 00 00 00 0A"
PDU = bytes.fromhex(READ)


def bytewise(framing: Framing, data: bytes) -> list[Event]:
    return [event for byte in data for event in framing.receive(bytes((byte,)), 0)]


def test_a_whole_frame_is_one_request() -> None:
    assert Framing().receive(frame(READ, transaction=0x1234, unit=17), 0) == [Request(0x1234, 17, PDU)]


def test_one_byte_per_segment_is_the_same_request_at_the_last_byte() -> None:
    framing, data = Framing(), frame(READ)
    assert bytewise(framing, data[:-1]) == []
    assert framing.receive(data[-1:], 0) == [Request(1, 1, PDU)]


def test_ten_requests_in_one_segment_are_ten_requests_in_order() -> None:
    data = b"".join(frame(READ, transaction=n) for n in range(10))
    assert Framing().receive(data, 0) == [Request(n, 1, PDU) for n in range(10)]


def test_a_segment_may_end_anywhere_in_a_pipeline() -> None:
    data = b"".join(frame(READ, transaction=n) for n in range(3))
    for cut in range(len(data) + 1):
        framing = Framing()
        assert framing.receive(data[:cut], 0) + framing.receive(data[cut:], 0) == [Request(n, 1, PDU) for n in range(3)]


@pytest.mark.parametrize("protocol", [1, 0x0100, 0xFFFF])
def test_another_protocol_identifier_is_skipped_by_its_length(protocol: int) -> None:
    data = frame("03 00 00 00 0A FF FF", protocol=protocol) + frame(READ, transaction=2)
    assert Framing().receive(data, 0) == [Foreign(protocol, 8), Request(2, 1, PDU)]
    assert bytewise(Framing(), data) == [Foreign(protocol, 8), Request(2, 1, PDU)]


@pytest.mark.parametrize("length", [0, 1, 255, 256, 0xFFFF])
@pytest.mark.parametrize("protocol", [0, 7])
def test_a_length_that_cannot_be_closes_as_soon_as_it_is_there(length: int, protocol: int) -> None:
    framing, data = Framing(), frame(READ, length=length, protocol=protocol)
    assert framing.receive(data[:5], 0) == []
    assert framing.receive(data[5:6], 0) == [Closing(Why.LENGTH, data[:6])]
    assert framing.deadline() is None
    assert framing.receive(frame(READ), 0) == [], "after the end of a stream nothing in it has a meaning"


def test_requests_before_a_wrong_length_are_still_reported() -> None:
    data = frame(READ) + frame(READ, length=0)
    assert [type(event) for event in Framing().receive(data, 0)] == [Request, Closing]


@pytest.mark.parametrize("size", [1, 253])
def test_the_shortest_and_the_longest_pdu(size: int) -> None:
    body = bytes(range(size))
    assert Framing().receive(frame(body.hex()), 0) == [Request(1, 1, body)]


def test_a_half_frame_is_given_up_2_s_after_its_first_byte() -> None:
    framing = Framing()
    assert framing.deadline() is None
    framing.receive(frame(READ)[:8], ms(5))
    assert framing.deadline() == ms(2005)
    assert framing.wake(ms(2005) - 1) == []
    assert framing.wake(ms(2005)) == [Closing(Why.HALF_FRAME, frame(READ)[:8])]
    assert framing.deadline() is None and framing.wake(ms(9000)) == []


def test_a_trickle_does_not_move_the_deadline_and_late_bytes_come_too_late() -> None:
    framing, data = Framing(ms(100)), frame(READ)
    for n in range(10):
        assert framing.receive(data[n : n + 1], ms(10 * n)) == []
        assert framing.deadline() == ms(100)
    assert framing.receive(data[10:], ms(100)) == [Closing(Why.HALF_FRAME, data[:10])]


def test_the_next_frame_has_its_own_deadline() -> None:
    framing, data = Framing(ms(100)), frame(READ)
    framing.receive(data[:4], 0)
    assert framing.receive(data[4:] + data[:3], ms(90)) == [Request(1, 1, PDU)]
    assert framing.deadline() == ms(190)
    assert framing.receive(data[3:], ms(189)) == [Request(1, 1, PDU)]
    assert framing.deadline() is None


def test_while_the_caller_does_not_read_no_frame_is_late() -> None:
    framing, data = Framing(ms(100)), frame(READ)
    framing.reading_again(0)
    assert framing.deadline() is None
    framing.receive(data[:4], 0)
    framing.reading_again(ms(500))
    assert framing.deadline() == ms(600)
    assert framing.receive(data[4:], ms(599)) == [Request(1, 1, PDU)]


def test_answers_carry_transaction_and_unit_of_their_requests_in_order_and_leave_once() -> None:
    framing = Framing()
    framing.reply(Request(0xABCD, 255, PDU), b"\x03\x02\x00\x05")
    framing.reply(Request(2, 1, PDU), b"\x83\x02")
    assert framing.take_output() == bytes.fromhex("AB CD 00 00 00 05 FF 03 02 00 05  00 02 00 00 00 03 01 83 02")
    assert framing.take_output() == b""


def test_the_end_of_the_connection_inside_a_frame_is_reported_and_between_frames_is_not() -> None:
    framing = Framing()
    assert framing.lost(0) == []
    framing.receive(b"\x00\x01", 0)
    framing.reply(Request(1, 1, PDU), b"\x83\x02")
    assert framing.lost(0) == [Closing(Why.LOST, b"\x00\x01")]
    assert framing.take_output() == b"" and framing.deadline() is None and framing.lost(0) == []


def test_a_stream_knows_neither_damage_nor_a_drained_line() -> None:
    framing = Framing()
    assert framing.damaged(Damage.PARITY, 0) == [] and framing.sent(0) == []


@given(st.lists(st.binary(max_size=300), max_size=12))
def test_any_bytes_in_any_segments_mean_the_same_and_hold_at_most_one_frame(segments: list[bytes]) -> None:
    whole = Framing().receive(b"".join(segments), 0)
    framing = Framing()
    parts = [event for segment in segments for event in framing.receive(segment, 0)]
    assert parts == whole
    assert all(len(event.half) < 260 for event in framing.lost(0) if isinstance(event, Closing))


@given(st.lists(st.tuples(st.integers(0, 0xFFFF), st.integers(0, 255), st.binary(min_size=1, max_size=253)), max_size=8))
def test_requests_come_out_as_they_went_in_wherever_the_segments_end(requests: list[tuple[int, int, bytes]]) -> None:
    data = b"".join(frame(pdu.hex(), transaction, unit) for transaction, unit, pdu in requests)
    expected = [Request(*request) for request in requests]
    assert Framing().receive(data, 0) == expected
    assert bytewise(Framing(), data) == expected
