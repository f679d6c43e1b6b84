"""The active RK512 station by hand, byte by byte: telegrams, each of its own errors, order of jobs (serial-protocols 2.1 to 2.6)."""

import pytest

from protocols.base.errors import EncodeError
from protocols.base.machine import Ns, ms
from protocols.rk512.active import MOST_JOBS, Active, Denied, Done, Event, Failed, Trouble, Unasked
from protocols.rk512.dialects import DIALECTS, STANDARD, Dialect
from protocols.rk512.header import Flag, Kind

OK, OK_NEXT = b"\x00\x00\x00\x00", b"\xff\x00\x00\x00"
DATA = bytes(value * 11 % 256 for value in range(4096))


class Line:
    """Hands telegrams to and fro; an exception is a failed assertion."""

    def __init__(self, dialect: Dialect = STANDARD, baud: int = 9600) -> None:
        self.active, self.now = Active(dialect, baud), 0
        self.events: list[Event] = []

    def says(self, telegram: bytes | None) -> "Line":
        found = self.active.take_output()
        assert found == telegram, f"{found and found.hex(' ')}"
        return self

    def acknowledged(self) -> "Line":
        return self._note(lambda: self.active.acknowledged(self.now))

    def given_up(self) -> "Line":
        return self._note(lambda: self.active.unsent(self.now))

    def hears(self, data: bytes) -> "Line":
        return self._note(lambda: self.active.reaction(data, self.now))

    def at(self, now: Ns) -> "Line":
        self.now = now
        return self._note(lambda: self.active.wake(now))

    def reports(self, *expected: Event) -> "Line":
        events, self.events = self.events, []
        assert events == list(expected)
        return self

    def _note(self, action: object) -> "Line":
        assert callable(action)
        self.events += action()
        return self


def head(text: str) -> bytes:
    return bytes.fromhex(text)


def asked() -> Line:
    """FETCH DB 5 DW 10, 7 words, acknowledged."""
    line = Line()
    assert line.active.fetch(10, 7, 5) == 1
    return line.says(head("00 00 45 44 05 0A 00 07 FF FF")).acknowledged().reports()


def given() -> Line:
    line = Line()
    line.active.send(1, DATA[:4], 5)
    return line.says(head("00 00 41 44 05 01 00 02 FF FF") + DATA[:4]).acknowledged().reports()


# ---- good jobs
def test_fetch() -> None:
    asked().hears(OK + DATA[:14]).reports(Done(1, DATA[:14])).says(None)


def test_send() -> None:
    assert given().active.name == "rk512"
    given().hears(OK).reports(Done(1, b"")).says(None)


@pytest.mark.parametrize("total", [130, 256, 258, 512, 4096])
def test_a_long_send(total: int) -> None:
    line = Line()
    line.active.send(0, DATA[:total], 10)
    line.says(head(f"00 00 41 44 0A 00 {total // 2:04X} FF FF") + DATA[:128]).acknowledged().reports()
    for at in range(128, total, 128):
        line.says(None).hears(OK if at == 128 else OK_NEXT).reports()
        line.says(head("FF 00 41 44") + DATA[at : min(at + 128, total)]).acknowledged().reports()
    line.hears(OK_NEXT).reports(Done(1, b"")).says(None)


@pytest.mark.parametrize("total", [130, 256, 258, 512, 4096])
@pytest.mark.parametrize("first", [OK, OK_NEXT])
def test_a_long_fetch(total: int, first: bytes) -> None:
    line = Line()
    line.active.fetch(0, total // 2, 10)
    line.says(head(f"00 00 45 44 0A 00 {total // 2:04X} FF FF")).acknowledged()
    for at in range(0, total - 128, 128):
        line.hears((OK if at == 0 else first) + DATA[at : at + 128]).reports().says(head("FF 00 45 44")).acknowledged()
    line.hears(first + DATA[(total - 1) // 128 * 128 : total]).reports(Done(1, DATA[:total]))


@pytest.mark.parametrize("kind, amount, unit", [("E", 3, 1), ("A", 3, 1), ("M", 32, 1), ("T", 2, 2), ("Z", 2, 2)])
def test_fetch_of_other_types(kind: str, amount: int, unit: int) -> None:
    line = Line()
    line.active.fetch(0x110, amount, kind=Kind(ord(kind)), flag=Flag(6, 4))
    line.says(head(f"00 00 45 {ord(kind):02X} 01 10 00 {amount:02X} 06 04")).acknowledged()
    line.hears(OK + DATA[: amount * unit]).reports(Done(1, DATA[: amount * unit]))


def test_extended_blocks() -> None:
    line = Line()
    line.active.fetch(2, 1, 7, Kind.EXTENDED)
    line.says(head("00 00 45 58 07 02 00 01 FF FF")).acknowledged().hears(OK + b"AB").reports(Done(1, b"AB"))
    line.active.send(2, b"CD", 7, Kind.EXTENDED, Flag(1, 2, 3))
    line.says(head("00 00 4F 58 07 02 00 01 01 32") + b"CD")


def test_send_to_flags_where_the_dialect_has_it() -> None:
    line = Line(Dialect(send_kinds=b"DM"))
    line.active.send(0x102, b"ABC", kind=Kind.FLAGS)
    line.says(head("00 00 41 4D 01 02 00 03 FF FF") + b"ABC")


def test_system_350_counts_bytes() -> None:
    line = Line(DIALECTS["bosch-system350-rk512"])
    line.active.send(64, b"AB", 5)
    line.says(head("00 00 41 44 05 80 00 01 FF FF") + b"AB")


def test_without_reactions_the_acknowledgement_ends_the_job() -> None:
    line = Line(DIALECTS["bosch-system350-3964r"])
    line.active.send(0, b"AB", 5)
    line.active.send(0, b"CD", 5)
    line.says(head("00 00 41 44 05 00 00 01 FF FF") + b"AB").acknowledged().reports(Done(1, b""))
    line.says(head("00 00 41 44 05 00 00 01 FF FF") + b"CD").acknowledged().reports(Done(2, b""))
    with pytest.raises(EncodeError, match="no reaction"):
        line.active.fetch(0, 1, 5)


def test_one_job_after_another() -> None:
    line = asked()
    line.active.fetch(0, 1, 6)
    assert line.says(None).active.pending == 2 and line.active.awaiting
    line.hears(OK + DATA[:14]).reports(Done(1, DATA[:14])).says(head("00 00 45 44 06 00 00 01 FF FF"))


# ---- each of its own errors
@pytest.mark.parametrize(
    "reaction, why",
    [
        (b"", Trouble.TOO_SHORT),
        (b"\x00\x00\x00", Trouble.TOO_SHORT),
        (b"\x01\x00\x00\x00" + DATA[:14], Trouble.FIRST_BYTE),
        (b"\x00\x01\x00\x00" + DATA[:14], Trouble.HEADER),
        (b"\x00\x00\x01\x00" + DATA[:14], Trouble.HEADER),
        (OK + DATA[:13], Trouble.TOO_LITTLE_DATA),
        (OK, Trouble.TOO_LITTLE_DATA),
        (OK + DATA[:15], Trouble.TOO_MUCH_DATA),
        (b"\x00\x00\x00\x14\x00", Trouble.TOO_MUCH_DATA),
    ],
)
def test_a_reaction_that_is_none(reaction: bytes, why: Trouble) -> None:
    asked().hears(reaction).reports(Failed(1, why)).hears(OK + DATA[:14]).reports(Unasked(OK + DATA[:6]))


def test_data_after_a_send() -> None:
    given().hears(OK + b"A").reports(Failed(1, Trouble.DATA_AFTER_SEND))


@pytest.mark.parametrize("number", [0x0A, 0x14, 0x32, 0x99])
def test_an_error_number_of_the_partner_is_passed_on(number: int) -> None:
    asked().hears(bytes((0, 0, 0, number))).reports(Denied(1, number))


def test_an_error_number_inside_a_long_job_ends_it() -> None:
    line = Line()
    line.active.send(0, DATA[:256], 10)
    line.says(head("00 00 41 44 0A 00 00 80 FF FF") + DATA[:128]).acknowledged().hears(b"\x00\x00\x00\x0a").reports(Denied(1, 0x0A)).says(
        None
    )


@pytest.mark.parametrize("baud, wait", [(300, 10), (600, 7), (1200, 5), (38400, 3)])
def test_no_reaction_in_time(baud: int, wait: int) -> None:
    line = Line(baud=baud)
    line.active.fetch(0, 1, 5)
    line.says(head("00 00 45 44 05 00 00 01 FF FF"))
    line.now = ms(40)
    line.acknowledged()
    assert line.active.deadline() == ms(40 + 1000 * wait)
    line.at(ms(40 + 1000 * wait) - 1).reports().at(ms(40 + 1000 * wait)).reports(Failed(1, Trouble.NO_REACTION))


def test_a_command_instead_of_the_reaction_where_nesting_is_forbidden() -> None:
    line = asked()
    assert line.active.interrupted(0) == [Failed(1, Trouble.COMMAND_INSTEAD)] and line.active.interrupted(0) == []


def test_a_reaction_nobody_asked_for() -> None:
    Line().hears(OK).reports(Unasked(OK))


def test_the_link_gives_up() -> None:
    line = Line()
    line.active.send(0, b"AB", 5)
    line.active.send(2, b"CD", 5)
    line.active.take_output()
    line.given_up().reports(Failed(1, Trouble.LINK)).says(head("00 00 41 44 05 02 00 01 FF FF") + b"CD")


def test_a_reaction_before_the_acknowledgement_of_a_short_job_is_not_taken() -> None:
    """The partner answers a command whose acknowledgement got lost; the repeat is answered again."""
    line = Line()
    line.active.fetch(0, 1, 5)
    line.says(head("00 00 45 44 05 00 00 01 FF FF")).hears(OK + b"AB").reports(Unasked(OK + b"AB"))
    line.acknowledged().hears(OK + b"AB").reports(Done(1, b"AB"))


def test_a_reaction_before_the_acknowledgement_inside_a_long_job_ends_it() -> None:
    """Follow-on telegrams carry no number: which piece the next reaction would hold cannot be known."""
    line = Line()
    line.active.fetch(0, 128, 5)
    line.active.fetch(0, 1, 6)
    line.says(head("00 00 45 44 05 00 00 80 FF FF")).acknowledged().hears(OK + DATA[:128]).says(head("FF 00 45 44"))
    line.hears(OK_NEXT + DATA[:128]).reports(Failed(1, Trouble.EARLY)).says(None)  # the link still has that telegram
    line.hears(OK).reports(Unasked(OK))
    line.acknowledged().reports().says(head("00 00 45 44 06 00 00 01 FF FF")).given_up().reports(Failed(2, Trouble.LINK))


def test_the_link_gives_up_a_telegram_whose_job_has_ended() -> None:
    line = Line()
    line.active.fetch(0, 128, 5)
    line.says(head("00 00 45 44 05 00 00 80 FF FF")).acknowledged().hears(OK + DATA[:128]).says(head("FF 00 45 44"))
    line.hears(OK_NEXT + DATA[:128]).reports(Failed(1, Trouble.EARLY)).given_up().reports().says(None)


def test_a_lost_port_ends_every_job() -> None:
    line = asked()
    line.active.fetch(0, 1, 6)
    assert line.active.lost() == [Failed(1, Trouble.LOST), Failed(2, Trouble.LOST)] and line.says(None).active.pending == 0


def test_nothing_grows_while_the_partner_is_away() -> None:
    line = Line()
    for _ in range(MOST_JOBS + 3):
        line.active.fetch(0, 1, 5)
    assert line.active.pending == MOST_JOBS + 1
    line.at(1).reports(Failed(2, Trouble.CROWDED), Failed(3, Trouble.CROWDED))


# ---- what cannot be asked
@pytest.mark.parametrize(
    "job, words",
    [
        (lambda active: active.send(0, b"A", 5), "1 bytes"),
        (lambda active: active.send(0, b"", 5), "amount = 0 bytes, range 2..4096"),
        (lambda active: active.fetch(0, 0, 5), "amount = 0"),
        (lambda active: active.fetch(0, 2049, 5), "amount = 4098 bytes, range 2..4096"),
        (lambda active: active.fetch(256, 1, 5), "word = 256, range 0..255"),
        (lambda active: active.fetch(-1, 1, 5), "word = -1"),
        (lambda active: active.fetch(0, 1, 256), "db = 256"),
        (lambda active: active.fetch(65536, 1, kind=Kind.FLAGS), "address = 65536"),
        (lambda active: active.send(0, b"A", kind=Kind.FLAGS), "SEND to M"),
    ],
)
def test_a_job_beyond_its_ranges_is_our_mistake(job: object, words: str) -> None:
    active = Active()
    assert callable(job)
    with pytest.raises(EncodeError, match=words):
        job(active)
    assert active.pending == 0 and active.take_output() is None
