"""protocols/canopen: the small codecs, with vectors from CiA 301 and CiA 305 and the ends of their ranges."""

import pytest

from protocols.base.errors import DecodeError, EncodeError
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.canopen import emcy, lss, nmt, pdo, sdo, sync
from protocols.canopen.emcy import Emergency
from protocols.canopen.types import BY_NAME, TYPES, DataType, decode, encode


def test_the_predefined_connection_set() -> None:
    """CiA 301, tables 39 and 40."""
    assert (cobid.emcy(1), cobid.emcy(127)) == (0x081, 0x0FF)
    assert [cobid.tpdo(number, 1) for number in (1, 2, 3, 4)] == [0x181, 0x281, 0x381, 0x481]
    assert [cobid.rpdo(number, 127) for number in (1, 2, 3, 4)] == [0x27F, 0x37F, 0x47F, 0x57F]
    assert (cobid.sdo_answer(1), cobid.sdo_request(127), cobid.heartbeat(1)) == (0x581, 0x67F, 0x701)


def test_restricted_identifiers_are_those_of_the_table() -> None:
    """CiA 301, table 41."""
    named = {0x000, *range(0x001, 0x080), *range(0x101, 0x181), *range(0x581, 0x600), *range(0x601, 0x680)}
    named |= {*range(0x6E0, 0x700), *range(0x701, 0x780), *range(0x780, 0x800)}
    assert {identifier for identifier in range(0x800) if cobid.restricted(identifier)} == named


CALLED = {
    0: "NMT",
    0x80: "SYNC",
    0x85: "EMCY of node 5",
    0x285: "TPDO2 of node 5",
    0x57F: "RPDO4 of node 127",
    0x605: "SDO request of node 5",
    0x705: "heartbeat of node 5",
    0x7E5: "LSS master",
    0x200: "0x200",
}


@pytest.mark.parametrize(("identifier", "text"), CALLED.items())
def test_an_identifier_is_called_by_its_use(identifier: int, text: str) -> None:
    assert cobid.describe(identifier) == text


@pytest.mark.parametrize("kind", TYPES.values(), ids=lambda kind: kind.name)
def test_every_type_keeps_its_ends_and_refuses_one_step_beyond(kind: DataType) -> None:
    if kind.whole:
        for value in (kind.low, kind.high, 0):
            data = encode(kind, value)
            assert len(data) == kind.size and decode(kind, data) == value
        for value in (kind.low - 1, kind.high + 1):
            with pytest.raises(EncodeError):
                encode(kind, value)
    else:
        assert decode(kind, encode(kind, kind.zero if not kind.size or kind.name.startswith("REAL") else bytes(kind.size))) is not None
    if kind.size:
        for data in (bytes(kind.size - 1), bytes(kind.size + 1)):
            with pytest.raises(DecodeError):
                decode(kind, data)


def test_little_endian_and_two_s_complement() -> None:
    assert encode(BY_NAME["UNSIGNED32"], 0x12345678) == bytes.fromhex("78563412")
    assert encode(BY_NAME["INTEGER24"], -2) == bytes.fromhex("feffff") and decode(BY_NAME["INTEGER24"], bytes.fromhex("feffff")) == -2
    assert encode(BY_NAME["REAL32"], 1.0) == bytes.fromhex("0000803f")
    with pytest.raises(EncodeError):
        encode(BY_NAME["UNSIGNED8"], "1")


def test_nmt_frames() -> None:
    assert nmt.command(nmt.Command.RESET_NODE, 5) == Frame(0, b"\x81\x05")
    assert nmt.command_of(Frame(0, b"\x80\x00")) == (nmt.Command.PRE_OPERATIONAL, 0)
    assert nmt.command_of(Frame(0, b"\x03\x00")) is None and nmt.command_of(Frame(1, b"\x01\x00")) is None
    assert nmt.heartbeat_of(Frame(0x705, b"\x05")) == (5, nmt.State.OPERATIONAL)
    assert nmt.heartbeat_of(Frame(0x705, b"\x85")) == (5, nmt.State.OPERATIONAL), "with the toggle bit of node guarding"
    assert nmt.heartbeat_of(Frame(0x700, b"\x05")) is None and nmt.heartbeat_of(Frame(0x705, b"\x06")) is None


def test_emergencies() -> None:
    frame = emcy.encode(0x85, Emergency(0x8130, 0x11, b"\x7f\0\0\0\0"))
    assert frame == Frame(0x85, bytes.fromhex("3081117f00000000"))
    assert emcy.decode(frame.data) == Emergency(0x8130, 0x11, b"\x7f\0\0\0\0")
    with pytest.raises(DecodeError):
        emcy.decode(bytes(7))


WORDS = {
    0: "no error, or error gone",
    0x8611: "following error",
    0x8130: "life guard or heartbeat error",
    0x3220: "DC link under-voltage",
    0x2312: "continuous over-current (2312h)",
    0x3299: "voltage inside the device (3299h)",
    0xFF42: "manufacturer specific (FF42h)",
    0x0042: "unknown error (0042h)",
}


@pytest.mark.parametrize(("code", "text"), WORDS.items())
def test_a_code_is_reported_in_words_as_exactly_as_the_table_knows(code: int, text: str) -> None:
    assert Emergency(code).text == text


def test_mapping_words() -> None:
    assert pdo.mapped(0x607A0020) == pdo.Mapped(0x607A, 0, 32) and pdo.Mapped(0x6041, 0, 16).word == 0x60410010
    assert [kind for kind in range(256) if pdo.reserved(kind)] == list(range(241, 252))
    assert [kind for kind in range(256) if pdo.synchronous(kind)] == [*range(241), 252]


def test_sdo_messages_of_the_standard() -> None:
    assert sdo.expedited(sdo.Request.INITIATE_DOWNLOAD, (0x1017, 0), b"\xe8\x03") == bytes.fromhex("2b171000e8030000")
    assert sdo.initiate(sdo.Request.INITIATE_UPLOAD, (0x1018, 1)) == bytes.fromhex("4018100100000000")
    assert sdo.initiate(sdo.Request.INITIATE_DOWNLOAD, (0x1F50, 1), 20) == bytes.fromhex("21501f0114000000")
    assert sdo.segment(sdo.Request.DOWNLOAD_SEGMENT, True, b"abc", True) == bytes.fromhex("1961626300000000")
    assert sdo.segment_data(bytes.fromhex("1961626300000000")) == b"abc"
    assert sdo.abort((0x6041, 0), sdo.Abort.READ_ONLY) == bytes.fromhex("8041600002000106")
    aborted = sdo.abort_of(bytes.fromhex("8041600002000106"))
    assert (aborted.index, aborted.sub, aborted.text) == (0x6041, 0, "attempt to write a read-only object")


def test_sync_counts_from_1_to_its_overflow() -> None:
    assert sync.frame() == Frame(0x80, b"") and sync.frame(3) == Frame(0x80, b"\x03")
    assert [sync.following(counter, 3) for counter in (1, 2, 3)] == [2, 3, 1]


def test_lss_messages_have_8_bytes() -> None:
    assert lss.request(lss.Service.SELECT_VENDOR, 0x12345678) == Frame(0x7E5, bytes.fromhex("4078563412000000"))
    assert lss.fastscan(0x80000000, 31, 1, 1) == Frame(0x7E5, bytes.fromhex("51000000801f0101"))
    assert lss.configure_bit_timing(2) == Frame(0x7E5, bytes.fromhex("1300020000000000"))
    assert lss.activate_bit_timing(1000) == Frame(0x7E5, bytes.fromhex("15e8030000000000"))
    assert lss.number_of(bytes.fromhex("5a78563412000000")) == 0x12345678
