"""RK512 jobs of more than 128 bytes, other data types, coordination flags, dialects: the passive station (serial-protocols 2.3 to 2.6)."""

from dataclasses import replace

import pytest

from hil_tests.lab.virtual.rk512_blocks import Areas, Blocks
from protocols.base.machine import Ns, ms
from protocols.rk512.dialects import DIALECTS, STANDARD, Dialect, dialect_of
from protocols.rk512.header import ErrorNumber, Flag, Kind
from protocols.rk512.passive import Continued, Event, Fetched, Passive, Refused, Written

OK, OK_NEXT = b"\x00\x00\x00\x00", b"\xff\x00\x00\x00"
DATA = bytes(value * 7 % 256 for value in range(512))


class Station:
    """The passive station with DB 10 (256 words), DB 11 (read only), and every other area."""

    def __init__(self, dialect: Dialect = STANDARD) -> None:
        self.blocks = Blocks({10: 256, 11: 256}, locked=(11,))
        self.areas = Areas()
        self.passive = Passive(self.blocks, dialect, self.areas)
        self.now: Ns = 0

    def hears(self, head: str, data: bytes = b"") -> "Station":
        self.events: list[Event] = self.passive.telegram(bytes.fromhex(head) + data, self.now)
        return self

    def says(self, reaction: bytes, *events: Event) -> "Station":
        assert self.passive.take_output() == reaction
        assert not events or self.events == list(events)
        return self

    def refuses(self, number: int, first: int = 0) -> "Station":
        assert isinstance(self.events[0], Refused) and self.events[0].number == number
        return self.says(bytes((first, 0, 0, number)))

    @property
    def written(self) -> bytes:
        return bytes(self.blocks.blocks[10])


# ---- SEND
@pytest.mark.parametrize("total", [130, 254, 256, 258, 510, 512])
def test_a_long_send_is_written_whole_with_its_last_telegram(total: int) -> None:
    station = Station().hears(f"00 00 41 44 0A 00 {total // 2:04X} FF FF", DATA[:128]).says(OK, Continued(total - 128))
    for at in range(128, total, 128):
        assert not any(station.written)
        station.hears("FF 00 41 44", DATA[at : min(at + 128, total)]).says(OK_NEXT)
    assert station.events == [Written(10, 0, DATA[:total])] and station.written[:total] == DATA[:total]


def test_a_long_send_to_a_block_that_is_not_there_is_refused_at_once() -> None:
    Station().hears("00 00 41 44 63 00 00 80 FF FF", DATA[:128]).refuses(0x14)
    Station().hears("00 00 41 44 0A C8 00 80 FF FF", DATA[:128]).refuses(0x14)


def test_a_long_send_to_a_block_that_may_not_be_written_changes_nothing() -> None:
    station = Station().hears("00 00 41 44 0B 00 00 80 FF FF", DATA[:128]).says(OK)
    station.hears("FF 00 41 44", DATA[128:256]).refuses(0x0A, 0xFF)
    assert not any(station.blocks.blocks[11])


@pytest.mark.parametrize("piece", [b"", DATA[:127], DATA[:129], DATA[:1]])
def test_a_follow_on_with_another_amount_than_is_missing(piece: bytes) -> None:
    station = Station().hears("00 00 41 44 0A 00 00 80 FF FF", DATA[:128]).says(OK)
    station.hears("FF 00 41 44", piece).refuses(0x34, 0xFF)
    station.hears("FF 00 41 44", DATA[:128]).refuses(0x36, 0xFF)  # the job has ended
    assert not any(station.written)


@pytest.mark.parametrize(
    "telegram, number",
    [("FF 00 45 44", 0x36), ("FF 00 41 58", 0x36), ("FF 01 41 44", 0x10), ("FF 00 41", 0x34), ("FF", 0x34)],
)
def test_a_follow_on_that_is_not_the_next_one(telegram: str, number: int) -> None:
    station = Station().hears("00 00 41 44 0A 00 00 80 FF FF", DATA[:128]).says(OK)
    station.hears(telegram).refuses(number, 0xFF)
    assert not any(station.written)


def test_a_first_telegram_instead_of_a_follow_on_is_refused_once() -> None:
    station = Station().hears("00 00 41 44 0A 00 00 80 FF FF", DATA[:128]).says(OK)
    station.hears("00 00 45 44 0A 00 00 01 FF FF").refuses(0x36).hears("00 00 45 44 0A 00 00 01 FF FF").says(OK + b"\x00\x00")


def test_a_job_left_open_is_forgotten_after_the_longest_reaction_time() -> None:
    station = Station().hears("00 00 41 44 0A 00 00 80 FF FF", DATA[:128]).says(OK)
    station.now = ms(20_000) + 1
    station.hears("00 00 45 44 0A 00 00 01 FF FF").says(OK + b"\x00\x00")


def test_a_lost_port_ends_an_open_job() -> None:
    station = Station().hears("00 00 41 44 0A 00 00 80 FF FF", DATA[:128])
    station.passive.lost()
    assert station.passive.take_output() is None
    station.hears("FF 00 41 44", DATA[:128]).refuses(0x36, 0xFF)


# ---- FETCH
@pytest.mark.parametrize("total", [130, 256, 258, 512])
def test_a_long_fetch_delivers_what_was_there_when_it_began(total: int) -> None:
    station = Station()
    station.blocks.blocks[10][:] = DATA
    station.hears(f"00 00 45 44 0A 00 {total // 2:04X} FF FF").says(OK + DATA[:128], Fetched(10, 0, total // 2))
    station.blocks.blocks[10][:] = bytes(512)
    for at in range(128, total, 128):
        piece = DATA[at : min(at + 128, total)]
        station.hears("FF 00 45 44").says(OK_NEXT + piece, Continued(max(0, total - at - 128)))
    station.hears("FF 00 45 44").refuses(0x36, 0xFF)


def test_a_wish_for_the_next_piece_carries_no_data() -> None:
    station = Station().hears("00 00 45 44 0A 00 00 80 FF FF")
    station.passive.take_output()
    station.hears("FF 00 45 44 00").refuses(0x34, 0xFF)


def test_follow_on_reactions_of_system_350_begin_with_00() -> None:
    station = Station(Dialect(follow_on_reaction=False)).hears("00 00 41 44 0A 00 00 41 FF FF", DATA[:128]).says(OK)
    station.hears("FF 00 41 44", DATA[128:130]).says(OK)


# ---- types
@pytest.mark.parametrize("kind, unit", [("X", 2), ("E", 1), ("A", 1), ("M", 1), ("T", 2), ("Z", 2)])
def test_fetch_of_every_type(kind: str, unit: int) -> None:
    station = Station().hears(f"00 00 45 {ord(kind):02X} 01 10 00 04 FF FF")
    place = (1, 0x10) if kind == "X" else (0, 0x110)
    station.says(OK + Areas.content(ord(kind), *place, 4 * unit), Fetched(*place, 4, ord(kind)))


def test_flags_of_the_manuals_example() -> None:
    """FETCH of 32 flag bytes from MB 16 on, coordination flag 6.4: served where flags are ignored."""
    station = Station(Dialect(coordination_flag="ignore")).hears("00 00 45 4D 00 10 00 20 06 04")
    station.says(OK + Areas.content(0x4D, 0, 16, 32))


@pytest.mark.parametrize("pair", ["4F 44", "4F 58"])
def test_send_to_an_extended_block_both_ways_of_writing_it(pair: str) -> None:
    station = Station().hears(f"00 00 {pair} 05 02 00 01 FF FF", b"\x12\x34").says(OK, Written(5, 2, b"\x12\x34", 0x58))
    assert station.areas.written == [(Kind.EXTENDED, 5, 2, b"\x12\x34")]


def test_a_long_send_to_another_area() -> None:
    station = Station().hears("00 00 4F 44 05 00 00 41 FF FF", DATA[:128]).says(OK).hears("FF 00 4F 44", DATA[128:130]).says(OK_NEXT)
    assert station.areas.written == [(Kind.EXTENDED, 5, 0, DATA[:130])]


@pytest.mark.parametrize("telegram", ["41 58 05 02 00 01 FF FF 00 00", "4F 4D 00 02 00 01 FF FF 00", "41 4D 00 02 00 01 FF FF 00"])
def test_a_send_that_no_station_has(telegram: str) -> None:
    Station().hears(f"00 00 {telegram}").refuses(0x12)


def test_a_send_to_flags_where_the_dialect_has_it() -> None:
    station = Station(Dialect(send_kinds=b"DXEAMTZ")).hears("00 00 41 4D 01 02 00 03 FF FF", b"ABC").says(OK)
    assert station.areas.written == [(Kind.FLAGS, 0, 0x102, b"ABC")]


def test_an_area_may_refuse() -> None:
    station = Station()
    station.areas.refuse = ErrorNumber.NOT_ALLOWED
    station.hears("00 00 45 4D 00 10 00 20 FF FF").refuses(0x0A).hears("00 00 4F 44 05 02 00 01 FF FF", b"\x12\x34").refuses(0x0A)


@pytest.mark.parametrize("kind", b"PBS")
def test_types_of_older_stations(kind: int) -> None:
    Station().hears(f"00 00 45 {kind:02X} 00 10 00 20 FF FF").refuses(0x12)


def test_a_station_without_areas() -> None:
    passive = Passive(Blocks({}))
    for telegram in ("00 00 45 4D 00 10 00 20 FF FF", "00 00 4F 44 05 02 00 01 FF FF 12 34"):
        passive.telegram(bytes.fromhex(telegram), 0)
        assert passive.take_output() == b"\x00\x00\x00\x12"


# ---- coordination flags
@pytest.mark.parametrize("job, data", [("41 44 0A 00 00 01 06 04", b"\x12\x34"), ("45 44 0A 00 00 01 06 04", b"")])
def test_a_flag_is_set_when_a_job_was_taken_and_locks_until_the_program_resets_it(job: str, data: bytes) -> None:
    station = Station(Dialect(coordination_flag="serve")).hears(f"00 00 {job}", data)
    assert station.passive.take_output() is not None and isinstance(station.events[0], Written | Fetched)
    station.hears("00 00 41 44 0A 00 00 01 06 04", b"\xaa\xbb").refuses(0x32).hears("00 00 45 44 0A 00 00 01 06 04").refuses(0x32)
    assert b"\xaa\xbb" not in station.written
    station.hears("00 00 45 44 0A 00 00 01 06 05").says(OK + station.written[:2])  # another bit
    station.hears("00 00 45 44 0A 00 00 01 FF FF").says(OK + station.written[:2])  # no flag
    station.passive.flags.reset(Flag(6, 4))
    station.hears("00 00 41 44 0A 00 00 01 06 04", b"\xaa\xbb").says(OK)


def test_a_refused_job_sets_no_flag() -> None:
    station = Station(Dialect(coordination_flag="serve")).hears("00 00 41 44 63 00 00 01 06 04", b"\x12\x34").refuses(0x14)
    station.hears("00 00 41 44 0A 00 00 01 06 04", b"\x12\x34").says(OK)


def test_a_long_send_sets_its_flag_with_its_last_telegram() -> None:
    station = Station(Dialect(coordination_flag="serve")).hears("00 00 41 44 0A 00 00 41 06 04", DATA[:128]).says(OK)
    assert not station.passive.flags.set
    station.hears("FF 00 41 44", DATA[128:130]).says(OK_NEXT)
    assert station.passive.flags.set == {Flag(6, 4)}


# ---- dialects
def test_stopped() -> None:
    station = Station()
    station.passive.stopped = True
    station.hears("00 00 45 44 0A 00 00 01 FF FF").refuses(0x2A)


def test_wago_answers_10h_to_more_than_62_words() -> None:
    Station(DIALECTS["wago"]).hears("00 00 45 44 0A 00 00 3F FF FF").refuses(0x10).hears("00 00 45 44 0A 00 00 3E FF FF").says(
        OK + bytes(124)
    )


def test_system_350_sends_dw_64_as_80h() -> None:
    station = Station(dialect_of("bosch-system350-rk512")).hears("00 00 41 44 0A 80 00 01 FF FF", b"\x12\x34").says(OK)
    assert station.written[128:130] == b"\x12\x34"
    station.hears("00 00 41 44 63 80 00 01 FF FF", b"\x12\x34").refuses(0x0A)


def test_system_350_raw_has_the_header_and_no_reaction() -> None:
    station = Station(dialect_of("bosch-system350-3964r-tcp")).hears("00 00 41 44 0A 80 00 01 FF FF", b"\x12\x34")
    assert station.passive.take_output() is None and station.written[128:130] == b"\x12\x34"


def test_every_dialect_has_its_link_profile_and_a_source() -> None:
    from protocols.p3964r.profiles import PROFILES

    assert set(DIALECTS) <= set(PROFILES) and all(each.source for each in DIALECTS.values())
    assert dialect_of("rho3") == STANDARD


@pytest.mark.parametrize("baud, wait", [(300, 10), (600, 7), (1200, 5), (9600, 5), (19200, 5), (38400, 3), (115200, 3)])
def test_waits_for_the_reaction_by_speed(baud: int, wait: int) -> None:
    assert STANDARD.waits(baud) == ms(1000 * wait) and replace(STANDARD, reaction_wait=ms(20)).waits(baud) == ms(20)
