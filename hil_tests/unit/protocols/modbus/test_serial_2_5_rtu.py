"""MODBUS over Serial Line V1.02, section 2.5.1: silences, checks, frames that are none.  All times are virtual and exact."""

import copy

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_tests.lab.virtual.bench import Bench
from protocols.base.machine import Damage, Ns, ms
from protocols.modbus.crc import START, crc, sealed
from protocols.modbus.mbap import Closing, Request, Why
from protocols.modbus.rtu import Dropped, Fault, RtuFraming, RtuTcpFraming
from protocols.modbus.timing import Timing, timing

READ = sealed(bytes.fromhex("01 03 0000 0001"))
T9600 = timing(9600)
CHAR = 11 * 1_000_000_000 // 9600


def exact(strict: bool = False, patience: Ns = 0) -> RtuFraming:
    return RtuFraming(timing(9600, strict=strict, patience=patience))


def test_the_check_of_the_guide() -> None:
    """V1.02, 6.2.2: the example 02 07 has the check 41 12."""
    assert sealed(b"\x02\x07") == bytes.fromhex("02 07 41 12")
    assert crc(bytes.fromhex("02 07 41 12")) == 0


@pytest.mark.parametrize(
    "baud, t15_us, t35_us", [(1200, 13749, 32083), (9600, 1718, 4010), (19200, 859, 2005), (19201, 750, 1750), (115200, 750, 1750)]
)
def test_silences_by_baud(baud: int, t15_us: int, t35_us: int) -> None:
    found = timing(baud)
    assert (found.t15 // 1000, found.t35 // 1000) == (t15_us, t35_us)


def test_a_frame_ends_after_three_and_a_half_characters_and_not_before() -> None:
    line = Bench(exact())
    line.at(0).hears(READ).reports()
    line.at(T9600.t35 - 1).reports()
    line.at(T9600.t35).reports(Request(0, 1, READ[1:-2]))


def test_the_answer_is_sealed_and_leaves_at_once() -> None:
    line = Bench(exact())
    line.at(0).hears(READ).at(T9600.t35).reports(request := Request(0, 1, READ[1:-2]))
    line.does(lambda framing, now: framing.reply(request, b"\x03\x02\x12\x34"))
    line.says(sealed(b"\x01\x03\x02\x12\x34"))


def fed(framing: RtuFraming, *pieces: tuple[Ns, bytes]) -> list[object]:
    """Each piece ends at its moment; every deadline on the way is kept; then silence."""
    events: list[object] = []
    for moment, data in pieces:
        begun = moment - len(data) * CHAR
        while (due := framing.deadline()) is not None and due <= begun:
            events += framing.wake(due)
        events += framing.receive(data, moment)
    while (due := framing.deadline()) is not None:
        events += framing.wake(due)
    return events


def test_a_gap_below_one_and_a_half_characters_is_no_gap() -> None:
    start = 4 * CHAR
    for strict in (False, True):
        assert fed(exact(strict), (start, READ[:4]), (start + T9600.t15 + 4 * CHAR, READ[4:])) == [Request(0, 1, READ[1:-2])]


def test_a_gap_above_it_spoils_the_frame_where_times_are_exact() -> None:
    start = 4 * CHAR
    pieces = ((start, READ[:4]), (start + T9600.t15 + 4 * CHAR + 1, READ[4:]))
    assert fed(exact(strict=True), *pieces) == [Dropped(Fault.GAP, READ)]
    assert fed(exact(), *pieces) == [Request(0, 1, READ[1:-2])], "the check decides where they are not (AX-344)"


def test_a_silence_inside_makes_two_pieces_of_it() -> None:
    start = 4 * CHAR
    events = fed(exact(), (start, READ[:4]), (start + T9600.t35 + 4 * CHAR, READ[4:]))
    assert events == [Dropped(Fault.CHECK, READ[:4]), Dropped(Fault.CHECK, READ[4:])]


def test_patience_waits_for_the_rest_of_a_frame_and_not_after_a_whole_one() -> None:
    start = 4 * CHAR
    late = start + T9600.t35 + ms(49) + 4 * CHAR
    assert fed(exact(patience=ms(50)), (start, READ[:4]), (late, READ[4:])) == [Request(0, 1, READ[1:-2])]
    framing = exact(patience=ms(50))
    framing.receive(READ, 0)
    assert framing.deadline() == T9600.t35
    framing = exact(patience=ms(50))
    framing.receive(READ[:-1], 0)
    assert framing.deadline() == T9600.t35 + ms(50)


def test_bytes_read_late_in_one_lump_are_no_silence() -> None:
    """The loop slept while 8 characters came: they are there together, the last one just now."""
    framing = exact()
    framing.receive(READ[:1], 0)
    assert framing.receive(READ[1:], 7 * CHAR) == []
    assert framing.wake(7 * CHAR + T9600.t35) == [Request(0, 1, READ[1:-2])]


@pytest.mark.parametrize(
    "frame, why",
    [
        (b"\x01", Fault.SHORT),
        (sealed(b"\x01")[:3], Fault.SHORT),
        (READ[:-1] + bytes((READ[-1] ^ 1,)), Fault.CHECK),
        (sealed(b"\x01" + bytes(253)) + b"\x00", Fault.LONG),
    ],
)
def test_what_is_no_frame_is_dropped_and_not_answered(frame: bytes, why: Fault) -> None:
    line = Bench(exact())
    line.at(0).hears(frame).at(T9600.t35).reports(Dropped(why, frame[:256])).says(b"")


def test_the_longest_frame_is_one() -> None:
    longest = sealed(b"\x01" + bytes(253))
    Bench(exact()).at(0).hears(longest).at(T9600.t35).reports(Request(0, 1, bytes(253)))


@pytest.mark.parametrize("kind, why", [(Damage.PARITY, Fault.DAMAGED), (Damage.FRAMING, Fault.DAMAGED), (Damage.OVERRUN, Fault.OVERRUN)])
def test_a_damaged_character_spoils_the_whole_frame(kind: Damage, why: Fault) -> None:
    line = Bench(exact())
    line.at(0).hears(READ[:3]).damaged(kind).hears(READ[4:])
    line.at(T9600.t35).reports(Dropped(why, READ[:3] + b"\x00" + READ[4:]))
    line.hears(READ).at(2 * T9600.t35).reports(Request(0, 1, READ[1:-2]))


def test_a_port_that_goes_away_leaves_nothing_behind() -> None:
    line = Bench(exact())
    line.at(0).hears(READ[:3]).loses_the_port().reports(Dropped(Fault.LOST, READ[:3]))
    line.at(ms(1)).hears(READ).at(ms(100)).reports(Request(0, 1, READ[1:-2]))


@given(st.lists(st.tuples(st.integers(0, 20), st.binary(min_size=1, max_size=300)), max_size=12), st.booleans())
def test_garbage_never_raises_and_only_good_checks_are_requests(pieces: list[tuple[int, bytes]], strict: bool) -> None:
    framing, now = exact(strict), 0
    for pause, data in pieces:
        now += ms(pause) + len(data) * CHAR
        for event in [*framing.receive(data, now), *framing.wake(now + 1)]:
            assert isinstance(event, Dropped) or len(event.pdu) >= 1
        assert len(framing._half) <= 256


# -------------------------------------------------------------------------------------------------------- RTU over TCP


def stream() -> Bench[RtuTcpFraming]:
    return Bench(RtuTcpFraming())


def test_over_tcp_the_length_ends_a_frame() -> None:
    write = sealed(bytes.fromhex("01 10 0000 0002 04 0001 0002"))
    line = stream().at(0)
    line.hears(READ + write + READ[:5]).reports(Request(0, 1, READ[1:-2]), Request(0, 1, write[1:-2]))
    line.at(ms(1999)).hears(READ[5:]).reports(Request(0, 1, READ[1:-2]))


def test_over_tcp_half_a_frame_is_closed_at_its_limit() -> None:
    stream().at(0).hears(READ[:5]).at(ms(2000)).reports(Closing(Why.HALF_FRAME, READ[:5]))


def test_over_tcp_a_wrong_check_loses_the_beat_and_closes() -> None:
    bad = READ[:-1] + bytes((READ[-1] ^ 1,))
    line = stream().at(0).hears(bad)
    assert [type(event).__name__ for event in line.told()] == ["Closing"]
    line.hears(READ).reports()


def test_over_tcp_the_check_ends_what_nothing_else_does() -> None:
    unknown, query = sealed(b"\x01\x41\x01\x02\x03"), sealed(bytes.fromhex("01 08 0000 1122 3344"))
    stream().at(0).hears(unknown + READ).reports(Request(0, 1, unknown[1:-2]), Request(0, 1, READ[1:-2]))
    stream().at(0).hears(query).reports(Request(0, 1, query[1:-2]))


@pytest.mark.parametrize("head", [b"\x01\x41", b"\x01\x08", bytes.fromhex("01 10 0000 007B F6")])
def test_over_tcp_a_frame_costs_the_same_byte_by_byte_as_whole(head: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    looked = 0

    def counted(data: bytes, check: int = START) -> int:
        nonlocal looked
        looked += len(data)
        return crc(data, check)

    monkeypatch.setattr("protocols.modbus.rtu.crc", counted)
    frame = sealed(head + bytes(n * 7 & 0xFF for n in range(246)))
    whole, byte_by_byte = RtuTcpFraming(), RtuTcpFraming()
    found = whole.receive(frame, 0)
    at_once, looked = looked, 0
    pieces = [event for byte in frame for event in byte_by_byte.receive(bytes((byte,)), 0)]
    assert pieces == found and len(found) == 1 and isinstance(found[0], Request)
    assert looked == at_once <= len(frame)


@given(st.lists(st.binary(max_size=40), max_size=12), st.integers(1, 7))
def test_over_tcp_pieces_make_no_difference(frames: list[bytes], size: int) -> None:
    data = b"".join(sealed(b"\x01" + frame) for frame in frames)
    whole, pieces = RtuTcpFraming(), RtuTcpFraming()
    found = whole.receive(data, 0)
    told = [event for at in range(0, len(data), size) for event in pieces.receive(data[at : at + size], 0)]
    assert [event for event in told if isinstance(event, Request)] == [event for event in found if isinstance(event, Request)]
    assert any(isinstance(event, Closing) for event in told) == any(isinstance(event, Closing) for event in found)


@given(st.lists(st.binary(max_size=300), max_size=10))
def test_over_tcp_garbage_is_bounded(pieces: list[bytes]) -> None:
    framing, now = RtuTcpFraming(), 0
    for data in pieces:
        now += ms(1)
        framing.receive(data, now)
        assert len(framing._half) <= 256
    copy.deepcopy(framing).wake(now + ms(3000))


def test_the_timing_is_plain_data() -> None:
    assert timing(9600) == Timing(CHAR, 3 * CHAR // 2, 7 * CHAR // 2)
