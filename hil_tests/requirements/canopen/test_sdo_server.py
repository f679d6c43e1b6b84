"""CiA 301, 7.2.4: the SDO server of the emulated device, message by message; every abort code of table 22 has its situation."""

import itertools
from collections.abc import Callable

import pytest

from hil_tests.lab.virtual.canopen_bus import AbortedError, CanopenBus, Master
from protocols.base.machine import Frame
from protocols.canopen import sdo
from protocols.canopen.sdo import Abort, Answer, Request

NOTES = (0x2F00, 0)  # DOMAIN, rw
NAME = (0x1008, 0)  # VISIBLE_STRING, const


def ready() -> tuple[CanopenBus, Master]:
    bus = CanopenBus()
    bus.run(0.1)
    return bus, bus.node()


def code_of(answer: bytes) -> int:
    assert answer[0] == 0x80, f"an abort expected: {answer.hex(' ')}"
    return sdo.abort_of(answer).code


def download(node: Master, key: tuple[int, int], data: bytes, announce: int | None = None) -> bytes:
    """Segmented; the last answer."""
    answer = node.ask(sdo.initiate(Request.INITIATE_DOWNLOAD, key, len(data) if announce is None else announce))
    for at in range(0, len(data), 7):
        if answer[0] == 0x80:
            return answer
        answer = node.ask(sdo.segment(Request.DOWNLOAD_SEGMENT, bool(at // 7 % 2), data[at : at + 7], at + 7 >= len(data)))
    return answer


def upload(node: Master, key: tuple[int, int]) -> bytes:
    answer = node.ask(sdo.initiate(Request.INITIATE_UPLOAD, key))
    if answer[0] & sdo.EXPEDITED:
        return sdo.expedited_data(answer)
    assert answer[0] == 0x41, answer.hex(" ")
    data = b""
    for toggle in itertools.cycle((False, True)):
        answer = node.ask(sdo.short(Request.UPLOAD_SEGMENT, sdo.TOGGLE * toggle))
        assert answer[0] >> 5 == Answer.UPLOAD_SEGMENT and bool(answer[0] & sdo.TOGGLE) is toggle
        data += sdo.segment_data(answer)
        if answer[0] & sdo.LAST:
            return data
    raise AssertionError


# -- plain transfers ----------------------------------------------------------------------------------


def test_an_expedited_upload_names_its_size() -> None:
    _, node = ready()
    assert node.ask(bytes.fromhex("4000100000000000")) == bytes.fromhex("4300100092010200")  # 1000h = 00020192h
    assert node.ask(bytes.fromhex("4001100000000000")) == bytes.fromhex("4f01100000000000")  # one byte
    assert node.ask(bytes.fromhex("4041600000000000"))[0] == 0x4B  # two bytes


def test_a_string_comes_in_segments() -> None:
    _, node = ready()
    assert upload(node, NAME) == b"axisgate emulated CiA 402 servo drive"


@pytest.mark.parametrize("size", [0, 1, 4, 5, 7, 8, 14, 700])
def test_what_was_written_in_segments_is_read_back(size: int) -> None:
    _, node = ready()
    data = bytes(number * 7 & 0xFF for number in range(size))
    if size:
        assert download(node, NOTES, data)[0] >> 5 == Answer.DOWNLOAD_SEGMENT
    assert upload(node, NOTES) == data


def test_an_expedited_download_without_size_means_the_object_s() -> None:
    _, node = ready()
    assert node.ask(bytes.fromhex("2240600006000000"))[0] == 0x60
    assert node.read(0x6040) == 6


def test_a_client_s_abort_is_not_answered_and_ends_the_transfer() -> None:
    _, node = ready()
    node.ask(sdo.initiate(Request.INITIATE_UPLOAD, NAME))
    assert node.asks(sdo.abort(NAME, Abort.GENERAL)) == []
    assert code_of(node.ask(sdo.short(Request.UPLOAD_SEGMENT))) == Abort.COMMAND


def test_a_new_request_ends_a_transfer_that_hangs() -> None:
    _, node = ready()
    node.ask(sdo.initiate(Request.INITIATE_UPLOAD, NAME))
    assert node.read(0x1000) == 0x20192


def test_a_stopped_node_answers_no_sdo() -> None:
    bus, node = ready()
    bus.hand(Frame(0, bytes((2, 1))))
    assert node.asks(sdo.initiate(Request.INITIATE_UPLOAD, NAME)) == []


def test_a_refused_write_changes_nothing() -> None:
    _, node = ready()
    with pytest.raises(AbortedError):
        node.set(0x605A, 9)
    assert node.read(0x605A) == 2


# -- blocks -------------------------------------------------------------------------------------------


def block_write(node: Master, data: bytes, drop: frozenset[int] = frozenset(), checksum: int | None = None, with_crc: bool = True) -> bytes:
    """Block download; `drop`: running numbers of segments lost the first time.  The answer to the end."""
    answer = node.ask(sdo.initiate_block(Request.BLOCK_DOWNLOAD, NOTES, len(data), with_crc))
    assert answer[0] == 0xA4 and answer[4] == 127
    size, at, sent = answer[4], 0, 0
    while at < len(data):
        answers: list[bytes] = []
        for number in range(1, size + 1):
            place = at + (number - 1) * 7
            final = place + 7 >= len(data)
            sent += 1
            if sent not in drop:
                answers += node.asks(sdo.block_segment(number, data[place : place + 7], final))
            if final:
                break
        assert len(answers) == 1 and answers[0][0] == 0xA2, [answer.hex() for answer in answers]
        at += answers[0][1] * 7
        size = answers[0][2]
    return node.ask(sdo.block_end(Request.BLOCK_DOWNLOAD, at - len(data), sdo.crc(data) if checksum is None else checksum))


DATA = bytes(number * 31 & 0xFF for number in range(2000))


@pytest.mark.parametrize("length", [1, 7, 8, 889, 890, 2000])
def test_a_block_download_of_any_length(length: int) -> None:
    _, node = ready()
    assert block_write(node, DATA[:length])[0] == 0xA1
    assert upload(node, NOTES) == DATA[:length]


def test_a_lost_segment_of_a_block_is_sent_again_from_there() -> None:
    _, node = ready()
    assert block_write(node, DATA, drop=frozenset({5, 130}))[0] == 0xA1
    assert upload(node, NOTES) == DATA


def test_the_crc_of_a_block_download_is_checked_where_the_client_has_one() -> None:
    _, node = ready()
    assert code_of(block_write(node, DATA, checksum=0x1234)) == Abort.CRC
    assert upload(node, NOTES) == b"", "nothing was taken"
    assert block_write(node, DATA, checksum=0x1234, with_crc=False)[0] == 0xA1


def test_the_crc_is_that_of_the_standard() -> None:
    assert sdo.crc(b"123456789") == 0x31C3  # CRC-CCITT (XModem), as CiA 301 7.2.4.3.16 names it


def block_read(node: Master, size: int, lose: frozenset[int] = frozenset()) -> bytes:
    """Block upload; `lose`: segments the client did not get, the first time."""
    answer = node.ask(bytes((0xA4, 0x00, 0x2F, 0x00, size, 0, 0, 0)))
    assert answer[0] == 0xC6, "CRC and size"
    total, data, seen = sdo.size_of(answer), b"", 0
    segments = node.asks(bytes((0xA3, 0, 0, 0, 0, 0, 0, 0)))
    while True:
        good = 0
        for number, segment in enumerate(segments, 1):
            assert segment[0] & 0x7F == number
            seen += 1
            if seen in lose:
                break
            good, data = number, data + segment[1:]
        done = segments[good - 1][0] & 0x80 if good else 0
        segments = node.asks(bytes((0xA2, good, size, 0, 0, 0, 0, 0)))
        if done:
            break
    assert segments[0][0] & 0xE1 == 0xC1
    unused = segments[0][0] >> 2 & 7
    data = data[:-unused] if unused else data
    assert len(data) == total and sdo.crc(data) == int.from_bytes(segments[0][1:3], "little")
    assert node.asks(bytes((0xA1, 0, 0, 0, 0, 0, 0, 0))) == []
    return data


@pytest.mark.parametrize("size", [1, 3, 127])
def test_a_block_upload_with_any_block_size(size: int) -> None:
    _, node = ready()
    block_write(node, DATA[:100])
    assert block_read(node, size) == DATA[:100]


def test_a_segment_the_client_lost_comes_again() -> None:
    _, node = ready()
    block_write(node, DATA)
    assert block_read(node, 20, lose=frozenset({4, 33})) == DATA


def test_a_short_object_is_uploaded_plainly_when_the_client_says_so() -> None:
    _, node = ready()
    assert node.ask(bytes((0xA4, 0x00, 0x10, 0x00, 127, 8, 0, 0))) == bytes.fromhex("4300100092010200")


# -- every abort code ---------------------------------------------------------------------------------


def wrong_toggle(bus: CanopenBus, node: Master) -> bytes:
    node.ask(sdo.initiate(Request.INITIATE_UPLOAD, NAME))
    return node.ask(sdo.short(Request.UPLOAD_SEGMENT, sdo.TOGGLE))


def silent_client(bus: CanopenBus, node: Master) -> bytes:
    node.ask(sdo.initiate(Request.INITIATE_UPLOAD, NAME))
    before = len(bus.said)
    bus.run(0.9999)
    assert not bus.heard(0x581, before)
    bus.run(0.0002)
    return bus.heard(0x581, before)[0].data


def too_big(bus: CanopenBus, node: Master) -> bytes:
    return node.ask(sdo.initiate(Request.INITIATE_DOWNLOAD, NOTES, 70_000))


def wrong_acknowledge(bus: CanopenBus, node: Master) -> bytes:
    download(node, NOTES, bytes(100))
    node.ask(bytes((0xA4, 0x00, 0x2F, 0x00, 3, 0, 0, 0)))
    node.asks(bytes((0xA3, 0, 0, 0, 0, 0, 0, 0)))
    return node.ask(bytes((0xA2, 9, 3, 0, 0, 0, 0, 0)))


def beyond_the_history(bus: CanopenBus, node: Master) -> bytes:
    return node.ask(sdo.initiate(Request.INITIATE_UPLOAD, (0x1003, 1)))


def write(index: int, sub: int, data: str) -> Callable[[CanopenBus, Master], bytes]:
    return lambda bus, node: node.ask(sdo.expedited(Request.INITIATE_DOWNLOAD, (index, sub), bytes.fromhex(data)))


def read(index: int, sub: int) -> Callable[[CanopenBus, Master], bytes]:
    return lambda bus, node: node.ask(sdo.initiate(Request.INITIATE_UPLOAD, (index, sub)))


def pdo_off(node: Master) -> None:
    """TPDO1 invalid and empty."""
    node.set(0x1800, 0xC0000181, 1)
    node.set(0x1A00, 0, 0)


def with_pdo_off(index: int, sub: int, data: str) -> Callable[[CanopenBus, Master], bytes]:
    def act(bus: CanopenBus, node: Master) -> bytes:
        pdo_off(node)
        return write(index, sub, data)(bus, node)

    return act


def too_many_bits(bus: CanopenBus, node: Master) -> bytes:
    pdo_off(node)
    for sub in (1, 2, 3):
        node.set(0x1A00, 0x60640020, sub)
    return write(0x1A00, 0, "03")(bus, node)


def store_while_moving(bus: CanopenBus, node: Master) -> bytes:
    node.enable(1)
    return write(0x1010, 1, "73617665")(bus, node)


def broken_memory(bus: CanopenBus, node: Master) -> bytes:
    bus.slave.memory_broken(1, True)
    return write(0x1010, 1, "73617665")(bus, node)


def from_the_panel(bus: CanopenBus, node: Master) -> bytes:
    bus.slave.local_control(1, True)
    return write(0x6040, 0, "0600")(bus, node)


def same_node_twice(bus: CanopenBus, node: Master) -> bytes:
    node.set(0x1016, 127 << 16 | 100, 1)
    return write(0x1016, 2, "64007f00")(bus, node)


def ordered(code: int) -> Callable[[CanopenBus, Master], bytes]:
    def act(bus: CanopenBus, node: Master) -> bytes:
        bus.slave.refuse(1, 0x6041, 0, code)
        return read(0x6041, 0)(bus, node)

    return act


SITUATIONS: dict[Abort, Callable[[CanopenBus, Master], bytes]] = {
    Abort.TOGGLE: wrong_toggle,
    Abort.TIMED_OUT: silent_client,
    Abort.COMMAND: lambda bus, node: node.ask(b"\xe0" + bytes(7)),
    Abort.BLOCK_SIZE: lambda bus, node: node.ask(bytes((0xA4, 0x00, 0x2F, 0x00, 0, 0, 0, 0))),
    Abort.SEQUENCE: wrong_acknowledge,
    Abort.CRC: lambda bus, node: block_write(node, DATA, checksum=1),
    Abort.MEMORY: too_big,
    Abort.ACCESS: write(0x1A00, 1, "10004160"),  # while the PDO is valid
    Abort.WRITE_ONLY: read(0x2010, 0),
    Abort.READ_ONLY: write(0x6041, 0, "0000"),
    Abort.NO_OBJECT: read(0x6042, 0),
    Abort.NOT_MAPPABLE: with_pdo_off(0x1A00, 1, "20001810"),
    Abort.MAPPED_LENGTH: too_many_bits,
    Abort.INCOMPATIBLE: same_node_twice,
    Abort.INTERNAL: ordered(Abort.INTERNAL),
    Abort.HARDWARE: broken_memory,
    Abort.LENGTH: lambda bus, node: download(node, NOTES, bytes(20), announce=30),
    Abort.TOO_LONG: write(0x6040, 0, "06000000"),
    Abort.TOO_SHORT: write(0x6040, 0, "06"),
    Abort.NO_SUB: read(0x1018, 5),
    Abort.VALUE: write(0x6060, 0, "02"),
    Abort.TOO_HIGH: write(0x605A, 0, "0900"),
    Abort.TOO_LOW: write(0x605D, 0, "0000"),
    Abort.LIMITS: ordered(Abort.LIMITS),
    Abort.NO_RESOURCE: ordered(Abort.NO_RESOURCE),
    Abort.GENERAL: ordered(Abort.GENERAL),
    Abort.NO_STORE: write(0x1010, 1, "6c6f6164"),  # "load" where "save" belongs
    Abort.LOCAL_CONTROL: from_the_panel,
    Abort.DEVICE_STATE: store_while_moving,
    Abort.NO_DICTIONARY: ordered(Abort.NO_DICTIONARY),
    Abort.NO_DATA: beyond_the_history,
}


@pytest.mark.parametrize("code", list(Abort), ids=lambda code: f"{code:08X}")
def test_every_abort_code_has_its_situation(code: Abort) -> None:
    bus, node = ready()
    answer = SITUATIONS[code](bus, node)
    assert code_of(answer) == code
    assert node.read(0x1000) == 0x20192, "the server is ready for the next transfer"


def test_every_abort_code_has_a_text() -> None:
    assert {int(code) for code in Abort} == set(sdo.TEXTS) and len(Abort) == 31


def test_an_abandoned_block_download_frees_the_server_though_others_keep_asking() -> None:
    """A client that dies in a block; the next one asks again and again within the time-out: its requests are no segments."""
    bus, node = ready()
    node.ask(sdo.initiate_block(Request.BLOCK_DOWNLOAD, NOTES, 700, False))
    for number in (1, 2, 3):
        node.asks(sdo.block_segment(number, bytes(7), False))
    answers: list[bytes] = []
    for _ in range(5):
        bus.run(0.3)
        answers += node.asks(sdo.initiate(Request.INITIATE_UPLOAD, (0x1000, 0)))
    assert answers and answers[-1] == bytes.fromhex("4300100092010200"), answers
