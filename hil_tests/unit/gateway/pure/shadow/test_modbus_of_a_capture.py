"""Modbus TCP out of a capture: packets of every link, segments in any order, requests paired with answers (AX-512).

Packets by hand: RFC 791 (IPv4), RFC 8200 (IPv6), RFC 9293 (TCP); bytes of Modbus: V1.1b3 6.1, 6.4 and the TCP guide 3.1.3.
"""

import struct

import pytest

from gateway.pure.shadow.compare import Answer, Comparison, as_data
from gateway.pure.shadow.modbus_addresses import Number, read_name, read_places
from gateway.pure.shadow.modbus_talk import Answered, Asked, ModbusTalk
from gateway.pure.shadow.packets import COOKED, COOKED2, Capture, Packet, segment_of
from hil_tests.lab.partners.captured import HEAD, LOOPBACK, record, segment
from protocols.base.errors import DecodeError
from protocols.base.machine import Ns, ms

PLC, CONTROL = (LOOPBACK, 50123), (LOOPBACK, 502)
READ = bytes.fromhex("0007 0000 0006 01 04 03e8 0002")  # transaction 7, unit 1: input registers 1000, 1001
TOLD = bytes.fromhex("0007 0000 0007 01 04 04 0102 0304")
REFUSED = bytes.fromhex("0007 0000 0003 01 84 02")


def packets(capture: bytes, *, piece: int = 1 << 20) -> list[Packet]:
    reader = Capture()
    return [packet for at in range(0, len(capture), piece) for packet in reader.feed(capture[at : at + piece])]


def asks(data: bytes, at: int = 1000) -> Packet:
    return Packet(5, 1, segment(PLC, CONTROL, at, data))


def tells(data: bytes, at: int = 9000) -> Packet:
    return Packet(9, 1, segment(CONTROL, PLC, at, data))


def talked(*all_: Packet) -> list[Asked | Answered]:
    talk = ModbusTalk(CONTROL)
    return [exchange for packet in all_ for exchange in talk.take(packet, 100)]


@pytest.mark.parametrize("piece", [1, 7, 1000])
def test_a_capture_in_pieces_of_any_size_gives_its_packets_with_their_stamps(piece: int) -> None:
    stream = HEAD + record(b"first", 1_000_000_007) + record(b"second", 2_000_000_000)
    assert packets(stream, piece=piece) == [Packet(1_000_000_007, 1, b"first"), Packet(2_000_000_000, 1, b"second")]


def test_microseconds_and_the_other_byte_order_are_read_too() -> None:
    stream = struct.pack(">IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 101) + struct.pack(">IIII", 3, 500_000, 2, 2) + b"ip"
    assert packets(stream) == [Packet(3_500_000_000, 101, b"ip")]


def test_a_packet_the_capture_cut_is_left_out_and_what_is_no_capture_is_reported() -> None:
    assert packets(HEAD + struct.pack("<IIII", 1, 0, 2, 60) + b"ip" + record(b"whole", 0)) == [Packet(0, 1, b"whole")]
    with pytest.raises(DecodeError, match=r"begins with 0a 0d 0d 0a: no pcap; tcpdump -w - writes one, dumpcap with -P"):
        packets(bytes.fromhex("0a0d0d0a") + bytes(24))


@pytest.mark.parametrize(
    ("link", "front"),
    [(1, bytes(12) + b"\x08\x00"), (1, bytes(12) + b"\x81\x00\x00\x05\x08\x00"), (101, b""), (COOKED, bytes(16)), (COOKED2, bytes(20))],
)
def test_tcp_is_found_behind_every_link(link: int, front: bytes) -> None:
    found = segment_of(Packet(0, link, front + segment(PLC, CONTROL, 77, b"data")[14:]))
    assert found is not None and (found.source, found.target, found.sequence, found.data) == (PLC, CONTROL, 77, b"data")


def test_padding_behind_the_packet_is_no_data_and_other_protocols_are_none() -> None:
    short = segment(PLC, CONTROL, 77, b"")
    found = segment_of(Packet(0, 1, short + bytes(6)))
    assert found is not None and found.data == b""
    udp = bytearray(short)
    udp[14 + 9] = 17
    assert segment_of(Packet(0, 1, bytes(udp))) is None and segment_of(Packet(0, 1, short[:20])) is None


def test_ipv6_is_read() -> None:
    tcp = segment(PLC, CONTROL, 5, b"six")[34:]
    six = b"\x60\0\0\0" + struct.pack(">HBB", len(tcp), 6, 64) + bytes(15) + b"\x01" + bytes(15) + b"\x02" + tcp
    found = segment_of(Packet(0, 101, six))
    assert found is not None and found.source == (bytes(15) + b"\x01", 50123) and found.data == b"six"


def test_a_request_and_its_answer_are_a_pair_with_both_moments() -> None:
    asked, answered = talked(asks(READ), tells(TOLD))
    assert isinstance(asked, Asked) and asked.request.pdu == READ[7:] and asked.stamp == 105
    assert isinstance(answered, Answered) and answered.pdu == TOLD[7:] and (answered.asked, answered.stamp) == (105, 109)
    assert answered.request == asked.request and asked.client == PLC


def test_an_answer_nobody_asked_for_and_other_servers_are_left_out() -> None:
    assert talked(tells(TOLD)) == []
    other = (LOOPBACK, 503)
    assert talked(Packet(0, 1, segment(PLC, other, 1, READ))) == []
    strange = TOLD[:1] + b"\x08" + TOLD[2:]
    assert len(talked(asks(READ), tells(strange))) == 1


@pytest.mark.parametrize("first", [1000, (1 << 32) - 5], ids=["plain", "comes round"])
def test_segments_come_in_any_order_twice_and_cut(first: int) -> None:
    """The capture saw the middle of the conversation first: one whole request tells where it stands."""
    second = bytes((0, 8)) + READ[2:]
    parts = [
        asks(READ, first),
        asks(second[5:], first + len(READ) + 5),  # before what stands before it
        asks(READ, first),  # repeated
        asks(READ[8:] + second[:5], first + 8),  # repeated, with more behind it
    ]
    found = talked(*parts)
    assert [each.request.transaction for each in found] == [7, 8]


def test_what_the_capture_lost_for_good_costs_no_more_than_that() -> None:
    rest = [asks(bytes((0, 10 + n)) + READ[2:], 5000 + n * len(READ)) for n in range(40)]
    found = talked(asks(READ, 1000), *rest)
    assert [each.request.transaction for each in found] == [7, *range(10, 50)]


def test_a_refusal_is_the_answer_to_its_request() -> None:
    _, answered = talked(asks(READ), tells(REFUSED))
    assert isinstance(answered, Answered) and answered.pdu == b"\x84\x02"


# ---- what is compared
def compared(pdu: bytes, numbers: dict[int, Number], there: bytes, here: bytes) -> list[dict[str, object]]:
    comparison = Comparison()
    comparison.declare("it", read_name(1, pdu), read_places(pdu, lambda function, bit: f"bit{bit}", numbers))
    comparison.ours("it", here, 0)
    stamp: Ns = ms(100)
    comparison.theirs(Answer("it", stamp, stamp, 0, there))
    comparison.finish()
    (block,) = as_data(comparison, 0, stamp)
    places = block["places"]
    assert isinstance(places, list)
    return places


def test_reals_are_compared_within_a_tolerance_and_other_words_exactly() -> None:
    pdu = bytes.fromhex("04 03e8 0003")
    numbers = {1000: Number("axis.A1.actual", "REAL", within=0.5)}
    there, near, far = struct.pack(">fH", 100.0, 7), struct.pack(">fH", 100.4, 7), struct.pack(">fH", 100.6, 8)
    assert compared(pdu, numbers, there, near) == []
    position, word = compared(pdu, numbers, there, far)
    assert (position["place"], position["name"]) == ("input register 1000", "axis.A1.actual")
    assert position["largest"] == pytest.approx(0.6, abs=1e-4) and word["place"] == "input register 1002"


def test_bits_are_compared_each_by_its_name_and_the_filling_is_not() -> None:
    pdu = bytes.fromhex("02 0040 0003")
    (bit,) = compared(pdu, {}, bytes((0b0000_0101,)), bytes((0b1110_0001,)))
    assert (bit["place"], bit["name"], bit["different"]) == ("discrete input 66", "bit66", 1)
    assert read_name(1, pdu) == "unit 1, discrete inputs 64..66"


def test_a_number_nobody_judges_and_half_a_number_at_the_end() -> None:
    numbers = {0: Number("axis.A1.lag", "REAL", judged=False), 2: Number("axis.A1.actual", "REAL", within=9.0)}
    places = read_places(bytes.fromhex("03 0000 0003"), lambda function, bit: "", numbers)
    assert [place.label for place in places] == ["holding register 2"] and places[0].number is None
