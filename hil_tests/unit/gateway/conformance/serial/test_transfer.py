"""send and fetch: number types, addresses, telegrams, refusals in words."""

import re
from collections.abc import Callable

import pytest

from gateway.conformance.serial.partners import Station, make
from gateway.links.serial.tool_wire import VirtualWire
from gateway.tools.line.client import MOST_CONFLICTS, Client, Refused
from gateway.tools.line.transfer import BadInput, decoded, encoded, kinds, place, words_needed
from protocols.base.machine import Ns
from protocols.p3964r.characters import check_of, wire_block
from protocols.p3964r.profiles import RHO3, Priority

CHAR = 11_000_000_000 // 9600


def client(partner: str = "good", priority: Priority = Priority.LOW) -> tuple[Client, Station]:
    station = make(partner, RHO3, priority)
    return Client(VirtualWire(station, CHAR), RHO3, Priority.HIGH), station


def test_what_is_sent_is_what_is_fetched() -> None:
    line, station = client()
    data = encoded(kinds("KF,KH,KG"), ["1200", "0A1F", "1200.5"])
    assert data.hex() == "04b00a1f0b4b0800"  # users.md 1: KG of 1200.5
    assert line.send(10, 2, data) == 1
    assert station.blocks.content[10][4:12] == data
    values = decoded(kinds("KF,KH,KG"), 10, 2, line.fetch(10, 2, words_needed(kinds("KF,KH,KG"), 3)))
    assert [(one.address, one.text) for one in values] == [("DB10.DW2", "1200"), ("DB10.DW3", "0A1F"), ("DB10.DD4", "1200.5")]


def test_more_than_128_bytes_are_several_telegrams() -> None:
    line, station = client()
    data = bytes(range(200))
    assert line.send(11, 0, data) == 2
    assert station.blocks.content[11][:200] == data
    assert line.fetch(11, 0, 100) == data


@pytest.mark.parametrize(
    "partner, words",
    [
        ("silent", "no answer to STX within QVZ/ADT 550 ms (6 attempts): partner off, cable"),
        ("includes-stx", "the block refused (NAK) (6 attempts): block check, parity, ZVZ/CDT"),
        ("raw", "no reaction telegram within 5 s: does the partner speak RK512"),
    ],
)
def test_what_went_wrong_is_reported_in_words(partner: str, words: str) -> None:
    line, _ = client(partner)
    with pytest.raises(Refused) as fault:
        line.fetch(10, 0, 1)
    assert words in str(fault.value)


class Scripted(Station):
    """A foreign partner in one rule: what was heard last -> what is said to it; QVZ and ZVZ play no part."""

    def __init__(self, rule: Callable[[bytes], bytes | None]) -> None:
        super().__init__(RHO3, Priority.HIGH)
        self._rule, self._heard, self._say = rule, b"", b""

    def receive(self, data: bytes, now: Ns) -> list[object]:
        self._heard += data
        answer = self._rule(self._heard)
        if answer is not None:
            self._say, self._heard = self._say + answer, b""
        return []

    def sent(self, now: Ns) -> list[object]:
        return []

    def take_output(self) -> bytes:
        said, self._say = self._say, b""
        return said

    def deadline(self) -> Ns | None:
        return None


COMMAND = b"\x00\x00ED\x0b\x00\x00\x01\xff\xff\x10\x03"
WIRE = COMMAND + bytes((check_of(COMMAND),))
BLOCK = re.compile(rb"\x00\x00ED.{6}\x10\x03.", re.DOTALL)


def scripted(*steps: tuple[bytes, bytes]) -> Callable[[bytes], bytes | None]:
    """Answers in their order, each when what was heard ends so; b"" is any whole FETCH."""
    left = list(steps)

    def rule(heard: bytes) -> bytes | None:
        if left and (BLOCK.search(heard) if left[0][0] == b"" else heard.endswith(left[0][0])):
            return left.pop(0)[1]
        return None

    return rule


def refused(partner: Station) -> str:
    with pytest.raises(Refused) as fault:
        Client(VirtualWire(partner, CHAR), RHO3, Priority.LOW).fetch(10, 0, 1)
    return str(fault.value)


def test_a_partner_that_always_has_a_job_of_its_own_does_not_hold_a_tool_for_ever() -> None:
    """With priority it may send again and again; its commands are no answer to ours."""
    rounds = 3 * MOST_CONFLICTS
    partner = Scripted(scripted(*[(b"\x02", b"\x02"), (b"\x10", WIRE), (b"\x10", b"")] * rounds))
    assert refused(partner).startswith(f"the partner sent {MOST_CONFLICTS} blocks of its own and left no room for our job")


def test_a_command_or_a_repeated_reaction_is_not_taken_for_the_answer() -> None:
    stale, right = (wire_block(bytes(4) + data) for data in (b"\x99\x99", b"\x12\x34"))
    for before in (WIRE, stale):
        steps = [(b"\x02", b"\x02"), (b"\x10", before), (b"\x10\x02", b"\x10"), (b"", b"\x10\x02"), (b"\x10", right)]
        line = Client(VirtualWire(Scripted(scripted(*steps)), CHAR), RHO3, Priority.LOW)
        assert line.fetch(10, 0, 1) == b"\x12\x34"


@pytest.mark.parametrize("char", [CHAR, 1000])
def test_a_reaction_somebody_left_untaken_is_not_the_answer_to_the_next_command(char: Ns) -> None:
    """A partner without priority keeps it, gives way to our command and sends it then: every later tool had got the one before."""
    station = make("good", RHO3, Priority.LOW)
    station.blocks.content[10][0:4] = b"\x12\x34\x56\x78"
    wire = VirtualWire(station, char)

    def left(reaction: bytes) -> None:
        def kept(now: Ns) -> None:
            station.link.send(reaction, now)

        wire.act(kept)

    for old in (bytes(4) + b"\x99\x99", bytes(4)):
        left(old)
        assert Client(wire, RHO3, Priority.HIGH).fetch(10, 0, 1) == b"\x12\x34"
    left(bytes(4) + b"\x99\x99")
    assert Client(wire, RHO3, Priority.HIGH).send(10, 1, b"\x00\x01") == 1


@pytest.mark.parametrize("old", [bytes(4), bytes(4) + b"\x99" * 4])
def test_a_reaction_kept_since_before_the_tool_was_there_is_passed_over_where_it_does_not_fit(old: bytes) -> None:
    """The partner's STX came before the port was opened, so nothing tells that its block is older; ours follows."""
    right = wire_block(bytes(4) + b"\x12\x34")
    steps = [(b"\x02", b"\x10"), (b"", b"\x10\x02"), (b"\x10", wire_block(old)), (b"\x10", b"\x02"), (b"\x10", right)]
    line = Client(VirtualWire(Scripted(scripted(*steps)), CHAR), RHO3, Priority.HIGH)
    found: bytes | str
    try:
        found = line.fetch(10, 0, 1)
    except Refused as fault:
        found = str(fault)
    assert found == b"\x12\x34"


def test_a_reaction_that_came_and_was_not_taken_is_not_missing() -> None:
    bad = wire_block(bytes(4) + b"\x12\x34")[:-1]
    without = refused(Scripted(scripted((b"\x02", b"\x10"), (b"", b"\x10\x02"), (b"\x10", bad))))
    assert without.startswith("the reaction telegram could not be taken: ") and "3964, not 3964R" in without
    wrong = refused(Scripted(scripted((b"\x02", b"\x10"), (b"", b"\x10\x02"), (b"\x10", bad + b"\x55"))))
    assert "its block check was wrong" in wrong


def test_a_partner_slower_than_qvz_is_not_called_busy() -> None:
    """It answered the fourth STX, then NAK: not every STX was answered with NAK."""
    told = refused(Scripted(scripted((b"\x02\x02\x02", b"\x10"), (b"", b"\x15"), *[(b"\x02", b"\x15")] * 20)))
    assert told.startswith("no answer to STX within QVZ/ADT 550 ms (2 attempts); the block refused (NAK) (1 attempt); NAK to STX (")
    assert told.endswith("the partner answers later than our QVZ/ADT: choose its --profile, or one with a longer QVZ")


def test_a_refusal_carries_number_and_words() -> None:
    line, _ = client()
    with pytest.raises(Refused, match="14h, block missing or too short"):
        line.fetch(99, 0, 1)
    assert [(one.ours, one.data.hex()) for one in line.traffic] == [(True, "00004544630000 01ffff".replace(" ", "")), (False, "00000014")]


@pytest.mark.parametrize(
    "kind, text, data",
    [
        ("KF", "-350", "fea2"),
        ("DH", "70000", "00011170"),
        ("KM", "0000000100000001", "0101"),
        ("KY", "12,34", "0c22"),
        ("KC", "AB", "4142"),
        ("KT", "500,1", "1500"),
        ("KZ", "123", "0123"),
        ("BCD", "1234", "1234"),
        ("KG", "-0.005", "f9ae147b"),
        ("REAL", "1,5", "3fc00000"),
        ("bit", "1", "0001"),
    ],
)
def test_every_number_type_is_written_as_a_person_writes_it(kind: str, text: str, data: str) -> None:
    assert encoded(kinds(kind), [text]).hex() == data
    assert encoded(kinds(kind), [decoded(kinds(kind), 1, 0, bytes.fromhex(data))[0].text.strip("'").replace("True", "1")]).hex() == data


@pytest.mark.parametrize(
    "types, values, words",
    [
        ("KF", ["40000"], "range -32768..32767"),
        ("KX", ["1"], "an S5 float is KG, an IEEE one REAL"),
        ("KY", ["12"], "as in 12,34"),
        ("KF", ["abc"], "'abc' is not a KF value"),
        ("KF", [], "no value"),
    ],
)
def test_a_wrong_value_is_refused_before_anything_is_sent(types: str, values: list[str], words: str) -> None:
    with pytest.raises(BadInput) as fault:
        encoded(kinds(types), values)
    assert words in str(fault.value)


@pytest.mark.parametrize("text", ["DB10.DL2", "DB10.D2.3", "E 1.0", "axis.X.actual", "DB300.DW0"])
def test_only_whole_words_of_a_block_can_be_moved(text: str) -> None:
    with pytest.raises(BadInput):
        place(text)
    assert place("DB10.DD4") == (10, 4)


def test_a_pattern_that_is_no_number_is_shown_with_its_bytes() -> None:
    (one,) = decoded(kinds("BCD"), 1, 0, b"\x12\x3f")
    assert one.value is None
    assert "no BCD" in one.text and one.data == b"\x12\x3f"
