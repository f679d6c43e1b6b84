"""users.md 3.5, `[[telegram]]`: the host's ORDER and the cell's DONE, by hand byte by byte; and everything that is not an ORDER."""

import pytest

from protocols.base.errors import EncodeError
from protocols.telegrams.builder import Edge, EdgeWatch, When, build, parse_when
from protocols.telegrams.fields import Field, Kind, Order, Value
from protocols.telegrams.judge import incoming_faults, outgoing_faults, same_block
from protocols.telegrams.layout import Incoming, Match, Outgoing, Received, Refused, Unknown
from protocols.telegrams.reader import Reader

ORDER = Incoming(
    "ORDER",
    (Match(0, b"\x00\x00"), Match(2, b"OR")),
    (
        Field(Kind.INTEGER, "order.number", 4),
        Field(Kind.INTEGER, "order.pallet", 8),
        Field(Kind.REAL, "order.height", 12, unit="mm"),
        Field(Kind.CHARACTER, "order.pattern", 16, count=2),
    ),
    18,
    "order.new",
)
DONE = Outgoing("DONE", (b"\0\0", b"DN", Field(Kind.INTEGER, "order.number", 4), Field(Kind.INTEGER, "error.first.code", 8)))
BLOCK = bytes.fromhex("00 00 4f 52  39 30 00 00  07 00 00 00  00 00 c0 3f  41 31")


def test_the_order_is_read_whole() -> None:
    reader = Reader([ORDER])
    values = (("order.number", 12345), ("order.pallet", 7), ("order.height", 1.5), ("order.pattern", "A1"))
    assert reader.block(BLOCK) == Received("ORDER", values, "order.new")
    assert reader.received == {"ORDER": 1} and reader.refused == {"ORDER": 0} and reader.unknown == 0


def test_done_is_built_out_of_the_values_of_the_moment() -> None:
    values: dict[str, Value] = {"order.number": 12345, "error.first.code": 0.0}
    assert build(DONE, values.__getitem__).hex(" ") == "00 00 44 4e 39 30 00 00 00 00 00 00"


def test_what_is_no_order_is_counted_and_nothing_of_it_is_taken() -> None:
    reader = Reader([ORDER])
    assert reader.block(BLOCK[:-1]) == Refused("ORDER", "17 bytes received, 18 expected")
    nan = BLOCK[:12] + bytes.fromhex("0000c07f") + BLOCK[16:]
    assert reader.block(nan) == Refused("ORDER", "order.height: 00 00 c0 7f is not a number (REAL)")
    assert reader.block(b"\0\0XX") == Unknown(b"\0\0XX")
    assert reader.block(b"") == Unknown(b"")
    assert reader.refused == {"ORDER": 2} and reader.unknown == 2 and reader.received == {"ORDER": 0}


def test_telegrams_that_differ_in_length_only_are_told_apart() -> None:
    short, long = Incoming("SHORT", (Match(0, b"A"),), (), 2), Incoming("LONG", (Match(0, b"A"),), (), 3)
    reader = Reader([short, long])
    assert reader.block(b"A1") == Received("SHORT", ()) and reader.block(b"A12") == Received("LONG", ())
    assert reader.block(b"A123") == Refused("SHORT", "4 bytes received, 2 expected")


def test_without_a_length_a_block_has_to_hold_matches_and_fields() -> None:
    reader = Reader([Incoming("ANY", (Match(0, b"A"),), (Field(Kind.WORD, "w", 1, order=Order.BIG),))])
    assert reader.block(b"A\x01") == Refused("ANY", "2 bytes received, 3 or more expected")
    assert reader.block(b"A\x01\x02rest") == Received("ANY", (("w", 0x0102),))


@pytest.mark.parametrize(
    "values, words",
    [
        ({"order.number": 1}, "DONE: error.first.code has no value yet"),
        ({"order.number": 2**31, "error.first.code": 0}, "DONE: order.number = 2147483648, range -2147483648..2147483647"),
    ],
)
def test_a_block_that_cannot_be_built_names_telegram_value_and_range(values: dict[str, Value], words: str) -> None:
    with pytest.raises(EncodeError) as refusal:
        build(DONE, values.__getitem__)
    assert str(refusal.value) == words


@pytest.mark.parametrize("length, fits", [(0, False), (1, True), (138, True), (139, False)])
def test_a_block_has_1_to_138_bytes(length: int, fits: bool) -> None:
    telegram = Outgoing("BIG", (bytes(length),) if length else ())
    nothing: dict[str, Value] = {}
    assert telegram.length == length
    assert [finding.key for finding in outgoing_faults(telegram)] == ([] if fits else ["build"])
    if fits:
        assert len(build(telegram, nothing.__getitem__)) == length
    else:
        with pytest.raises(EncodeError, match=r"BIG: .* bytes, range 1\.\.138"):
            build(telegram, nothing.__getitem__)


@pytest.mark.parametrize(
    "edge, seen, fired",
    [
        (Edge.RISING, [1, 1, 0, 1, 1], [False, False, False, True, False]),  # a standing bit sends nothing
        (Edge.RISING, [None, 0, None, 1], [False, False, False, True]),
        (Edge.FALLING, [1, 0, 0, 1, 0], [False, True, False, False, True]),
        (Edge.FALLING, [0, 1], [False, False]),
        (Edge.CHANGE, [5, 5, 6, None, 6, "x"], [False, False, True, False, False, True]),
    ],
)
def test_edges(edge: Edge, seen: list[Value | None], fired: list[bool]) -> None:
    watch = EdgeWatch(When(edge, "order.done"))
    assert [watch.fires(value) for value in seen] == fired


def test_when_is_an_edge_and_a_name() -> None:
    assert parse_when("rising order.done") == When(Edge.RISING, "order.done")
    assert parse_when("change  axis.A1.actual") == When(Edge.CHANGE, "axis.A1.actual")
    assert parse_when("order.done") is None and parse_when("up order.done") is None and parse_when("") is None


def test_a_sound_telegram_has_no_findings() -> None:
    assert list(incoming_faults(ORDER)) == [] and list(outgoing_faults(DONE)) == []


@pytest.mark.parametrize(
    "telegram, words",
    [
        (Incoming("T", (Match(0, b"\0\0"),), (Field(Kind.INTEGER, "a", 1),), 18), "a overlaps match[0]: both cover byte 1"),
        (Incoming("T", (), (Field(Kind.REAL, "a", 0), Field(Kind.WORD, "b", 3)), 18), "b overlaps a: both cover byte 3"),
        (Incoming("T", (), (Field(Kind.REAL, "a", 15),), 18), "a covers bytes 15..18, beyond the length: bytes 0..17"),
        (Incoming("T", (Match(0, b"A"),), (), 139), "139 bytes; a block of this line's profile has 1..138"),
        (Incoming("T", (Match(137, b"AB"),)), "match[0] covers bytes 137..138, beyond the length: bytes 0..137"),
        (Incoming("T", (Match(0, b""),)), "no bytes to recognise"),
        (Incoming("T", (), (Field(Kind.BYTE, "a", 0), Field(Kind.BYTE, "a", 1))), "a is written twice"),
        (Incoming("T", (), (Field(Kind.TEXT, "a", 0, count=2),), None), "TEXT is one text of 80 bytes"),
        (Incoming("T", (), (Field(Kind.BINARY, "a", 0, scale=2.0),)), "BINARY has no scale, min or max"),
        (Incoming("T", (), (Field(Kind.CHARACTER, "a", 0, low=2.0),)), "CHARACTER has no scale, min or max"),
        (Incoming("T", (), (Field(Kind.CHARACTER, "a", 0, high=2.0),)), "CHARACTER has no scale, min or max"),
        (Incoming("T", (), (Field(Kind.WORD, "a", 0, scale=0.0),)), "scale 0 makes every value 0"),
        (Incoming("T", (), (Field(Kind.WORD, "a", 0, low=2.0, high=2.0),)), "min 2 must be below max 2"),
        (Incoming("T", (), (Field(Kind.POINT, "a", 0, count=13),)), "POINT has 1..12 coordinates"),
    ],
)
def test_findings_of_one_telegram(telegram: Incoming, words: str) -> None:
    assert any(words in finding.words for finding in incoming_faults(telegram))


def test_findings_of_a_build_name_the_entry() -> None:
    telegram = Outgoing("T", (b"", Field(Kind.WORD, "a", 0, low=1.0, high=9.0), Field(Kind.WORD, "a", 2, scale=0.0)))
    assert [(finding.key, finding.index) for finding in outgoing_faults(telegram)] == [("build", 0), ("build", 2)]


@pytest.mark.parametrize(
    "one, other, shared",
    [
        (ORDER, Incoming("X", (Match(0, b"\0\0"),), (), 18), "00 00 4f 52"),
        (ORDER, Incoming("X", (Match(0, b"\0\0"),), (), 19), None),
        (ORDER, Incoming("X", (Match(0, b"\0\1"),)), None),
        (ORDER, Incoming("X", (Match(5, b"\7"),)), "00 00 4f 52 00 07"),
        (ORDER, Incoming("X", (Match(20, b"\7"),)), None),  # 18 bytes cannot hold it
        (Incoming("X", (Match(3, b"XX"),)), ORDER, None),
        (Incoming("X", (Match(3, b"RX"),)), Incoming("Y", (Match(2, b"OR"),)), "00 00 4f 52 58"),
        (Incoming("X", ()), Incoming("Y", ()), ""),
        (Incoming("X", (), (), 4), Incoming("Y", (), (), 5), None),
    ],
)
def test_two_telegrams_that_would_take_the_same_block(one: Incoming, other: Incoming, shared: str | None) -> None:
    found = same_block(one, other)
    assert (None if found is None else found.hex(" ")) == shared
