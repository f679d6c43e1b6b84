"""RK512, passive side: header, reaction and error numbers (SIMATIC CP 341 manual 09/2008; choices AX-053..055), by hand, byte by byte."""

import pytest

from hil_tests.lab.virtual.rk512_blocks import Blocks
from protocols.base.errors import DecodeError, EncodeError
from protocols.rk512.header import ErrorNumber, Flag, Header, decode_header, encode_reaction
from protocols.rk512.passive import Dialect, Event, Fetched, Passive, Refused, UnexpectedReaction, Written

OK = b"\x00\x00\x00\x00"


class Line:
    """The passive station with DB 5 (100 words, counting 00 01 02 ..), DB 10 (64 words, zero) and DB 11 (read only)."""

    def __init__(self, settings: Dialect | None = None) -> None:
        self.blocks = Blocks({5: 100, 10: 64, 11: 8}, locked=(11,))
        self.blocks.blocks[5][:] = bytes(range(200))
        self.passive = Passive(self.blocks, settings)

    def hears(self, text: str, data: bytes = b"") -> "Line":
        self.events: list[Event] = self.passive.telegram(bytes.fromhex(text) + data, 0)
        return self

    def says(self, expected: bytes | None) -> "Line":
        assert self.passive.take_output() == expected
        assert self.passive.take_output() is None
        return self

    def reports(self, *expected: Event) -> "Line":
        assert self.events == list(expected)
        return self

    def refuses(self, number: int, first: int = 0x00) -> None:
        """With this number, and nothing was written."""
        assert self.passive.take_output() == bytes((first, 0, 0, number))
        assert [type(event) for event in self.events] == [Refused]
        assert isinstance(self.events[0], Refused) and self.events[0].number == number and self.events[0].why
        assert not any(self.blocks.blocks[10]) and not any(self.blocks.blocks[11])


# ---- good telegrams
def test_send_of_two_words() -> None:
    line = Line().hears("00 00 41 44 0A 03 00 02 FF FF 12 34 56 78").says(OK).reports(Written(10, 3, b"\x12\x34\x56\x78"))
    assert line.blocks.blocks[10][6:10] == b"\x12\x34\x56\x78" and sum(line.blocks.blocks[10]) == 0x12 + 0x34 + 0x56 + 0x78


def test_fetch_of_seven_words() -> None:
    Line().hears("00 00 45 44 05 0A 00 07 FF FF").says(OK + bytes(range(20, 34))).reports(Fetched(5, 10, 7))


def test_a_header_full_of_10h() -> None:
    line = Line()
    line.blocks.blocks[16] = bytearray(range(100, 200))
    line.hears("00 00 45 44 10 10 00 10 FF FF").says(OK + bytes(range(132, 164))).reports(Fetched(16, 16, 16))


@pytest.mark.parametrize("words", [1, 63, 64])
def test_up_to_128_bytes_each_way(words: int) -> None:
    data = bytes(range(1, 2 * words + 1))
    line = Line().hears(f"00 00 41 44 0A 00 00 {words:02X} FF FF", data).says(OK)
    line.hears(f"00 00 45 44 0A 00 00 {words:02X} FF FF").says(OK + data)


def test_no_coordination_flag_whatever_is_in_byte_10() -> None:
    Line().hears("00 00 45 44 05 00 00 01 FF 0F").says(OK + b"\x00\x01")


# ---- refusals, one for each error number
@pytest.mark.parametrize(
    "telegram, number",
    [
        ("01 00 45 44 05 00 00 01 FF FF", 0x10),  # byte 1
        ("00 01 45 44 05 00 00 01 FF FF", 0x10),  # byte 2
        ("", 0x10),
        ("00 00 42 44 05 00 00 01 FF FF", 0x16),  # byte 3
        ("00 00 45 51 05 00 00 01 FF FF", 0x0C),  # byte 4: no such type
        ("00 00 45 58 05 00 00 01 FF FF", 0x12),  # extended data block
        ("00 00 4F 58 05 00 00 01 FF FF 00 00", 0x12),
        ("00 00 4F 44 0A 00 00 01 FF FF 00 00", 0x12),
        ("00 00 45 4D 00 10 00 20 FF FF", 0x12),  # flags
        ("00 00 41 4D 0A 00 00 01 FF FF 00 00", 0x12),
        ("00 00 45 44 63 00 00 01 FF FF", 0x14),  # no DB 99
        ("00 00 45 44 05 63 00 02 FF FF", 0x14),  # DB 5 ends before
        ("00 00 41 44 0A 3F 00 02 FF FF 01 02 03 04", 0x14),
        ("00 00 41 44 0B 00 00 01 FF FF 01 02", 0x0A),  # may not be written
        ("00 00 45 44 05 00 00 00 FF FF", 0x34),  # nothing asked
        ("00 00 45 44 05 00 00 01 FF FF 00", 0x34),  # FETCH with data
        ("00 00 41 44 0A 00 00 01 FF FF", 0x34),  # data missing
        ("00 00 41 44 0A 00 00 01 FF FF 01", 0x34),
        ("00 00 41 44 0A 00 00 01 FF FF 01 02 03", 0x34),
        ("00 00 41 44 0A 00 00 02 FF", 0x34),  # header too short
        ("00 00 45", 0x34),
        ("00 00 45 44 05 00 01 01 FF FF", 0x14),  # byte 7 counts: 257 words are more than DB 5 has
        ("00 00 45 44 05 00 08 01 FF FF", 0x10),  # 4098 bytes
        ("00 00 41 44 0A 00 00 80 FF FF", 0x34),
        ("00 00 45 44 05 00 00 01 06 04", 0x32),  # coordination flag 6.4
        ("00 00 41 44 0A 00 00 01 06 14 01 02", 0x32),
    ],
)
def test_refused(telegram: str, number: int) -> None:
    Line().hears(telegram).refuses(number)


@pytest.mark.parametrize("telegram", ["FF 00 41 44 DE AD BE EF", "FF 00 45 44", "FF"])
def test_a_follow_on_telegram_without_a_first_one(telegram: str) -> None:
    Line().hears(telegram).refuses(0x36, first=0xFF)
    Line(Dialect(follow_on_reaction=False)).hears(telegram).refuses(0x36)


@pytest.mark.parametrize("telegram", ["00 00 00 00", "00 00 00 14", "FF 00 00 00", "00 00 00 00 12 34", "00 00 00 44 05 00 00 01 FF FF"])
def test_a_reaction_is_never_answered(telegram: str) -> None:
    Line().hears(telegram).says(None).reports(UnexpectedReaction(bytes.fromhex(telegram)[:10]))


def test_after_a_refusal_the_next_telegram_is_served() -> None:
    Line().hears("00 00 45").says(b"\x00\x00\x00\x34").hears("00 00 45 44 05 00 00 01 FF FF").says(OK + b"\x00\x01")


def test_a_reaction_that_nobody_took_is_replaced() -> None:
    Line().hears("00 00 45 44 05 00 00 01 FF FF").hears("00 00 45 44 05 01 00 01 FF FF").says(OK + b"\x02\x03")


# ---- settings
def test_without_reaction_telegrams() -> None:
    line = Line(Dialect(reaction=False)).hears("00 00 41 44 0A 00 00 01 FF FF 12 34").says(None)
    line.reports(Written(10, 0, b"\x12\x34")).hears("00 00 45").says(None)


def test_a_partner_that_counts_bytes() -> None:
    line = Line(Dialect(db_address_unit="byte")).hears("00 00 45 44 05 14 00 01 FF FF").says(OK + bytes((20, 21)))
    line.reports(Fetched(5, 10, 1)).hears("00 00 45 44 05 15 00 01 FF FF").refuses(0x14)


def test_the_number_for_an_unknown_block_is_a_setting() -> None:
    Line(Dialect(unknown_block=0x0A)).hears("00 00 45 44 63 00 00 01 FF FF").refuses(0x0A)


def test_coordination_flags_can_be_ignored() -> None:
    Line(Dialect(coordination_flag="ignore")).hears("00 00 45 44 05 00 00 01 06 04").says(OK + b"\x00\x01")


# ---- the codec
def test_header_round_trip() -> None:
    for header in (
        Header(0x45, 0x44, 5, 10, 7),
        Header(0x41, 0x44, 255, 255, 64, Flag(6, 4, 1)),
        Header(0x45, 0x4D, 0, 16, 32, Flag(6, 4)),
    ):
        assert decode_header(header.encode()) == header
    assert Header(0x45, 0x4D, 0, 16, 32, Flag(6, 4)).encode() == bytes.fromhex("00 00 45 4D 00 10 00 20 06 04")


@pytest.mark.parametrize(
    "header",
    [
        Header(0x45, 0x44, 256, 0, 1),
        Header(0x45, 0x44, 5, -1, 1),
        Header(0x45, 0x44, 5, 0, 65536),
        Header(0x45, 0x44, 5, 0, 1, Flag(255, 0)),
        Header(0x45, 0x44, 5, 0, 1, Flag(0, 8)),
        Header(0x45, 0x44, 5, 0, 1, Flag(0, 0, 5)),
    ],
)
def test_a_header_beyond_its_ranges_is_our_mistake(header: Header) -> None:
    with pytest.raises(EncodeError):
        header.encode()


def test_a_header_too_short_is_a_decode_error() -> None:
    with pytest.raises(DecodeError, match="10 bytes expected, 9 received"):
        decode_header(bytes(9))


def test_error_numbers_of_other_stations_are_passed_on() -> None:
    assert encode_reaction(ErrorNumber(0x99)) == b"\x00\x00\x00\x99" and ErrorNumber(0x99).name == "NUMBER_99"
    with pytest.raises(ValueError):
        ErrorNumber(256)
