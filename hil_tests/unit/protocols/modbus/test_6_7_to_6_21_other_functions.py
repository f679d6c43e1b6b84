"""V1.1b3, sections 6.7 to 6.21: diagnosis, events, names, files, masks, both at once, queues, identification; examples as printed there."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_tests.lab.virtual.modbus_view import MemoryView
from protocols.modbus.answering import answer
from protocols.modbus.rights import Rights
from protocols.modbus.station import Identity, Station
from protocols.modbus.validate import refusal
from protocols.modbus.view import ExceptionCode, Kind

FUNCTION, ADDRESS, VALUE = ExceptionCode.ILLEGAL_FUNCTION, ExceptionCode.ILLEGAL_DATA_ADDRESS, ExceptionCode.ILLEGAL_DATA_VALUE


class WholeView(MemoryView):
    """Tables, an octet, files of ten records each, one queue."""

    def __init__(self, size: int = 2000) -> None:
        super().__init__(size)
        self.status = 0
        self.files: dict[int, list[int]] = {3: [0] * 20, 4: [0] * 20}
        self.queue: list[int] = []

    def exception_status(self) -> int:
        return self.status

    def read_record(self, file: int, record: int, count: int) -> Sequence[int] | ExceptionCode:
        table = self.files.get(file, [])
        return table[record : record + count] if record + count <= len(table) else ADDRESS

    def refuses_record(self, file: int, record: int, count: int) -> ExceptionCode | None:
        found = self.read_record(file, record, count)
        return found if isinstance(found, ExceptionCode) else None

    def write_record(self, file: int, record: int, values: Sequence[int]) -> ExceptionCode | None:
        self.files[file][record : record + len(values)] = values
        return None

    def read_queue(self, address: int) -> Sequence[int] | ExceptionCode:
        return self.queue if address == 0x04DE else ADDRESS


def says(view: MemoryView, request: str, station: Station | None = None, may_write: bool = True) -> str:
    return answer(bytes.fromhex(request), view, may_write, station).hex(" ").upper()


# -------------------------------------------------------------------------------------------------- printed examples


def test_6_7_the_exception_status_is_an_octet() -> None:
    view = WholeView()
    view.status = 0x6D
    assert says(view, "07") == "07 6D"


def test_6_8_query_data_comes_back() -> None:
    assert says(WholeView(), "08 0000 A537", Station()) == "08 00 00 A5 37"
    assert says(WholeView(), "08 0000 A537 0102", Station()) == "08 00 00 A5 37 01 02"


def test_6_14_two_groups_of_two_files() -> None:
    view = WholeView()
    view.files[4][1:3], view.files[3][9:11] = [0x0DFE, 0x0020], [0x33CD, 0x0040]
    assert says(view, "14 0E 06 0004 0001 0002 06 0003 0009 0002") == "14 0C 05 06 0D FE 00 20 05 06 33 CD 00 40"


def test_6_15_a_group_is_written_and_repeated() -> None:
    view = WholeView()
    request = "15 0D 06 0004 0007 0003 06AF 04BE 100D"
    assert says(view, request) == bytes.fromhex(request).hex(" ").upper()
    assert view.files[4][7:10] == [0x06AF, 0x04BE, 0x100D]


def test_6_16_the_mask_keeps_and_sets() -> None:
    view = WholeView()
    view.words[Kind.HOLDING_REGISTERS][4] = 0x12
    assert says(view, "16 0004 00F2 0025") == "16 00 04 00 F2 00 25"
    assert view.words[Kind.HOLDING_REGISTERS][4] == 0x17


def test_6_17_three_are_written_and_six_read() -> None:
    view = WholeView()
    view.words[Kind.HOLDING_REGISTERS][3:9] = [0x00FE, 0x0ACD, 0x0001, 0x0003, 0x000D, 0x00FF]
    assert says(view, "17 0003 0006 000E 0003 06 00FF 00FF 00FF") == "17 0C 00 FE 0A CD 00 01 00 03 00 0D 00 FF"
    assert view.words[Kind.HOLDING_REGISTERS][14:17] == [0xFF] * 3


def test_6_17_the_write_comes_before_the_read() -> None:
    assert says(WholeView(), "17 0003 0002 0004 0001 02 BEEF") == "17 04 00 00 BE EF"


def test_6_18_two_in_the_queue() -> None:
    view = WholeView()
    view.queue = [0x01B8, 0x1284]
    assert says(view, "18 04DE") == "18 00 06 00 02 01 B8 12 84"
    assert says(view, "18 04DF") == "98 02"
    view.queue = [1] * 32
    assert says(view, "18 04DE") == "98 03"


# --------------------------------------------------------------------------------------------------- who are you, 6.21


def test_6_21_the_basic_stream() -> None:
    station = Station(Identity(vendor="Company", product_code="XL", revision="V2.11", product="not here"))
    assert says(WholeView(), "2B 0E 01 00", station) == ("2B 0E 01 83 00 00 03 00 07 43 6F 6D 70 61 6E 79 01 02 58 4C 02 05 56 32 2E 31 31")


def test_6_21_one_object_and_one_that_is_not_there() -> None:
    station = Station(Identity(vendor="Company"))
    assert says(WholeView(), "2B 0E 04 00", station) == "2B 0E 04 83 00 00 01 00 07 43 6F 6D 70 61 6E 79"
    assert says(WholeView(), "2B 0E 04 50", station) == "AB 02"


def test_6_21_a_stream_goes_on_where_it_stopped_and_an_unknown_start_is_the_first() -> None:
    names = {0x80 + n: chr(65 + n) * 100 for n in range(5)}
    station, seen, start = Station(Identity(more=names)), dict[int, bytes](), 0
    for _ in range(10):
        data = answer(bytes((43, 14, 3, start)), WholeView(), True, station)
        assert len(data) <= 253 and data[3] == 0x83
        at = 7
        for _ in range(data[6]):
            seen[data[at]] = data[at + 2 : at + 2 + data[at + 1]]
            at += 2 + data[at + 1]
        assert at == len(data)
        if not data[4]:
            break
        start = data[5]
    assert seen[0x84] == b"E" * 100 and list(seen) == sorted(Identity(more=names).objects())
    assert answer(b"\x2b\x0e\x01\x77", WholeView(), True, station) == answer(b"\x2b\x0e\x01\x00", WholeView(), True, station)


def test_6_13_the_server_reports_its_number_that_it_runs_and_its_name() -> None:
    assert says(WholeView(), "11", Station(Identity(vendor="A", product_code="B", revision="1"), number=7)) == "11 07 07 FF 41 20 42 20 31"


# ----------------------------------------------------------------------------------------------- counters, 6.8 to 6.10


def asked(station: Station, view: MemoryView, *requests: str) -> list[str]:
    """As a server does: each request is heard, answered, noted."""
    answers = []
    for text in requests:
        request = bytes.fromhex(text)
        station.heard()
        said = b"" if station.listening_only and request[0] != 8 else answer(request, view, True, station)
        station.said(request, said)
        answers.append(said.hex(" ").upper())
    return answers


def counter(station: Station, sub: int) -> int:
    return int(says(WholeView(), f"08 {sub:04X} 0000", station)[-5:].replace(" ", ""), 16)


def test_6_8_each_counter_counts_its_own() -> None:
    station, view = Station(), WholeView()
    asked(station, view, "03 0000 0001", "03 0000 0000", "06 0000 0001", "2A")
    station.spoiled()
    station.spoiled(overrun=True)
    assert [counter(station, sub) for sub in (11, 12, 13, 14, 15, 17, 18)] == [4, 2, 2, 4, 0, 0, 1]
    view.fails = ExceptionCode.SERVER_DEVICE_BUSY
    asked(station, view, "03 0000 0001")
    assert counter(station, 17) == 1
    assert says(view, "08 0014 0000", station) == "08 00 14 00 00" and counter(station, 18) == 0
    assert says(view, "08 000A 0000", station) == "08 00 0A 00 00"
    assert [counter(station, sub) for sub in (11, 12, 13, 14, 15, 17)] == [0] * 6


def test_6_9_only_what_was_done_is_an_event() -> None:
    station = Station()
    asked(station, WholeView(), "03 0000 0001", "03 0000 0000", "0B", "0C", "08 0000 0000", "06 0000 0001")
    assert says(WholeView(), "0B", station) == "0B 00 00 00 02"


def test_6_10_the_log_has_the_newest_first_and_64_at_most() -> None:
    station = Station()
    asked(station, WholeView(), "03 0000 0001", "03 0000 0000")
    station.spoiled()
    assert says(WholeView(), "0C", station) == "0C 0B 00 00 00 01 00 02 82 41 80 40 80"
    asked(station, WholeView(), *["03 0000 0001"] * 50)
    log = bytes.fromhex(says(WholeView(), "0C", station))
    assert len(log) == 2 + 6 + 64 and log[1] == 70


def test_6_8_listening_only_is_silent_until_the_restart_which_is_silent_too() -> None:
    station = Station(serial=True)
    assert asked(station, WholeView(), "08 0004 0000", "03 0000 0001") == ["", ""]
    assert station.listening_only
    assert asked(station, WholeView(), "08 0001 0000", "03 0000 0001") == ["", "03 02 00 00"]
    assert asked(station, WholeView(), "08 0001 FF00") == ["08 00 01 FF 00"]
    assert says(WholeView(), "0C", station)[-5:] == "80 00" or says(WholeView(), "0C", station).endswith("40 80 00")


def test_listening_only_is_for_lines() -> None:
    """AX-342: over TCP nobody could wake it up again."""
    assert says(WholeView(), "08 0004 0000", Station()) == "88 01"


# ------------------------------------------------------------------------------------------------------ what is refused

ROWS = [
    ("6.7 nothing follows", "07", None),
    ("6.7", "07 00", VALUE),
    ("6.8 the sub-function is part of the function", "08 0005 0000", FUNCTION),
    ("6.8", "08 0013 0000", FUNCTION),
    ("6.8", "08 FFFF 0000", FUNCTION),
    ("6.8", "08", VALUE),
    ("6.8", "08 00", VALUE),
    ("6.8 data of query", "08 0000", VALUE),
    ("6.8", "08 0000 11", VALUE),
    ("6.8", "08 0000 " + "1122" * 125, None),
    ("6.8", "08 0000 " + "1122" * 126, VALUE),
    ("6.8 restart", "08 0001 0000", None),
    ("6.8", "08 0001 FF00", None),
    ("6.8", "08 0001 0001", VALUE),
    ("6.8 counters take zero", "08 000B 0001", VALUE),
    ("6.8", "08 000B 0000 00", VALUE),
    ("6.9", "0B 00", VALUE),
    ("6.10", "0C 0000", VALUE),
    ("6.13", "11 01", VALUE),
    ("6.14 byte count 07h..F5h", "14 00", VALUE),
    ("6.14", "14", VALUE),
    ("6.14", "14 06 06 0001 0000 00", VALUE),
    ("6.14", "14 07 06 0001 0000 0001", None),
    ("6.14", "14 0E 06 0001 0000 0001", VALUE),
    ("6.14", "14 07 06 0001 0000 0001 00", VALUE),
    ("6.14 reference type", "14 07 05 0001 0000 0001", ADDRESS),
    ("6.14 file 0", "14 07 06 0000 0000 0001", ADDRESS),
    ("6.14 record 9999 is the last", "14 07 06 0001 270F 0001", None),
    ("6.14", "14 07 06 0001 270F 0002", ADDRESS),
    ("6.14", "14 07 06 0001 2710 0001", ADDRESS),
    ("6.14 the answer must fit", "14 07 06 0001 0000 0079", None),
    ("6.14", "14 07 06 0001 0000 007A", VALUE),
    ("6.14", "14 0E 06 0001 0000 0070 06 0001 0000 0009", VALUE),
    ("6.15 byte count 09h..FBh", "15 07 06 0001 0000 0000", VALUE),
    ("6.15", "15", VALUE),
    ("6.15", "15 09 06 0001 0000 0001 1234", None),
    ("6.15", "15 09 06 0001 0000 0001 12", VALUE),
    ("6.15", "15 09 06 0001 0000 0002 1234", VALUE),
    ("6.15", "15 0B 06 0001 0000 0001 1234 0000", VALUE),
    ("6.15", "15 09 07 0001 0000 0001 1234", ADDRESS),
    ("6.15", "15 09 06 0001 2710 0001 1234", ADDRESS),
    ("6.16", "16 0000 0000 0000", None),
    ("6.16", "16 0000 0000 00", VALUE),
    ("6.16", "16 0000 0000 0000 00", VALUE),
    ("6.17 read 1..7Dh", "17 0000 0000 0000 0001 02 0000", VALUE),
    ("6.17", "17 0000 007D 0000 0001 02 0000", None),
    ("6.17", "17 0000 007E 0000 0001 02 0000", VALUE),
    ("6.17 write 1..79h", "17 0000 0001 0000 0000 00", VALUE),
    ("6.17", "17 0000 0001 0000 0079 F2" + "00" * 242, None),
    ("6.17", "17 0000 0001 0000 007A F4" + "00" * 244, VALUE),
    ("6.17", "17 0000 0001 0000 0001 04 0000 0000", VALUE),
    ("6.17", "17 0000 0001 0000 0001 02 00", VALUE),
    ("6.17 both ranges", "17 FFFF 0002 0000 0001 02 0000", ADDRESS),
    ("6.17", "17 0000 0001 FFFF 0002 04 0000 0000", ADDRESS),
    ("6.18", "18 0000", None),
    ("6.18", "18 00", VALUE),
    ("6.18", "18 0000 00", VALUE),
    ("6.19 another interface", "2B 0D 01 00", FUNCTION),
    ("6.19", "2B 0D", FUNCTION),
    ("6.21", "2B", VALUE),
    ("6.21", "2B 0E", VALUE),
    ("6.21 code 1..4", "2B 0E 00 00", VALUE),
    ("6.21", "2B 0E 01 00", None),
    ("6.21", "2B 0E 04 00", None),
    ("6.21", "2B 0E 05 00", VALUE),
    ("6.21", "2B 0E 01 00 00", VALUE),
]


@pytest.mark.parametrize("section, pdu, demanded", ROWS)
def test_a_row_of_the_flow_charts(section: str, pdu: str, demanded: ExceptionCode | None) -> None:
    assert refusal(bytes.fromhex(pdu)) == demanded


@pytest.mark.parametrize("pdu", ["15 09 06 0003 0000 0001 1234", "16 0000 0000 0000", "17 0000 0001 0000 0001 02 0000", "08 000A 0000"])
def test_who_may_only_read_gets_01_for_these_too(pdu: str) -> None:
    assert refusal(bytes.fromhex(pdu)) is None
    assert refusal(bytes.fromhex(pdu), may_write=False) is FUNCTION


def test_a_view_without_these_data_answers_01() -> None:
    view = MemoryView()
    for request in ("07", "14 07 06 0003 0000 0001", "15 09 06 0003 0000 0001 1234", "18 0000"):
        assert says(view, request) == f"{int(request[:2], 16) | 0x80:02X} 01"
    for request in ("08 0000 0000", "0B", "0C", "11", "2B 0E 01 00"):
        assert says(view, request, station=None) == f"{int(request[:2], 16) | 0x80:02X} 01"


def test_what_cannot_be_read_is_not_written_before() -> None:
    view = WholeView(size=100)
    assert says(view, "17 0060 0010 0000 0001 02 BEEF") == "97 02"
    assert view.words[Kind.HOLDING_REGISTERS][0] == 0
    assert says(view, "15 12 06 0004 0000 0001 1111 06 0009 0000 0001 2222") == "95 02"
    assert view.files[4][0] == 0


@given(st.sampled_from([7, 8, 11, 12, 17, 20, 21, 22, 23, 24, 43]), st.binary(max_size=252))
def test_whatever_follows_the_answer_is_legal(function: int, rest: bytes) -> None:
    said = answer(bytes((function,)) + rest, WholeView(), True, Station())
    assert 1 < len(said) <= 253 and said[0] & 0x7F == function
    assert said[0] == function or said[1] in (1, 2, 3)


# ---------------------------------------------------------------------------------------------------------- rights


def test_writing_may_be_limited_to_addresses() -> None:
    """AX-343."""
    rights = Rights(coils=((0, 63),), holding=((1000, 1063), (5, 5)))
    allowed = ["05 003F FF00", "0F 0000 0040 08" + "00" * 8, "06 0005 0001", "10 03E8 0002 04 0000 0000", "16 0005 0000 0000",
               "17 0000 0001 0005 0001 02 0000", "03 0000 0001", "01 0000 0001"]  # fmt: skip
    denied = ["05 0040 FF00", "0F 003F 0002 01 00", "06 0004 0001", "10 0427 0002 04 0000 0000", "16 0006 0000 0000",
              "17 0005 0001 0004 0001 02 0000", "15 09 06 0003 0000 0001 1234"]  # fmt: skip
    assert {rights.refusal(bytes.fromhex(pdu)) for pdu in allowed} == {None}
    assert {rights.refusal(bytes.fromhex(pdu)) for pdu in denied} == {ADDRESS}
    files = Rights(coils=(), files=((3, 4),))
    for pdu, why in (("15 09 06 0003 0000 0001 1234", None), ("15 12 06 0004 0000 0001 1111 06 0005 0000 0001 2222", ADDRESS)):
        assert files.refusal(bytes.fromhex(pdu)) is why
    assert Rights(files=()).refusal(bytes.fromhex("15 09 06 0003 0000 0001 1234")) is ADDRESS and Rights(files=()).limited
    assert rights.limited and not Rights().limited and not Rights(write=False).limited


def test_who_may_not_read_gets_01() -> None:
    rights = Rights(read=False)
    reads = ("01 0000 0001", "03 0000 0001", "07", "17 0000 0001 0000 0001 02 0000", "18 0000")
    assert {rights.refusal(bytes.fromhex(pdu)) for pdu in reads} == {FUNCTION}
    assert rights.refusal(bytes.fromhex("06 0000 0001")) is None
